"""Exact scenes of known solids, with the covariances that vertices of a given sd would give.

They are the truth that tests, demonstrations and model tests compare with. All faces of a solid
are there, its hidden ones too, unless `seen_from` takes those away.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from facetlog.perception.scene import Body, Edge, Face, Plane, Scene, SightLines, Vertex
from facetlog.perception.types import FloatArray

UP = (0.0, 0.0, 1.0)
CUBOID_SIDES = ("bottom", "top", "front", "back", "left", "right")
"""The sides of each cuboid in the order of its faces; front is -y, left is -x."""
# The same as loops over the corners (x fastest, then y, then z), from outside.
_CUBOID_FACES = (
    (0, 2, 3, 1),
    (4, 5, 7, 6),
    (0, 1, 5, 4),
    (2, 6, 7, 3),
    (0, 4, 6, 2),
    (1, 3, 7, 5),
)


def fit_plane_through_loop(points: ArrayLike, sd: float) -> Plane:
    """Return the plane of a loop of flat points (k, 3), normal by the right hand; each has `sd`
    (1σ) a side.

    The covariance is that of the least-squares plane: tilt about the in-plane axis e has variance
    sd² / Σ (x·e')², with e' the other axis; the offset at the middle has sd² / k.
    """
    loop = np.asarray(points, dtype=np.float64)
    middle = loop.mean(axis=0)
    spokes = loop - middle
    normal = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    normal /= np.linalg.norm(normal)
    spread, axes = np.linalg.eigh(spokes.T @ spokes)
    tilt = sum(
        (sd**2 / max(float(spread[i]), 1e-300) * np.outer(axes[:, i], axes[:, i]) for i in (1, 2)),
        start=np.zeros((3, 3)),
    )
    # offset = -normal · middle, so its error is -middle · (error of normal) + error at the middle
    lever = np.vstack([np.eye(3), -middle])
    cov = lever @ tilt @ lever.T
    cov[3, 3] += sd**2 / len(loop)
    return Plane(normal, float(-normal @ middle), cov)


def polyhedron(
    points: ArrayLike,
    loops: Sequence[Sequence[int]],
    loose: Iterable[tuple[int, int]] = (),
    *,
    sd: float = 0.001,
    name: str = "polyhedron",
    up: ArrayLike | None = UP,
    metric: bool = True,
    holes: Mapping[int, Sequence[Sequence[int]]] = MappingProxyType({}),
) -> Scene:
    """Return the scene of faces (loops of indices into `points` (n, 3), counter-clockwise from
    outside).

    All sides become edges, followed by the `loose` ones. `holes` are loops in a face, by its place.
    """
    where = np.asarray(points, dtype=np.float64)
    sides = dict.fromkeys(
        (min(a, b), max(a, b))
        for loop in (*loops, *(ring for rings in holes.values() for ring in rings))
        for a, b in zip(loop, (*loop[1:], loop[0]), strict=True)
    )
    return Scene(
        name,
        vertices=tuple(Vertex(p, sd**2 * np.eye(3)) for p in where),
        edges=tuple(Edge(a, b) for a, b in (*sides, *loose)),
        faces=tuple(
            Face(
                tuple(loop),
                fit_plane_through_loop(where[list(loop)], sd),
                tuple(tuple(ring) for ring in holes.get(index, ())),
            )
            for index, loop in enumerate(loops)
        ),
        up=None if up is None else np.asarray(up, dtype=np.float64),
        metric=metric,
    )


def _make_box_corners(
    low: Sequence[float], high: Sequence[float]
) -> list[tuple[float, float, float]]:
    return [
        (x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])
    ]


def boxes(
    corners: Sequence[tuple[Sequence[float], Sequence[float]]], sd: float, name: str
) -> Scene:
    """Return upright cuboids, each from its lowest to its highest corner, with six faces each."""
    points: list[tuple[float, float, float]] = []
    loops: list[tuple[int, ...]] = []
    for low, high in corners:
        loops += [tuple(len(points) + i for i in face) for face in _CUBOID_FACES]
        points += _make_box_corners(low, high)
    return polyhedron(points, loops, sd=sd, name=name)


def cuboid(
    length: float = 0.254, width: float = 0.2032, height: float = 0.1524, *, sd: float = 0.001
) -> Scene:
    """Return a block on the ground with a corner at the origin; by default the paper's 10 x 8 x 6
    in.
    """
    return boxes([((0, 0, 0), (length, width, height))], sd, "cuboid")


def wedge(
    length: float = 0.3, width: float = 0.2, height: float = 0.15, *, sd: float = 0.001
) -> Scene:
    """Return a ramp: a right-angled triangle (length, height) drawn out along y."""
    points = [
        (x, y, z) for y in (0.0, width) for x, z in ((0.0, 0.0), (length, 0.0), (0.0, height))
    ]
    loops = [(0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (0, 2, 5, 3)]
    return polyhedron(points, loops, sd=sd, name="wedge")


def pyramid(side: float = 0.3, height: float = 0.25, *, sd: float = 0.001) -> Scene:
    """Return a square pyramid on the ground."""
    points = [(0, 0, 0), (side, 0, 0), (side, side, 0), (0, side, 0), (side / 2, side / 2, height)]
    loops = [(0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    return polyhedron(points, loops, sd=sd, name="pyramid")


def l_block(
    length: float = 0.4, width: float = 0.2, height: float = 0.4, *, sd: float = 0.001
) -> Scene:
    """Return an L: a block with a quarter of its long side cut away."""
    profile = [
        (0.0, 0.0),
        (length, 0.0),
        (length, height / 2),
        (length / 2, height / 2),
        (length / 2, height),
        (0.0, height),
    ]
    return extrude_profile(profile, width, sd=sd, name="l_block")


def extrude_profile(
    profile: Sequence[tuple[float, float]], width: float, *, sd: float, name: str
) -> Scene:
    """Return the prism from y = 0 to `width` over a profile (x, z), anticlockwise seen from -y."""
    points = [(x, y, z) for y in (0.0, width) for x, z in profile]
    n = len(profile)
    loops: list[tuple[int, ...]] = [tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1))]
    loops += [(i, n + i, n + (i + 1) % n, (i + 1) % n) for i in range(n)]
    return polyhedron(points, loops, sd=sd, name=name)


def room_corner(
    side: float = 3.0, height: float = 2.5, *, angle: float = np.pi / 2, sd: float = 0.005
) -> Scene:
    """Return a floor and two walls at `angle` (radians), seen from inside: three faces meet
    concavely.
    """
    along, across = (side, 0.0), (side * np.cos(angle), side * np.sin(angle))
    points = [
        (0, 0, 0),
        (*along, 0),
        (along[0] + across[0], across[1], 0),
        (*across, 0),
        (0, 0, height),
        (*along, height),
        (*across, height),
    ]
    loops = [(0, 1, 2, 3), (0, 4, 5, 1), (0, 3, 6, 4)]
    return polyhedron(points, loops, sd=sd, name="room_corner")


def table(
    length: float = 1.2,
    width: float = 0.8,
    height: float = 0.74,
    *,
    thickness: float = 0.04,
    leg: float = 0.06,
    inset: float = 0.05,
    sd: float = 0.001,
) -> Scene:
    """Return a slab on four square legs, each `inset` from the rim; the legs' tops are not
    faces.
    """
    legs = [
        ((x, y, 0.0), (x + leg, y + leg, height - thickness))
        for x in (inset, length - inset - leg)
        for y in (inset, width - inset - leg)
    ]
    scene = boxes([((0, 0, height - thickness), (length, width, height)), *legs], sd, "table")
    hidden = range(7, 6 * 5, 6)  # the second face of each leg is its top
    return drop_faces(scene, hidden)


def stick_table(
    length: float = 1.2,
    width: float = 0.8,
    height: float = 0.74,
    *,
    thickness: float = 0.04,
    sd: float = 0.001,
) -> Scene:
    """Return a slab seen from above, without its underside, on four legs known as loose edges
    only.
    """
    slab = _make_box_corners((0, 0, height - thickness), (length, width, height))
    feet = [(x, y, 0.0) for x, y, _ in slab[:4]]
    return polyhedron(
        [*slab, *feet],
        _CUBOID_FACES[1:],
        [(i, 8 + i) for i in range(4)],
        sd=sd,
        name="stick_table",
    )


def chair(
    width: float = 0.45,
    depth: float = 0.45,
    seat: float = 0.45,
    height: float = 0.9,
    *,
    thickness: float = 0.04,
    leg: float = 0.04,
    inset: float = 0.01,
    sd: float = 0.001,
) -> Scene:
    """Return a seat on four legs, each `inset` from the rim, with a back flush with the seat's
    rear.
    """
    under = seat - thickness
    corners: list[tuple[Sequence[float], Sequence[float]]] = [
        ((0.0, 0.0, under), (width, depth, seat)),
        ((0.0, depth - thickness, seat), (width, depth, height)),
    ]
    corners += [
        ((x, y, 0.0), (x + leg, y + leg, under))
        for x in (inset, width - inset - leg)
        for y in (inset, depth - inset - leg)
    ]
    scene = boxes(corners, sd, "chair")
    return drop_faces(scene, (6, *range(13, 6 * 6, 6)))


def one_object(scene: Scene) -> Scene:
    """Return the scene as one object, of which the surface is known from all sides."""
    faces, edges = (tuple(range(len(parts))) for parts in (scene.faces, scene.edges))
    return replace(scene, bodies=(Body(faces, edges, whole=True),))


def drop_faces(scene: Scene, hidden: Iterable[int]) -> Scene:
    """Return the scene without these of its faces, and without edges that only they had."""
    drop = set(hidden)
    faces = tuple(f for i, f in enumerate(scene.faces) if i not in drop)
    return _keep_faces(scene, faces)


def _keep_faces(scene: Scene, faces: tuple[Face, ...]) -> Scene:
    """Return the scene with these of its faces, and without edges that only lost faces had."""
    before = {s for f in scene.faces for s in _sides(f)}
    after = {s for f in faces for s in _sides(f)}
    edges = tuple(
        e for e in scene.edges if (s := frozenset((e.start, e.end))) in after or s not in before
    )
    return Scene(
        scene.name, scene.views, scene.vertices, edges, faces, scene.up, scene.metric,
        scene.warnings,
    )  # fmt: skip


def _sides(face: Face) -> list[frozenset[int]]:
    return [
        frozenset(pair)
        for ring in (face.outline, *face.holes)
        for pair in zip(ring, (*ring[1:], ring[0]), strict=True)
    ]


def seen_from(scene: Scene, *eyes: ArrayLike) -> Scene:
    """Return the scene without the faces that turn their backs on all eyes (3,)."""
    places = np.asarray(eyes, dtype=np.float64).reshape(-1, 3)
    return _keep_faces(
        scene, tuple(f for f in scene.faces if (f.plane.distance(places) > 0.0).any())
    )


def together(*scenes: Scene, name: str = "scene") -> Scene:
    """Return one scene of all vertices, edges and faces; up and scale are the first one's."""
    vertices: list[Vertex] = []
    edges: list[Edge] = []
    faces: list[Face] = []
    for scene in scenes:
        n = len(vertices)
        vertices += scene.vertices
        edges += [replace(e, start=n + e.start, end=n + e.end) for e in scene.edges]
        for face in scene.faces:
            outline, *holes = (tuple(n + i for i in r) for r in (face.outline, *face.holes))
            faces.append(replace(face, outline=outline, holes=tuple(holes)))
    first = scenes[0]
    return Scene(name, (), tuple(vertices), tuple(edges), tuple(faces), first.up, first.metric)


def moved(
    scene: Scene,
    rotation: ArrayLike | None = None,
    translation: ArrayLike = (0.0, 0.0, 0.0),
    scale: float = 1.0,
) -> Scene:
    """Return the scene after x → scale · rotation · x + translation, with its covariances."""
    turn: FloatArray = np.eye(3) if rotation is None else np.asarray(rotation, dtype=np.float64)
    shift = np.asarray(translation, dtype=np.float64)

    def plane(old: Plane) -> Plane:
        # n' = R n,  d' = s d - n'·t
        change = np.zeros((4, 4))
        change[:3, :3] = turn
        change[3, :3] = -shift @ turn
        change[3, 3] = scale
        normal = turn @ old.normal
        normal /= np.linalg.norm(normal)
        return Plane(
            normal, float(scale * old.offset - normal @ shift), change @ old.cov @ change.T
        )

    def move(points: FloatArray) -> FloatArray:
        return scale * points @ turn.T + shift

    return replace(
        scene,
        vertices=tuple(
            replace(v, point=scale * turn @ v.point + shift, cov=scale**2 * turn @ v.cov @ turn.T)
            for v in scene.vertices
        ),
        faces=tuple(replace(face, plane=plane(face.plane)) for face in scene.faces),
        up=None if scene.up is None else turn @ scene.up,
        patches=tuple(
            replace(p, points=move(p.points), normals=p.normals @ turn.T, areas=scale**2 * p.areas)
            for p in scene.patches
        ),
        sights=tuple(
            SightLines(scale * turn @ s.origin + shift, move(s.ends), s.view) for s in scene.sights
        ),
        lattices=tuple(
            replace(
                seen,
                corner=scale * turn @ seen.corner + shift,
                steps=scale * seen.steps @ turn.T,
                origins=move(seen.origins),
            )
            for seen in scene.lattices
        ),
        poses=(),
        cameras=(),
        lenses=(),
        scale_sd=0.0,
    )
