"""Lab 4 of armtwin: calibration, and what cannot be known."""

import marimo

app = marimo.App(app_title="Lab 4: calibration", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 4: calibration, and what cannot be known

    About 90 minutes. You need Lab 3's kinematics (given below) and a little linear algebra.

    An arm was built from a drawing. Its links are a millimetre or two off and its servo horns sit a degree or two
    askew. A camera has watched the tip on two circles of 50 poses each. You will find what the arm is like, first
    as the paper does (Algorithm 1), then by least squares. On the way you will meet a number that no measurement of
    this arm can tell, and that the paper reports all the same.

    The seven unknowns are what the built arm differs by from the drawing, in this order:

    $$\delta = (\Delta l_1, \Delta l_2, \Delta l_4, \Delta l_5 \;[\text{mm}],\;
    \Delta\theta_1, \Delta\theta_2, \Delta\theta_3 \;[\text{rad}])$$

    Write where it says **Your turn**. The boxes below say what is right and what is not; everything runs again by
    itself when you change a cell.
    """)


@app.cell
def _():
    import marimo as mo
    import numpy as np

    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import calibration as check
    from armtwin.scenarios.labs.material.calibration import DRAWN_MM, NAMES, measured_arm, slope_of

    return DRAWN_MM, NAMES, check, measured_arm, mo, np, show, slope_of


@app.cell
def _(DRAWN_MM, np):
    def forward(delta, q):
        """(N, 2) place of the tip, mm, of the arm that differs by delta, for (N, 3) joint angles."""
        l1, l2, l4, l5 = np.array(DRAWN_MM) + delta[:4]
        a = np.cumsum(q + delta[4:] + np.pi / 2, axis=1)  # direction of each link
        z = l1 * np.exp(1j * a[:, 0]) + l2 * np.exp(1j * a[:, 1]) + (l4 - 1j * l5) * np.exp(1j * a[:, 2])
        return np.stack([z.real, z.imag], axis=-1)

    return (forward,)


@app.cell(hide_code=True)
def _(forward, measured_arm, mo, np, show):
    circles, line = measured_arm()  # each has .q_cmd (N, 3), rad, and .tip_mm (N, 2)
    drawn = forward(np.zeros(7), circles.q_cmd)
    mo.vstack(
        [
            mo.md(
                "## What the drawing gets wrong\n\nFrom where the drawing expects the tip to where the camera saw it:"
            ),
            show.arrows(drawn, circles.tip_mm - drawn, 1.0),
        ]
    )
    return circles, line


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 1. The cost

    **Your turn.** Return the mean over all poses of the squared distance between predicted and measured tip, in mm².
    `forward` is at your disposal.
    """)


@app.cell
def _(forward, np):
    def cost(delta, q, tip_mm):
        return None

    return (cost,)


@app.cell(hide_code=True)
def _(check, cost):
    check.cost(cost)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. Down the slope: Algorithm 1

    **Your turn.** Return a `(steps + 1, n)` array: the start, then where each step leads. A step goes against
    `slope(x)`, `rate` times as far as the slope is steep.
    """)


@app.cell
def _(np):
    def descend(slope, start, rate, steps):
        return None

    return (descend,)


@app.cell(hide_code=True)
def _(check, descend):
    descends = check.descent(descend)
    descends
    return (descends,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    Now let it run on the arm. Steps are in units of 1 mm and 1° (as in Table 4), so that all seven slopes are of
    about one size. Find a rate that is fast, and one that is too fast, and take as many steps as it needs until
    the table stands still: both runs start at different places and end with the same error.
    """)


@app.cell(hide_code=True)
def _(mo):
    rate = mo.ui.slider(0.005, 0.1, 0.005, value=0.02, label="rate", show_value=True)
    steps = mo.ui.slider(500, 20000, 500, value=1000, label="steps", show_value=True)
    mo.hstack([rate, steps], justify="start")
    return rate, steps


@app.cell(hide_code=True)
def _(NAMES, circles, descend, descends, forward, mo, np, rate, show, slope_of, steps):
    mo.stop(not descends.passed, mo.md("*This runs when `descend` is right.*"))
    _unit = np.array([1.0, 1.0, 1.0, 1.0, *np.full(3, np.pi / 180)])
    _starts = {"from zero": np.zeros(7), "from the paper's start": np.array([5.0, 5, 1, 1, 5, 5, 5])}
    _every = steps.value // 100
    with np.errstate(all="ignore"):
        _paths = {_name: descend(slope_of(circles), _x, rate.value, steps.value) for _name, _x in _starts.items()}
        _errors = {
            _name: np.array(
                [
                    np.linalg.norm(forward(_x * _unit, circles.q_cmd) - circles.tip_mm, axis=1).mean()
                    for _x in _path[::_every]
                ]
            )
            for _name, _path in _paths.items()
        }
    _ends = [
        {
            "parameter": _name,
            **{_start: f"{_path[-1][_k]:.2f}" for _start, _path in _paths.items()},
            "unit": "mm" if _k < 4 else "°",
        }
        for _k, _name in enumerate(NAMES)
    ]
    mo.vstack(
        [
            show.curves(_every * np.arange(101), _errors, "step", "mean error of the tip, mm", log=True),
            mo.ui.table(_ends, selection=None, label="where each run ends"),
        ]
    )


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** Let both runs settle. Which of the seven end at different values, by more than the run still
    wanders? Write their names as a set, such as `{"l1", "theta2"}`.
    """)


@app.cell
def _():
    start_decides = None
    return (start_decides,)


@app.cell(hide_code=True)
def _(check, start_decides):
    check.start_decides(start_decides)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. What do the data tell?

    **Your turn.** Return the `(2N, 7)` Jacobian: how each tip coordinate moves with each parameter. Rows go pose by
    pose (x, y, x, y …); columns in the order of δ. Central differences with `forward` are good enough.
    """)


@app.cell
def _(forward, np):
    def jacobian(delta, q):
        return None

    return (jacobian,)


@app.cell(hide_code=True)
def _(check, jacobian):
    tells = check.jacobian(jacobian)
    tells
    return (tells,)


@app.cell(hide_code=True)
def _(circles, jacobian, mo, np, show, tells):
    mo.stop(not tells.passed, mo.md("*The singular values are drawn when `jacobian` is right.*"))
    _J = jacobian(np.zeros(7), circles.q_cmd)
    # Columns in mm and degrees, so that all have one unit.
    _s = np.linalg.svd(_J * np.array([1, 1, 1, 1, *np.full(3, np.pi / 180)]), compute_uv=False)
    show.curves(np.arange(1, 8), {"singular values": _s}, "number", "mm a unit step", log=True, marks=True)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** How many of the seven can these data tell? And which direction of δ (seven numbers, in mm and rad,
    of any length) changes nothing at all? `np.linalg.svd` returns it; find out which row of which factor.
    """)


@app.cell
def _():
    known = None
    return (known,)


@app.cell
def _():
    silent = None
    return (silent,)


@app.cell(hide_code=True)
def _(check, known):
    check.known(known)


@app.cell(hide_code=True)
def _(check, silent):
    check.silent(silent)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 4. Least squares

    **Your turn.** Find δ on the circles by Gauss–Newton: linearise with your Jacobian, solve, move, repeat. A
    solution of smallest length (`np.linalg.lstsq` with a sensible `rcond`) keeps the silent direction quiet. The check
    holds your δ against the line, which you have not used.
    """)


@app.cell
def _(circles, forward, jacobian, np):
    estimate = None
    return (estimate,)


@app.cell(hide_code=True)
def _(check, estimate):
    check.calibrated(estimate)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** How well do you know l1? Estimate the noise from what is left of the residuals, take the covariance
    $\sigma^2 (J^\top J)^{-1}$ on what can be known, and give the standard deviation of Δl1 in mm. Mind the degrees of
    freedom.
    """)


@app.cell
def _(circles, estimate, forward, jacobian, np):
    std_l1_mm = None
    return (std_l1_mm,)


@app.cell(hide_code=True)
def _(check, std_l1_mm):
    check.interval(std_l1_mm)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    Table 4 of the paper gives Δl4, Δl5 and Δθ3 with a small spread over ten repetitions. You have seen that no data of
    this arm can tell them apart. Why is the spread small? And what would you have to measure, with what, to tell them
    after all?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
