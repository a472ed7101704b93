"""All ways of judging say the same of a test, and what the reference says."""

import json
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from facetlog.kb.engine.engine import house
from facetlog.kb.loading.schema import declarations
from tests.kb.one_meaning import STATES, Case, Outline, prolog, random_case, reference

HERE = Path(__file__).parent
WAYS = ("proof", "outline", "state", "specialised", "specialised state")
TOLERANCE = 1e-9
TESTS = 40  # of a scene


class Judging:
    """A process of SWI-Prolog with the program's code, asked of one scene after the other."""

    def __init__(self, code: Path | None = None) -> None:
        bridge = (code or house("kb") / "prolog") / "bridge.pl"
        program = (
            f"load_files({str(bridge)!r}, [silent(true)]),"
            f"schema:declare_facts({declarations()}),"
            "create_prolog_flag(facetlog_native, true, []),"
            "facetlog_bridge:ask_base(oracle_base, all),"
            f"load_files({str(HERE / 'one_meaning.pl')!r}, [silent(true)]),"
            "serve"
        )
        self._process = subprocess.Popen(
            ["swipl", "-q", "-g", program, "-t", "halt"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # what a mutant says of itself
            text=True,
        )

    def said(self, case: Case) -> list[list[list[object]]]:
        facts = ",".join(_fact(key, values) for key, values in case.facts.items())
        words = ",".join(f"'{word}'(X)-{prolog(meaning)}" for word, meaning in case.words.items())
        tests = ",".join(map(prolog, case.tests))
        crisp = str(case.crisp).lower()
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"scene([{facts}], [{words}], {crisp}, [{tests}]).\n")
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())  # type: ignore[no-any-return]

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(10)

    def close(self) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait(10)


def _fact(key: tuple[object, ...], values: tuple[float, ...]) -> str:
    rest = ("e1",) if key[0] == "adjoins" else values
    return prolog((*key, *rest))


@pytest.fixture(scope="module")
def judging() -> Iterator[Judging]:
    made = Judging()
    yield made
    made.close()


def differences(case: Case, rows: Sequence[Sequence[Sequence[object]]]) -> list[str]:
    """One line for each way of judging that says something else than the reference."""
    found = []
    for test, ways in zip(case.tests, rows, strict=True):
        expected = reference(case, test)
        for way, said in zip(WAYS, ways, strict=True):
            if not _agrees(said, expected):
                found.append(f"{way} of {prolog(test)}: {said}, not {expected}")
    return sorted(found, key=len)


def _agrees(said: Sequence[object], expected: Outline) -> bool:
    if said[0] != STATES[expected[0]]:
        return False
    degrees = zip(said[1:], expected[1:], strict=False)
    return all(abs(float(a) - b) <= TOLERANCE for a, b in degrees)  # type: ignore[arg-type]


@pytest.mark.parametrize("block", range(5))
def test_all_ways_of_judging_say_what_the_reference_says(judging: Judging, block: int) -> None:
    for seed in range(10 * block, 10 * block + 10):
        case = random_case(seed, TESTS)
        assert not differences(case, judging.said(case))[:3], f"seed {seed}"


@pytest.mark.slow
@pytest.mark.parametrize("block", range(25))
def test_a_hundred_thousand_tests_are_judged_alike(judging: Judging, block: int) -> None:
    for seed in range(1000 + 100 * block, 1100 + 100 * block):
        case = random_case(seed, TESTS)
        assert not differences(case, judging.said(case))[:3], f"seed {seed}"
