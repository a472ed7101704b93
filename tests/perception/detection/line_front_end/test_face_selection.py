"""Which outlines are faces: judged by rendered views, and against one another."""

import numpy as np

from facetlog.perception.detection.edge_maps import EdgeMap
from facetlog.perception.detection.line_front_end.face_selection import select_faces
from facetlog.perception.detection.line_front_end.outline_search import Outline
from facetlog.perception.detection.view_graph import view_graph
from facetlog.perception.types import FloatArray
from tests.perception.detection.line_front_end.block_rig import CAMERA, Rig, block_rig


def outline(corners: FloatArray, worth: float | None = None) -> Outline:
    """An outline (k, 3) that was covered in full."""
    length = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    return Outline(
        corners,
        tuple(range(len(corners))),
        np.ones(len(corners)),
        float(length.sum()) if worth is None else worth,
        normal / np.linalg.norm(normal),
    )


def true_outlines(rig: Rig) -> list[Outline]:
    return [outline(rig.points[list(face)]) for face in rig.solid.faces]


def top_of(rig: Rig) -> FloatArray:
    (top,) = (f for f in rig.solid.faces if (rig.points[list(f), 2] > 5.9).all())
    return rig.points[list(top)]


def selected(rig: Rig, outlines: list[Outline], maps: tuple[EdgeMap, ...] | None = None):
    return select_faces(outlines, rig.views, maps or rig.maps, view_graph(rig.views), rig.pixel)


def edges_everywhere(rig: Rig) -> tuple[EdgeMap, ...]:
    """Maps in which every view shows every outline: only geometry can decide."""
    size = (CAMERA.height, CAMERA.width)
    nothing = np.zeros(size, np.float32)
    full = np.full(size, 0xFFFF, np.uint16)
    return tuple(EdgeMap(nothing, nothing, 1.0, full, 2.0) for _ in rig.views)


def test_the_five_faces_that_views_see_are_selected() -> None:
    rig = block_rig()
    faces = selected(rig, true_outlines(rig))
    heights = sorted(float(f.corners[:, 2].mean()) for f in faces)
    np.testing.assert_allclose(heights, [3, 3, 3, 3, 6], atol=1e-9)
    assert all(f.support > 0.9 for f in faces)


def test_faces_run_counter_clockwise_seen_from_outside() -> None:
    rig = block_rig()
    clockwise = [outline(o.corners[::-1]) for o in true_outlines(rig)]
    middle = rig.points.mean(axis=0)
    for face in selected(rig, clockwise):
        newell = np.cross(face.corners, np.roll(face.corners, -1, axis=0)).sum(axis=0)
        assert face.normal @ newell > 0
        assert face.normal @ (face.corners.mean(axis=0) - middle) > 0


def test_turning_an_outline_round_keeps_each_side_on_its_line() -> None:
    rig = block_rig()
    for face in selected(rig, [outline(o.corners[::-1]) for o in true_outlines(rig)]):
        (given,) = (
            o.corners[::-1]
            for o in true_outlines(rig)
            if np.allclose(o.corners.mean(axis=0), face.corners.mean(axis=0))
        )
        for i, line in enumerate(face.lines):
            ends = {tuple(face.corners[i]), tuple(np.roll(face.corners, -1, axis=0)[i])}
            assert ends == {tuple(given[line]), tuple(np.roll(given, -1, axis=0)[line])}


def test_shown_are_views_that_face_it_only() -> None:
    rig = block_rig()
    for face in selected(rig, true_outlines(rig)):
        for view, shown in zip(rig.views, face.shown, strict=True):
            assert not shown or face.normal @ (view.pose.centre - face.corners[0]) > 0


def test_an_outline_in_the_air_is_no_face() -> None:
    rig = block_rig()
    above = top_of(rig) + np.array([0.0, 0.0, 2.0])
    section = rig.points[[0, 2, 6, 4]]  # through the inside of the block
    for wrong in (above, section):
        assert not selected(rig, [outline(wrong)])


def test_of_two_overlapping_faces_in_a_plane_the_worthier_stays() -> None:
    rig = block_rig()
    top = top_of(rig)
    middle = top.mean(axis=0)
    inner = outline(middle + 0.5 * (top - middle))
    maps = edges_everywhere(rig)
    for order in ([outline(top), inner], [inner, outline(top)]):
        (face,) = selected(rig, order, maps)
        np.testing.assert_allclose(face.corners.mean(axis=0), middle)
        assert np.ptp(face.corners[:, 0]) > 5


def test_faces_side_by_side_in_a_plane_both_stay() -> None:
    rig = block_rig()
    a, b, c, d = top_of(rig)
    left = outline(np.array([a, (a + b) / 2, (c + d) / 2, d]))
    right = outline(np.array([(a + b) / 2, b, c, (c + d) / 2]))
    assert len(selected(rig, [left, right], edges_everywhere(rig))) == 2


def test_what_would_hide_a_better_face_from_the_views_that_show_it_is_none() -> None:
    rig = block_rig()
    top = top_of(rig)
    middle = top.mean(axis=0)
    lid = middle + 1.5 * (top - middle) + np.array([0.0, 0.0, 3.0])
    maps = edges_everywhere(rig)
    (face,) = selected(rig, [outline(top, 100.0), outline(lid, 10.0)], maps)
    np.testing.assert_allclose(face.corners[:, 2], 6.0)


def test_the_selection_is_the_same_in_any_order() -> None:
    rig = block_rig()
    outlines = true_outlines(rig)
    one, other = selected(rig, outlines), selected(rig, outlines[::-1])
    assert {tuple(f.corners.mean(axis=0)) for f in one} == {
        tuple(f.corners.mean(axis=0)) for f in other
    }


def test_no_outlines_are_no_faces() -> None:
    assert selected(block_rig(), []) == ()
