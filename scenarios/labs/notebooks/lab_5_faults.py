"""Lab 5 of armtwin: what is still wrong."""

import marimo

app = marimo.App(app_title="Lab 5: what is still wrong", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 5: what is still wrong

    About 90 minutes. You need Lab 4, or a notion of residuals; a little statistics.

    Five arms were calibrated, and every one still misses. Each has exactly one thing wrong with it that no link length
    and no joint zero can mend. You will find the five by looking at pictures of residuals, then let a test say how sure
    you may be, then see how a model that fits better can be a worse one.

    Write where it says **Your turn**. The boxes below say what is right and what is not.
    """)


@app.cell(hide_code=True)
def _():
    import marimo as mo
    import numpy as np
    from scipy import stats

    import armtwin
    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import faults as check
    from armtwin.scenarios.labs.material.faults import POSSIBLE, few_rows, joint_errors, recording

    return POSSIBLE, armtwin, check, few_rows, joint_errors, mo, np, recording, show, stats


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 1. Residuals as pictures

    The five causes are among these six:

    | name | what it is |
    |---|---|
    | `backlash` | play at a joint: the link follows only after the gap is taken up |
    | `camera_moved` | the camera was bumped once |
    | `gravity_sag` | a joint gives under the torque of gravity (the arm stands upright here) |
    | `joint_slip` | a servo's horn slipped once: a zero that jumps |
    | `servo_nonlinearity` | a smooth or wavy error over the servo's angle |
    | `thermal_drift` | a zero that creeps as the servo gets warm |

    `joint_errors("A")` has one row a pose in the order they happened: `.q_cmd` (N, 3), rad; `.error_rad` (N, 3),
    the angle of each joint as the markers show it, less the commanded one; `.base_mm` (N, 2), where marker A was seen;
    `.held_out` (N,), the poses of the last motion, which are kept for judging.
    """)


@app.cell(hide_code=True)
def _(mo):
    which = mo.ui.dropdown(list("ABCDE"), value="A", label="recording")
    what = mo.ui.dropdown(["joint 1", "joint 2", "joint 3", "marker A"], value="joint 1", label="error of")
    against = mo.ui.dropdown(
        ["order", "angle of joint 1", "angle of joint 2", "angle of joint 3", "angle of link 2"],
        value="order",
        label="against",
    )
    mo.hstack([which, what, against], justify="start")
    return against, what, which


@app.cell(hide_code=True)
def _(against, joint_errors, np, show, what, which):
    _seen = joint_errors(which.value)
    _number = int(what.value[-1]) - 1 if what.value != "marker A" else None
    _axes = {
        "order": np.arange(len(_seen.q_cmd)),
        **{f"angle of joint {_k + 1}": _seen.q_cmd[:, _k] for _k in range(3)},
        "angle of link 2": _seen.q_cmd[:, 0] + _seen.q_cmd[:, 1],
    }
    if _number is None:
        _curves = {"x, mm": _seen.base_mm[:, 0], "y, mm": _seen.base_mm[:, 1]}
    else:
        _rising = np.diff(_seen.q_cmd[:, _number], prepend=_seen.q_cmd[0, _number] - 1e-9) >= 0
        _error = 1000 * _seen.error_rad[:, _number]
        _up, _down = np.where(_rising, _error, np.nan), np.where(_rising, np.nan, _error)
        _curves = {"came from below": _up, "from above": _down}
    _x_title = against.value if against.value == "order" else f"{against.value}, rad"
    _y_title = "mm" if _number is None else "measured less commanded, mrad"
    show.curves(_axes[against.value], _curves, _x_title, _y_title, marks=True)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** Which is which?
    """)


@app.cell
def _():
    causes = {"A": None, "B": None, "C": None, "D": None, "E": None}
    return (causes,)


@app.cell(hide_code=True)
def _(causes, check):
    check.causes(causes if any(causes.values()) else None)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. How sure may you be?

    A model with more parameters always leaves less. With n poses, a small model of $k_s$ parameters that leaves the sum
    of squares $R_s$, and a big one ($k_b$, $R_b$) that contains it,

    $$F = \frac{(R_s - R_b) / (k_b - k_s)}{R_b / (n - k_b)}$$

    follows Fisher's distribution with $(k_b - k_s,\; n - k_b)$ degrees of freedom if the small model is all there is.

    **Your turn.** Return the probability of an F at least as large (`stats.f.sf`).
    """)


@app.cell
def _(stats):
    def p_value(rss_small, k_small, rss_big, k_big, n):
        return None

    return (p_value,)


@app.cell(hide_code=True)
def _(check, p_value):
    tests = check.p_value(p_value)
    tests
    return (tests,)


@app.cell(hide_code=True)
def _(joint_errors, mo, np, p_value, tests):
    mo.stop(not tests.passed, mo.md("*The table is made when `p_value` is right.*"))
    _rows = []
    for _name in "ABCDE":
        _seen = joint_errors(_name)
        for _k in range(3):
            _x, _y = _seen.q_cmd[:, _k], _seen.error_rad[:, _k]
            _rising = np.diff(_x, prepend=_x[0] - 1e-9) >= 0
            _small = np.vander(_x, 2)
            _left = [
                float(((_y - _M @ np.linalg.lstsq(_M, _y, rcond=None)[0]) ** 2).sum())
                for _M in (_small, np.column_stack([_small, _rising]), np.vander(_x, 6))
            ]
            _rows.append(
                {
                    "recording": _name,
                    "joint": _k + 1,
                    "p: direction of approach": f"{p_value(_left[0], 2, _left[1], 3, len(_x)):.1e}",
                    "p: curve over the angle": f"{p_value(_left[0], 2, _left[2], 6, len(_x)):.1e}",
                }
            )
    mo.vstack(
        [
            mo.md(
                "A straight line over the angle is the small model; a step by direction, or a curve of the fifth "
                "degree, the big ones. Not every tiny p is the cause: E's slip makes others small too."
            ),
            mo.ui.table(_rows, selection=None, page_size=15),
        ]
    )


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. A better fit, a worse model

    You were in a hurry and took every sixth pose only (`few_rows()`, 20 of them). Fit a polynomial to joint 1's error
    in recording A over the joint's angle.

    **Your turn.** Fit on the rows `fit`, return the RMS on the rows `test`. `np.polynomial.Polynomial.fit` scales the
    angles, which high degrees need.
    """)


@app.cell
def _(np):
    def held_out_rms(x, y, fit, test, degree):
        return None

    return (held_out_rms,)


@app.cell(hide_code=True)
def _(check, held_out_rms):
    judges = check.held_out(held_out_rms)
    judges
    return (judges,)


@app.cell(hide_code=True)
def _(few_rows, held_out_rms, joint_errors, judges, mo, np, show):
    mo.stop(not judges.passed, mo.md("*The curves are drawn when `held_out_rms` is right.*"))
    _seen, _fit = joint_errors("A"), few_rows()
    _x, _y = _seen.q_cmd[:, 0], 1000 * _seen.error_rad[:, 0]
    show.curves(
        np.arange(19),
        {
            _name: np.array([held_out_rms(_x, _y, _fit, _test, _degree) for _degree in range(19)])
            for _name, _test in {"poses that were fitted": _fit, "poses held out": _seen.held_out}.items()
        },
        "degree",
        "RMS, mrad",
        log=True,
    )


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** Which degree would you use?
    """)


@app.cell
def _():
    degree = None
    return (degree,)


@app.cell(hide_code=True)
def _(check, degree):
    check.degree(degree)


@app.cell(hide_code=True)
def _(mo):
    mo.md("""## 4. Ask the tool\n\nCompare your five with what `armtwin.diagnose` says, and with how sure it is.""")


@app.cell(hide_code=True)
def _(mo):
    ask = mo.ui.run_button(label="diagnose all five (some seconds)")
    ask
    return (ask,)


@app.cell(hide_code=True)
def _(armtwin, ask, mo, recording):
    mo.stop(not ask.value)
    _found = {_name: armtwin.diagnose(recording(_name)) for _name in "ABCDE"}
    mo.ui.table(
        [
            {
                "recording": _name,
                "verdict": _one.verdict,
                "cause": ", ".join(_cause.active.label for _cause in _one.causes),
                "p": ", ".join(f"{_cause.p_value:.1e}" for _cause in _one.causes),
            }
            for _name, _one in _found.items()
        ],
        selection=None,
    )


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    A joint that sags under gravity and a servo with a curved error both give smooth residuals. In which recordings
    could you not tell them apart, however many poses you take? What would you change about the experiment: the poses,
    or something else?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
