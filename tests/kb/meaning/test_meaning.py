"""All ways of judging say the same of a test and of a model, and what the reference says."""

from collections.abc import Iterator

import pytest

from tests.kb.meaning.cases import random_case
from tests.kb.meaning.judging import Judging, differences

TESTS = 36  # of a scene


@pytest.fixture(scope="module")
def judging() -> Iterator[Judging]:
    made = Judging()
    yield made
    made.close()


def judge_alike(judging: Judging, seed: int) -> None:
    case = random_case(seed, TESTS)
    assert not differences(case, judging.said(case))[:3], f"seed {seed}"


def test_all_ways_of_judging_say_what_the_reference_says(judging: Judging) -> None:
    for seed in range(12):
        judge_alike(judging, seed)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(5))
def test_thousands_of_cases_are_judged_alike(judging: Judging, block: int) -> None:
    for seed in range(1000 + 45 * block, 1045 + 45 * block):
        judge_alike(judging, seed)
