"""Walls, ceilings and floors are what things stand in, also where all is one surface."""

import numpy as np
import pytest
import trimesh

from facetlog.perception.scene import Scene
from tests.perception.shapes.meshes.made_meshes import Point, block, scene_of, table, together

HALF, HEIGHT, THICK = 2.0, 2.4, 0.1
CORNERS = ((-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF))


def quad(*corners: Point) -> trimesh.Trimesh:
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def level_sheet(height: float) -> trimesh.Trimesh:
    return quad(*((x, y, height) for x, y in CORNERS))


def wall_sheet(side: int) -> trimesh.Trimesh:
    (ax, ay), (bx, by) = CORNERS[side], CORNERS[(side + 1) % 4]
    return quad((ax, ay, 0), (bx, by, 0), (bx, by, HEIGHT), (ax, ay, HEIGHT))


def wall_slab(side: int) -> trimesh.Trimesh:
    far = HALF + THICK
    low, high = (
        ((-HALF, -far, 0), (HALF, -HALF, HEIGHT)),
        ((HALF, -HALF, 0), (far, HALF, HEIGHT)),
        ((-HALF, HALF, 0), (HALF, far, HEIGHT)),
        ((-far, -HALF, 0), (-HALF, HALF, HEIGHT)),
    )[side]
    return block(low, high)


def carton(x: float, y: float) -> trimesh.Trimesh:
    return block((x - 0.2, y - 0.15, 0), (x + 0.2, y + 0.15, 0.25))


def sheets(count: int) -> trimesh.Trimesh:
    return together(level_sheet(0), *map(wall_sheet, range(count)))


def slabs(count: int) -> trimesh.Trimesh:
    floor = block((-HALF, -HALF, -THICK), (HALF, HALF, 0))
    return together(floor, *map(wall_slab, range(count)))


def one_surface(made: trimesh.Trimesh) -> trimesh.Trimesh:
    fine = made.subdivide().subdivide()
    fine.merge_vertices()
    return fine


def crate(length: float, width: float, height: float) -> trimesh.Trimesh:
    t = 0.02
    return together(
        block((0, 0, 0), (length, width, t)),
        block((0, 0, t), (length, t, height)),
        block((0, width - t, t), (length, width, height)),
        block((0, t, t), (t, width - t, height)),
        block((length - t, t, t), (length, width - t, height)),
    )


def boxes_of(scene: Scene) -> list[list[float]]:
    """Number of faces and extents of each object, in order of these."""
    found = []
    for body in scene.bodies:
        corners = scene.points[[i for face in body.faces for i in scene.faces[face].outline]]
        found.append([len(body.faces), *np.ptp(corners, axis=0).round(4).tolist()])
    return sorted(found)


ROOMS = {
    **{f"{count} sheets": sheets(count) for count in (2, 3, 4)},
    **{f"{count} slabs": slabs(count) for count in (2, 4)},
    "sheets and a ceiling": together(sheets(4), level_sheet(HEIGHT)),
    "slabs and a ceiling": together(
        slabs(4), block((-HALF, -HALF, HEIGHT), (HALF, HALF, HEIGHT + THICK))
    ),
    "one surface": one_surface(sheets(4)),
}
THINGS = {
    "table": (table(-0.6, -0.4),),
    "carton at a wall": (carton(HALF - 0.2, 0),),
    "carton in a corner": (carton(HALF - 0.2, -HALF + 0.15),),
    "several": (table(-0.6, -0.4), carton(1.5, 1.5)),
}


@pytest.mark.parametrize("things", THINGS)
@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.slow
def test_what_stands_in_a_room_is_what_it_is_without(room: str, things: str) -> None:
    bare = [row for thing in THINGS[things] for row in boxes_of(scene_of(thing))]
    assert boxes_of(scene_of(together(ROOMS[room], *THINGS[things]))) == sorted(bare)


@pytest.mark.slow
def test_walls_are_told_from_a_crate_by_size_in_metres_alone() -> None:
    full = together(crate(1.2, 1.0, 0.9), carton(0.6, 0.5).apply_translation((0, 0, 0.02)))
    for scale, metric, objects in ((1.0, True, 2), (4.0, True, 1), (4.0, False, 2)):
        made = full.copy().apply_scale(scale)
        whole = [row for row in boxes_of(scene_of(made, metric=metric)) if row[1] > scale]
        assert len(whole) == objects - 1


def floor_with(holes: list[tuple[float, float, float, float]]) -> trimesh.Trimesh:
    """A floor of 2 m that shares its corners with boxes .25 m high over these holes."""
    cuts = [sorted({-1.0, 1.0, *(h[k] for h in holes), *(h[k + 2] for h in holes)}) for k in (0, 1)]
    quads = []
    for x0, x1 in zip(cuts[0], cuts[0][1:], strict=False):
        for y0, y1 in zip(cuts[1], cuts[1][1:], strict=False):
            if not any(a <= x0 and x1 <= c and b <= y0 and y1 <= d for a, b, c, d in holes):
                quads.append(quad((x0, y0, 0), (x1, y0, 0), (x1, y1, 0), (x0, y1, 0)))
    for a, b, c, d in holes:
        box = block((a, b, 0), (c, d, 0.25))
        quads.append(trimesh.Trimesh(box.vertices, box.faces[box.face_normals[:, 2] > -0.5]))
    made = together(*quads)
    made.merge_vertices()
    return made


HOLES = [(-0.2, -0.15, 0.2, 0.15), (0.5, 0.5, 0.7, 0.9)]


@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("turn", [0.0, 3.0])
@pytest.mark.parametrize("below", [False, True])
def test_a_box_on_a_floor_of_one_surface_with_it_is_a_box(
    count: int, turn: float, below: bool
) -> None:
    made = floor_with(HOLES[:count])
    if below:
        made = together(
            made,
            *(quad((a, b, 0), (c, b, 0), (c, d, 0), (a, d, 0)) for a, b, c, d in HOLES[:count]),
        )
        made.merge_vertices()
    made.apply_transform(trimesh.transformations.rotation_matrix(np.deg2rad(turn), (1, 0, 0)))
    scene = scene_of(made)
    assert [len(body.faces) for body in scene.bodies] == [6] * count
    assert all(body.whole for body in scene.bodies)


def test_a_rough_floor_and_the_box_on_it_are_told_apart() -> None:
    made = floor_with(HOLES[:1]).subdivide_to_size(0.04)
    made.merge_vertices()
    rng = np.random.default_rng(5)
    made.vertices += 0.0005 * rng.standard_normal(made.vertices.shape)
    scene = scene_of(made)
    (body,) = scene.bodies
    corners = scene.points[[i for face in body.faces for i in scene.faces[face].outline]]
    assert np.ptp(corners, axis=0) == pytest.approx([0.4, 0.3, 0.25], abs=0.008)


@pytest.mark.parametrize("far", [10.0, 1e2, 1e4])
@pytest.mark.slow
def test_a_table_is_the_same_whatever_is_far_away(far: float) -> None:
    stray = trimesh.Trimesh([[far, 0, 0], [far + 0.1, 0, 0], [far, 0.1, 0.1]], [[0, 1, 2]])
    ground = quad((-far, -far, 0), (far, -far, 0), (far, far, 0), (-far, far, 0))
    beyond = carton(far, 0)
    (bare,) = boxes_of(scene_of(table(-0.6, -0.4)))
    for other in (stray, ground, beyond):
        assert bare in boxes_of(scene_of(together(table(-0.6, -0.4), other)))


@pytest.mark.parametrize("name", ["4 sheets", "4 slabs"])
def test_an_empty_room_is_no_thing(name: str) -> None:
    empty = scene_of(ROOMS[name])
    assert len(empty.faces) >= 5
    assert not any(body.faces for body in empty.bodies)
