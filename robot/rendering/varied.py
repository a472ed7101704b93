"""Furniture, boxes and stairs whose sizes follow from a seed, as large as the real things.

Lengths are drawn in centimetres, from the ranges that makers of furniture offer, and given in
inches. `shrunk` makes a model of the thing that the paper's tour of 24 views sees well.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from facetlog.robot.rendering.furniture import (
    bed,
    bench,
    cabinet,
    crate,
    desk,
    frame,
    shelf,
    sofa,
    stairs,
    stool,
)
from facetlog.robot.rendering.solids import chair, cuboid, placed, table
from facetlog.robot.rendering.world import Solid

CM = 1 / 2.54  # inches
# What the tour's cameras, 35 inches away and 28.5 high, see whole in 20 of 24 pictures and from
# above (measured on boxes turned at random): the diagonal of the plan, and the height.
PLAN_IN = 16.5
HEIGHT_IN = 16.0
# Models are made a little smaller than that at random.
SMALLEST_SHARE = 0.8

Range = tuple[float, float]
# Height, length, and width over length, of what people sit at: coffee, dining and bar tables.
TABLES: tuple[tuple[Range, Range, Range], ...] = (
    ((38.0, 50.0), (70.0, 130.0), (0.45, 1.0)),
    ((71.0, 78.0), (70.0, 220.0), (0.42, 1.0)),
    ((90.0, 110.0), (60.0, 150.0), (0.5, 1.0)),
)
COMMONEST_TABLE = (0.25, 0.6, 0.15)

Draw = Callable[[np.random.Generator], Solid]


def shrunk(solid: Solid, rng: np.random.Generator) -> tuple[Solid, float]:
    """Return a model of a thing that fits the tour, and how many times larger the thing is."""
    x, y, z = np.ptp(solid.vertices, axis=0)
    largest = min(PLAN_IN / float(np.hypot(x, y)), HEIGHT_IN / float(z))
    share = largest * float(rng.uniform(SMALLEST_SHARE, 1.0))
    return placed(solid, 0.0, 0.0, scale=share), 1 / share


def _cm(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a length between two of so many centimetres, in inches."""
    return CM * float(rng.uniform(low, high))


def _table(rng: np.random.Generator) -> Solid:
    height, length, share = TABLES[int(rng.choice(len(TABLES), p=COMMONEST_TABLE))]
    long = _cm(rng, *length)
    return table(
        long,
        long * float(rng.uniform(*share)),
        _cm(rng, *height),
        thickness=_cm(rng, 2.0, 6.0),
        leg=_cm(rng, 4.0, 10.0),
        inset=float(rng.uniform(0.02, 0.1)),
    )


def _chair(rng: np.random.Generator) -> Solid:
    width = _cm(rng, 38.0, 55.0)
    return chair(
        width,
        width * float(rng.uniform(0.85, 1.1)),
        _cm(rng, 42.0, 50.0),
        _cm(rng, 35.0, 60.0),
        thickness=_cm(rng, 2.0, 6.0),
        leg=_cm(rng, 3.0, 6.0),
    )


def _box(rng: np.random.Generator) -> Solid:
    length = _cm(rng, 15.0, 80.0)
    width = length * float(rng.uniform(0.35, 1.0))
    return cuboid(length, width, width * float(rng.uniform(0.3, 1.5)), name="box")


def _desk(rng: np.random.Generator) -> Solid:
    ends = ((0, 0), (1, 0), (0, 1), (1, 1))[int(rng.integers(4))]
    left, right = (end * _cm(rng, 35.0, 48.0) for end in ends)
    return desk(
        _cm(rng, 110.0, 180.0),
        _cm(rng, 55.0, 80.0),
        _cm(rng, 70.0, 78.0),
        thickness=_cm(rng, 2.0, 4.0),
        panel=_cm(rng, 2.0, 4.0),
        modesty=float(rng.uniform(0.3, 0.7)),
        blocks=(left, right),
    )


def _bench(rng: np.random.Generator) -> Solid:
    panels = bool(rng.random() < 0.5)
    return bench(
        _cm(rng, 90.0, 180.0),
        _cm(rng, 28.0, 45.0),
        _cm(rng, 40.0, 50.0),
        thickness=_cm(rng, 2.5, 6.0),
        support=_cm(rng, 2.5, 6.0) if panels else _cm(rng, 4.0, 8.0),
        panels=panels,
    )


def _stool(rng: np.random.Generator) -> Solid:
    length = _cm(rng, 28.0, 42.0)
    return stool(
        length,
        length * float(rng.uniform(0.85, 1.0)),
        _cm(rng, 42.0, 75.0),
        thickness=_cm(rng, 2.0, 5.0),
        leg=_cm(rng, 3.0, 5.0),
    )


def _shelf(rng: np.random.Generator) -> Solid:
    return shelf(
        _cm(rng, 60.0, 120.0),
        _cm(rng, 22.0, 40.0),
        _cm(rng, 75.0, 200.0),
        boards=int(rng.integers(3, 7)),
        thickness=_cm(rng, 1.6, 3.0),
        back=bool(rng.random() < 0.5),
    )


def _cabinet(rng: np.random.Generator) -> Solid:
    depth = _cm(rng, 30.0, 60.0)
    on_legs = bool(rng.random() < 0.5)
    return cabinet(
        _cm(rng, 40.0, 110.0),
        depth,
        depth * float(rng.uniform(1.3, 3.5)),
        foot=_cm(rng, 8.0, 15.0) if on_legs else _cm(rng, 5.0, 10.0),
        leg=_cm(rng, 3.0, 6.0) if on_legs else 0.0,
    )


def _stairs(rng: np.random.Generator) -> Solid:
    return stairs(
        int(rng.integers(3, 6)), _cm(rng, 60.0, 110.0), _cm(rng, 15.0, 20.0), _cm(rng, 24.0, 32.0)
    )


def _steps(rng: np.random.Generator) -> Solid:
    return stairs(2, _cm(rng, 35.0, 50.0), _cm(rng, 18.0, 24.0), _cm(rng, 17.0, 24.0))


def _bed(rng: np.random.Generator) -> Solid:
    height = _cm(rng, 35.0, 60.0)
    return bed(
        _cm(rng, 185.0, 215.0),
        _cm(rng, 80.0, 190.0),
        height,
        head=height + _cm(rng, 20.0, 60.0),
        thickness=_cm(rng, 3.0, 8.0),
    )


def _sofa(rng: np.random.Generator) -> Solid:
    seat = _cm(rng, 36.0, 48.0)
    return sofa(
        _cm(rng, 150.0, 240.0),
        _cm(rng, 75.0, 100.0),
        seat + _cm(rng, 30.0, 45.0),
        seat=seat,
        arm=_cm(rng, 10.0, 25.0),
        back=_cm(rng, 15.0, 28.0),
    )


def _crate(rng: np.random.Generator) -> Solid:
    length = _cm(rng, 30.0, 60.0)
    width = length * float(rng.uniform(0.5, 1.0))
    return crate(length, width, width * float(rng.uniform(0.45, 0.9)), thickness=_cm(rng, 0.8, 2.0))


def _door(rng: np.random.Generator) -> Solid:
    size = _cm(rng, 70.0, 100.0), _cm(rng, 3.5, 8.0), _cm(rng, 195.0, 215.0)
    return cuboid(*size, name="door")


def _frame(rng: np.random.Generator) -> Solid:
    width = _cm(rng, 25.0, 70.0)
    return frame(
        width,
        width * float(rng.uniform(0.75, 1.5)),
        thickness=_cm(rng, 1.5, 3.0),
        rim=width * float(rng.uniform(0.08, 0.16)),
    )


VARIED: Mapping[str, Draw] = MappingProxyType(
    {
        "boxes": _box,
        "tables": _table,
        "chairs": _chair,
        "desk": _desk,
        "bench": _bench,
        "stool": _stool,
        "shelf": _shelf,
        "cabinet": _cabinet,
        "stairs": _stairs,
        "steps": _steps,
        "bed": _bed,
        "sofa": _sofa,
        "crate": _crate,
        "door": _door,
        "frame": _frame,
    }
)
"""The thing at its real size in inches, by the name of its world."""
