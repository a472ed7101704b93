"""All ways of judging, asked of cases; where they say something else than the reference."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

from facetlog.kb.engine.engine import house
from facetlog.kb.loading.builtin_rules import builtin_rules
from facetlog.kb.loading.encode import declarations
from tests.kb.meaning.cases import Case
from tests.kb.meaning.models import Model
from tests.kb.meaning.proofs import Proof, proof_of
from tests.kb.meaning.reference import said
from tests.kb.meaning.scene import HOLDS, STATES, FaultyTestError, Scene
from tests.kb.meaning.terms import Term, mentions, prolog
from tests.kb.meaning.verdicts import rank, scene_of, verdict, verdict_on

__all__ = ["HERE", "Judging", "close", "differences", "program", "written"]

HERE = Path(__file__).parent
WAYS = ("proof", "outline", "state", "specialised", "specialised state")
TOLERANCE = 1e-9
NO_DEGREE = 0.001  # least_degree/1 of specialise.pl
# Two choices of faces that differ by less may be told apart by rounding.
ALIKE = (0, 0, 0, 2, 2, 2)


def program() -> str:
    """Return the goal that loads the program and judging.pl."""
    bridge = house("kb") / "prolog" / "bridge.pl"
    return (
        f"load_files({str(bridge)!r}, [silent(true)]),"
        f"asserta(user:file_search_path(facetlog, {str(builtin_rules())!r})),"
        f"schema:declare_facts({declarations()}),"
        "create_prolog_flag(facetlog_native, true, []),"
        f"load_files({str(HERE / 'judging.pl')!r}, [silent(true)])"
    )


class Judging:
    """A process of SWI-Prolog with the program's code, asked of one case after the other."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            ["swipl", "-q", "-g", f"{program()},serve", "-t", "halt"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def said(self, case: Case) -> Any:
        """Return the answer of judging.pl to the case."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(written(case))
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait(10)


def written(case: Case) -> str:
    """Return the line that judging.pl reads."""
    facts = ",".join(_fact(key, values) for key, values in case.facts.items())
    files = [f"[{','.join(f'({rule})' for rule in rules)}]" for rules in case.rules()]
    tests = ",".join(map(prolog, case.tests))
    pairs = ",".join(f"pair(X,Y,{prolog(test)})" for test in case.pairs)
    models = ",".join(model.name for model in case.models)
    crisp = str(case.crisp).lower()
    return f"case([{facts}],[{','.join(files)}],{crisp},[{tests}],[{pairs}],[{models}]).\n"


def _fact(key: tuple[object, ...], values: tuple[float, ...]) -> str:
    rest = ("e1",) if key[0] == "adjoins" else values
    term = (*key, *rest)
    return prolog(term)


def differences(case: Case, rows: Any) -> list[str]:
    """Return one line for each way of judging that says something else than the reference, short
    ones first."""
    tests, pairs, verdicts = rows
    scene = scene_of(case)
    found = []
    for test, ways in zip(case.tests, tests, strict=True):
        found += _of_test(scene, test, ways)
    for test, said_pairs in zip(case.pairs, pairs, strict=True):
        expected = _pairs(scene, test)
        if said_pairs != expected:
            found.append(f"each_pair of {prolog(test)}: {said_pairs}, not {expected}")
    for model, both in zip(case.models, verdicts, strict=True):
        for way, one in zip(("verdict", "brief verdict"), both, strict=True):
            refused = way == "brief verdict" and _is_refused(scene, model, one)
            if not refused and not _same_verdict(scene, model, one):
                found.append(f"{way} of {model.name}: {one}, not {verdict(scene, model)}")
    return sorted(found, key=len)


# -------------------------------------------------------------------------------------------- tests


def _of_test(scene: Scene, test: Term, ways: Sequence[Any]) -> Iterator[str]:
    expected: tuple[object, ...]
    try:
        state, *degrees = said(scene, test)
        expected = (STATES[state], *degrees)
    except FaultyTestError as error:
        expected = ("error", error.kind, error.expected, prolog(error.culprit).replace("'", ""))
    general = mentions(test, "is_a")
    for way, row in zip(WAYS, ways[:-1], strict=True):
        if general and way.startswith("specialised") and "facetlog_general" in str(row):
            continue  # what depends on verdicts is left to the interpreter
        if not close(row, expected[: len(row)]):
            yield f"{way} of {prolog(test)}: {row}, not {expected}"
    if ways[-1] != "none" and expected[0] != "error":
        wrong = _wrong_step(ways[-1], proof_of(scene, test))
        if wrong:
            yield f"proof of {prolog(test)}: {wrong}"


def close(said_now: Any, expected: Any) -> bool:
    """Return whether words are equal, and numbers that are as good as equal."""
    if isinstance(said_now, list):
        return len(said_now) == len(expected) and all(map(close, said_now, expected))
    if isinstance(expected, (int, float)) and isinstance(said_now, (int, float)):
        return abs(said_now - expected) <= TOLERANCE * max(1, abs(expected))
    return bool(said_now == expected)


def _wrong_step(row: Any, expected: Proof) -> str:
    """Return the fault of the first step that is not as expected."""
    state, low, high, detail, rows = row
    if not close([state, low, high], [expected.state, expected.low, expected.high]):
        return f"{row[:4]}, not {expected.state, expected.low, expected.high}"
    if not any(close(detail, list(one)) for one in expected.details):
        return f"{detail}, not {expected.details}"
    if len(rows) != len(expected.steps):
        return f"{len(rows)} steps below {detail}, not {len(expected.steps)}"
    if expected.ordered:
        wrong = map(_wrong_step, rows, expected.steps)
        return next((one for one in wrong if one), "")
    left = [list(one[:3]) for one in rows]
    for step in expected.steps:
        outline = [step.state, step.low, step.high]
        alike = next((one for one in left if close(one, outline)), None)
        if alike is None:
            return f"none of {left} below is {outline}"
        left.remove(alike)
    return ""


def _pairs(scene: Scene, test: Term) -> list[list[str]]:
    faces = sorted(str(key[1]) for key in scene.case.facts if key[0] == "evidence")
    return [
        [x, y]
        for x, y in combinations(faces, 2)
        if said(scene.with_names({"X": x, "Y": y}), test)[0] == HOLDS
    ]


# ----------------------------------------------------------------------------------------- verdicts


def _is_refused(scene: Scene, model: Model, row: Any) -> bool:
    """Return whether a row says only that the model fails, and no assignment has a degree."""
    expected = verdict(scene, model)
    return row[0] == expected[0] == "fails" and not row[3] and expected[2] < NO_DEGREE


def _same_verdict(scene: Scene, model: Model, row: Any) -> bool:
    expected = verdict(scene, model)
    if len(row) != len(expected):
        return False
    roles = dict(row[3])
    chosen, best = (
        tuple(str(of.get(part.lower())) for part in model.parts) for of in (roles, expected.roles)
    )
    if chosen != best and roles and expected.roles:
        # As good as the best, but for rounding.
        ranks = zip(rank(scene, model, chosen), rank(scene, model, best), ALIKE, strict=True)
        if all(a == b or abs(a - b) <= most for a, b, most in ranks):
            expected = verdict_on(scene, model, chosen)
    return (
        close(row[:3], expected[:3])
        and roles == expected.roles
        and close(row[4], [list(size) for size in expected.sizes])
    )
