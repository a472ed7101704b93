"""Whether unit vectors can have given angles: exactly for three, by a search for more."""

import math
import random
from collections.abc import Mapping
from functools import lru_cache
from typing import TypeAlias

__all__ = ["FULL", "GIVE", "impossible_three", "left_over", "vectors_exist"]

Angles: TypeAlias = tuple[float, float]
"""Least and greatest angle of two directions, degrees."""

Pair: TypeAlias = tuple[int, int]

FULL: Angles = (0.0, 180.0)
"""What nothing is known of."""

GIVE = 1e-6
"""Degrees: what differs by less differs by rounding."""

NEAR = 0.1
"""Degrees by which found vectors may miss a region: the search goes towards its edge in steps."""

SEED = 4
STARTS = 30
SWEEPS = 80
"""From so many random starts, so often through all pairs. Of 300 random sets that exist, of four to
nine vectors, all were found, the hardest in 974 times through (test_lint_directions.py)."""

MOST_STEPS = 30_000
"""Pairs looked at in one search: about a tenth of a second."""


def impossible_three(ab: Angles, ac: Angles, bc: Angles) -> str:
    """Why no three directions have such angles, or nothing if some have.

    Three angles are those of three directions if each is at most the sum of the others, and all
    three are at most 360 degrees; of regions that is required of their ends. Both ways: from the
    least angles, those of the shorter two can be opened until the sum is that of the longest.
    """
    regions = (ab, ac, bc)
    if sum(low for low, _ in regions) > 360 + GIVE:
        return "more than 360 deg in all"
    for i in range(3):
        others = [high for j, (_, high) in enumerate(regions) if j != i]
        if regions[i][0] > sum(others) + GIVE:
            return "one is more than the two others together"
    return ""


def left_over(angles: Mapping[Pair, Angles]) -> dict[Pair, Angles]:
    """The angles that decide whether the directions exist, if every three of them do.

    A direction that is bound to one other, or to two whatever their angle, can always be placed
    last: it is taken away, and so on.
    """
    left = dict(angles)
    again = True
    while again:
        again = False
        neighbours: dict[int, list[int]] = {}
        for a, b in left:
            neighbours.setdefault(a, []).append(b)
            neighbours.setdefault(b, []).append(a)
        for one, others in neighbours.items():
            if len(others) == 1 or (len(others) == 2 and _placeable(left, one, *others)):
                left = {pair: region for pair, region in left.items() if one not in pair}
                again = True
                break
    return left


def _placeable(angles: Mapping[Pair, Angles], one: int, a: int, b: int) -> bool:
    """Whether a direction has its angles to two others, whatever angle these have."""
    (low1, high1), (low2, high2) = angles[_pair(one, a)], angles[_pair(one, b)]
    low, high = angles.get(_pair(a, b), FULL)
    return (
        high <= high1 + high2
        and low1 - high2 <= low
        and low2 - high1 <= low
        and low1 + low2 + high <= 360
    )


def _pair(a: int, b: int) -> Pair:
    return (a, b) if a < b else (b, a)


@lru_cache(maxsize=256)
def vectors_exist(count: int, angles: tuple[tuple[Pair, Angles], ...]) -> tuple[bool, int]:
    """Whether unit vectors with such angles were found, and how many steps that took.

    Every pair that is out of its region is turned towards it in its own plane, again and again,
    from several seeded starts. False proves nothing.
    """
    chance = random.Random(SEED)
    steps = 0
    for _ in range(STARTS):
        vectors = [_random_unit(chance) for _ in range(count)]
        for _ in range(SWEEPS):
            worst = 0.0
            for (a, b), region in angles:
                worst = max(worst, _turn(vectors, a, b, region))
            steps += len(angles)
            if worst <= NEAR:
                return True, steps
            if steps > MOST_STEPS:
                return False, steps
    return False, steps


def _random_unit(chance: random.Random) -> list[float]:
    while True:
        vector = [chance.gauss(0, 1) for _ in range(3)]
        length = math.hypot(*vector)
        if length > GIVE:
            return [x / length for x in vector]


def _turn(vectors: list[list[float]], a: int, b: int, region: Angles) -> float:
    """Turns two vectors towards their region; by how many degrees they were out of it."""
    (ax, ay, az), (bx, by, bz) = vectors[a], vectors[b]
    cosine = max(-1.0, min(1.0, ax * bx + ay * by + az * bz))
    angle = math.degrees(math.acos(cosine))
    target = min(max(angle, region[0]), region[1])
    off = angle - target
    if abs(off) <= GIVE:
        return 0.0
    # The direction in their plane that stands square on the first.
    ex, ey, ez = bx - cosine * ax, by - cosine * ay, bz - cosine * az
    length = math.hypot(ex, ey, ez)
    if length < GIVE:
        # Along one line: any plane will do.
        least = min(range(3), key=lambda i: abs(vectors[a][i]))
        axis = [0.0, 0.0, 0.0]
        axis[least] = 1.0
        along = vectors[a][least]
        ex, ey, ez = axis[0] - along * ax, axis[1] - along * ay, axis[2] - along * az
        length = math.hypot(ex, ey, ez)
    ex, ey, ez = ex / length, ey / length, ez / length
    first, second = math.radians(off / 2), math.radians(target + off / 2)
    for index, turn in ((a, first), (b, second)):
        c, s = math.cos(turn), math.sin(turn)
        x, y, z = c * ax + s * ex, c * ay + s * ey, c * az + s * ez
        # Rounding would grow from turn to turn.
        length = math.hypot(x, y, z)
        vectors[index] = [x / length, y / length, z / length]
    return abs(off)
