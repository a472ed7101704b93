"""The pieces of things: what they are like, and what carries what."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.facts.named_rows import FactRows
from facetlog.perception.facts.pieces.kinds import PIECE_KINDS
from facetlog.perception.pieces.pieces import find_pieces
from facetlog.perception.scene import Plane, Scene
from facetlog.perception.space.grid import Grid, Lattice
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.exact_solids.polyhedra import stick_table
from tests.perception.pieces.test_openings import of_boxes

KINDS = {kind.functor for kind in PIECE_KINDS}


def facts(scene: Scene) -> FactRows:
    return fact_rows(scene, KINDS)


def kinds(rows: FactRows) -> dict[str, str]:
    """Return the word for each piece, by its proportions."""
    found = {}
    for name, length, width, thickness, _ in rows["piece_size"]:
        thin, slender = thickness <= 0.35 * width, width <= 0.35 * length
        found[name] = "board" if thin else "bar" if slender else "block"
    return found


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("cuboid", {"block": 1}),
        ("table", {"board": 1, "bar": 4}),
        ("stool", {"board": 1, "bar": 4}),
        ("chair", {"board": 2, "bar": 4}),
        ("bench", {"board": 3}),
        ("desk", {"board": 4}),
        ("shelf", {"board": 7}),
        ("cabinet", {"block": 1, "board": 1}),
        ("tray", {"board": 5}),
        ("l_block", {"block": 2}),
    ],
)
def test_furniture_has_the_pieces_that_a_person_names(name: str, expected: dict[str, int]) -> None:
    assert Counter(kinds(facts(build(name, {}))).values()) == expected


def test_extents_of_a_table_are_those_that_it_was_built_with() -> None:
    sizes = {"width": 0.8, "length": 1.2, "height": 0.74, "thickness": 0.04, "leg": 0.06}
    rows = facts(build("table", sizes))
    top, *legs = sorted(rows["piece_size"], key=lambda row: -row[2])
    assert top[1:4] == pytest.approx((1.2, 0.8, 0.04), abs=1e-6)
    for _, length, width, thickness, sd in legs:
        assert length == pytest.approx(0.7, abs=3 * sd)
        assert (width, thickness) == pytest.approx((0.06, 0.06), abs=1e-6)


@pytest.mark.parametrize("thickness", [0.02, 0.03, 0.05])
@pytest.mark.slow
def test_boards_of_a_bookcase_are_as_thick_as_they_are_though_cells_are_thicker(
    thickness: float,
) -> None:
    sides = [((x, 0.0, 0.0), (x + thickness, 0.3, 1.8)) for x in (0.0, 0.8 - thickness)]
    levels = [
        ((thickness, 0.0, z), (0.8 - thickness, 0.3, z + thickness))
        for z in (0.05, 0.5, 0.95, 1.4, 1.8 - thickness)
    ]
    rows = facts(of_boxes(*sides, *levels))
    assert [row[3] for row in rows["piece_size"]] == pytest.approx([thickness] * 7, abs=1e-6)


def test_legs_carry_the_back_of_a_chair_through_its_seat() -> None:
    rows = facts(build("chair", {}))
    legs = {name for name, kind in kinds(rows).items() if kind == "bar"}
    heights = {name: (low, high) for name, low, high, _ in rows["piece_heights"]}
    back = max(heights, key=lambda name: heights[name][1])
    (seat,) = set(heights) - legs - {back}
    assert {name for (name,) in rows["piece_on_ground"]} == legs
    carried = {(one, other) for one, other in rows["carries"]}
    assert carried >= {(leg, other) for leg in legs for other in (seat, back)} | {(seat, back)}
    assert not any(other in legs for _, other in carried)
    joined = sum((leg, back) in rows["joins"] for leg in legs)
    assert joined < len(legs)


@pytest.mark.parametrize("seed", range(3))
def test_turning_the_world_moves_no_end_by_more_than_two_cells(seed: int) -> None:
    scene = build("chair", {})
    cell = 0.9 / 40  # of its height
    rotation = Rotation.random(random_state=seed).as_matrix()
    turned = _turned(scene, rotation)
    before, after = facts(scene), facts(turned)
    sizes = [np.array([row[1:4] for row in rows["piece_size"]]) for rows in (before, after)]
    one, other = (each[np.argsort(each.prod(axis=1))] for each in sizes)
    assert one == pytest.approx(other, abs=2 * cell)
    assert len(before["carries"]) == len(after["carries"])


def _turned(scene: Scene, rotation: np.ndarray) -> Scene:
    up = scene.up
    assert up is not None
    return replace(
        scene,
        up=rotation @ up,
        vertices=tuple(replace(v, point=rotation @ v.point) for v in scene.vertices),
        faces=tuple(
            replace(f, plane=Plane(rotation @ f.plane.normal, f.plane.offset, f.plane.cov))
            for f in scene.faces
        ),
    )


def test_legs_that_are_known_as_edges_alone_are_bars() -> None:
    rows = facts(stick_table())
    assert Counter(kinds(rows).values()) == {"board": 1, "bar": 4}
    assert len(rows["carries"]) == 4
    assert all(share == 0.0 for _, share in rows["piece_round"])


def test_a_solid_part_in_which_an_edge_merely_ends_is_a_piece_along_the_grid() -> None:
    solid = np.zeros((9, 3, 3), np.bool_)
    solid[:3] = solid[6:] = True
    grid = Grid(Lattice(0.1, np.eye(3), np.zeros(3), solid.shape), solid, solid)
    # An edge from inside of one part to the rim of the other: one point of it lies in that.
    edge = np.array([[[0.15, 0.15, 0.15], [0.61, 0.15, 0.15]]])
    found = find_pieces(grid, (), np.zeros((0, 3)), edge)
    assert len(found.pieces) == 2
    for piece in found.pieces:
        assert np.isfinite([piece.length.value, piece.width.value, piece.thickness.value]).all()
        assert np.abs(np.linalg.det(piece.axes)) == pytest.approx(1.0)
