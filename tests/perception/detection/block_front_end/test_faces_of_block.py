from collections import Counter

import numpy as np
import pytest

from facetlog.perception.detection.block_front_end.correspondence import track_vertices
from facetlog.perception.detection.block_front_end.faces_of_block import (
    block_front_end,
    track_points,
)
from facetlog.perception.detection.block_front_end.image_vertices import ImageVertex
from facetlog.perception.detection.block_front_end.position_labels import (
    LabelledVertex,
    estimate_upward_direction,
    find_rule_label,
)
from facetlog.perception.types import Pose, PositionLabel, View

FACES = [
    frozenset(f) for f in ((4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))
]


@pytest.fixture(scope="module")
def found(tour):
    return block_front_end(tour.views)


def owners(scene, tracks):
    """The true corner of each track, -1 if its observations are of several."""
    result = []
    for track in tracks:
        names = set()
        for seen in track.observations:
            visible = list(scene.visible[seen.view])
            distance = np.linalg.norm(scene.pixels[seen.view][visible] - seen.uv, axis=1)
            names.add(visible[int(distance.argmin())] if distance.min() < 3 else -1)
        result.append(names.pop() if len(names) == 1 else -1)
    return result


def test_every_corner_becomes_one_track_of_its_own_observations(tour, found):
    assert sorted(owners(tour, found.tracks)) == list(range(8))


def test_the_tracks_meet_at_the_true_corners(tour, found):
    points = track_points(found.tracks, tour.views)
    truth = tour.corners[owners(tour, found.tracks)]
    assert np.sqrt(((points - truth) ** 2).sum(axis=1).mean()) < 0.05  # of a block of 10


def test_all_visible_faces_get_their_true_outlines(tour, found):
    corner = owners(tour, found.tracks)
    outlines = [frozenset(corner[i] for i in outline) for outline in found.outlines]
    assert sorted(map(sorted, outlines)) == sorted(map(sorted, FACES))


def test_outlines_run_counter_clockwise_seen_from_outside(tour, found):
    points = track_points(found.tracks, tour.views)
    middle = tour.corners.mean(axis=0)
    for outline in found.outlines:
        ring = points[list(outline)]
        normal = np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)
        assert normal @ (ring.mean(axis=0) - middle) > 0
        sides = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
        assert sides.max() < 10.2  # no diagonal


def test_a_label_means_the_same_corner_in_every_view(tour, found):
    meant = {}
    for index, labelled in enumerate(found.vertices):
        visible = list(tour.visible[index])
        for vertex in labelled:
            off = np.linalg.norm(tour.pixels[index][visible] - vertex.vertex.uv, axis=1)
            if vertex.block_label is not None and off.min() < 3:
                corner = visible[int(off.argmin())]
                meant.setdefault(vertex.block_label, Counter())[corner] += 1
    assert len(meant) == 8
    assert len({c.most_common(1)[0][0] for c in meant.values()}) == 8
    assert all(len(c) == 1 for c in meant.values())


def test_labels_name_the_corners_as_the_first_view_shows_them(tour, found):
    view = tour.views[0]
    seen = {t.label: c for t, c in zip(found.tracks, owners(tour, found.tracks), strict=True)}
    frame = (tour.corners - view.pose.centre) @ view.pose.rotation

    def corner(name):
        return frame[seen[PositionLabel(name)]]

    for level in ("top", "bottom"):
        assert corner(f"front_left_{level}")[0] < corner(f"front_right_{level}")[0]
        assert corner(f"front_left_{level}")[2] < corner(f"back_left_{level}")[2]
    assert corner("front_left_top")[1] < corner("front_left_bottom")[1]


def world_moved(scene, scale, seed):
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    shift = rng.normal(size=3) * 100 * scale
    return tuple(
        View(
            v.name,
            v.image,
            v.camera,
            Pose(turn @ v.pose.rotation, scale * turn @ v.pose.centre + shift),
        )
        for v in scene.views
    )


def test_tracks_labels_and_outlines_depend_on_no_world_frame_or_scale(tour, found):
    moved = block_front_end(world_moved(tour, 1e3, 4))
    assert [len(t.observations) for t in moved.tracks] == [
        len(t.observations) for t in found.tracks
    ]
    assert [t.label for t in moved.tracks] == [t.label for t in found.tracks]
    assert moved.outlines == found.outlines


def test_the_order_of_the_views_changes_no_track(tour, found):
    order = np.random.default_rng(1).permutation(len(tour.views))
    turned = block_front_end(tuple(tour.views[i] for i in order))

    def members(tracks, names):
        return {
            frozenset((names[o.view], *np.round(o.uv, 6)) for o in t.observations) for t in tracks
        }

    assert members(turned.tracks, order) == members(found.tracks, range(len(order)))


def test_missing_and_false_vertices_do_not_break_tracks(tour, found):
    rng = np.random.default_rng(0)
    spoiled = []
    for labelled in found.vertices:
        kept = [v for v in labelled if rng.random() > 0.25]
        false = [
            LabelledVertex(
                ImageVertex(rng.uniform((90, 60), (230, 180)), 0.02 * np.eye(2), (0, 1)),
                None,
                None,
            )
            for _ in range(3)
        ]
        spoiled.append((*kept, *false))
    tracks = track_vertices(tuple(spoiled), tour.views)
    names = owners(tour, tracks)
    assert len(set(names) - {-1}) >= 7
    assert names.count(-1) <= 1


def test_wrong_labels_are_outvoted_by_geometry(tour, found):
    rng = np.random.default_rng(2)
    labels = list(PositionLabel)
    spoiled = tuple(
        tuple(
            LabelledVertex(
                v.vertex,
                v.label,
                labels[int(rng.integers(8))] if rng.random() < 0.15 else v.block_label,
            )
            for v in labelled
        )
        for labelled in found.vertices
    )
    names = owners(tour, track_vertices(spoiled, tour.views))
    assert set(names) >= set(range(8))


def test_chance_alone_makes_no_track(tour):
    rng = np.random.default_rng(5)
    noise = tuple(
        tuple(
            LabelledVertex(
                ImageVertex(rng.uniform((60, 40), (260, 200)), 0.02 * np.eye(2), (0, 1)),
                None,
                None,
            )
            for _ in range(8)
        )
        for _ in tour.views
    )
    assert len(track_vertices(noise, tour.views)) <= 1


def test_two_views_are_matched_by_label(draw_block):
    scene = draw_block((20, 45))
    tracks = block_front_end(scene.views).tracks
    assert len(tracks) >= 3
    assert -1 not in owners(scene, tracks)
    assert all(t.label is not None for t in tracks)


def test_views_from_one_place_give_no_tracks(tour):
    assert block_front_end((tour.views[0],) * 4).tracks == ()


def test_no_views_and_one_view_give_no_tracks(tour):
    assert block_front_end(()).tracks == ()
    one = block_front_end(tour.views[:1])
    assert one.tracks == ()
    assert one.outlines == ()
    assert len(one.vertices[0]) >= 5


def test_a_dark_picture_among_good_ones_is_reported_and_left_out(tour, found):
    first = tour.views[0]
    dark = View("dark", np.zeros_like(first.image), first.camera, first.pose)
    mixed = block_front_end((*tour.views[1:], dark))
    assert mixed.warnings == ("dark: nothing is as bright as the threshold",)
    assert len(mixed.tracks) == len(found.tracks)


def test_up_is_found_from_level_cameras(tour):
    assert np.allclose(estimate_upward_direction(tour.views), [0, 0, 1], atol=1e-9)
    assert estimate_upward_direction(tour.views[:1])[2] > 0.8


def test_rule_one_is_the_papers():
    assert find_rule_label(frozenset({"S", "E", "SE"})) is PositionLabel.BACK_LEFT_TOP
    assert find_rule_label(frozenset({"S", "E", "SE", "N"})) is None
