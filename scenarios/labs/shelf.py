"""The labs in their order, and a student's copy of one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from armtwin.models import atomic
from armtwin.models.errors import InputError

_HERE = Path(__file__).parent
NOTEBOOKS, INSTRUCTOR = _HERE / "notebooks", _HERE / "instructor"


@dataclass(frozen=True)
class Lab:
    """A lab: its number, its file's stem, what it is about, and about how long it takes, minutes."""

    number: int
    stem: str
    title: str
    minutes: int

    @property
    def notebook(self) -> Path:
        """The notebook as it is handed out."""
        return NOTEBOOKS / f"{self.stem}.py"


LABS = (
    Lab(1, "lab_1_lens", "The lens", 60),
    Lab(2, "lab_2_marker", "The marker", 75),
    Lab(3, "lab_3_arm", "The arm and its inverse", 75),
    Lab(4, "lab_4_calibration", "Calibration, and what cannot be known", 90),
    Lab(5, "lab_5_faults", "What is still wrong", 90),
    Lab(6, "lab_6_experiment", "The next experiment", 75),
    Lab(7, "lab_7_sealed", "The sealed robot", 90),
)


def lab_numbered(number: int) -> Lab:
    """Return a lab; raises `InputError` for a number that there is not."""
    for lab in LABS:
        if lab.number == number:
            return lab
    raise InputError(f"lab: there is no lab {number}; one of {', '.join(str(lab.number) for lab in LABS)} is wanted")


def students_copy(lab: Lab, folder: Path) -> Path:
    """Return the student's own copy of a notebook in `folder`, made if there is none; his work is never overwritten."""
    path = folder / lab.notebook.name
    if not path.exists():
        atomic.write_bytes(path, lab.notebook.read_bytes())
    return path
