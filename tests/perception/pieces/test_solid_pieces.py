"""The pieces of closed meshes are the parts that they were built of, however the mesh is made."""

import numpy as np
import pytest
import trimesh

from benchmarks.shapes.accuracy_pieces import is_as_built
from benchmarks.shapes.built_things import (
    FAMILIES,
    Parts,
    Sizes,
    iter_variants,
    list_builds,
    turn_at_random,
)
from benchmarks.shapes.own_solids import bar, block
from facetlog.perception.pieces.exact.cut_pieces import CutPieces
from facetlog.perception.pieces.exact.find_pieces import find_solid_pieces


def unite_boxes(parts: Parts) -> trimesh.Trimesh:
    """The surface of boxes along the axes, as one body: the sides of cells that are not shared."""
    bounds = np.array([part.bounds for part in parts])
    places = [np.unique(np.round(bounds[..., axis], 9)) for axis in range(3)]
    full = np.zeros([len(place) - 1 for place in places], dtype=bool)
    for low, high in np.round(bounds, 9):
        ends = [np.searchsorted(places[k], (low[k], high[k])) for k in range(3)]
        full[tuple(slice(*each) for each in ends)] = True
    full = np.pad(full, 1)
    corners, faces = [], []
    for axis in range(3):
        for cell in np.argwhere(np.diff(full.astype(int), axis=axis)):
            inner = full[tuple(cell)]
            quad = np.tile(cell - 1, (4, 1))
            quad[:, axis] += 1
            other = [(axis + 1) % 3, (axis + 2) % 3]
            quad[1:3, other[0]] += 1
            quad[2:, other[1]] += 1
            corners.append([[places[k][row[k]] for k in range(3)] for row in quad])
            faces.append([0, 1, 2, 3] if inner else [3, 2, 1, 0])
    numbers = 4 * np.arange(len(faces))[:, None] + np.array(faces)
    triangles = np.concatenate([numbers[:, [0, 1, 2]], numbers[:, [0, 2, 3]]])
    return trimesh.Trimesh(np.concatenate(corners), triangles)


def count(mesh: trimesh.Trimesh) -> int:
    return len(find_solid_pieces(mesh.vertices, mesh.faces).pieces)


def table(legs: float = 0.7) -> Parts:
    spots = [(x, y) for x in (0.0, 1.14) for y in (0.0, 0.74)]
    return [
        block([0, 0, legs], [1.2, 0.8, legs + 0.03]),
        *(block([x, y, 0], [x + 0.06, y + 0.06, legs]) for x, y in spots),
    ]


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("way", ["joined", "separate"])
def test_pieces_are_the_parts_that_things_were_built_of(family: str, way: str) -> None:
    for parts, points, triangles, turn in iter_variants(family, range(3), way):
        found = find_solid_pieces(points, triangles)
        assert any(is_as_built(build, found, turn) for build in list_builds(family, parts))
        assert found.explained == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("family", ["pallet", "cabinet", "shelf", "frame", "crate"])
def test_one_body_is_cut_into_its_parts(family: str) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        parts = FAMILIES[family](Sizes(rng))
        if any(len(part.vertices) != 8 for part in parts):
            continue
        turn = turn_at_random(rng)
        mesh = unite_boxes([block(*part.bounds) for part in parts])
        found = find_solid_pieces(mesh.vertices @ turn.T, mesh.faces)
        assert is_as_built(parts, found, turn)


@pytest.mark.parametrize("percent", range(-20, 21))
def test_no_length_changes_what_the_pieces_are(percent: int) -> None:
    share = 1.0 + percent / 100.0
    for stretch in np.eye(3) * (share - 1.0) + 1.0:
        parts = [block(*(part.bounds * stretch)) for part in table()]
        assert count(unite_boxes(parts)) == 5
    assert count(unite_boxes(table(legs=0.1 * share))) == 5


def test_turn_unit_and_order_change_nothing() -> None:
    rng = np.random.default_rng(3)
    mesh = unite_boxes(table())
    plain = find_solid_pieces(mesh.vertices, mesh.faces)
    turn = turn_at_random(rng)
    order = rng.permutation(len(mesh.faces))
    other = find_solid_pieces(1000.0 * mesh.vertices @ turn.T + 5e3, mesh.faces[order])
    assert len(plain.contacts) == len(other.contacts) == 4
    for one, two in zip(plain.pieces, other.pieces, strict=True):
        np.testing.assert_allclose(1000.0 * one.extents, two.extents, rtol=1e-6)
    assert other.pieces[0].extents == pytest.approx([1200.0, 800.0, 30.0])


def harm(mesh: trimesh.Trimesh, how: str) -> tuple[np.ndarray, np.ndarray]:
    points, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    if how == "inside out":
        return points, faces[:, ::-1]
    if how == "doubled":
        return points, np.concatenate([faces, faces])
    if how == "two-sided":
        return points, np.concatenate([faces, faces[:, ::-1]])
    if how == "wound at random":
        turned = np.random.default_rng(0).random(len(faces)) < 0.5
        return points, np.where(turned[:, None], faces[:, ::-1], faces)
    if how == "no shared corners":
        return points[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)
    if how == "single precision":
        return points.astype(np.float32).astype(np.float64), faces
    if how == "subdivided":
        finer = mesh.subdivide()
        return np.asarray(finer.vertices), np.asarray(finer.faces)
    # a corner on every edge that only one of its two triangles knows
    middles = points[faces[:, :2]].mean(axis=1)
    extra = len(points) + np.arange(len(faces))
    split = [
        np.column_stack([faces[:, 0], extra, faces[:, 2]]),
        np.column_stack([extra, faces[:, 1], faces[:, 2]]),
    ]
    return np.concatenate([points, middles]), np.concatenate(split)


@pytest.mark.parametrize(
    "how",
    [
        "inside out",
        "doubled",
        "two-sided",
        "wound at random",
        "no shared corners",
        "single precision",
        "subdivided",
        "corners within edges",
    ],
)
def test_harmed_meshes_have_the_same_pieces(how: str) -> None:
    turn = turn_at_random(np.random.default_rng(1))
    mesh = unite_boxes(table())
    mesh.vertices = mesh.vertices @ turn.T
    found = find_solid_pieces(*harm(mesh, how))
    assert is_as_built(table(), found, turn), found.reason


def test_bodies_that_overlap_are_pieces_of_their_own() -> None:
    crossing = [block([-1, -0.1, 0], [1, 0.1, 0.1]), block([-0.1, -1, 0.05], [0.1, 1, 0.15])]
    found = find_solid_pieces(*_as_arrays(trimesh.util.concatenate(crossing)))
    assert len(found.pieces) == 2
    assert found.contacts == ((0, 1),)


def test_wheels_are_round_and_blocks_are_not() -> None:
    wheel = bar([0, 0, 0], [0, 0.03, 0], 0.06, sections=24)
    (piece,) = find_solid_pieces(*_as_arrays(wheel)).pieces
    assert piece.round > 0.9
    (piece,) = find_solid_pieces(*_as_arrays(block([0, 0, 0], [0.06, 0.06, 0.03]))).pieces
    assert piece.round == 0.0


def test_a_cavity_is_no_piece() -> None:
    hollow = trimesh.util.concatenate(
        [block([0, 0, 0], [1, 1, 1]), block([0.1, 0.1, 0.1], [0.9, 0.9, 0.9])]
    )
    faces = np.asarray(hollow.faces)
    faces = np.concatenate([faces[:12], faces[12:, ::-1]])
    assert len(find_solid_pieces(np.asarray(hollow.vertices), faces).pieces) == 6


@pytest.mark.parametrize(
    "faces",
    [[], [[0, 0, 0]], [[0, 1, 1], [2, 1, 2]]],
)
def test_what_encloses_nothing_has_no_pieces_and_says_why(faces: list[list[int]]) -> None:
    found = find_solid_pieces(block([0] * 3, [1] * 3).vertices, np.array(faces).reshape(-1, 3))
    assert not found
    assert found.reason
    assert found.explained == 0.0


@pytest.mark.parametrize("seed", range(20))
def test_random_triangles_do_no_harm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = np.round(rng.normal(size=(12, 3)), 1)
    found = find_solid_pieces(points, rng.integers(0, 12, (40, 3)))
    assert isinstance(found, CutPieces)


@pytest.mark.parametrize("seed", range(6))
def test_bodies_through_one_another_do_no_harm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    blocks = []
    for _ in range(6):
        low = rng.integers(0, 3, 3) + rng.choice([0.0, 1e-7, 0.3], 3)
        part = block(low, low + rng.integers(1, 3, 3))
        part.vertices = part.vertices @ (turn_at_random(rng).T if rng.random() < 0.5 else np.eye(3))
        blocks.append(part)
    mesh = trimesh.util.concatenate(blocks)
    mesh.merge_vertices()
    found = find_solid_pieces(*_as_arrays(mesh))
    assert 0.0 <= found.explained <= 1.0


def _as_arrays(mesh: trimesh.Trimesh) -> tuple[np.ndarray, np.ndarray]:
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)
