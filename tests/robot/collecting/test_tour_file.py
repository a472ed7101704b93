"""Tours from CSV files, and the paper's."""

from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import CalibrationError, InputError
from facetlog.perception.pan_tilt import pan_tilt_pose
from facetlog.robot.collecting.tour_file import Tour, TourView, make_paper_tour, read_tour
from facetlog.robot.rendering.worlds import BLOCK_CENTRE, INCH
from facetlog.robot.tour import make_pose_looking_at

HEADER = "image,x,y,z,pan_deg,tilt_deg,skew_deg\n"


def _written(folder: Path, text: str) -> Path:
    path = folder / "tour.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_papers_tour_looks_at_the_block_in_metres() -> None:
    tour = make_paper_tour()
    assert len(tour.views) == 24
    np.testing.assert_allclose(tour.views[0].pose.centre, [9 * INCH, 14 * INCH, 28.5 * INCH])
    assert tour.target is not None
    off = tour.target[:2] - np.array(BLOCK_CENTRE) * INCH
    assert np.hypot(*off) < 0.03
    assert not any(view.skewed for view in tour.views)


def test_poses_are_read_in_the_unit_that_is_reported(tmp_path: Path) -> None:
    path = _written(tmp_path, HEADER + "# a remark\na.jpg,10,20,30,45,-100,3\n\n,1,2,3,0,-90,\n")
    tour = read_tour(path, unit=0.01)
    assert [view.name for view in tour.views] == ["a.png", "view002.png"]
    wanted = pan_tilt_pose(0.1, 0.2, 0.3, *np.radians([45, -100, 3]))
    np.testing.assert_allclose(tour.views[0].pose.rotation, wanted.rotation, atol=1e-12)
    np.testing.assert_allclose(tour.views[0].pose.centre, wanted.centre)
    assert [view.skewed for view in tour.views] == [True, False]


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("image,x,y\na,1,2\n", InputError, r":1: no column z, pan_deg, tilt_deg"),
        (HEADER + "a.png,1,2,3,0,-90\n", InputError, r":2: 6 fields, the first line has 7"),
        (HEADER + "a.png,1,2,x,0,-90,0\n", CalibrationError, r":2: z is 'x': give a finite"),
        (HEADER + "a.png,1,2,3,nan,-90,0\n", CalibrationError, r":2: pan_deg is 'nan'"),
        (HEADER + "a.png,1,2,3,0,-90,0\na.jpg,1,2,3,0,-90,0\n", InputError, r":3: .* in line 2"),
        (HEADER, InputError, "has no poses"),
        ("", InputError, "has no poses"),
    ],
)
def test_errors_name_their_line(
    tmp_path: Path, text: str, kind: type[Exception], said: str
) -> None:
    with pytest.raises(kind, match=said):
        read_tour(_written(tmp_path, text), unit=1.0)


def test_the_target_is_where_lines_of_sight_cross() -> None:
    point = np.array([0.3, 0.4, 0.2])
    eyes = [(1.5, 0.0, 0.7), (0.0, 2.0, 0.6), (-1.0, -1.0, 0.8)]
    tour = Tour(
        "t", tuple(TourView(f"{i}.png", make_pose_looking_at(e, point)) for i, e in enumerate(eyes))
    )
    assert tour.target is not None
    np.testing.assert_allclose(tour.target, point, atol=1e-9)


def test_a_missing_unit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="give --unit"):
        read_tour(_written(tmp_path, HEADER + "a,1,2,3,0,-90,0\n"))
