"""Lab 1 of armtwin: the lens."""

import marimo

app = marimo.App(app_title="Lab 1: the lens", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 1: the lens

    About 60 minutes. You need arrays in NumPy and the pinhole camera from a lecture.

    A webcam watches an arm, and everything that this project ever knows of the arm goes through its lens. You will
    write down what the lens does to a ray of light, find where the formula of the paper stops being a lens, and
    calibrate a camera from photographs of a chessboard. One set of photographs will turn out to be useless.

    Write where it says **Your turn**. The boxes below say what is right and what is not; everything runs again by
    itself when you change a cell.
    """)


@app.cell(hide_code=True)
def _():
    import cv2
    import marimo as mo
    import numpy as np

    import armtwin
    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import lens as check
    from armtwin.scenarios.labs.material.lens import TABLE_2, board_mm, views

    return TABLE_2, armtwin, board_mm, check, cv2, mo, np, show, views


@app.cell
def _(armtwin, mo, np, show):
    with armtwin.open_bench("simulated") as _bench:
        _bench.move(np.array([0.2, 0.2, -0.4]))
        _frame = _bench.capture()
        K = _bench.description.camera.K
    mo.vstack(
        [
            mo.image(show.photograph(_frame.image)),
            mo.md(f"What the webcam of Table 2 sees, and its matrix K: `{K.tolist()}`"),
        ]
    )
    return (K,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 1. The pinhole

    A point at $(X, Y, Z)$ in camera axes (x right, y down, z forward, mm) is seen at

    $$u = f_x \frac{X}{Z} + c_x, \qquad v = f_y \frac{Y}{Z} + c_y.$$

    **Your turn.** Return the `(N, 2)` pixels of `(N, 3)` points.
    """)


@app.cell
def _(np):
    def pinhole(X, K):
        return None

    return (pinhole,)


@app.cell(hide_code=True)
def _(check, pinhole):
    check.pinhole(pinhole)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. The lens: equation 15

    Before the camera matrix comes the lens. With $x = X/Z$, $y = Y/Z$ and $r^2 = x^2 + y^2$ the paper prints

    $$x_q = (1 + k_1 r^2 + k_2 r^4 + k_3 r^6)\, x + 2 p_1 x y + p_2 (r^2 + 2 x^2)$$

    $$y_q = (1 + k_1 r^2 + k_2 r^4 + k_3 r^6)\, y + p_1 (r^2 + 2 x^2) + 2 p_2 x y$$

    One symbol of it is a misprint. A lens does not know which way is up, so exchanging the two axes must exchange the
    two rows (and $p_1$ with $p_2$).

    **Your turn.** Return the `(N, 2)` distorted places of `(N, 2)` undistorted ones, with the misprint mended.
    """)


@app.cell
def _(np):
    def distort(points, k1, k2, k3, p1, p2):
        return None

    return (distort,)


@app.cell(hide_code=True)
def _(check, distort):
    bends = check.distort(distort)
    bends
    return (bends,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. Where the polynomial stops being a lens

    Follow a ray that leaves the axis further and further. Table 2's numbers, without the tangential part:
    """)


@app.cell(hide_code=True)
def _(TABLE_2, bends, distort, mo, np, show):
    _r = np.linspace(0, 0.9, 400)
    _radial = {**TABLE_2, "p1": 0.0, "p2": 0.0}
    mo.stop(not bends.passed, mo.md("*The curve is drawn when `distort` is right.*"))
    _bent = distort(np.stack([_r, 0 * _r], axis=-1), **_radial)
    show.curves(
        _r, {"with the lens": np.asarray(_bent)[:, 0], "without": _r}, "radius of the ray", "radius in the picture"
    )


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** At which radius of the ray does the curve turn back? Three digits, from the polynomial rather than
    from the picture.
    """)


@app.cell
def _(TABLE_2, np):
    fold_radius = None
    return (fold_radius,)


@app.cell(hide_code=True)
def _(check, fold_radius):
    check.fold(fold_radius)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 4. Calibrating from boards

    `views(tilted=True)` are twelve photographs of the paper's board (6 by 9 inner corners, 23 mm), each already reduced
    to the `(54, 2)` pixels of its corners; `board_mm()` are the same corners on the board, `(54, 3)`, mm. In
    `views(tilted=False)` the board was held square to the view each time, nearer and farther.

    `cv2.calibrateCameraExtended(boards, corners, (width, height), None, None)` takes lists of float32 arrays and
    returns `rms, K, D, rvecs, tvecs, std_intrinsics, …`; the first of `std_intrinsics` is that of $f_x$. The picture is
    1280 by 720.

    **Your turn.** What is $f_x$ from the tilted boards, and what from the boards held square? Look at the standard
    deviations too.
    """)


@app.cell
def _(board_mm, cv2, np, views):
    fx_px = None
    return (fx_px,)


@app.cell(hide_code=True)
def _(check, fx_px):
    check.focal_length(fx_px)


@app.cell
def _(board_mm, cv2, np, views):
    fx_square_px = None
    return (fx_square_px,)


@app.cell(hide_code=True)
def _(check, fx_square_px):
    check.square(fx_square_px)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    The corner of the picture lies at a radius of about 0.52. Say that no corner of any board was ever seen beyond 0.35.
    What does the calibration say about the lens at the corner of the picture, and how would you find out how wrong it
    is there, with a board and no other tool?

    And: from the boards held square OpenCV finds a focal length that is wrong by hundreds of its own standard
    deviations, with residuals as small as the others'. What does a standard deviation promise, and what not?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
