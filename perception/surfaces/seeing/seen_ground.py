"""Where the ground shows: on a lattice of its points, which views see each.

What a line of sight to the ground passes through is free. The level of a pixel alone hardly says
where it ends: beneath a plain thing the views agree on the thing's own grey. So views see the
ground where they show the same print round a point of it, or a level that the ground shows and the
faces that hide it do not. These faces say how often either is wrong.

Lines tell the ground to some pixels, and a part of a degree. Beside its place hardly any print
agrees, so the number of windows that do has a sharp peak there; what stands on the ground does not
matter: it is elsewhere.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from facetlog.perception.detection.line_front_end.evidence.photo_consistency import (
    AGREES_SDS,
    GreyLevels,
)
from facetlog.perception.detection.line_front_end.evidence.photometric_views import MIN_FACING_SINE
from facetlog.perception.flat_faces import clip_polygon_above, make_plane_axes
from facetlog.perception.scene import SeenLattice
from facetlog.perception.surfaces.seeing.seen_faces import BEFORE_PX, NEAREST
from facetlog.perception.types import FloatArray, View

# The time grows with the square of their number.
MOST_VIEWS = 32
# Of points that are known to be hidden so many pass as seen, or it is left: a place that two views
# pass by mistake is one in 25.
MOST_WRONG = 0.2

# So many views, spread among all, are compared.
COMPARED = 8
# How far off the ground may be, px, and between which heights one more is tried.
FARTHEST, STEP = 6, 0.5
# A peak has this many times as many windows that agree as this quantile of all heights, since from
# nearly the same direction views agree over half of these, and so many of those that are pictured:
# less is chance.
PEAK, BESIDE_PEAK, LEAST_SHARE = 1.5, 0.25, 0.01
# A ground that is this near to level may be level: cos 3°.
MAY_BE_LEVEL = 0.9986

Plane = tuple[FloatArray, float]
_Bits = NDArray[np.bool_]
# Points are so many pixels apart: no two have the same nearest pixel, and hardly a pixel is left.
PITCH_PX = 1.5
# Points at most, in all and along a side; above, they are further apart.
MOST_POINTS = 200_000
MOST_ALONG = 8_000
# Fewest along a side.
FEWEST_ALONG = 8
# Beyond the lattice, along its sides, shadows are cut off.
FAR = 1 << 14
# Print is compared in square windows of so many points across.
WINDOW = 7
# n independent samples of noise correlate with an sd of 1 / √n: beyond so many once in 4,000.
CORRELATES_SDS = 3.5
# A window shows print if its variance is this many times that of the picture's noise: of noise
# alone, with 49 samples, an sd is a fifth of it.
PRINT_VARIANCE = 2.0
# So many other views, by weight, show the same as one,
WITNESSES = 2.0
# and this share of those that show print there: two windows of smooth print, with some four
# independent samples, correlate by chance as well as one time in six.
AGREE_SHARE = 1 / 3
# Levels are about so much, from which they are counted so that their squares stay small.
MIDDLE_GREY = np.float32(128.0)
# Of lattice points across and down one in so many is kept: windows overlap.
EVERY = 2

KEPT = (slice(None, None, EVERY), slice(None, None, EVERY))
"""The points of a lattice that are kept."""

# Of the levels those that tell the ground best from what hides it are taken as the ground's, until
# this share of what is known to be hidden shows them: they are wrong one time in 20.
RARE = 0.05
# What shows the ground shows one level: more than half of the views that may see it.
MOST_SHARE = 0.5

_Reals = NDArray[np.float32]


@dataclass(frozen=True, eq=False, slots=True)
class GroundLattice:
    """Points `corner` (3,) + i steps[0] + j steps[1] for i, j below `shape`, rows and columns.

    `steps` (2, 3) are square to each other and equally long; `normal` (3,) is that of the ground.
    """

    corner: FloatArray
    steps: FloatArray
    normal: FloatArray
    shape: tuple[int, int]

    @classmethod
    def under(
        cls, views: Sequence[View], normal: FloatArray, height: float
    ) -> "GroundLattice | None":
        """Return the lattice half a picture's width round where the optical axes meet the ground;
        None if none does.

        The ground is normal · x = height.
        """
        axes = make_plane_axes(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
        middles, pixels, widths = [], [], []
        for view in views:
            forward, centre = view.pose.rotation[:, 2], view.pose.centre
            fall, above = -float(forward @ normal), float(centre @ normal) - height
            if fall < MIN_FACING_SINE or above <= 0:
                continue
            away = above / fall
            middles.append(axes @ (centre + away * forward))
            pixel = away / view.camera.fx
            widths.append(pixel * view.camera.width)
            # A pixel's area is that of its square by the sine at which it is seen.
            pixels.append(pixel / np.sqrt(fall))
        if not middles:
            return None
        half = np.array(widths)[:, None] / 2
        low, high = (middles - half).min(axis=0), (middles + half).max(axis=0)
        sides = high - low
        pitch = max(
            PITCH_PX * float(np.median(pixels)),
            float(np.sqrt(sides.prod() / MOST_POINTS)),
            float(sides.max() / MOST_ALONG),
        )
        rows, columns = np.maximum(sides // pitch, FEWEST_ALONG).astype(int).tolist()
        return cls(low @ axes + height * normal, pitch * axes, normal, (rows, columns))

    def pixels(self, view: View) -> FloatArray:
        """Return the homography (3, 3) from (column, row, 1) to homogeneous pixels, depth last."""
        across, down = self.steps[1], self.steps[0]
        points = np.column_stack([np.stack([across, down, self.corner]), [0.0, 0.0, 1.0]]).T
        homography: FloatArray = view.projection @ points
        return homography

    def shadow(self, faces: Sequence[Sequence[FloatArray]], view: View) -> NDArray[np.bool_]:
        """Return the points (rows, columns) that faces, each some rings (k, 3), hide from a view
        above.

        Of a face on the ground nothing does.
        """
        mask = np.zeros(self.shape, dtype=np.uint8)
        for rings in faces:
            loops = [loop for ring in rings for loop in self._cast(ring, view)]
            if loops:
                cv2.fillPoly(mask, loops, 1)
        return mask.view(np.bool_)

    def _cast(self, ring: FloatArray, view: View) -> Iterator[NDArray[np.int32]]:
        """Return the ring as its shadow has it, in columns and rows, if it has any."""
        centre = view.pose.centre
        top = float((centre - self.corner) @ self.normal)
        # What stands on the ground hides it; what lies there is known to be there to some pixels.
        least = BEFORE_PX * top / view.camera.fx
        part = clip_polygon_above(ring, (ring - self.corner) @ self.normal - least)
        if len(part) >= 3:
            part = clip_polygon_above(
                part, (1 - NEAREST) * top - (part - self.corner) @ self.normal
            )
        if len(part) >= 3:
            below = top - (part - self.corner) @ self.normal
            met = centre + (part - centre) * (top / below)[:, None] - self.corner
            at = met @ self.steps[::-1].T / (self.steps[0] @ self.steps[0])
            yield np.clip(np.rint(at), -FAR, FAR).astype(np.int32)


class Windows:
    """Windows that V views show at the points kept of a lattice, (rows, columns) of them.

    `pictured` (V, rows, columns) are the points in the pictures.
    """

    def __init__(
        self,
        levels: GreyLevels,
        views: NDArray[np.intp],
        pixels: Sequence[FloatArray],
        shape: tuple[int, int],
    ) -> None:
        kept = len(views), *np.empty(shape, dtype=np.bool_)[KEPT].shape
        self._all = np.empty((len(views), *shape), dtype=np.float32)
        self._level, self._sd, self._mean, self._variance = np.empty((4, *kept), dtype=np.float32)
        self.pictured, whole = np.empty((2, *kept), dtype=np.bool_)
        for n, (k, matrix) in enumerate(zip(views.tolist(), pixels, strict=True)):
            level = levels.warped(k, matrix, shape)
            seen = np.isfinite(level)
            level = self._all[n] = np.where(seen, level - MIDDLE_GREY, np.float32(0.0))
            self.pictured[n] = seen[KEPT]
            whole[n] = _find_full_windows(seen)[KEPT]
            self._level[n] = level[KEPT]
            self._sd[n] = levels.warped_sds(k, matrix * [EVERY, EVERY, 1], kept[1:])
            self._mean[n] = _average_windows(level)[KEPT]
            self._variance[n] = _average_windows(level * level)[KEPT] - self._mean[n] ** 2
        least = PRINT_VARIANCE * levels.noise[views, None, None] ** 2
        self._has_print = whole & (self._variance > least)

    def printed(self, weight: _Reals) -> _Bits:
        """Return where (V, rows, columns) a view shows the same print as others, and their
        level.
        """
        # cov > r sd sd, where no print reaches it without print.
        least = np.where(self._has_print, CORRELATES_SDS / WINDOW * self._variance, np.inf)
        least = np.sqrt(least, dtype=np.float32)

        def agree(a: int, b: int) -> _Bits:
            cov = _average_windows(self._all[a] * self._all[b])[KEPT]
            cov -= self._mean[a] * self._mean[b]
            return np.asarray(cov > least[a] * least[b])

        seen = _find_confirmed(agree, self._has_print, weight, AGREE_SHARE)
        return np.asarray(seen & self._near(_compute_level_medians(self._level, seen)))

    def unlike(self, weight: _Reals, hidden: _Bits) -> _Bits:
        """Return where (V, rows, columns) a view shows, as others do, a level that is rare where
        faces hide the ground, `hidden`, and common elsewhere.
        """
        may_see = self.pictured & ~hidden
        if not may_see.any() or not hidden.any():
            return np.zeros_like(may_see)
        bins = np.asarray(np.clip(self._level + MIDDLE_GREY, 0, 255), dtype=np.uint8)
        sd = float(np.median(self._sd[may_see]))
        common = _choose_ground_levels(*(_density(bins[which], sd) for which in (may_see, hidden)))
        seen: _Bits = self.pictured & common[bins]

        most = (np.float32(AGREES_SDS) * self._sd) ** 2

        def agree(a: int, b: int) -> _Bits:
            apart = self._level[a] - self._level[b]
            return np.asarray(seen[a] & seen[b] & (apart * apart < most[a] + most[b]))

        return seen & _find_confirmed(agree, seen, weight, MOST_SHARE)

    def _near(self, surface: _Reals) -> _Bits:
        # Where the views show a surface of that level.
        return np.asarray(np.abs(self._level - surface) < AGREES_SDS * self._sd)


def _find_confirmed(
    agree: Callable[[int, int], _Bits], may: _Bits, weight: _Reals, share: float
) -> _Bits:
    """Return where (V, rows, columns) so many views agree with one, and that share of those that
    `may`.
    """
    witnesses = np.zeros(may.shape, dtype=np.float32)
    for a in range(len(weight)):
        for b in range(a):
            both = agree(a, b)
            witnesses[a] += weight[b] * both
            witnesses[b] += weight[a] * both
    others = np.einsum("v,vij->ij", weight, may) - weight[:, None, None]
    return np.asarray(witnesses >= np.maximum(WITNESSES, share * others))


def _choose_ground_levels(ground: _Reals, faces: _Reals) -> _Bits:
    """Return levels (256,) that tell the ground best from the faces that hide it, by both
    densities.
    """
    least = np.finfo(np.float32).tiny
    best = np.asarray(np.argsort(-ground / (faces + least), kind="stable"))
    common = np.zeros(len(ground), dtype=np.bool_)
    common[best] = (np.cumsum(faces[best]) <= RARE) & (ground[best] > faces[best])
    return common


def _compute_level_medians(level: _Reals, seen: _Bits) -> _Reals:
    """Return medians (...) of the levels (V, ...) of the views that see a point, NaN where none
    does.
    """
    median = np.full(level.shape[1:], np.nan, dtype=np.float32)
    some = seen.any(axis=0)
    ranked = np.sort(np.where(seen, level, np.float32(np.inf))[:, some], axis=0)
    count, point = seen[:, some].sum(axis=0), np.arange(ranked.shape[1])
    median[some] = (ranked[(count - 1) // 2, point] + ranked[count // 2, point]) / 2
    return median


def _density(bins: NDArray[np.uint8], sd: float) -> NDArray[np.float32]:
    count = np.bincount(bins, minlength=256).astype(np.float32)
    smooth = cv2.GaussianBlur(count[None], (0, 0), sd, borderType=cv2.BORDER_REFLECT)[0]
    return np.asarray(smooth / smooth.sum())


def _average_windows(values: _Reals) -> _Reals:
    return np.asarray(cv2.blur(values, (WINDOW, WINDOW)), dtype=np.float32)


def _find_full_windows(bits: _Bits) -> _Bits:
    around = np.ones((WINDOW, WINDOW), dtype=np.uint8)
    return cv2.erode(bits.view(np.uint8), around, borderValue=0).view(np.bool_)


@dataclass(frozen=True, eq=False, slots=True)
class GroundViews:
    """Views above the ground, with the levels of all pictures: `chosen` (v,) are theirs.

    `weight` (v,) is that of each view beside views almost like it.
    """

    views: Sequence[View]
    levels: GreyLevels
    chosen: NDArray[np.intp]
    weight: NDArray[np.float32]

    def windows(self, lattice: GroundLattice) -> Windows:
        """Return what the views show at the points of a lattice."""
        pixels = [lattice.pixels(view) for view in self.views]
        return Windows(self.levels, self.chosen, pixels, lattice.shape)

    def spread(self, count: int) -> "GroundViews":
        """Return so many of the views at most, spread evenly among all."""
        last = len(self.views) - 1
        rows = np.unique(np.linspace(0, last, count).round().astype(np.intp))
        views = [self.views[k] for k in rows]
        return GroundViews(views, self.levels, self.chosen[rows], self.weight[rows])

    def aligned(self, ground: Plane, up: FloatArray | None = None) -> Plane:
        """Return the ground where most of its print agrees; as given without print.

        The ground is its normal (3,) and the height along it. Where `up` is known and the ground
        about level heights are tried without a tilt, and the best one with its own, too.
        """
        some = self.spread(COMPARED)
        lattice = GroundLattice.under(some.views, *ground)
        if lattice is None or len(some.views) < 3:
            return ground
        pixel = float(np.linalg.norm(lattice.steps[0])) / PITCH_PX
        middle = lattice.corner + 0.5 * (np.array(lattice.shape) @ lattice.steps)
        level = up is not None and float(up @ ground[0]) > MAY_BE_LEVEL
        normal = up if up is not None and level else ground[0]

        def tried(normal: FloatArray, *offsets: float) -> list[tuple[int, int, float, FloatArray]]:
            """Return how many windows agree, of how many, so many px above the middle."""
            heights = [float(middle @ normal) + offset * pixel for offset in offsets]
            counts = [some.agreeing((normal, height)) for height in heights]
            return [(*c, o, normal) for c, o in zip(counts, offsets, strict=True)]

        all_ = tried(normal, *sorted(range(-FARTHEST, FARTHEST + 1), key=abs))
        usual = float(np.quantile([count for count, *_ in all_], BESIDE_PEAK))
        best = max(all_, key=lambda one: one[0])
        if level:
            best = max(best, *tried(ground[0], best[2]), key=lambda one: one[0])
        most, pictured, offset, normal = best
        if most < PEAK * usual or most < LEAST_SHARE * pictured:
            return ground
        finer = tried(normal, offset - STEP, offset + STEP)
        _, _, offset, _ = max(best, *finer, key=lambda one: one[0])
        return normal, float(middle @ normal) + offset * pixel

    def agreeing(self, plane: Plane) -> tuple[int, int]:
        """Return how many windows views show with the same print in the middle of a plane, half its
        lattice across, and of how many they picture.
        """
        lattice = GroundLattice.under(self.views, *plane)
        if lattice is None:
            return 0, 1
        rows, columns = lattice.shape
        corner = lattice.corner + np.array([rows // 4, columns // 4]) @ lattice.steps
        lattice = replace(lattice, corner=corner, shape=(rows // 2, columns // 2))
        windows = self.windows(lattice)
        return int(windows.printed(self.weight).sum()), int(windows.pictured.sum())


def seen_ground(
    views: Sequence[View],
    levels: GreyLevels,
    weight: FloatArray,
    faces: Sequence[Sequence[FloatArray]],
    ground: tuple[FloatArray, float],
    up: FloatArray | None = None,
) -> tuple[SeenLattice, ...]:
    """Return up to two lattices on the ground: what the views see of it by its print, and by its
    levels.

    `levels` are those of the views, and `weight` (V,) is as in `PhotometricViews`; `faces` are the
    rings of corners, each (k, 3), of what may hide the ground, which is a normal (3,) to the views'
    side and the height along it: about, for it is put where most of its print agrees, level with
    `up` if more agrees then. A lattice is left out where nothing of it is seen or where it is
    often wrong, that of levels also where no face says whether it is.
    """
    normal, height = ground
    above = np.flatnonzero([view.pose.centre @ normal > height for view in views])
    if not len(above):
        return ()
    weights = weight[above].astype(np.float32)
    seeing = GroundViews([views[int(k)] for k in above], levels, above, weights).spread(MOST_VIEWS)
    lattice = GroundLattice.under(seeing.views, *seeing.aligned(ground, up))
    if lattice is None:
        return ()
    windows = seeing.windows(lattice)
    shadows = [lattice.shadow(faces, view) for view in seeing.views]
    hidden = windows.pictured & np.array([shadow[KEPT] for shadow in shadows])
    beside = windows.pictured & np.array([_widened(shadow)[KEPT] for shadow in shadows])
    # Windows of print reach over what they are beside, and two of them may show it. A level tells
    # by itself which of the two a pixel shows, however far off the outline of what hides is.
    found = [(windows.printed(seeing.weight), beside)]
    if hidden.any():
        found.append((windows.unlike(seeing.weight, hidden), hidden))
    origins = np.array([view.pose.centre for view in seeing.views])
    named = tuple(seeing.chosen.tolist())
    lattices = []
    for seen, covered in found:
        wrong = float(seen[hidden].mean()) if hidden.any() else None
        seen &= ~covered
        if seen.any() and (wrong is None or wrong <= MOST_WRONG):
            steps = EVERY * lattice.steps
            lattices.append(SeenLattice(lattice.corner, steps, origins, seen, named, wrong))
    return tuple(lattices)


def _widened(shadow: _Bits) -> _Bits:
    # By as much as the outlines of faces may be off.
    across = 2 * round(BEFORE_PX / PITCH_PX) + 1
    return cv2.dilate(shadow.view(np.uint8), np.ones((across, across), np.uint8)).view(np.bool_)
