"""When and where the runs of a collection began, and where pictures placed their robot since."""

from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.robot.collecting.run_sessions import runs_of
from facetlog.robot.pose2 import Pose2

FOLDER = Path("views")


def _run(began: float, *start: float) -> dict[str, object]:
    return {"schema": "facetlog-collect/1", "began": began, "start": list(start)}


def _placed(since: float, *start: float) -> dict[str, object]:
    return {"result": "placed", "since": since, "start": list(start)}


def test_odometry_counts_from_where_pictures_placed_the_robot_last() -> None:
    lines = [
        _run(10.0, 1.0, 2.0, 0.0),
        {"result": "taken", "view": 1},
        _placed(20.0, 1.1, 2.0, 90.0),
        _run(30.0, 5.0, 5.0, 0.0),
        _placed(40.0, 5.0, 5.5, 0.0),
    ]
    first, second = runs_of(lines, FOLDER)
    driven = Pose2(1.0, 0.0, 0.0)
    assert first.place(driven, 10.0) == Pose2(2.0, 2.0, 0.0)
    assert first.place(driven, 20.0) == Pose2(2.0, 2.0, 0.0)
    there = first.place(driven, 20.1)
    assert (there.x, there.y) == pytest.approx((1.1, 3.0))
    assert second.place(driven, 35.0) == Pose2(6.0, 5.0, 0.0)
    assert second.place(driven, 45.0) == Pose2(6.0, 5.5, 0.0)
    # A clock that was put back moves nothing.
    assert second.place(driven, 1.0) == Pose2(6.0, 5.0, 0.0)


@pytest.mark.parametrize("line", [{"schema": "x"}, {"schema": "x", "start": [1.0, 2.0]}])
def test_a_run_without_a_start_is_refused(line: dict[str, object]) -> None:
    with pytest.raises(InputError, match="does not say where a run began"):
        runs_of([line], FOLDER)
