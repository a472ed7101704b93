"""The parts of a scene: vertex, plane, edge, face, patch, body, and lines of sight.

World frame: right-handed, any unit of length (metres where the unit is known). From these classes,
with the limits that they state, scene files are read and their JSON Schema is made.
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import chain
from typing import Annotated

import numpy as np
from annotated_types import Ge, MinLen
from numpy.typing import ArrayLike, NDArray

from facetlog.perception.types import (
    ArrayShape,
    Camera,
    FloatArray,
    Index,
    LensError,
    Observation,
    Pose,
    PositionLabel,
    Share,
    frozen,
)
from facetlog.plain_text import plain_text

__all__ = [
    "Body",
    "Edge",
    "Evidence",
    "Face",
    "FaceSight",
    "Patch",
    "Plane",
    "Scene",
    "SeenLattice",
    "SightLines",
    "SolidPiece",
    "Solids",
    "Vertex",
]

Vector3 = Annotated[FloatArray, ArrayShape(3)]
Vectors3 = Annotated[FloatArray, ArrayShape(None, 3)]
Ring = Annotated[tuple[Index, ...], MinLen(3)]


@dataclass(frozen=True, eq=False, slots=True)
class Vertex:
    """A 3-D vertex: mean (3,), covariance (3, 3), and the observations that it was made from."""

    point: Vector3
    cov: Annotated[FloatArray, ArrayShape(3, 3)]
    observations: tuple[Observation, ...] = ()
    label: PositionLabel | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", frozen(self.point, 3))
        object.__setattr__(self, "cov", frozen(self.cov, 3, 3))


@dataclass(frozen=True, eq=False, slots=True)
class Plane:
    """The plane normal · x + offset = 0 with a unit normal; `cov` (4, 4) of (normal, offset).

    The covariance has rank 3: along the normal itself there is nothing to vary.
    """

    normal: Vector3
    offset: float
    cov: Annotated[FloatArray, ArrayShape(4, 4)]

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", frozen(self.normal, 3))
        object.__setattr__(self, "cov", frozen(self.cov, 4, 4))
        if abs(math.hypot(*self.normal) - 1.0) > 1e-6:  # of what is huge, too
            raise ValueError("the normal is not of unit length")

    def flipped(self) -> "Plane":
        """Return the plane with the opposite normal."""
        return Plane(-self.normal, -self.offset, self.cov)

    def distance(self, points: ArrayLike) -> FloatArray:
        """Return signed distance of points (..., 3), positive on the side the normal points to."""
        return np.asarray(points, dtype=np.float64) @ self.normal + self.offset


class Evidence(StrEnum):
    """Whether pictures support a thing, or it was completed from its neighbours."""

    MEASURED = "measured"
    IMPLIED = "implied"


@dataclass(frozen=True, slots=True)
class Edge:
    """A straight 3-D edge between two vertices (indices into the scene).

    `support` in [0, 1] is the share of its length that was found in the views that could see it.
    """

    start: Index
    end: Index
    support: Share = 1.0
    evidence: Evidence = Evidence.MEASURED


@dataclass(frozen=True, slots=True)
class FaceSight:
    """How a view (its index) before a face shows it, as shares of the face's area in [0, 1].

    `seen` is what it shows, `hidden` what other faces (their indices) hide, each with its share,
    `outside` what lies beyond the picture's border. On the rest the picture does not agree with the
    other views: something that is no face may be before it.
    """

    view: Index
    seen: Share
    hidden: tuple[tuple[Index, Share], ...] = ()
    outside: Share = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Face:
    """A flat face: `outline` is a loop of vertex indices, counter-clockwise seen from outside.

    The plane's normal points outwards, to the side from which the face was seen. `coverage` in
    [0, 1] is the share of the face that was seen in at least one view, `sights` what each view
    before it shows of it.
    """

    outline: Ring
    plane: Plane
    holes: tuple[Ring, ...] = ()
    support: Share = 1.0
    coverage: Share = 1.0
    evidence: Evidence = Evidence.MEASURED
    sights: tuple[FaceSight, ...] = ()

    def __post_init__(self) -> None:
        if len(self.outline) < 3 or len(set(self.outline)) != len(self.outline):
            raise ValueError("an outline is a loop of at least three different vertices")


@dataclass(frozen=True, eq=False, slots=True)
class Patch:
    """A piece of surface that is not flat, as points that each stand for some of its area.

    `points` (n, 3); unit `normals` (n, 3) outwards, rows of zeros where they are not known;
    `areas` (n,). Points lie so close that the surface has no hole between them that matters.
    `hull` are vertices (indices into the scene) that reach as far as the patch does: the corners
    of its convex hull, or enough of them. Points without area, which a face's noise explains, say
    where surface is, but not how far it reaches.
    """

    points: Vectors3
    normals: Vectors3
    areas: Annotated[FloatArray, ArrayShape(None, item=Annotated[float, Ge(0.0)])]
    hull: tuple[Index, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.points)
        if len(self.normals) != count or len(self.areas) != count:
            raise ValueError(
                f"{count} points, {len(self.normals)} normals and {len(self.areas)} areas: "
                "give as many of each"
            )
        object.__setattr__(self, "points", frozen(self.points, count, 3))
        object.__setattr__(self, "normals", frozen(self.normals, count, 3))
        object.__setattr__(self, "areas", frozen(self.areas, count))


@dataclass(frozen=True, eq=False, slots=True)
class SolidPiece:
    """A solid part of a body, as exact as the surface that it was cut from.

    `corners` (n, 3) are those of its convex hull; unit `axes` (3, 3) the directions of its length,
    width and thickness, as rows. `round` is the share of its section's outline that is curved,
    0..1: 1 for a wheel, whatever its flat sides. `faces` are indices of faces mostly its own.
    """

    corners: Vectors3
    axes: Annotated[FloatArray, ArrayShape(3, 3)]
    round: Share = 0.0
    faces: tuple[Index, ...] = ()

    def __post_init__(self) -> None:
        if len(self.corners) < 4:
            raise ValueError("a solid piece has at least four corners")
        object.__setattr__(self, "corners", frozen(self.corners, len(self.corners), 3))
        object.__setattr__(self, "axes", frozen(self.axes, 3, 3))


@dataclass(frozen=True, slots=True)
class Solids:
    """The solid pieces of a body, the largest first.

    `joins` are pairs of them (indices) that touch. `explained` is the share of the body's volume
    that they fill together, 0..1; `gaps` are boxes round what none fills: x, y, z of the lowest
    corner, then of the highest.
    """

    pieces: tuple[SolidPiece, ...]
    joins: tuple[tuple[Index, Index], ...]
    explained: Share
    gaps: tuple[tuple[float, float, float, float, float, float], ...] = ()

    def __post_init__(self) -> None:
        if any(not 0 <= i < len(self.pieces) for pair in self.joins for i in pair):
            raise ValueError("two solid pieces join of which one does not exist")


@dataclass(frozen=True, slots=True)
class Body:
    """One object, told apart where the scene was read: indices of its faces, edges and patches.

    `whole` says that it was read from what has surface on every side, as a mesh has: where there is
    no surface, there is nothing, unless its space turns out to be open behind what there is.
    Otherwise it may go on where nobody looked. `solids` are its pieces where the file has a closed
    surface; else they are found from its faces and patches.
    """

    faces: tuple[Index, ...] = ()
    edges: tuple[Index, ...] = ()
    patches: tuple[Index, ...] = ()
    whole: bool = False
    solids: Solids | None = None


@dataclass(frozen=True, eq=False, slots=True)
class SightLines:
    """Lines of sight from one place to what was seen from there: nothing stands on them before.

    `origin` (3,) is a camera's centre or where a scanner stood, `ends` (n, 3) are points of
    surfaces, to single precision; `view` is the index of the camera's view.
    """

    origin: FloatArray
    ends: FloatArray
    view: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", frozen(self.origin, 3))
        ends = np.asarray(self.ends).astype(np.float32).astype(np.float64)
        object.__setattr__(self, "ends", frozen(ends, len(ends), 3))


@dataclass(frozen=True, eq=False, slots=True)
class SeenLattice:
    """Points of a plane on a lattice, and which views show them: nothing stands before those.

    Point (i, j) is at `corner` (3,) + i `steps`[0] + j `steps`[1], steps (2, 3). `shown` (v, rows,
    columns) says what is seen from each of the `origins` (v, 3), the centres of `views` (v,).
    `wrong` in [0, 1] is the share of points that pass as shown where it is known that something
    hides them; None where nothing is known to. The plane is that of the `ground`, or of a face.
    """

    corner: FloatArray
    steps: FloatArray
    origins: FloatArray
    shown: NDArray[np.bool_]
    views: tuple[int, ...]
    wrong: float | None = None
    ground: bool = True

    def __post_init__(self) -> None:
        count = len(self.views)
        object.__setattr__(self, "corner", frozen(self.corner, 3))
        object.__setattr__(self, "steps", frozen(self.steps, 2, 3))
        object.__setattr__(self, "origins", frozen(self.origins, count, 3))
        shown = np.array(self.shown, dtype=np.bool_)
        if shown.ndim != 3 or len(shown) != count:
            raise ValueError("a lattice is to say of each of its views what it shows")
        shown.setflags(write=False)
        object.__setattr__(self, "shown", shown)

    @property
    def lines(self) -> tuple[SightLines, ...]:
        """A line of sight to each point from each view that shows it."""
        found = []
        for origin, shown, view in zip(self.origins, self.shown, self.views, strict=True):
            if shown.any():
                ends = self.corner + np.argwhere(shown) @ self.steps
                found.append(SightLines(origin, ends, view))
        return tuple(found)


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Scene:
    """Everything that was reconstructed: what the facts are made of.

    Lengths are metres where `metric` is true.
    """

    name: str
    """Name of the scene."""
    views: tuple[str, ...] = ()
    """The names of the pictures."""
    vertices: tuple[Vertex, ...] = ()
    """Points with their covariances; v1 is the first."""
    edges: tuple[Edge, ...] = ()
    """Straight edges between vertices; they need not bound a face."""
    faces: tuple[Face, ...] = ()
    """Flat faces with outlines and holes; f1 is the first."""
    up: FloatArray | None = None
    """A unit vector (3,), or None where it is not known."""
    metric: bool = False
    """Whether lengths are metres; otherwise the scale is unknown and only ratios mean something."""
    warnings: tuple[str, ...] = field(default=())
    """Doubts, a line each."""
    patches: tuple[Patch, ...] = ()
    """Surface that is not flat."""
    bodies: tuple[Body, ...] = ()
    """Objects that the file states; each face, edge and patch is of one at most. Without any they
    are found from what touches what (things.py)."""
    poses: tuple[Pose, ...] = ()
    """Poses of the views as adjusted to what all show; empty where no picture shows the scene."""
    lenses: tuple[LensError, ...] = ()
    """By what the views were corrected, empty where lenses are as stated; a file keeps none."""
    sights: tuple[SightLines, ...] = ()
    """Lines of sight, along which space is known to be free."""
    cameras: tuple[Camera, ...] = ()
    """Cameras of the pictures; empty where no picture shows the scene."""
    lattices: tuple[SeenLattice, ...] = ()
    """Cells of planes that views see, up to which space is known to be free."""
    scale_sd: float = 0.0
    """Relative standard deviation of metres: an error of all lengths alike, in no covariance."""

    def __repr__(self) -> str:
        # All numbers of a scene would fill a notebook.
        there = {
            "views": self.views,
            "faces": self.faces,
            "edges": self.edges,
            "vertices": self.vertices,
        }
        counts = ", ".join(f"{len(those)} {called}" for called, those in there.items())
        return f"<Scene {self.name!r}: {counts}>"

    def __post_init__(self) -> None:
        # What names files may be no text, which no file of ours and no engine takes.
        object.__setattr__(self, "name", plain_text(self.name))
        for texts in ("views", "warnings"):
            object.__setattr__(self, texts, tuple(map(plain_text, getattr(self, texts))))
        if self.up is not None:
            object.__setattr__(self, "up", frozen(self.up, 3))
        count = len(self.vertices)
        ends = chain.from_iterable((edge.start, edge.end) for edge in self.edges)
        outlines = chain.from_iterable(face.outline for face in self.faces)
        holes = chain.from_iterable(hole for face in self.faces for hole in face.holes)
        hulls = chain.from_iterable(patch.hull for patch in self.patches)
        used = {*ends, *outlines, *holes, *hulls}
        if used and not 0 <= min(used) <= max(used) < count:
            raise ValueError("an edge, face or patch names a vertex that the scene does not have")
        if self.cameras and not len(self.cameras) == len(self.poses) == len(self.views):
            raise ValueError("cameras and poses are not as many as there are views")
        self._check_bodies()
        self._check_sights()

    def _check_bodies(self) -> None:
        solids = (body.solids for body in self.bodies if body.solids is not None)
        named = [face for each in solids for piece in each.pieces for face in piece.faces]
        if any(not 0 <= face < len(self.faces) for face in named):
            raise ValueError("a solid piece names a face that the scene does not have")
        for kind, parts in (("face", self.faces), ("edge", self.edges), ("patch", self.patches)):
            plural = "patches" if kind == "patch" else f"{kind}s"
            named = [i for body in self.bodies for i in getattr(body, plural)]
            if any(not 0 <= i < len(parts) for i in named):
                raise ValueError(f"a body names a {kind} that the scene does not have")
            if len(set(named)) != len(named):
                raise ValueError(f"two bodies name the same {kind}")

    def _check_sights(self) -> None:
        of_faces = [sight for face in self.faces for sight in face.sights]
        views = [s.view for s in of_faces] + [s.view for s in self.sights if s.view is not None]
        views += chain.from_iterable(seen.views for seen in self.lattices)
        if any(not 0 <= view < len(self.views) for view in views):
            raise ValueError("a sight names a view that the scene does not have")
        if any(not 0 <= face < len(self.faces) for s in of_faces for face, _ in s.hidden):
            raise ValueError("a sight names a face that the scene does not have")

    @property
    def lines_of_sight(self) -> tuple[SightLines, ...]:
        """All lines of sight: `sights`, and those to what the lattices show."""
        return (*self.sights, *chain.from_iterable(seen.lines for seen in self.lattices))

    @property
    def seen_ground(self) -> tuple[SeenLattice, ...]:
        """The lattices on the ground."""
        return tuple(seen for seen in self.lattices if seen.ground)

    @property
    def points(self) -> FloatArray:
        """All vertices' means, (n, 3)."""
        return np.array([v.point for v in self.vertices], dtype=np.float64).reshape(-1, 3)
