"""Lab 7 of armtwin: the sealed robot."""

import marimo

app = marimo.App(app_title="Lab 7: the sealed robot", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 7: the sealed robot

    About 90 minutes. You need Labs 4 to 6.

    Somewhere stands a robot with one thing wrong with it, or nothing. You may take 60 pictures of it. Find out what is
    wrong, where, and how much, with an interval that you would bet on; then bring its tip along a line all the same.

    Practise here first: twenty robots stand ready on your own machine, and the checks hold your answer against their
    truth. Your own robot is served by your instructor, and its truth is on no file of yours.
    """)


@app.cell(hide_code=True)
def _():
    import marimo as mo
    import numpy as np

    import armtwin
    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import sealed as check
    from armtwin.scenarios.labs.material.sealed import PRACTICE, hand_in, measure, measure_served

    return PRACTICE, armtwin, check, hand_in, measure, measure_served, mo, np, show


@app.cell(hide_code=True)
def _(PRACTICE, mo):
    choice = mo.ui.slider(1, 20, value=7, label="practice robot", show_value=True)
    mo.vstack([choice, mo.md(f"What may be wrong with it: {', '.join(f'`{name}`' for name in PRACTICE)}.")])
    return (choice,)


@app.cell(hide_code=True)
def _(choice):
    robot = choice.value
    return (robot,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 1. The experiment

    **Your turn.** Choose 12 to 60 poses, `(N, 3)`, rad, within ±90°. Their order counts: what remembers where it came
    from shows only where a joint turns back. The last sixth of them is held out.
    """)


@app.cell
def _(np):
    my_poses = None
    return (my_poses,)


@app.cell(hide_code=True)
def _(check, my_poses, robot):
    fits = check.plan(my_poses, robot)
    fits
    return (fits,)


@app.cell(hide_code=True)
def _(fits, measure, mo, my_poses, robot):
    mo.stop(not fits.passed, mo.md("*The recording is made when your poses fit.*"))
    recording = measure(robot, my_poses)
    mo.md(
        f"`recording` holds {len(recording)} poses: `recording.q_cmd`, `recording.markers_px['f']` and the "
        "other markers, `recording.trajectory`."
    )
    return (recording,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. What is wrong

    Look at residuals as in Lab 5, or ask `armtwin.calibrate(recording)` and `armtwin.diagnose(recording)`, if your
    instructor allows them; believe nothing that you cannot explain. (`armtwin effects NAME`, in a terminal, says what
    each cause is confused with and what tells it apart.)
    """)


@app.cell
def _(armtwin, np, recording):
    # Yours: as many cells as you like.
    return


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** The answer: `cause` (or `"none"`), `joint` where it sits at one, one `parameter` of it by its name
    with the unit, its `value`, and the interval from `low` to `high`. (`armtwin.twin_of(found).effects` states what a
    diagnosis found in these parameters.)
    """)


@app.cell
def _():
    answer = None
    # answer = {"cause": "...", "joint": 1, "parameter": "..._rad", "value": 0.0, "low": 0.0, "high": 0.0}
    return (answer,)


@app.cell(hide_code=True)
def _(answer, check, robot):
    check.cause(answer, robot)


@app.cell(hide_code=True)
def _(answer, check, robot):
    check.size(answer, robot)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. The line, all the same

    **Your turn.** Return commands `(N, 3)` that bring the tip along the paper's line, N points evenly spaced from
    (−145, 25) mm to (−115, 45) mm with θ_F = π. The arm's geometry is not the drawing's either. `armtwin.correct` does
    it for a twin (`armtwin.twin_of(found)`); so does Lab 3's inverse with Lab 4's lengths, and a thought about the
    cause.
    """)


@app.cell
def _(armtwin, np):
    line_commands = None
    return (line_commands,)


@app.cell(hide_code=True)
def _(check, line_commands, robot):
    check.line(line_commands, robot)


@app.cell(hide_code=True)
def _(mo):
    address = mo.ui.text(label="the address on your hand-out", full_width=True)
    key = mo.ui.text(label="its token", kind="password")
    run = mo.ui.run_button(label="run my poses on my robot (takes pictures of the budget)")
    give = mo.ui.run_button(label="hand in my answer")
    mo.vstack([mo.md("## 4. Your own robot"), address, key, mo.hstack([run, give], justify="start")])
    return address, give, key, run


@app.cell(hide_code=True)
def _(address, key, measure_served, mo, my_poses, run):
    mo.stop(not run.value)
    my_recording = measure_served(address.value.split("?")[0], key.value, my_poses)
    mo.md(f"`my_recording` holds all {len(my_recording)} pictures that you have taken of it.")
    return (my_recording,)


@app.cell(hide_code=True)
def _(address, answer, give, hand_in, key, line_commands, mo):
    mo.stop(not give.value)
    mo.md(hand_in(address.value.split("?")[0], key.value, answer, line_commands))


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    Say that your diagnosis is wrong: something that you have not thought of makes the same residuals. What in your
    recording could have told you, and what would your corrected line look like?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
