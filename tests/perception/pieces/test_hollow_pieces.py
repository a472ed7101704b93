"""Rings, bored boards and wheels are one piece each, however many sides they have."""

from collections.abc import Callable

import numpy as np
import pytest
import shapely
import trimesh

from benchmarks.shapes.built_things import turn_at_random
from benchmarks.shapes.own_solids import block, extruded
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.pieces.exact.cut_pieces import CutPieces
from facetlog.perception.pieces.exact.find_pieces import find_solid_pieces
from tests.perception.shapes.meshes.made_meshes import scene_of, together

SIDES = (8, 11, 12, 20, 64)


def disc(radius: float, sides: int) -> shapely.Polygon:
    turns = 2.0 * np.pi * (np.arange(sides) + 0.3) / sides
    return shapely.Polygon(radius * np.column_stack([np.cos(turns), np.sin(turns)]))


def pipe(outer: float, inner: float, low: float, high: float, sides: int) -> trimesh.Trimesh:
    return extruded(disc(outer, sides).difference(disc(inner, sides)), low, high)


def lathe(profile: list[tuple[float, float]], sides: int) -> trimesh.Trimesh:
    return trimesh.creation.revolve(np.array(profile), sections=sides)


def cut(made: trimesh.Trimesh, seed: int = 0) -> CutPieces:
    rng = np.random.default_rng(seed)
    made = made.subdivide() if seed % 2 else made
    order = rng.permutation(len(made.faces))
    return find_solid_pieces(made.vertices @ turn_at_random(rng).T, np.asarray(made.faces)[order])


MUG = [(0, 0), (0.05, 0), (0.05, 0.1), (0.045, 0.1), (0.045, 0.005), (0, 0.005)]
BUCKET = [(0, 0), (0.1, 0), (0.14, 0.3), (0.135, 0.3), (0.097, 0.01), (0, 0.01)]
BOWL = [(0, 0), (0.1, 0.01), (0.18, 0.08), (0.2, 0.19), (0.19, 0.192), (0.17, 0.09), (0, 0.02)]
ROUND: dict[str, Callable[[int], trimesh.Trimesh]] = {
    "pipe": lambda sides: pipe(0.1, 0.08, 0.0, 0.5, sides),
    "washer": lambda sides: pipe(0.1, 0.05, 0.0, 0.01, sides),
    "frame": lambda sides: pipe(0.3, 0.27, 0.0, 0.02, sides),
    "tyre": lambda sides: trimesh.creation.torus(
        0.3, 0.06, major_sections=sides, minor_sections=16
    ),
    "mug": lambda sides: lathe(MUG, sides),
    "bucket": lambda sides: lathe(BUCKET, sides),
    "bowl": lambda sides: lathe(BOWL, sides),
}


@pytest.mark.parametrize("sides", SIDES)
@pytest.mark.parametrize("name", ROUND)
def test_what_is_round_and_hollow_is_one_round_piece(name: str, sides: int) -> None:
    for seed in range(2):
        found = cut(ROUND[name](sides), seed)
        assert len(found.pieces) == 1, found.reason
        assert found.explained == pytest.approx(1.0)
        assert found.pieces[0].round > 0.7


@pytest.mark.parametrize("sides", SIDES)
def test_a_well_has_a_shaft_two_posts_a_roof_and_a_bucket_that_hangs_free(sides: int) -> None:
    posts = [block((x, -0.05, 0.0), (x + 0.1, 0.05, 1.8)) for x in (-0.66, 0.56)]
    roof = block((-0.9, -0.4, 1.8), (0.9, 0.4, 1.85))
    bucket = lathe(BUCKET, sides).apply_translation((0.0, 0.0, 0.4))
    found = cut(together(pipe(0.6, 0.45, 0.0, 0.8, sides), *posts, roof, bucket))
    assert len(found.pieces) == 5
    assert len(found.contacts) == 4
    assert found.explained == pytest.approx(1.0)


PLAN = shapely.box(0.0, 0.0, 2.0, 0.6)
SINK = shapely.box(0.5, 0.1, 1.1, 0.5)
HOLES = {
    "bored": shapely.affinity.translate(disc(0.1, 32), 1.0, 0.3),
    "sink": SINK,
    "rounded sink": SINK.buffer(-0.05).buffer(0.05, quad_segs=8),
    "pegs": shapely.unary_union(
        [
            shapely.affinity.translate(disc(0.012, 12), x, y)
            for x in np.arange(0.1, 2.0, 0.2)
            for y in np.arange(0.1, 0.6, 0.1)
        ]
    ),
}


@pytest.mark.parametrize("name", HOLES)
@pytest.mark.parametrize("seed", range(2))
def test_a_board_with_a_hole_is_the_board(name: str, seed: int) -> None:
    (piece,) = cut(extruded(PLAN.difference(HOLES[name]), 0.0, 0.04), seed).pieces
    assert piece.extents == pytest.approx([2.0, 0.6, 0.04])
    assert piece.round == 0.0


def test_an_axle_through_a_wheel_is_another_piece() -> None:
    wheel, axle = pipe(0.1, 0.02, 0.0, 0.03, 24), extruded(disc(0.02, 24), -0.1, 0.1)
    found = cut(together(wheel, axle))
    assert [piece.extents.round(2).tolist() for piece in found.pieces] == [
        [0.2, 0.2, 0.03],
        [0.2, 0.04, 0.04],
    ]
    assert found.contacts == ((0, 1),)


def unite(sides: int) -> trimesh.Trimesh:
    """A wheel flush with the post above it, as one closed body."""
    wheel = shapely.affinity.translate(disc(0.06, sides), 0.0, 0.06)
    plan = wheel.union(shapely.box(-0.015, 0.06, 0.015, 0.5))
    return extruded(plan, 0.0, 0.03)


@pytest.mark.parametrize("sides", [12, 16, 24, 48])
@pytest.mark.parametrize("seed", range(2))
def test_a_wheel_flush_with_its_post_is_round_and_the_post_a_bar(sides: int, seed: int) -> None:
    found = cut(unite(sides), seed)
    assert sorted(piece.round > 0.7 for piece in found.pieces) == [False, True]
    assert found.explained == pytest.approx(1.0, abs=0.03)


def test_what_cannot_be_cut_leaves_the_other_bodies_theirs() -> None:
    table = [block((0, 0, 0.7), (1.2, 0.8, 0.74))]
    table += [block((x, y, 0.0), (x + 0.06, y + 0.06, 0.7)) for x in (0, 1.14) for y in (0, 0.74)]
    rng = np.random.default_rng(0)
    star = trimesh.creation.icosphere(subdivisions=2, radius=0.1)
    star.vertices *= 1.0 + rng.uniform(-0.5, 0.5, (len(star.vertices), 1))
    star.apply_translation((0.6, 0.4, 0.9 - 0.74 + 0.7 - star.bounds[0][2] - 0.12))
    found = cut(together(*table, star))
    assert len(found.pieces) == 5
    assert found.explained == pytest.approx(
        1.0 - abs(star.volume) / sum(abs(each.volume) for each in (*table, star)), abs=1e-6
    )
    assert found.unexplained.shape == (1, 2, 3)
    rows = fact_rows(scene_of(together(*table, star)), {"piece", "explained"})
    assert len(rows["piece"]) == 5
    assert rows["explained"][0][1] < 0.99


def harm(made: trimesh.Trimesh, how: str) -> tuple[np.ndarray, np.ndarray]:
    points, faces = np.asarray(made.vertices), np.asarray(made.faces)
    rng = np.random.default_rng(0)
    if how == "inside out":
        return points, faces[:, ::-1]
    if how == "doubled":
        return points, np.concatenate([faces, faces])
    if how == "wound at random":
        return points, np.where(rng.random((len(faces), 1)) < 0.5, faces[:, ::-1], faces)
    if how == "no shared corners":
        return points[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    # a sliver at every triangle: a corner next to the middle of its first side
    extra = len(points) + np.arange(len(faces))
    middles = points[faces[:, :2]].mean(axis=1)
    split = [(faces[:, 0], extra, faces[:, 2]), (extra, faces[:, 1], faces[:, 2])]
    split += [(faces[:, 0], faces[:, 1], extra)]
    return np.concatenate([points, middles]), np.concatenate([np.column_stack(s) for s in split])


@pytest.mark.parametrize(
    "how", ["inside out", "doubled", "wound at random", "no shared corners", "slivers"]
)
@pytest.mark.parametrize("name", ["pipe", "mug", "tyre"])
def test_harmed_rings_are_one_piece_or_unknown(name: str, how: str) -> None:
    made = ROUND[name](24)
    made.vertices = made.vertices @ turn_at_random(np.random.default_rng(2)).T
    found = find_solid_pieces(*harm(made, how))
    assert len(found.pieces) == 1 or found.explained < 0.99
    if how != "slivers":
        assert len(found.pieces) == 1, found.reason


def test_pieces_of_bodies_through_one_another_stay() -> None:
    through = together(pipe(0.3, 0.25, 0.0, 1.0, 24), block((-0.5, -0.1, 0.4), (0.5, 0.1, 0.5)))
    assert len(cut(through).pieces) == 2
