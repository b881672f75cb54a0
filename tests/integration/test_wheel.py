"""What is installed is one package, whole, and untouched by what a user calls his own files."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

# The first import of an unpacked wheel compiles it.
pytestmark = pytest.mark.slow

REPOSITORY = Path(__file__).parents[2]
ROOMS = ("models", "sim", "calib", "hardware", "scenarios")


def built(kind: str, source: Path, out: Path) -> Path:
    """Return the wheel or the sdist of a source tree, built without a network."""
    build = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(out)]
    done = subprocess.run(build, cwd=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return next(out.glob("armtwin-*"))


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel of the working tree."""
    return built("wheel", REPOSITORY, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of packages with the wheel in it: what stands in a wheel is what is installed."""
    site = tmp_path_factory.mktemp("site")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    return site


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a user's folder with names of our rooms in it, each of which complains when it is imported."""
    (tmp_path / "models").mkdir()
    for path in (tmp_path / "models" / "__init__.py", tmp_path / "scenarios.py", tmp_path / "sim.py"):
        path.write_text(f"raise RuntimeError('imported the user\\'s {path.name}')\n")
    return tmp_path


def run(installed: Path, folder: Path, *arguments: str) -> str:
    """Run Python in the user's folder, with the wheel before the working tree."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(installed)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_holds_one_package_with_every_file_of_its_rooms(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert {name.split("/")[0] for name in names if ".dist-info/" not in name} == {"armtwin"}
    assert "armtwin/py.typed" in names
    tracked = subprocess.run(["git", "ls-files", *ROOMS], cwd=REPOSITORY, capture_output=True, text=True).stdout
    assert tracked, "the working tree is no git repository"
    assert {f"armtwin/{path}" for path in tracked.splitlines() if (REPOSITORY / path).is_file()} <= names


def test_the_wheel_that_is_built_from_the_sdist_is_the_same(wheel: Path, tmp_path: Path) -> None:
    with tarfile.open(built("sdist", REPOSITORY, tmp_path / "sdist")) as archive:
        archive.extractall(tmp_path, filter="data")
    again = built("wheel", next(tmp_path.glob("armtwin-*")), tmp_path / "again")
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(again) as other:
        assert {i.filename: i.CRC for i in one.infolist()} == {i.filename: i.CRC for i in other.infolist()}


def test_a_user_s_own_models_and_scenarios_are_left_alone(installed: Path, folder: Path) -> None:
    (folder / "mine.py").write_text(
        "import armtwin, numpy as np\n"
        "print(armtwin.__file__)\n"
        "with armtwin.open_bench('simulated') as bench:\n"
        "    bench.move(np.array([0.1, 0.1, -0.1]))\n"
        "    print(bench.capture().image.shape)\n"
    )
    where, shape = run(installed, folder, "mine.py").splitlines()
    assert Path(where).is_relative_to(installed)
    assert shape == "(720, 1280, 3)"


def test_processes_that_it_starts_leave_them_alone_too(installed: Path, folder: Path) -> None:
    said = run(
        installed, folder, "-m", "armtwin", "seal", "--n", "2", "--jobs", "2", "--effects", "none", "--out", "out"
    )
    assert "2 worlds in" in said
    (folder / "mine.py").write_text(
        "from armtwin.scenarios.runner.job import open_job\n"
        "from armtwin.scenarios.runner.run import run_stages\n"
        "from armtwin.scenarios.runner.stages import STAGES\n"
        "from armtwin.scenarios.scenario import read_scenario\n"
        "from pathlib import Path\n"
        "if __name__ == '__main__':\n"
        "    job = open_job(Path('run'), read_scenario('geometric').model_copy(update={'board_views': 5}))\n"
        "    run_stages(job, {'board': STAGES['board']}, quiet=True)\n"
        "    print(len(job.load('board')['poses']))\n"
    )
    assert run(installed, folder, "mine.py") == "5\n"
