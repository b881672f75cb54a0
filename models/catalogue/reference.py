"""What every effect says of itself, as data: for the terminal, JSON and the documentation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from armtwin.models.arm import Arm, nominal_arm
from armtwin.models.camera_files import nominal_camera
from armtwin.models.catalogue.context import Context, nominal_links
from armtwin.models.catalogue.injection import taken_by
from armtwin.models.catalogue.registry import Effect, Parameter, catalogue

# Poses of the recording that effects are asked about: bounds by sample are written as this number.
_POSES = 150


def reference_context(arm: Arm | None = None) -> Context:
    """Return the known side of a recording of the nominal arm, standing in gravity, to ask effects for parameters."""
    arm = nominal_arm() if arm is None else arm
    return Context(
        arm=arm,
        camera=nominal_camera(),
        plane_z_mm=-80.0,
        markers=arm.marker_names,
        q_cmd=np.zeros((_POSES, arm.n_joints)),
        time_s=np.linspace(0.0, 1.5 * (_POSES - 1), _POSES),
        trajectory=np.full(_POSES, "reference"),
        payload_kg=np.zeros(_POSES),
        temperature_c=np.full(_POSES, 20.0),
        links=nominal_links(arm),
    )


def reference(effects: Iterable[Effect] | None = None) -> list[dict[str, Any]]:
    """List the effects, by name: meaning, place, parameters with unit and bounds, confusions, experiment."""
    context = reference_context()
    chosen = catalogue().values() if effects is None else effects
    return [_described(effect, context) for effect in sorted(chosen, key=lambda effect: effect.name)]


def _described(effect: Effect, context: Context) -> dict[str, Any]:
    site = effect.sites(context)[0]
    return {
        "effect": effect.name,
        "summary": effect.summary,
        "where": effect.where,
        "stage": effect.stage.name.lower(),
        "parameters": [_parameter(one) for one in effect.parameters(context, site)],
        "injected": [
            {
                **{"name": one.name, "unit": unit_of(one.name), "kind": one.kind},
                **{"bounds": _bounds(one.bounds), "default": one.default},
            }
            for one in taken_by(effect.injected, context.arm).values()
        ],
        "confused_with": list(effect.confused_with),
        "experiment": effect.experiment,
    }


def _parameter(one: Parameter) -> dict[str, Any]:
    return {"name": one.name, "unit": unit_of(one.name), "bounds": _bounds(one.bounds), "prior_std": one.prior_std}


def unit_of(name: str) -> str:
    """Return the unit that a parameter's name ends in; empty for a number without one."""
    units = {
        "rad_per_nm": "rad/(N m)",
        "per_nm2": "1/(N m2)",
        "rad_s": "rad/s",
        "rad": "rad",
        "mm": "mm",
        "px": "px",
        "kg": "kg",
        "nm": "N m",
        "s": "s",
        "sample": "sample",
        "per_turn": "1/turn",
    }
    return next((unit for ending, unit in units.items() if name.endswith(f"_{ending}")), "")


def _bounds(bounds: tuple[float, float]) -> list[float] | None:
    return None if bounds == (0.0, 0.0) else [float(bound) for bound in bounds]


def as_markdown(effects: list[dict[str, Any]]) -> str:
    """Return the effects as a page of the documentation."""
    parts = [
        "# Effects",
        "",
        "What can be found, as the code has it (`armtwin effects --markdown`).",
        "",
    ]
    parts += ["| effect | what it is | sits at |", "|---|---|---|"]
    parts += [f"| [`{e['effect']}`](#{e['effect']}) | {_cell(e['summary'])} | {e['where']} |" for e in effects]
    for effect in effects:
        parts += [
            "",
            f"## {effect['effect']}",
            "",
            f"{_sentence(effect['summary'])} It sits at: {effect['where']}.",
            "",
        ]
        if effect["parameters"]:
            parts += ["| parameter | unit | least | most |", "|---|---|---|---|"]
        else:
            parts += ["It has no parameters of its own: it is found sample by sample."]
        for one in effect["parameters"]:
            low, high = one["bounds"] or ("", "")
            parts.append(f"| `{one['name']}` | {one['unit'] or '1'} | {_number(low)} | {_number(high)} |")
        parts += ["", f"In a scenario or a twin: {injected_words(effect)}."]
        taken = ", ".join(f"`{name}`" for name in effect["confused_with"]) or "nothing"
        parts += ["", f"Taken for: {taken}.", "", f"Told apart by: {_sentence(effect['experiment'])}"]
    return "\n".join(parts) + "\n"


def injected_words(effect: dict[str, Any]) -> str:
    """Return what scenario and twin files state of an effect, in a line."""
    words = []
    for one in effect["injected"]:
        unit = f" in {one['unit']}" if one["unit"] and one["unit"] != "sample" else ""
        range_ = f" from {one['bounds'][0]:.4g} to {one['bounds'][1]:.4g}{unit}" if one["bounds"] else ""
        default = "" if one["default"] is None else f" ({one['default']:g} if left out)"
        words.append(f"{one['name']}, a {one['kind']}{range_}{default}")
    said = "; ".join(words) or "nothing more"
    return said.replace("a samples", "a list of samples").replace("a whole", "a whole number")


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith('.') else '.'}"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _number(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"
