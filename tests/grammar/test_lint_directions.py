"""Unit vectors with given angles."""

import math
import random
from itertools import combinations

import pytest

from facetlog.grammar.lint.directions import impossible_three, left_over, vectors_exist


def _unit(chance: random.Random) -> list[float]:
    vector = [chance.gauss(0, 1) for _ in range(3)]
    return [x / math.hypot(*vector) for x in vector]


def _angle(a: list[float], b: list[float]) -> float:
    dot = sum(x * y for x, y in zip(a, b, strict=True))
    return math.degrees(math.acos(max(-1.0, min(1.0, dot))))


def test_three_vectors_that_exist_are_never_called_impossible() -> None:
    chance = random.Random(1)
    for _ in range(2000):
        a, b, c = (_unit(chance) for _ in range(3))
        regions = [
            (x - chance.random(), x + chance.random())
            for x in (_angle(a, b), _angle(a, c), _angle(b, c))
        ]
        assert not impossible_three(*regions)


@pytest.mark.parametrize("seed", range(100))
def test_vectors_that_exist_are_found(seed: int) -> None:
    chance = random.Random(seed)
    count = chance.randint(4, 9)
    vectors = [_unit(chance) for _ in range(count)]
    width = chance.choice([1, 5, 15])
    regions = {}
    for a, b in combinations(range(count), 2):
        if chance.random() < 0.7:
            angle = _angle(vectors[a], vectors[b])
            low, high = angle - width * chance.random(), angle + width * chance.random()
            regions[a, b] = (max(0.0, low), min(180.0, high))
    assert vectors_exist(count, tuple(sorted(regions.items())))[0]


def test_vectors_that_do_not_exist_are_not_found() -> None:
    square = tuple((pair, (85.0, 95.0)) for pair in combinations(range(4), 2))
    assert not vectors_exist(4, square)[0]


def test_a_direction_bound_to_one_other_is_taken_away() -> None:
    assert left_over({(0, 1): (10.0, 20.0), (1, 2): (30.0, 40.0)}) == {}


def test_a_direction_is_kept_whose_place_depends_on_others() -> None:
    square = dict.fromkeys(combinations(range(4), 2), (85.0, 95.0))
    assert left_over(square) == square
