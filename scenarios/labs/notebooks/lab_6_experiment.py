"""Lab 6 of armtwin: the next experiment."""

import marimo

app = marimo.App(app_title="Lab 6: the next experiment", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 6: the next experiment

    About 75 minutes. You need Lab 4's Jacobian (given) and least squares.

    An arm stands upright and misses. Two causes are under suspicion: joint 1 gives under **gravity**, or its servo
    turns 3 % **too far**. Twenty poses on the paper's small circle have been measured, and they cannot tell. You have a
    budget of twenty more poses. Anyone can measure more; you will measure what matters.

    Write where it says **Your turn**. The boxes below say what is right and what is not.
    """)


@app.cell(hide_code=True)
def _():
    import marimo as mo
    import numpy as np

    import armtwin
    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import experiment as check
    from armtwin.scenarios.labs.material.experiment import NOISE_MM, geometry, measure, paper_poses, signature

    return NOISE_MM, armtwin, check, geometry, measure, mo, np, paper_poses, show, signature


@app.cell(hide_code=True)
def _(mo, np, paper_poses, show, signature):
    _q = paper_poses()
    _order = np.arange(len(_q))
    mo.vstack(
        [
            mo.md(
                "## 1. Two causes, one picture\n\n`signature(cause, q)` is how far a cause of the usual size moves the "
                "tip, `(N, 2)`, mm. On the paper's circle:"
            ),
            show.curves(
                _order,
                {
                    f"{_cause}, {_axis}": signature(_cause, _q)[:, _k]
                    for _cause in ("gravity_sag", "servo_gain")
                    for _k, _axis in enumerate("xy")
                },
                "pose",
                "mm",
            ),
        ]
    )


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    They look different. But each has a size that nobody knows, and the seven numbers of the geometry are fitted along,
    and explain what they can. Only what is *left* then can tell the causes apart.

    **Your turn.** Return what is left, `(2N,)`, of one `signature` (2N,) after the best combination of the `other`
    signature (2N,) and the columns of `J` (2N, 7) is taken away. (`J` has one column too many, as in Lab 4: let
    `np.linalg.lstsq` deal with it.)
    """)


@app.cell
def _(np):
    def left_over(signature, other, J):
        return None

    return (left_over,)


@app.cell(hide_code=True)
def _(check, left_over):
    projects = check.left_over(left_over)
    projects
    return (projects,)


@app.cell(hide_code=True)
def _(NOISE_MM, geometry, left_over, mo, np, paper_poses, projects, signature):
    mo.stop(not projects.passed, mo.md("*The separation is computed when `left_over` is right.*"))

    def separation(q):
        """How many standard deviations of the camera's noise the two are apart, in the worse direction."""
        _a, _b = signature("gravity_sag", q).ravel(), signature("servo_gain", q).ravel()
        _J = geometry(q)
        return min(np.linalg.norm(left_over(_a, _b, _J)), np.linalg.norm(left_over(_b, _a, _J))) / NOISE_MM

    mo.md(
        f"On the paper's circle the two are **{separation(paper_poses()):.2f}** standard deviations apart: whoever "
        "names one of them there, guesses."
    )
    return (separation,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. Twenty poses

    **Your turn.** Choose at most 20 poses, `(N, 3)` joint angles in rad within ±90°, in all of which the arm stays in
    the picture. Think first: on what does the torque of gravity at joint 1 depend, and on what the servo's error? Then
    try, with `separation` in a cell of your own. `measure(q)` costs nothing here; in Lab 7 it will.
    """)


@app.cell
def _(np):
    my_poses = None
    return (my_poses,)


@app.cell(hide_code=True)
def _(check, my_poses):
    tells = check.poses(my_poses)
    tells
    return (tells,)


@app.cell(hide_code=True)
def _(armtwin, mo, my_poses, np, show, tells):
    mo.stop(not tells.passed, mo.md("*Some of your poses are shown when they tell the causes apart.*"))
    _pictures = []
    with armtwin.open_bench("simulated") as _bench:
        for _q in np.asarray(my_poses)[[0, len(my_poses) // 2, -1]]:
            _bench.move(_q)
            _pictures.append(mo.image(show.photograph(_bench.capture().image, 360)))
    mo.hstack(_pictures)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. The verdict

    `measure(my_poses)` is what the camera says of the arm in question: the tip less the drawing's, `(N, 2)`, mm, with a
    noise of `NOISE_MM` a coordinate.

    **Your turn.** Fit each cause together with the geometry. Which one is it, and what is its size with its standard
    deviation, in units of the usual size (a pair)?
    """)


@app.cell
def _(NOISE_MM, geometry, measure, my_poses, np, signature):
    verdict = None
    return (verdict,)


@app.cell(hide_code=True)
def _(check, verdict):
    check.verdict(verdict)


@app.cell
def _(NOISE_MM, geometry, measure, my_poses, np, signature):
    size = None
    return (size,)


@app.cell(hide_code=True)
def _(check, my_poses, size):
    check.size(size, my_poses)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    You chose poses that tell two given causes apart. A third one, which you have not thought of, might make the same
    residuals as one of them in these very poses. What would you keep of your twenty poses to notice that?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
