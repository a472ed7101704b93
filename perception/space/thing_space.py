"""The space round a thing, from its surface and from the lines of sight of its scene."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from facetlog.perception.attached_edges import RIM_SHARE
from facetlog.perception.flat_faces import FlatFace
from facetlog.perception.min_views import FEWEST_VIEWS
from facetlog.perception.ragged import find_row_starts
from facetlog.perception.scene import SightLines
from facetlog.perception.space.flooding import count_missed_cells, enclosed, is_empty_shell
from facetlog.perception.space.grid import CELLS, Cells, Lattice
from facetlog.perception.space.space import Space, State
from facetlog.perception.space.surface_points import inner_points, sample_lines
from facetlog.perception.types import FloatArray

# A line ends where surface was seen, and passes no cell that holds measured surface: what is hidden
# behind it is not free by that line.

# Places along a line are this far apart, in cells: it misses only cells that it cuts a corner of.
STEP = 0.5
# A line says nothing of the last cell before what it ends on.
BEFORE_END = 1.0
# Places that are worked on in one go: some 30 MB.
AT_ONCE = 400_000


def count_places_through(
    lattice: Lattice, sights: Iterable[SightLines], full: Cells
) -> NDArray[np.int32]:
    """Count the different places from which a line passed each cell (nx, ny, nz) before its end.

    `full` (nx, ny, nz) are the cells that hold measured surface; lines end there at the latest.
    """
    origins: dict[tuple[float, ...], list[FloatArray]] = {}
    for lines in sights:
        origins.setdefault(tuple(lines.origin.tolist()), []).append(lines.ends)
    counts = np.zeros(lattice.size, dtype=np.int32)
    flat = full.ravel()
    for origin, ends in origins.items():
        counts += _passed(lattice, np.array(origin), np.concatenate(ends), flat)
    return counts.reshape(lattice.shape)


def _passed(
    lattice: Lattice, origin: FloatArray, ends: FloatArray, full: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return cells (n,) that lines from one place to some ends (k, 3) passed."""
    passed = np.zeros(lattice.size, dtype=np.bool_)
    start = lattice.local(origin[None])[0]
    rays = lattice.local(ends) - start
    length = np.sqrt((rays * rays).sum(axis=1))
    ahead = length > BEFORE_END
    rays, length = rays[ahead], length[ahead]
    rays /= length[:, None]
    first, last = _within(lattice, start, rays)
    last = np.minimum(last, length - BEFORE_END)
    counts = np.maximum(np.ceil((last - first) / STEP), 0.0).astype(np.intp)
    through = np.flatnonzero(counts)
    batches = np.cumsum(counts[through]) // AT_ONCE
    for some in np.split(through, np.flatnonzero(np.diff(batches)) + 1):
        passed[
            _find_cells_of_lines(lattice, start, rays[some], first[some], counts[some], full)
        ] = True
    return passed


def _within(lattice: Lattice, start: FloatArray, rays: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where unit rays (k, 3) enter and leave the lattice, in cells along them.

    The first is not behind the start, and beyond the last where the ray misses the lattice.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = -start / rays, (np.array(lattice.shape) - start) / rays
    # along an axis that a ray does not run along, it is always within or never
    beside = (start < 0) | (start > lattice.shape)
    still = rays == 0.0
    low = np.where(still, np.where(beside, np.inf, -np.inf), low)
    high = np.where(still, np.where(beside, -np.inf, np.inf), high)
    first = np.maximum(np.minimum(low, high).max(axis=1), 0.0)
    last = np.maximum(low, high).min(axis=1)
    return first, np.where(still & beside, -np.inf, last[:, None]).min(axis=1)


def _find_cells_of_lines(
    lattice: Lattice,
    start: FloatArray,
    rays: FloatArray,
    first: FloatArray,
    counts: NDArray[np.intp],
    full: NDArray[np.bool_],
) -> NDArray[np.intp]:
    """Return the cells (m,) in which so many places along each ray lie, up to the first that is
    full.
    """
    starts = find_row_starts(counts)
    ray = np.repeat(np.arange(len(counts)), counts)
    nth = np.arange(len(ray)) - starts[ray]
    away = first[ray] + STEP * (nth + 0.5)
    nx, ny, nz = lattice.shape
    cell = np.zeros(len(ray), dtype=np.intp)
    for axis, size in enumerate((nx, ny, nz)):
        along = (start[axis] + away * rays[ray, axis]).astype(np.intp)
        cell = cell * size + np.clip(along, 0, size - 1)
    stopped = np.where(full[cell], nth, counts[ray])
    return cell[nth < np.minimum.reduceat(stopped, starts)[ray]]


# Samples of a face are this share of a cell apart, so that none of its cells is missed: an inner
# cell of a plane holds a sample at any spacing below 1; corners of cells are cut at more than .5.
SPACING = 0.5
# A surface is closed unless more than this share of it has free space behind it. Of furniture as
# meshes up to a third has, where walls are single sheets; of what lacks a side nearly all.
OPEN_SHARE = 0.5
# A point right before or behind a surface is so many cells from it.
BESIDE = 1.0
# A normal that points this much along an axis faces that way (cosine of 60 degrees).
FACES_ALONG = 0.5
# A side was seen if more than this share of the surface faces it: less may be noise.
LEAST_SHOWN = 0.05
# A cell that lies open to so many of these sides is not behind seen surface.
MOST_MISSING = 2
# A view looks at a side, and not along it, from so far before it: the sine of 15 degrees.
LOOKED_AT = 0.26
# A rim lies within so many cells of its side: an inner edge stands for an outer one now and then.
RIM = round(RIM_SHARE * CELLS)
# What seems enclosed is not if more than this share of it is known to be free, as of a room that
# was scanned from within: less are lines of sight that grazed a rim.
FREE_SHARE = 0.1
# Where a line of sight may be wrong, places that are known to be free are so many cells wide:
# narrower ones are where lines grazed a rim, or where two wrong ones cross. Of what is free beneath
# furniture in pictures nine tenths are that wide, of boxes' rims a twentieth.
WIDE = 2


@dataclass(frozen=True, eq=False, slots=True)
class ThingSurface:
    """A thing's surface as far as it is known.

    `outer` (k, 3) are points that reach as far as the thing does, `curved` (m, 3) points of what
    is not flat, with unit `normals` (m, 3) outwards or rows of zeros; `lines` (l, 2, 3) are edges
    that bound no face, those of bars that are too thin for one; `corner_sd` is the sd of a
    face's corner. `all_round` says that it was read from what shows surface on every side.
    """

    faces: tuple[FlatFace, ...]
    outer: FloatArray
    curved: FloatArray
    normals: FloatArray
    lines: FloatArray = field(default_factory=lambda: np.zeros((0, 2, 3)))
    corner_sd: float = 0.0
    all_round: bool = False


def thing_space(
    surface: ThingSurface,
    up: FloatArray,
    *,
    sights: Sequence[SightLines] = (),
    places: int = 1,
    on_ground: bool = True,
) -> Space | None:
    """Return the space round a thing along the unit vector `up` (3,), or None if it has no extent.

    What lines of sight passed from so many different `places` is free. What does not stand
    `on_ground` is reached from below, too.
    """
    upright = [face for face in surface.faces if abs(float(face.normal @ up)) < FACES_ALONG]
    square_to = None
    if upright and not surface.all_round:
        square_to = max(upright, key=lambda face: face.area).normal
    lattice = Lattice.round(surface.outer, up, square_to=square_to)
    if lattice is None:
        return None
    flat, face = inner_points(surface.faces, SPACING * lattice.cell)
    normals = np.array([f.normal for f in surface.faces]).reshape(-1, 3)
    points = lattice.local(np.concatenate([flat, surface.curved]))
    # axis by axis in memory, as `local` gives the points
    facing = np.concatenate(
        [np.take(lattice.axes @ normals.T, face, axis=1), lattice.axes @ surface.normals.T], axis=1
    ).T
    touched = lattice.holding(points)
    if not len(flat):
        touched |= lattice.holding(lattice.local(surface.outer))
    walls, rooms = enclosed(
        touched, on_ground=on_ground, missed=count_missed_cells(surface.corner_sd / lattice.cell)
    )
    within = walls | rooms
    closed = surface.all_round and _open_share(lattice, within, points, facing) <= OPEN_SHARE
    if closed:
        cells = np.where(within, State.FULL, State.FREE).astype(np.uint8)
        return Space(lattice, cells, closed, rooms if rooms.any() else None)
    # right before surface that was seen from there
    before = np.zeros(lattice.size, dtype=np.bool_)
    numbers = lattice.numbers(points + BESIDE * facing)
    before[numbers[(numbers >= 0) & _find_facing(facing)]] = True
    passed = count_places_through(lattice, sights, touched) >= places
    free = ~touched & (before.reshape(lattice.shape) | passed)
    blind = _find_empty_rooms(lattice, within & ~touched, surface.outer, sights)
    free &= ~blind
    full = touched | _drop_free_rooms(within & ~touched & ~blind, free)
    shown = _find_shown_sides(facing)
    free &= ~full
    sure = _wide(free) if places > 1 else free
    looked = _looked_at(lattice, sights) if places > 1 else ()
    cells = _assign_states(full, free, sure, shown, looked)
    cells[blind] = State.UNSEEN
    # One sees past an edge: it hides nothing, and what lies between two is not enclosed.
    bars = lattice.local(sample_lines(surface.lines, SPACING * lattice.cell))
    cells[lattice.holding(bars)] = State.FULL
    return Space(lattice, cells, closed)


def _find_facing(facing: FloatArray) -> NDArray[np.bool_]:
    """Return which directions (n, 3) are not zero: column by column, rows of three take longer."""
    x, y, z = facing.T
    return np.asarray((x != 0.0) | (y != 0.0) | (z != 0.0))


def _open_share(lattice: Lattice, within: Cells, points: FloatArray, facing: FloatArray) -> float:
    """Return how much of the surface has free space behind it; boards thinner than a cell have
    none.
    """
    known = _find_facing(facing)
    if not known.all():
        points, facing = points[known], facing[known]
    if not len(points):
        return 0.0
    behind = lattice.numbers(points - BESIDE * facing)
    # the rest may be open, unless the back of a board is there
    rest = np.flatnonzero(~(within.ravel()[behind] & (behind >= 0)))
    if not len(rest):
        return 0.0
    at = lattice.numbers(points)
    passed = at[rest], lattice.numbers(points[rest] - BESIDE / 2.0 * facing[rest]), behind[rest]
    solid = np.zeros(len(rest), dtype=np.bool_)
    for along in facing.T:
        for sense in (1.0, -1.0):
            backs = np.zeros(lattice.size + 1, dtype=np.bool_)  # the last for what is outside
            backs[at[sense * along < -FACES_ALONG]] = True
            backs[-1] = False
            own = sense * along[rest] > FACES_ALONG
            solid |= own & np.logical_or.reduce([backs[cells] for cells in passed])
    return float((~solid).sum()) / len(points)


def _drop_free_rooms(within: Cells, free: Cells) -> Cells:
    """Return the cells of seemingly enclosed rooms of which next to nothing is free."""
    from scipy import ndimage  # loaded only now: what has no space does without

    if not (within & free).any():
        return within
    rooms, count = ndimage.label(within)
    sizes = np.bincount(rooms.ravel(), minlength=count + 1)
    opened = np.bincount(rooms[free], minlength=count + 1)
    kept = opened <= FREE_SHARE * sizes
    kept[0] = False
    return np.asarray(kept[rooms], dtype=np.bool_)


def _find_empty_rooms(
    lattice: Lattice, within: Cells, outer: FloatArray, sights: Sequence[SightLines]
) -> Cells:
    """Return the cells of enclosed rooms in which something sees nothing but their walls, of
    which `outer` (k, 3) are points: it does not know whether that is a thing, nor what is outside.
    """
    from scipy import ndimage  # loaded only now: what has no space does without

    blind = np.zeros_like(within)
    eyes = np.array([lines.origin for lines in sights]).reshape(-1, 3)
    numbers = lattice.numbers(lattice.local(eyes))
    inside = np.flatnonzero((numbers >= 0) & within.ravel()[numbers])
    if not len(inside):
        return blind
    rooms, _ = ndimage.label(within)
    for nth in inside.tolist():
        if is_empty_shell(outer, sights[nth].ends, eyes[nth]):
            blind |= rooms == rooms.ravel()[numbers[nth]]
    return blind


def _find_shown_sides(facing: FloatArray) -> dict[tuple[int, int], bool]:
    """Return along which axes, and in which sense (1 or -1), seen surface faces."""
    return {
        (axis, sense): (sense * facing[:, axis] > FACES_ALONG).sum() > LEAST_SHOWN * len(facing)
        for axis in range(3)
        for sense in (1, -1)
    }


def _assign_states(
    full: Cells,
    free: Cells,
    sure: Cells,
    shown: dict[tuple[int, int], bool],
    looked: Collection[tuple[int, int]] = (),
) -> NDArray[np.uint8]:
    """Return the states of all cells, of which these are full and these free, some of them for
    `sure`.

    Of the others those are assumed to be full from which surface is met along some axis, and along
    none of them such free space before it: no place that is sure to be free opens to them. Nor do
    they lie open to two sides that are `shown`, where surface of their own would have been seen: of
    one side some may be missing, as where it mirrors; but not within a rim that was found all round
    of a side that was `looked` at: a face of these edges would have been found.
    """
    states = np.full(full.shape, State.UNSEEN, dtype=np.uint8)
    states[free], states[full] = State.FREE, State.FULL
    ahead = np.where(free & ~sure, State.UNSEEN, states).astype(np.uint8)
    opened, backed = np.zeros_like(full), np.zeros_like(full)
    missing = np.zeros(full.shape, dtype=np.uint8)
    for axis in range(3):
        for sense in (1, -1):
            met = _find_first_met(ahead, axis, sense)
            opened |= met == State.FREE
            if (axis, sense) in looked:
                opened |= (met == State.UNSEEN) & _find_within_rim(full, axis, sense)
            if shown[axis, sense]:
                missing += met == State.UNSEEN
            backed |= met == State.FULL
    states[(states == State.UNSEEN) & backed & ~opened & (missing < MOST_MISSING)] = State.ASSUMED
    return states


def _looked_at(lattice: Lattice, sights: Sequence[SightLines]) -> set[tuple[int, int]]:
    """Return the sides, by axis and sense, that enough views look at, and not along them."""
    eyes = np.array([lines.origin for lines in sights]).reshape(-1, 3)
    if not len(eyes):
        return set()
    local = lattice.local(eyes)
    found = set()
    for axis, sense in product(range(3), (1, -1)):
        middle = np.array(lattice.shape) / 2.0
        middle[axis] = lattice.shape[axis] if sense > 0 else 0.0
        steps = local - middle
        before = sense * steps[:, axis] > LOOKED_AT * np.linalg.norm(steps, axis=1)
        if int(before.sum()) >= FEWEST_VIEWS:
            found.add((axis, sense))
    return found


def _find_within_rim(full: Cells, axis: int, sense: int) -> Cells:
    """Return cells (nx, ny, nz) behind what of a side is open, with full cells at the side all
    round.
    """
    from scipy import ndimage  # loaded only now: what has no space does without

    outer = np.moveaxis(full, axis, 0)[::-sense][:RIM]
    rim: Cells = np.asarray(outer.any(axis=0))
    open_within = ndimage.binary_fill_holes(rim) & ~rim
    return np.broadcast_to(np.expand_dims(open_within, axis), full.shape)


def _wide(free: Cells) -> Cells:
    """Return the free cells that are of places `WIDE` cells wide each way."""
    from scipy import ndimage  # loaded only now: what has no space does without

    found: Cells = ndimage.binary_opening(free, np.ones((WIDE,) * 3, dtype=np.bool_))
    return found


def _find_first_met(states: NDArray[np.uint8], axis: int, sense: int) -> NDArray[np.uint8]:
    """Return the state of the first free or full cell from each cell on along an axis, else
    unseen.
    """
    layers = np.moveaxis(states, axis, 0)[::-sense]
    met = np.full_like(layers, State.UNSEEN)
    for here in range(1, len(layers)):
        before = layers[here - 1]
        met[here] = np.where(before == State.UNSEEN, met[here - 1], before)
    return np.moveaxis(met[::-sense], 0, axis)
