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


@pytest.mark.parametrize("block", range(5))
@pytest.mark.slow
def test_all_ways_of_judging_say_what_the_reference_says(judging: Judging, block: int) -> None:
    for seed in range(9 * block, 9 * block + 9):
        judge_alike(judging, seed)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(25))
def test_a_hundred_thousand_cases_are_judged_alike(judging: Judging, block: int) -> None:
    for seed in range(1000 + 110 * block, 1110 + 110 * block):
        judge_alike(judging, seed)
