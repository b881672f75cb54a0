"""Lab 3 of armtwin: the arm and its inverse."""

import marimo

app = marimo.App(app_title="Lab 3: the arm", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 3: the arm and its inverse

    About 75 minutes. You need homogeneous transforms and Denavit–Hartenberg parameters from a lecture.

    You will write the arm of the paper, first forwards, then backwards, and close the loop: the forward kinematics of
    the inverse must give back what was asked for. With the formulas as they are printed it does not. One sign is wrong,
    and nobody had closed the loop.

    Write where it says **Your turn**. The boxes below say what is right and what is not.
    """)


@app.cell(hide_code=True)
def _():
    import marimo as mo
    import numpy as np

    import armtwin
    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import arm as check

    L1, L2, L4, L5 = 120.0, 121.7, 38.0, 6.73  # Table 1, mm
    return L1, L2, L4, L5, armtwin, check, mo, np, show


@app.cell
def _(armtwin, mo, np, show):
    sliders = mo.ui.array(
        [
            mo.ui.slider(-90, 90, 1, value=_v, label=f"θ{_k + 1}, °", show_value=True)
            for _k, _v in enumerate((4, 16, -20))
        ]
    )
    bench = armtwin.open_bench("simulated")
    bench.connect()
    mo.vstack([mo.md("## The arm\n\nMove it, and look at which way each joint turns and where zero is."), *sliders])
    return bench, sliders


@app.cell(hide_code=True)
def _(bench, mo, np, show, sliders):
    bench.move(np.radians(sliders.value))
    mo.image(show.photograph(bench.capture().image))


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 1. One row of a D-H table

    Equation 1: $T(z, \theta)\, T(z, d)\, T(x, a)\, T(x, \alpha)$, rotation about z, shift along z, shift along x,
    rotation about x.

    **Your turn.** Return the `(4, 4)` transform, angles in radians, lengths in mm.
    """)


@app.cell
def _(np):
    def dh(theta, d, a, alpha):
        return None

    return (dh,)


@app.cell(hide_code=True)
def _(check, dh):
    check.dh(dh)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. Forwards

    Table 1: B is at $a = l_1$, $\theta_1 + \pi/2$; C at $a = l_2$, $\theta_2 + \pi/2$; E at $a = l_4$,
    $\theta_3 + \pi/2$; F at $a = l_5$, $-\pi/2$; every $\alpha$ and $d$ is 0. The orientation of the tip is
    $\theta_F = \theta_1 + \theta_2 + \theta_3 + \pi$ (equation 4).

    **Your turn.** Return `(N, 3)`: x and y of F in mm, and $\theta_F$ in rad, for `(N, 3)` joint angles. Multiply your
    transforms, or add up four complex numbers.
    """)


@app.cell
def _(L1, L2, L4, L5, dh, np):
    def forward(q):
        return None

    return (forward,)


@app.cell(hide_code=True)
def _(check, forward):
    forwards = check.forward(forward)
    forwards
    return (forwards,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. Backwards, as printed

    Equations 5 to 9 of the paper, word for word:
    """)


@app.cell
def _(L1, L2, L4, L5, np):
    def printed_inverse(poses):
        x, y, theta_F = poses.T
        Cx = x - L4 * np.sin(theta_F - np.pi) + L5 * np.cos(theta_F - np.pi)  # (5)
        Cy = y + L4 * np.cos(theta_F - np.pi) + L5 * np.sin(theta_F - np.pi)  # (6)
        theta2 = -np.arcsin((Cx**2 + Cy**2 - L1**2 - L2**2) / (2 * L1 * L2))  # (7)
        s2, c2 = np.sin(theta2), np.cos(theta2)
        theta1 = -np.arctan((Cy * L2 * c2 - Cx * (L2 * s2 - L1)) / (Cx * L2 * c2 + Cy * (L2 * s2 - L1)))  # (8)
        theta3 = theta_F - theta1 - theta2 - np.pi  # (9)
        return np.stack([theta1, theta2, theta3], axis=-1)

    _turn = np.arange(50) * 2 * np.pi / 50
    circle = np.stack([-130 + 15 * np.cos(_turn), 40 + 15 * np.sin(_turn), np.full(50, np.pi)], axis=-1)
    return circle, printed_inverse


@app.cell(hide_code=True)
def _(circle, forward, forwards, mo, np, printed_inverse, show):
    mo.stop(not forwards.passed, mo.md("*The loop is drawn when `forward` is right.*"))
    _came = np.asarray(forward(printed_inverse(circle)))[:, :2]
    show.arrows(circle[:, :2], _came - circle[:, :2], 1.0, "from where the tip was sent to where it came")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** How far does FK(IK(p)) miss p on this circle at worst, in mm?
    """)


@app.cell
def _(circle, forward, np, printed_inverse):
    worst_mm = None
    return (worst_mm,)


@app.cell(hide_code=True)
def _(check, worst_mm):
    check.printed(worst_mm)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 4. Backwards, mended

    $\theta_2$ comes from the triangle A, B, C alone and is right. Write C as a function of $\theta_1$ and $\theta_2$
    (equations 2 and 3 without the last link), solve for $\cos\theta_1$ and $\sin\theta_1$, and let `np.arctan2` find
    the quadrant.

    **Your turn.** Return `(N, 3)` joint angles for `(N, 3)` poses x, y, θ_F.
    """)


@app.cell
def _(L1, L2, L4, L5, np):
    def inverse(poses):
        return None

    return (inverse,)


@app.cell(hide_code=True)
def _(check, inverse):
    check.inverse(inverse)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 5. Branches and reach

    **Your turn.** Return both joint solutions, `(2, 3)`, of one pose `(3,)`. And say how near to A and how far from it
    the joint C can be, as a pair in mm, if every joint turns all the way round.
    """)


@app.cell
def _(L1, L2, L4, L5, np):
    def branches(pose):
        return None

    return (branches,)


@app.cell(hide_code=True)
def _(branches, check):
    check.branches(branches)


@app.cell
def _(L1, L2):
    reach_mm = None
    return (reach_mm,)


@app.cell(hide_code=True)
def _(check, reach_mm):
    check.reach(reach_mm)


@app.cell(hide_code=True)
def _(L1, L2, bench, mo, np, show):
    _limits = bench.description.limits
    _q = np.random.default_rng(0).uniform(_limits.min_rad, _limits.max_rad, (4000, 3))[:, :2]
    _a = np.cumsum(_q + np.pi / 2, axis=1)
    _C = L1 * np.exp(1j * _a[:, 0]) + L2 * np.exp(1j * _a[:, 1])
    _fig = show.curves(_C.real, {"C within the servos' ±90°": _C.imag}, "x, mm", "y, mm", marks=True)
    _fig.update_traces(marker={"size": 3})
    _fig.update_yaxes(scaleanchor="x")
    mo.vstack([_fig])


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    Of the two branches of the circles' centre, which can the servos go to? The paper's authors ran their arm with
    printed formulas that miss by centimetres. What may their program have had that their paper has not, and which
    test of five lines would have found it before print?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
