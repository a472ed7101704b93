"""Pictures and poses that contradict one another: all of them, or single views."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from facetlog.errors import InconsistentViewsError
from facetlog.perception.detection.edge_maps import edge_map
from facetlog.perception.detection.line_front_end.faces_from_lines import (
    Pictures,
    prepare_pictures,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_cloud import (
    SUPPORTED,
    LineCloud,
    find_shown_lines,
)
from facetlog.perception.detection.line_front_end.segments_3d.line_support import coverage
from facetlog.perception.detection.line_front_end.segments_3d.pose_consistency import (
    check_consistency,
    measure_share_explained,
)
from facetlog.perception.detection.line_front_end.segments_3d.view_judgement import (
    Contradiction,
    find_contradicting_views,
    track_without,
)
from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.detection.tracked_faces import TrackedFaces
from facetlog.perception.step_clock import StepClock
from facetlog.perception.types import Image, Pose, View
from facetlog.pipeline import render_simulated_views
from facetlog.robot.rendering.views import shuffled
from tests.perception.detection.line_front_end.block_rig import block_rig

NO_SEGMENTS = np.zeros((0, 2, 3))
ALL = np.ones(len(block_rig().views))


def test_a_blocks_edges_explain_its_pictures() -> None:
    rig = block_rig()
    found = [detect_segments(v.image) for v in rig.views]
    assert measure_share_explained(rig.edges, rig.shown_edges, rig.views, found) > 0.8
    check_consistency(rig.edges, rig.shown_edges, ALL, rig.views, found)


def test_wrong_poses_explain_little_and_are_reported() -> None:
    rig = block_rig()
    found = [detect_segments(v.image) for v in rig.views]
    views = shuffled(rig.views, np.random.default_rng(0))
    everywhere = np.ones_like(rig.shown_edges)
    assert measure_share_explained(rig.edges, everywhere, views, found) < 0.2
    with pytest.raises(InconsistentViewsError, match="10 views"):
        check_consistency(rig.edges, everywhere, ALL, views, found)


def test_views_that_agree_with_no_other_are_named_first() -> None:
    rig = block_rig()
    found = [detect_segments(v.image) for v in rig.views]
    shown = rig.shown_edges.copy()
    shown[:, 2:] = False
    names = ", ".join(v.name for v in rig.views[2:5])
    with pytest.raises(InconsistentViewsError, match=f"least in {names} and 5 more; check"):
        check_consistency(rig.edges, shown, ALL, rig.views, found)


def test_a_few_views_are_never_called_inconsistent() -> None:
    rig = block_rig()
    few = rig.views[:4]
    found = [detect_segments(v.image) for v in few]
    check_consistency(NO_SEGMENTS, np.zeros((0, 4), np.bool_), ALL[:4], few, found)


RIG = block_rig()


def judged(views: Sequence[View], most: int | None = None) -> tuple[Contradiction, ...]:
    """Return the contradictions, of each view's segments the `most` longest."""
    found = [detect_segments(v.image)[:most] for v in views]
    maps = [edge_map(v.image) for v in views]
    use = np.nan_to_num(coverage(RIG.edges, views, maps)) > SUPPORTED
    weight = np.ones(len(views))
    return find_contradicting_views(RIG.edges, use, weight, views, maps, found, lambda _: RIG.edges)


def turned(view: View, degrees: float) -> View:
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array([0.6, 0.8, 0.0])).as_matrix()
    return replace(view, pose=Pose(view.pose.rotation @ turn, view.pose.centre))


def with_view(k: int, view: View) -> tuple[View, ...]:
    return (*RIG.views[:k], view, *RIG.views[k + 1 :])


def test_right_views_do_not_contradict_each_other() -> None:
    assert judged(RIG.views) == ()


@pytest.mark.parametrize(("k", "degrees"), [(0, 3.0), (9, 180.0)])
def test_a_gross_pose_is_found_with_what_little_it_explains(k: int, degrees: float) -> None:
    (wrong,) = judged(with_view(k, turned(RIG.views[k], degrees)))
    assert wrong.view == k
    assert wrong.explained < 0.3 < 0.7 < wrong.usual


def test_the_picture_of_another_pose_is_found() -> None:
    (wrong,) = judged(with_view(2, replace(RIG.views[2], image=RIG.views[6].image)))
    assert wrong.view == 2


def test_a_right_view_with_many_edges_of_its_own_is_no_contradiction() -> None:
    image = RIG.views[3].image.copy()
    for row in range(6, 60, 6):
        cv2.line(image, (0, row), (319, row + row % 4), 90, 2)
    assert judged(with_view(3, replace(RIG.views[3], image=image))) == ()


def test_what_the_rest_shows_comes_with_the_numbers_of_the_views_used() -> None:
    handed: list[Sequence[int]] = []

    def track(kept: Sequence[int]) -> TrackedFaces:
        handed.append(kept)
        # Of the rest one more is left out, the third.
        return TrackedFaces((), (), (0.5,) * 4, warnings=("of the rest",), used=(0, 1, 3, 4))

    views = RIG.views[:6]
    tracked = track_without([Contradiction(2, 0.04, 0.9)], views, track)
    assert handed == [[0, 1, 3, 4, 5]]
    assert tracked.used == (0, 1, 4, 5)
    assert tracked.weight == (0.5,) * 4
    first, last = tracked.warnings
    assert first.startswith(f"{views[2].name}: ")
    assert "4% of its straight edges" in first
    assert "usual are 90%" in first
    assert last == "of the rest"


@pytest.fixture(scope="module")
def tour() -> Pictures:
    """Ten views of a table, looked at."""
    views = render_simulated_views("table", 1, progress=None, clock=StepClock()).views[:20:2]
    return prepare_pictures(views, StepClock())


def foreign_picture(kind: str, shape: tuple[int, int]) -> Image:
    image = np.full(shape, 128, np.uint8)
    rng = np.random.default_rng(3)
    if kind == "chair":
        (view,) = render_simulated_views("chair", 2, progress=None, clock=StepClock()).views[:1]
        image = cv2.resize(view.image, shape[::-1])
    else:
        for _ in range(40):
            ring = rng.integers(0, shape[::-1], (4, 2)).astype(np.int32)
            cv2.fillPoly(image, [ring], int(rng.integers(0, 255)))
    return image


def named(pictures: Pictures) -> list[int]:
    def lines(kept: Sequence[int]) -> tuple[LineCloud, NDArray[np.bool_]]:
        own = pictures.select(kept)
        return find_shown_lines(own.views, own.maps, own.segments)

    views = pictures.views
    cloud, use = lines(range(len(views)))
    found = find_contradicting_views(
        cloud.segments,
        use,
        np.ones(len(views)),
        views,
        pictures.maps,
        pictures.segments,
        lambda kept: lines(kept)[0].segments,
    )
    return [wrong.view for wrong in found]


@pytest.mark.parametrize("kind", ["chair", "polygons"])
@pytest.mark.slow
def test_a_foreign_picture_is_named_though_it_helps_to_find_lines(
    tour: Pictures, kind: str
) -> None:
    assert named(tour) == []
    k = 3
    image = foreign_picture(kind, tour.views[k].image.shape)
    other = prepare_pictures([replace(tour.views[k], image=image)], StepClock())
    kept = [j for j in range(len(tour.views)) if j != k]
    assert named(tour.select(kept).extend_by(other)) == [len(kept)]
