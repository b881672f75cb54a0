"""`calibrate-camera`: from photographs to a camera file, or one line that says what is wrong with them."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from armtwin.models.camera import Camera
from armtwin.models.camera_files import read_camera, write_camera
from armtwin.models.errors import InputError
from armtwin.models.lenses import PlumbBob
from armtwin.scenarios.commands.calibrate_camera import calibrate_camera_command

CHESSBOARD = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "chessboard"
K = np.array([[600.0, 0.0, 322.0], [0.0, 600.0, 237.0], [0.0, 0.0, 1.0]])
TILTS = [(0.0, 0.1, 0.0), (0.5, 0.0, 0.1), (-0.5, 0.1, 0.0), (0.1, 0.5, -0.1), (0.0, -0.5, 0.2)]
needs_photographs = pytest.mark.skipif(not CHESSBOARD.is_dir(), reason="the shared chessboard photographs are absent")


def photograph(tilt: tuple[float, float, float], scale: int = 4) -> np.ndarray:
    """A board of 9x6 inner corners and 23 mm squares, 640x480, seen without distortion."""
    per_square = 40
    board = np.full((9 * per_square, 12 * per_square), 210, np.uint8)
    for row in range(7):
        for column in range(10):
            if (row + column) % 2 == 0:
                y, x = (row + 1) * per_square, (column + 1) * per_square
                board[y : y + per_square, x : x + per_square] = 40
    R, _ = cv2.Rodrigues(np.array(tilt))
    to_mm = np.array([[23 / per_square, 0, -138.0], [0, 23 / per_square, -103.5], [0, 0, 1.0]])
    H = K @ np.column_stack([R[:, 0], R[:, 1], [0.0, 0.0, 420.0]]) @ to_mm
    # Pixel centres of the enlarged picture lie half a fine pixel inside.
    finer = np.array([[scale, 0, (scale - 1) / 2], [0, scale, (scale - 1) / 2], [0, 0, 1.0]])
    size = (640 * scale, 480 * scale)
    fine = cv2.warpPerspective(board, finer @ H, size, flags=cv2.INTER_LINEAR, borderValue=210)
    return cv2.resize(fine, (640, 480), interpolation=cv2.INTER_AREA)


@pytest.fixture(scope="module")
def pictures() -> list[np.ndarray]:
    return [photograph(tilt) for tilt in TILTS]


@pytest.fixture
def folder(tmp_path, pictures) -> Path:
    views = tmp_path / "views"
    views.mkdir()
    for i, picture in enumerate(pictures):
        cv2.imwrite(str(views / f"view{i}.png"), picture)
    return views


def run(images: list[Path], out: Path, **options) -> None:
    calibrate_camera_command(images=images, out=out, **{"board": "9x6", "square_mm": 23.0} | options)


def test_the_camera_that_took_the_pictures_is_written(folder, tmp_path, capsys):
    run([folder], tmp_path / "camera.yaml")
    camera = read_camera(tmp_path / "camera.yaml")
    np.testing.assert_allclose(camera.K, K, atol=1.5)
    # The middle of the board, 4 squares and 2.5 squares from the first corner, stands 420 mm before the camera.
    middle = camera.R_board_camera @ [92.0, 57.5, 0.0] + camera.t_board_camera_mm
    np.testing.assert_allclose(middle, [0.0, 0.0, 420.0], atol=1.5)
    printed = capsys.readouterr().out
    for part in ("RMS", "fx px", "view4.png", "Coverage", "add more views"):
        assert part in printed


def test_the_file_tells_its_own_uncertainty(folder, tmp_path):
    run([folder], tmp_path / "camera.yml")
    head = (tmp_path / "camera.yml").read_text()
    assert "5 views of a board: 9x6 inner corners, squares of 23 mm" in head
    assert "#   fx: " in head


def test_the_report_is_one_page_that_needs_no_network(folder, tmp_path):
    cv2.imwrite(str(folder / "a <b>.png"), np.full((480, 640), 128, np.uint8))
    (folder / "view1.png").rename(folder / "view <i>.png")
    run([folder], tmp_path / "camera.yaml", report=tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert page.count("<figure>") == 5
    assert not re.search(r"<(script|link|img)[^>]+(src|href)=", page)
    assert "a &lt;b&gt;.png" in page  # names are escaped, in the text and in the figures
    assert "<b>.png" not in page
    assert "<i>.png" not in page


def test_a_picture_without_the_board_is_reported_and_left_out(folder, tmp_path, capsys):
    cv2.imwrite(str(folder / "wall.png"), np.full((480, 640), 128, np.uint8))
    run([folder], tmp_path / "camera.yaml")
    assert "board was not found: wall.png" in " ".join(capsys.readouterr().out.split())


def test_the_reference_view_gives_the_pose(folder, tmp_path):
    run([folder], tmp_path / "first.yaml")
    run([folder], tmp_path / "other.yaml", reference="view1.png")
    first, other = (read_camera(tmp_path / name).R_board_camera for name in ("first.yaml", "other.yaml"))
    turn, _ = cv2.Rodrigues(other @ first.T)
    expected, _ = cv2.Rodrigues(cv2.Rodrigues(np.array(TILTS[1]))[0] @ cv2.Rodrigues(np.array(TILTS[0]))[0].T)
    np.testing.assert_allclose(turn, expected, atol=0.02)


def test_the_same_name_in_two_folders_is_two_views(folder, tmp_path, pictures, capsys):
    (tmp_path / "more").mkdir()
    cv2.imwrite(str(tmp_path / "more" / "view0.png"), pictures[3])
    run([folder, tmp_path / "more"], tmp_path / "camera.yaml")
    assert "6 views" in capsys.readouterr().out


class TestMistakes:
    @pytest.fixture(autouse=True)
    def nothing_written(self, tmp_path):
        yield
        assert not (tmp_path / "camera.yaml").exists()
        assert not list(tmp_path.glob("**/*.part"))

    def refused(self, message: str, images: list[Path], out: Path, **options) -> None:
        with pytest.raises(InputError, match=message) as caught:
            run(images, out, **options)
        assert "\n" not in str(caught.value)

    def test_two_views_are_too_few(self, folder, tmp_path):
        self.refused("in 2 of 2 images, wanted at least 3", [folder / "view[01].png"], tmp_path / "camera.yaml")

    def test_views_without_a_board_are_named(self, folder, tmp_path):
        cv2.imwrite(str(folder / "view0.png"), np.full((480, 640), 128, np.uint8))
        images = [folder / "view[012].png"]
        self.refused(r"in 2 of 3 images, .* not in view0\.png", images, tmp_path / "camera.yaml")

    def test_squares_counted_for_corners_are_recognised(self, folder, tmp_path):
        self.refused("try --board 9x6", [folder], tmp_path / "camera.yaml", board="10x7")

    def test_a_miscounted_board_is_recognised(self, folder, tmp_path):
        self.refused("try --board 9x6", [folder], tmp_path / "camera.yaml", board="9x5")

    def test_images_of_two_sizes(self, folder, tmp_path, pictures):
        cv2.imwrite(str(folder / "view9.png"), pictures[0][:400])
        self.refused(r"view9\.png: found 640x400 px, wanted 640x480", [folder], tmp_path / "camera.yaml")

    def test_a_corrupt_image(self, folder, tmp_path):
        path = folder / "view2.png"
        path.write_bytes(path.read_bytes()[:1000])
        self.refused(r"view2\.png: found no image or a corrupt one", [folder], tmp_path / "camera.yaml")

    def test_a_missing_image(self, folder, tmp_path):
        self.refused(r"none\.png: found no image", [folder, folder / "none.png"], tmp_path / "camera.yaml")

    def test_one_view_again_and_again(self, folder, tmp_path, pictures):
        for i in range(5):
            cv2.imwrite(str(folder / f"view{i}.png"), photograph((0.0, 0.0, 0.0)))
        self.refused(r"tilted alike in all 5 views|do not determine the camera", [folder], tmp_path / "camera.yaml")

    def test_squares_in_metres(self, folder, tmp_path):
        self.refused("--square-mm: found 0.023", [folder], tmp_path / "camera.yaml", square_mm=0.023)

    def test_an_unknown_reference(self, folder, tmp_path):
        self.refused("did you mean 'view1.png'", [folder], tmp_path / "camera.yaml", reference="viev1.png")

    @pytest.mark.parametrize("out", ["camera.json", "views", "views/view0.png/camera.yaml"])
    def test_outputs_that_cannot_be_written(self, folder, tmp_path, out):
        self.refused("--out", [folder], tmp_path / out)

    def test_a_report_that_is_no_page_leaves_no_camera_either(self, folder, tmp_path):
        self.refused("--report", [folder], tmp_path / "camera.yaml", report=tmp_path / "report.pdf")


@needs_photographs
def test_the_photographs_match_the_published_camera_and_show_what_to_drop(tmp_path, capsys):
    out = tmp_path / "camera.yaml"
    run([CHESSBOARD], out, square_mm=25.0, window_px=11, model="plumb_bob")
    published = read_camera(CHESSBOARD / "published_intrinsics.yml")
    np.testing.assert_allclose(read_camera(out).K, published.K, atol=0.2)
    printed = " ".join(capsys.readouterr().out.split())
    for part in (
        "13 views",
        "RMS 0.409 px",
        "drop left02.jpg: 1.22 px",
        "drop left13.jpg",
        "passed over: published_intrinsics.yml is no photograph",
        "top left",
    ):
        assert part in printed


@needs_photographs
def test_by_itself_the_refinement_sees_one_corner_only_and_no_view_is_poor(tmp_path, capsys):
    run([CHESSBOARD], tmp_path / "camera.yaml", square_mm=25.0)
    printed = " ".join(capsys.readouterr().out.split())
    assert "13 views of 9x6 inner corners, plumb_bob, RMS 0.181 px" in printed
    assert "drop" not in printed


def test_known_intrinsics_are_kept_and_the_pose_comes_from_one_photograph(folder, tmp_path, capsys):
    known = Camera(640, 480, K, PlumbBob(np.zeros(5)), np.eye(3), np.zeros(3))
    write_camera(tmp_path / "known.yaml", known)
    run([folder / "view1.png"], tmp_path / "camera.yaml", intrinsics=tmp_path / "known.yaml")
    camera = read_camera(tmp_path / "camera.yaml")
    np.testing.assert_array_equal(camera.K, K)
    middle = camera.R_board_camera @ [92.0, 57.5, 0.0] + camera.t_board_camera_mm
    np.testing.assert_allclose(middle, [0.0, 0.0, 420.0], atol=0.3)
    assert "Pose from view1.png" in capsys.readouterr().out


def test_intrinsics_of_another_size_are_refused(folder, tmp_path):
    known = Camera(1280, 720, K, PlumbBob(np.zeros(5)), np.eye(3), np.zeros(3))
    write_camera(tmp_path / "known.yaml", known)
    with pytest.raises(InputError, match=r"found 640x480 px, wanted 1280x720 px as in --intrinsics"):
        run([folder / "view1.png"], tmp_path / "camera.yaml", intrinsics=tmp_path / "known.yaml")


@pytest.mark.parametrize(
    ("option", "value", "told"),
    [
        ("target", "chessbord", "did you mean 'chessboard'"),
        ("model", "fisheye", "found 'fisheye', wanted one of"),
    ],
)
def test_a_misspelt_option_is_refused_with_what_there_is(folder, tmp_path, option, value, told):
    with pytest.raises(InputError, match=told):
        run([folder], tmp_path / "camera.yaml", **{option: value})


def test_the_help_shows_an_example():
    app = typer.Typer()
    app.command()(calibrate_camera_command)
    printed = " ".join(CliRunner().invoke(app, ["--help"]).output.split())
    assert "armtwin calibrate-camera out/paper/board/*.png --square-mm 23 --out camera.yaml" in printed
