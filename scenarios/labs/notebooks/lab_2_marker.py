"""Lab 2 of armtwin: the marker."""

import marimo

app = marimo.App(app_title="Lab 2: the marker", width="medium")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    # Lab 2: the marker

    About 75 minutes. You need arrays in NumPy, the normal distribution and least squares.

    Where in a picture is the centre of a white disc? The paper's chain answers to about a pixel. The picture knows it
    to a hundredth. You will look at the chain stage by stage, write a better one in two small functions, and compute
    how well any detector could possibly do.

    Write where it says **Your turn**. The boxes below say what is right and what is not.
    """)


@app.cell(hide_code=True)
def _():
    import marimo as mo
    import numpy as np

    import armtwin
    from armtwin.scenarios.labs import show
    from armtwin.scenarios.labs.checks import marker as check
    from armtwin.scenarios.labs.material.marker import (
        LENGTHS_MM,
        MEASURED_MM,
        MM_PER_PX,
        figure_3,
        hough_centre,
        photographs,
        read_normals,
        rough_centre,
    )

    return (
        LENGTHS_MM,
        MEASURED_MM,
        MM_PER_PX,
        armtwin,
        check,
        figure_3,
        hough_centre,
        mo,
        np,
        photographs,
        read_normals,
        rough_centre,
        show,
    )


@app.cell
def _(armtwin, figure_3, mo, np, show):
    with armtwin.open_bench("simulated") as _bench:
        _bench.move(np.array([-0.05, 0.40, -0.35]))
        frame = _bench.capture().image
    mo.vstack(
        [
            mo.md("## 1. Figure 3, stage by stage\n\nWhat does each stage keep of an edge's place, what does it lose?"),
            mo.ui.tabs({_name: mo.image(show.photograph(_stage)) for _name, _stage in figure_3(frame).items()}),
        ]
    )
    return (frame,)


@app.cell(hide_code=True)
def _(hough_centre, mo, np, photographs, show):
    _off = np.array([hough_centre(_one.image) - _one.centre for _one in photographs()])
    hough_rms = float(np.sqrt(np.nanmean(_off**2)))
    mo.vstack(
        [
            mo.md(
                f"On 60 small pictures of one disc, whose centres are known, the paper's chain is off by "
                f"**{hough_rms:.2f} px** RMS. One of them:"
            ),
            mo.image(show.photograph(np.kron(photographs()[0].image, np.ones((4, 4), np.uint8))), width=288),
        ]
    )
    return (hough_rms,)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 2. An edge between samples

    Along a line from inside the disc outwards the grey level falls from the face's to the ground's over a few pixels:
    """)


@app.cell(hide_code=True)
def _(photographs, read_normals, rough_centre, show):
    _grey, _x, _ = read_normals(photographs()[0].image, rough_centre(photographs()[0].image))
    show.curves(_x, {"a normal": _grey[0], "another": _grey[20]}, "distance outwards, px", "grey level")


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    **Your turn.** Return the place of the edge, a number between the samples, for distances `x` (S,) and levels `grey`
    (S,). One way: the differences of neighbouring levels say how steep it is between them; their centre of gravity is
    the edge. Mind where between two samples a difference belongs, and what noise far from the edge does.
    """)


@app.cell
def _(np):
    def edge_position(x, grey):
        return None

    return (edge_position,)


@app.cell(hide_code=True)
def _(check, edge_position):
    check.edge(edge_position)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 3. A circle through the edge points

    **Your turn.** Return the centre `(2,)` of the circle through `(N, 2)` points, by least squares. A circle
    $u^2 + v^2 = 2 a u + 2 b v + c$ is linear in $a, b, c$.
    """)


@app.cell
def _(np):
    def centre_of(points):
        return None

    return (centre_of,)


@app.cell(hide_code=True)
def _(centre_of, check):
    check.circle(centre_of)


@app.cell(hide_code=True)
def _(centre_of, check, edge_position):
    check.chain(edge_position, centre_of)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 4. How well could anyone do?

    Move the disc by a little in u: the picture changes by $g(n)\cos t$ at the distance n from the edge and the angle t
    on the outline, where g is a Gaussian of standard deviation s (the blur) whose area is the contrast C. With white
    noise of standard deviation σ a pixel, the Fisher information about u is the integral of
    $(g \cos t)^2 / \sigma^2$ over the picture, and no unbiased detector has a smaller standard deviation than one over
    its root.

    **Your turn.** Return that bound in px.
    """)


@app.cell
def _(np):
    def bound_px(radius_px, contrast, blur_px, noise):
        return None

    return (bound_px,)


@app.cell(hide_code=True)
def _(bound_px, check):
    check.bound(bound_px)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## 5. Table 3

    The paper measured gauges of known length in the same way:
    """)


@app.cell(hide_code=True)
def _(LENGTHS_MM, MEASURED_MM, mo):
    mo.ui.table(
        [
            {"length, mm": _true, "measured, mm": _seen, "too long by, mm": round(_seen - _true, 4)}
            for _true, _seen in zip(LENGTHS_MM.tolist(), MEASURED_MM.tolist(), strict=True)
        ],
        selection=None,
    )


@app.cell(hide_code=True)
def _(MM_PER_PX, mo):
    mo.md(rf"""
    A pixel is about {MM_PER_PX} mm in the arm's plane. **Your turn.** Is it a wrong scale, or edges that are seen in
    the wrong place? Say how far outwards each edge seems to lie, in pixels.
    """)


@app.cell
def _(LENGTHS_MM, MEASURED_MM, MM_PER_PX, np):
    edge_shift_px = None
    return (edge_shift_px,)


@app.cell(hide_code=True)
def _(check, edge_shift_px):
    check.table_3(edge_shift_px)


@app.cell(hide_code=True)
def _(mo):
    mo.md(r"""
    ## To think about

    An edge that lies a third of a pixel outwards makes every gauge 0.2 mm too long. What does it do to the centre of a
    disc? When would it harm the calibration of the arm after all?

    *Write your answer here, in a few sentences.*
    """)


if __name__ == "__main__":
    app.run()
