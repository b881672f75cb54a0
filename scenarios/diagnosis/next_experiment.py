"""Which poses to run next, where these could not tell the causes apart."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from calib.diagnosis.diagnosis import Diagnosis
from models.effects.predict import Active


@dataclass(frozen=True)
class NextExperiment:
    """A trajectory by name, the effects that it tells apart, and why."""

    trajectory: str
    tells_apart: tuple[str, ...]
    why: str


def next_experiment(diagnosis: Diagnosis) -> NextExperiment | None:
    """Return the experiment that most of the rivals ask for; None where there are no rivals."""
    rivals = _rivals(diagnosis)
    plans = Counter(plan for active in rivals for plan in active.effect.plans)
    if not plans:
        return None
    trajectory = max(plans, key=lambda plan: plans[plan])  # of equals the first: the best explanation's
    asking = next(active for active in rivals if trajectory in active.effect.plans)
    labels = " and ".join(active.label for active in rivals)
    apart = f"tells {labels} apart" if len(rivals) > 1 else f"shows whether it is {labels}"
    return NextExperiment(
        trajectory=trajectory,
        tells_apart=tuple(dict.fromkeys(active.effect.name for active in rivals)),
        why=f"{asking.effect.experiment}: {apart}",
    )


def _rivals(diagnosis: Diagnosis) -> list[Active]:
    if diagnosis.verdict == "ambiguous":
        tied = next(cause for cause in diagnosis.causes if cause.equivalents)
        return [tied.active, *tied.equivalents]
    if diagnosis.verdict == "unknown":
        return [active for cause in diagnosis.suspects for active in (cause.active, *cause.equivalents)]
    return []
