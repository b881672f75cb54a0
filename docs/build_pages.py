"""Make the pages of the site in build/docs: those of this folder, guides of the rooms, and the reference from the code.

python docs/build_pages.py && mkdocs build
"""

from __future__ import annotations

import ast
import inspect
import re
import shutil
from pathlib import Path

import cv2
import numpy as np
from typer.testing import CliRunner

import armtwin
from armtwin.models.arm import nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.reference import as_markdown, reference
from armtwin.models.kinematics import Deviation
from armtwin.models.plan import paper_plan
from armtwin.models.twin import Twin, TwinEffect, rebuild
from armtwin.scenarios.cli import COMMANDS, build_app
from armtwin.scenarios.diagnosis.pipeline import report_on, write_report
from armtwin.scenarios.labs.shelf import INSTRUCTOR, LABS
from armtwin.scenarios.twins.simulation import simulate
from armtwin.sim.bench import SimulatedBench

HERE = Path(__file__).parent
ROOT = HERE.parent
OUT = ROOT / "build" / "docs"
# Guides that stand in the rooms they tell of.
GUIDES = {
    "measurements.md": "docs/measurements.md",
    "tutorials/own-bench.md": "hardware/bench-guide.md",
    "tutorials/own-effect.md": "models/effects/README.md",
}
REPOSITORY_LINK = re.compile(r"\[([^\]]+)\]\((?!https?://|#)([^)]+)\)")


def main() -> None:
    """Write every page and picture."""
    shutil.rmtree(OUT, ignore_errors=True)
    shutil.copytree(HERE, OUT, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    for page, guide in GUIDES.items():
        _copy_guide(ROOT / guide, OUT / page)
    pages = {"effects.md": as_markdown(reference()), "commands.md": commands_page(), "python.md": python_page()}
    (OUT / "labs" / "solutions.md").write_text(solutions_page(), "utf-8")
    for name, text in pages.items():
        (OUT / "reference").mkdir(exist_ok=True)
        (OUT / "reference" / name).write_text(text, "utf-8")
    make_pictures(OUT / "pictures")


def commands_page() -> str:
    """Return the help of every command."""
    parts = ["# Commands", "", "Exit code 0: done; 1: the job failed; 2: the input is wrong, and one line says where."]
    runner = CliRunner()
    for name in COMMANDS:
        app = build_app(name)
        family = [str(one.name) for group in app.registered_groups for one in group.typer_instance.registered_commands]
        for words in [[name], *([name, member] for member in family)]:
            help_text = runner.invoke(app, [*words, "--help"], env={"COLUMNS": "100", "TERM": "dumb"}).output
            parts += ["", f"## armtwin {' '.join(words)}", "", "```text", help_text.strip("\n"), "```"]
    return "\n".join(parts) + "\n"


def solutions_page() -> str:
    """Return what the instructor reads of each lab: goals, time, stumbling blocks, and the solution's code."""
    parts = ["# Labs: goals and solutions", "", "For instructors. Nothing here is in what `armtwin lab open` opens."]
    for lab in LABS:
        module = ast.parse((INSTRUCTOR / f"lab_{lab.number}.py").read_text("utf-8"))
        prose = ast.get_docstring(module) or ""
        title, _, rest = prose.partition("\n\n")
        wanted = [node for node in module.body if isinstance(node, ast.FunctionDef | ast.Assign | ast.AnnAssign)]
        code = "\n\n\n".join(ast.unparse(node) for node in wanted if not _is_mistakes(node))
        parts += ["", f"## {title.rstrip('.')}", "", rest, "", '??? note "Solution"', ""]
        parts += [f"    {line}".rstrip() for line in ("```python", *code.splitlines(), "```")]
    return "\n".join(parts) + "\n"


def _is_mistakes(node: ast.stmt) -> bool:
    return isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.target.id == "WRONG"


def python_page() -> str:
    """Return what `import armtwin` offers, by its docstrings."""
    parts = ["# Python", "", "```text", inspect.cleandoc(armtwin.__doc__ or ""), "```"]
    for name in sorted(armtwin.__all__, key=str.lower):
        value = getattr(armtwin, name)
        kind = "class" if inspect.isclass(value) else "function"
        parts += ["", f"## {name}", ""]
        if kind == "function":
            parts += ["```python", f"armtwin.{name}{inspect.signature(value)}", "```", ""]
        parts += ["```text", inspect.getdoc(value) or "", "```"]
    return "\n".join(parts) + "\n"


def make_pictures(folder: Path) -> None:
    """Film a pose, and diagnose a recording with play, as a reader would."""
    folder.mkdir(parents=True)
    arm = nominal_arm()
    deviation = Deviation(np.array([1.5, -2.0, 0.4, 0.0]), np.array([0.02, -0.03, 0.01]))
    play = TwinEffect("backlash", 2, None, {"width_rad": 0.02})
    twin = Twin(arm, deviation, np.array([8.0, -6.0, -80.87]), nominal_camera(), (play,))
    plan = paper_plan(arm)
    with SimulatedBench(rebuild(twin)) as bench:
        bench.move(plan.q_cmd[0])
        cv2.imwrite(str(folder / "frame.jpg"), bench.capture().image, [cv2.IMWRITE_JPEG_QUALITY, 85])
    aside = folder / "diagnosis"
    write_report(aside, "play at joint 2", report_on(simulate(twin, plan, seed=1, held_out=("line",))))
    shutil.move(aside / "report.html", folder / "report.html")
    shutil.rmtree(aside)


def _copy_guide(source: Path, page: Path) -> None:
    """Copy a room's guide with its pictures; links to other files of the repository become their names."""
    text = source.read_text("utf-8")

    def linked(match: re.Match[str]) -> str:
        label, target = match.groups()
        file = (source.parent / target.split("#")[0]).resolve()
        if file.suffix in (".png", ".jpg", ".svg") and file.is_file():
            shutil.copyfile(file, page.parent / file.name)
            return f"[{label}]({file.name})"
        return f"{label} (`{file.relative_to(ROOT)}`)" if file.is_relative_to(ROOT) else label

    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text(REPOSITORY_LINK.sub(linked, text), "utf-8")


if __name__ == "__main__":
    main()
