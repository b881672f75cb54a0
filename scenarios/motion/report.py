"""The page of a moving arm's diagnosis."""

from __future__ import annotations

from markupsafe import Markup

from armtwin.calib.motion.diagnosis import Estimate, MotionCause, MotionDiagnosis
from armtwin.calib.motion.experiment import NextMotion
from armtwin.models.catalogue.motion_effect import motion_effect_named
from armtwin.scenarios.motion import figures
from armtwin.scenarios.motion import response_figures as answers
from armtwin.scenarios.motion.notes import in_every_motion, notes
from armtwin.scenarios.motion.remainder import follows
from armtwin.scenarios.motion.resimulate import Resimulated
from armtwin.scenarios.motion.words import gain, headline, label, missed, parameter_words, ties, what_next, where
from armtwin.scenarios.report.page import page
from armtwin.scenarios.report.section import Cell, Section, fold, number, plot, plots, prose, table

# Frequency responses are of the joints whose causes change most.
_MOST_RESPONSES = 2


def motion_page(
    name: str, found: MotionDiagnosis, again: Resimulated | None = None, proposed: NextMotion | None = None
) -> str:
    """Return the report's HTML."""
    figures_of_all = [
        _verdict(found),
        *((number(1e3 * value, 2, "mrad"), what) for value, what in _errors(found)),
    ]
    recording = found.recording
    set_up = "".join(f"Set up wrongly: {fault.said}.\n" for fault in found.set_up)
    about = (
        f"{set_up}{headline(found)}\n{len(recording)} rows of '{recording.arm.name}' in motion, "
        f"{recording.n_joints} joints, {len(recording.motions)} motions ({', '.join(recording.motions[:8])})."
    )
    sections = [*_set_up(found), _causes(found), _time(found), _answers(found), _remainder(found)]
    sections += [_gain(found, again), _next(found, proposed)]
    told = notes(found)
    if told:
        sections.append(Section("notes", "What this recording cannot tell", "", tuple(prose(note) for note in told)))
    return page(f"Diagnosis of {name}", about, figures_of_all, sections, key=("commanded", "geometry", "extended"))


def _verdict(found: MotionDiagnosis) -> tuple[str, str]:
    if found.verdict == "none":
        return "nothing", "is wrong beyond the noise"
    if found.verdict == "unknown":
        return "unknown", "no known effect explains it"
    count = len(found.causes)
    strongest = label(found, found.causes[0])
    if found.verdict == "ambiguous":
        return strongest, "or another: ambiguous"
    return (strongest, "the cause") if count == 1 else (f"{count} causes", f"strongest: {strongest}")


def _errors(found: MotionDiagnosis) -> list[tuple[float, str]]:
    n = max(len(found.held_out), 1)
    keys = ("before_rms_rad", "after_rms_rad", "noise_floor_rad")
    names = ("held-out error, calibrated geometry", "held-out error, extended twin", "noise floor")
    return [
        (float((sum(getattr(one, key) ** 2 for one in found.held_out) / n) ** 0.5), what)
        for key, what in zip(keys, names, strict=True)
    ]


def _set_up(found: MotionDiagnosis) -> list[Section]:
    """Show what is set up wrongly, before anything else."""
    if not found.set_up:
        return []
    lead = "This comes first: all that follows is of the recording without it."
    lines = tuple(prose(f"{fault.said}: {fault.remedy}") for fault in found.set_up)
    return [Section("set-up", "What is set up wrongly", lead, lines)]


def _causes(found: MotionDiagnosis) -> Section:
    if not found.causes:
        lead = headline(found)
        return Section("causes", "No cause to name", lead)
    rows: list[list[Cell]] = []
    for cause in sorted(found.causes, key=lambda one: (one.joint or 0, -one.explained_percent)):
        rows += _rows(found, cause)
    lead = " ".join(
        f"{effect}: {motion_effect_named(effect).summary}." for effect in dict.fromkeys(c.effect for c in found.causes)
    )
    caption = (
        "Each cause joint by joint. 'Explains' is the share of the squared error that comes back when this cause alone "
        "is left out and all others are fitted again; intervals are from blocks longer than the remainder's memory."
    )
    header = ["effect", "at", "explains", "parameter", "value", "95 % interval"]
    return Section("causes", "What is wrong", lead, (table(header, rows, caption, marked=(4, 5)),))


def _rows(found: MotionDiagnosis, cause: MotionCause) -> list[list[Cell]]:
    head: list[Cell] = [cause.effect, where(found, cause), f"{cause.explained_percent:.1f} %"]
    values = [(name, *parameter_words(name, one)) for name, one in cause.parameters.items()]
    if cause.rows:
        values.append(("rows", ", ".join(map(str, cause.rows[:12])) + (" …" if len(cause.rows) > 12 else ""), "–"))
    out: list[list[Cell]] = []
    for k, (name, value, interval) in enumerate(values or [("", "", "")]):
        out.append([*(head if k == 0 else ["", "", ""]), name, value, interval])
    out += [[f"or {other}", where(found, cause), "as well", "", "", ""] for other in cause.equivalents]
    return out


def _time(found: MotionDiagnosis) -> Section:
    joints = _worst_first(found)
    lead = (
        "Blue is what was measured, green the extended twin, orange the nominal servo with its zero fitted. Where "
        "green lies on blue and orange does not, the causes say what the arm does; each twin began at the first "
        "measured angle of the motion and was told no later one."
    )
    shown = [figures.stretch(found, joint, titled=joint != joints[0]) for joint in joints]
    blocks = [plot(shown[0], figures.what_to_see(found, joints[0]))]
    if len(shown) > 1:
        blocks.append(plots(shown[1:], "The same of the other joints."))
    return Section("time", "How the arm moves, and how its twins do", lead, tuple(blocks))


def _answers(found: MotionDiagnosis) -> Section:
    """Show how the joints answer to frequencies and steps, and whether they do so in every motion."""
    joints = _worst_first(found)
    blocks = [
        plot(
            answers.delay_by_correlation(found),
            "How late the measurement follows its command: where a curve is highest. A lag makes the hill wide, a "
            "delay moves it.",
        )
    ]
    for joint in joints[:_MOST_RESPONSES]:
        shown = answers.frequency_response(found, joint)
        if shown:
            blocks.append(
                plots(
                    shown,
                    "Swings of the command by their size, the extended twin dotted. A delay is level over frequency "
                    "and one for all sizes; a lag bends the gain down; friction and play weaken small swings, a speed "
                    "limit large ones. Where the coherence falls, something else than the command moves the joint.",
                )
            )
    steps = [fig for joint in joints if (fig := answers.step_responses(found, joint)) is not None]
    if steps:
        caption = (
            "Steps laid over one another, as shares of each. Until a curve leaves zero nothing has arrived; curves of "
            "large steps behind those of small ones show a speed limit, those that end short a stop or friction."
        )
        blocks.append(plots(steps, caption) if len(steps) > 1 else plot(steps[0], caption))
    if found.by_motion:
        blocks.append(_by_motion(found))
    return Section("answers", "How the joints answer", in_every_motion(found), tuple(blocks))


def _by_motion(found: MotionDiagnosis) -> Markup:
    rows: list[list[Cell]] = []
    for one in found.by_motion:
        value, _ = parameter_words(one.parameter, Estimate(one.value, None))
        over_all, _ = parameter_words(one.parameter, Estimate(one.over_all, None))
        name = found.recording.joint_names[one.joint]
        rows.append([name, one.parameter, one.motion, value, over_all, "another" if one.differs else "the same"])
    caption = "Each number asked of one motion alone, all else as found; 'another' is beyond four deviations and 15 %."
    return fold(
        "Delay, lag and friction of every motion",
        [table(["joint", "parameter", "motion", "alone", "all", ""], rows, caption)],
    )


def _remainder(found: MotionDiagnosis) -> Section:
    against = follows(found)
    lead = (
        f"What the extended twin leaves still follows {', '.join(against)}."
        if against
        else "What the extended twin leaves follows neither time, nor angle, speed, direction or load."
    )
    joints = _worst_first(found)
    blocks = [
        plots(figures.phase_plane(found, joints[0]), "What each twin leaves over angle and speed: pale is right."),
        plots([figures.error_over_time(found, joint) for joint in joints], "What each twin leaves over time."),
    ]
    return Section("remainder", "What is left", lead, tuple(blocks))


def _gain(found: MotionDiagnosis, again: Resimulated | None) -> Section:
    header = ["motion", "joint", "command", "nominal", "geometry", "extended", "worst", "noise"]
    keys = ("command", "nominal", "before", "after")
    rows: list[list[Cell]] = [
        [
            one.trajectory,
            found.recording.joint_names[one.joint],
            *(number(1e3 * getattr(one, f"{key}_rms_rad"), 2) for key in keys),
            number(1e3 * one.after_worst_rad, 2),
            number(1e3 * one.noise_floor_rad, 2),
        ]
        for one in found.held_out
    ]
    caption = "RMS over every sample of the held-out motions, milliradians: by the command alone and by each twin."
    lead = f"{gain(found)} {missed(found, again)}"
    return Section("gain", "What it gained", lead, (table(header, rows, caption, marked=(5,)),))


def _next(found: MotionDiagnosis, proposed: NextMotion | None) -> Section:
    told = tuple(
        prose(f"{cause} looks like {others}; told apart by: {experiment}.") for cause, others, experiment in ties(found)
    )
    return Section("next", "What to do now", what_next(found, proposed), told)


def _worst_first(found: MotionDiagnosis) -> list[int]:
    """Return the joints that move, the one whose causes change most first."""

    def changed(joint: int) -> float:
        model = found.arm.joints[joint]
        return -float(((model.geometric.e - model.fit.e) ** 2).sum())

    joints = [j for j in range(found.recording.n_joints) if found.problem.moves(j)]
    return sorted(joints, key=changed) or [0]
