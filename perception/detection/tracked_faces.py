"""The result of a front end: vertices tracked through the views, and the loops they form."""

from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.types import FloatArray, Track


@dataclass(frozen=True, eq=False, slots=True)
class FacePlane:
    """normal · x = height, where `cov` (k, k) is that of its errors at the face's corners
    (TrackedFace.corners).

    A plane is shifted and tilted as a whole: the errors of neighbouring corners are correlated.
    """

    normal: FloatArray
    height: float
    cov: FloatArray


@dataclass(frozen=True, slots=True)
class TrackedFace:
    """A face as a loop of tracks (indices), counter-clockwise seen from outside; holes clockwise.

    `support` in [0, 1] is that of `Face`. `plane` is the front end's estimate, if it has one; no
    view shows a face that is `implied`.
    """

    outline: tuple[int, ...]
    support: float = 1.0
    plane: FacePlane | None = None
    implied: bool = False
    holes: tuple[tuple[int, ...], ...] = ()

    @property
    def corners(self) -> tuple[int, ...]:
        """The tracks of the outline, then those of the holes."""
        return tuple(chain(self.outline, *self.holes))


@dataclass(frozen=True, eq=False, slots=True)
class Completion:
    """A track that may have too few observations for a point: its offset (3,) from another track,
    with a standard deviation of `sd` along each axis.
    """

    track: int
    beside: int
    offset: FloatArray
    sd: float


@dataclass(frozen=True, eq=False, slots=True)
class Landmarks:
    """Points (n, 3) of surfaces that views show, of faces or not; `seen` (n, V) says which do."""

    points: FloatArray
    seen: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class TrackedFaces:
    """All tracks and faces of a set of views, in pixels of their pictures.

    `weight` has one number in (0, 1] for each view: how much it counts beside nearly identical
    views. `edges` are straight edges between tracks that bound no face. `stand_ins` replace the
    first tracks, at the places of the faces' outlines, where the pictures do not determine them;
    `completions` are the last resort. `used` are the views (indices) that all this refers to, in
    the order of its view numbers: all where it is None. `ground` is the plane that everything
    stands on, where there is one: a normal (3,) to the cameras' side, and the height along it.
    `landmarks` are other points that views show.
    """

    tracks: tuple[Track, ...]
    faces: tuple[TrackedFace, ...]
    weight: tuple[float, ...]
    edges: tuple[tuple[int, int], ...] = ()
    stand_ins: tuple[Track, ...] = ()
    completions: tuple[Completion, ...] = ()
    warnings: tuple[str, ...] = ()
    used: tuple[int, ...] | None = None
    ground: tuple[FloatArray, float] | None = None
    landmarks: Landmarks | None = None
