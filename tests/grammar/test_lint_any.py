"""Lint of whatever a text may hold: no traceback, no run-away, one message a fault."""

import random
import time
from pathlib import Path

import pytest

import facetlog.rules
from facetlog.grammar.analysis import analyse
from tests.grammar.linted import faults_in, faults_of

RULES = sorted(Path(facetlog.rules.__path__[0]).glob("*.model"))

SLOW_S = 20.0
"""Far more than any of these texts takes; without bounds they take hours."""


@pytest.mark.parametrize("path", RULES, ids=lambda path: path.stem)
def test_the_models_that_come_with_facetlog_have_no_faults(path: Path) -> None:
    assert analyse(path).faults == ()


@pytest.mark.slow
def test_any_words_in_any_order_are_read() -> None:
    chance = random.Random(3)
    texts = [path.read_text(encoding="utf-8") for path in RULES]
    tokens = " ".join(texts).split(" ")
    for _ in range(150):
        lines = chance.choice(texts).split("\n")
        for _ in range(chance.randint(1, 3)):
            at = chance.randrange(len(lines))
            words = lines[at].split(" ")
            words[chance.randrange(len(words))] = chance.choice(tokens)
            lines[at] = " ".join(words)
        faults = faults_of("\n".join(lines))
        assert all(f.message and f.span.end >= f.span.start for f in faults)


def _doubling(levels: int) -> str:
    lines = ["define f0(x): x is level, x is upward"]
    lines += [f"define f{n}(x): f{n - 1}(x), f{n - 1}(x) or f{n - 1}(x)" for n in range(1, levels)]
    return "\n".join(lines) + f"\nface a\na is measured\nf{levels - 1}(a)"


def _deep(levels: int) -> str:
    lines = ["define f0(x): 2 * length(x)"]
    inner = "(" * 30 + "f{}(x)" + " + 1 * width(x))" * 30
    lines += [f"define f{n}(x): " + inner.format(n - 1) for n in range(1, levels)]
    return "\n".join(lines) + f"\nface a\na is level, f{levels - 1}(a) at least width(a)"


NAMES = [f"f{n}" for n in range(12)]
EACH = f"each pair x, y of {', '.join(NAMES)}: "
NESTED = EACH + EACH.replace("x, y", "z, u") + EACH.replace("x, y", "v, w")


@pytest.mark.parametrize(
    "body",
    [
        _doubling(25),
        _deep(2),
        f"face {', '.join(NAMES)}\n{NESTED}angle(x, z) = 90 deg ± 5 deg, u adjoins w, v adjoins y",
        f"face {', '.join(NAMES)}\n{EACH}angle(x, y) = 80 deg ± 15 deg\n"
        + "\n".join(
            f"length({a}) at least {n} * width({b})"
            for n, a in enumerate(NAMES, 1)
            for b in NAMES
            if a != b
        ),
    ],
    ids=["doubling", "deep", "nested", "many"],
)  # fmt: skip
def test_what_would_take_for_ever_is_left(body: str) -> None:
    start = time.process_time()
    faults_in(body)
    assert time.process_time() - start < SLOW_S
