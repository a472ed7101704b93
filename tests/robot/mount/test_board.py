"""Boards in rendered pictures: corners where they are."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.errors import InputError
from facetlog.perception.types import FloatArray, Image, Pose
from facetlog.robot.camera.optics import Optics
from facetlog.robot.mount.board import Board, undistort_pixels
from facetlog.robot.tour import tour_camera

CAMERA = tour_camera()
CHARUCO = Board(7, 5, 0.05, 0.037)
TURN = Rotation.from_rotvec([0.3, -0.4, 0.1]).as_matrix()
SHIFT = np.array([-0.15, -0.1, 0.9])
# Sharp prints, drawn once.
PRINTS: dict[Board, Image] = {}


def _shown(board: Board) -> Image:
    return seen_by(board, Pose(np.eye(3), np.zeros(3)), Pose(TURN, SHIFT))


def seen_by(board: Board, camera: Pose, place: Pose) -> Image:
    """The printed board on a grey wall, at `place`, as the tour's camera at `camera` sees it."""
    if board not in PRINTS:
        PRINTS[board] = np.asarray(cv2.GaussianBlur(board.picture(), (0, 0), 1.5), dtype=np.uint8)
    picture = PRINTS[board]
    turn = camera.rotation.T @ place.rotation
    shift = camera.rotation.T @ (place.centre - camera.centre)
    scale = board.square * board.across / picture.shape[1]
    # Its upper left pixel reaches from the board's corner on: its middle is half a pixel in.
    board_from_print = np.array([[scale, 0, scale / 2], [0, scale, scale / 2], [0, 0, 1]])
    plane = CAMERA.matrix @ np.column_stack([turn[:, 0], turn[:, 1], shift])
    size = (CAMERA.width, CAMERA.height)
    shown = cv2.warpPerspective(picture, plane @ board_from_print, size, borderValue=(128,))
    return np.asarray(shown, dtype=np.uint8)


def _projected(points: FloatArray) -> FloatArray:
    x, y, z = TURN @ points.T + SHIFT[:, None]
    return np.stack([CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy], axis=1)


def test_corners_are_found_where_they_are() -> None:
    found = CHARUCO.corners(_shown(CHARUCO))
    assert found is not None
    assert len(found.points) == 6 * 4
    off = np.linalg.norm(found.pixels - _projected(found.points), axis=1)
    assert off.max() < 0.3


def test_a_charuco_board_is_known_by_a_part_of_it() -> None:
    image = _shown(CHARUCO).copy()
    whole = CHARUCO.corners(image)
    assert whole is not None
    image[:, : round(float(np.median(whole.pixels[:, 0])))] = 128
    part = CHARUCO.corners(image)
    assert part is not None
    assert len(part.points) < len(whole.points)
    assert np.linalg.norm(part.pixels - _projected(part.points), axis=1).max() < 0.5


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        ((2, 5, 0.05, 0.03), "too small"),
        ((7, 5, 0.05, 0.05), "markers are smaller"),
        ((7, 5, 0.05, 0.0), "both above 0"),
    ],
)
def test_boards_that_cannot_serve_are_refused(
    sizes: tuple[int, int, float, float], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        Board(*sizes)


@pytest.mark.parametrize(
    "optics",
    [
        Optics(CAMERA, "OPENCV", (("k1", -0.2), ("k2", 0.05), ("p1", 0.001), ("k3", 0.01))),
        Optics(CAMERA, "OPENCV_FISHEYE", (("k1", 0.05), ("k2", -0.01))),
    ],
)
def test_distortion_is_taken_out(optics: Optics) -> None:
    points = np.array([[0.1, 0.2, 1.0], [-0.3, 0.1, 1.2], [0.2, -0.25, 0.9]])
    ideal = np.stack(
        [
            CAMERA.fx * points[:, 0] / points[:, 2] + CAMERA.cx,
            CAMERA.fy * points[:, 1] / points[:, 2] + CAMERA.cy,
        ],
        axis=1,
    )
    if optics.model == "OPENCV":
        bent = np.array([-0.2, 0.05, 0.001, 0.0, 0.01])
        seen, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), CAMERA.matrix, bent)
    else:
        bent = np.array([0.05, -0.01, 0.0, 0.0])
        seen, _ = cv2.fisheye.projectPoints(
            points.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), CAMERA.matrix, bent
        )
    np.testing.assert_allclose(undistort_pixels(optics, seen.reshape(-1, 2)), ideal, atol=0.02)
