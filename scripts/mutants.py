"""Does a wrong meaning of a test stay unseen? Changes the clauses that judge, one place at a time,
and lets the oracle of tests/kb/meaning look at each change.

    python scripts/mutants.py [--scenes N] [--only FILE] [--list]

A mutant is killed when a way of judging says something else than the reference, or an error. The
survivors are printed with their lines; the exit status is 1 if there are any.
"""

import argparse
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread

from facetlog.kb.engine.engine import house
from tests.kb.meaning.cases import random_case
from tests.kb.meaning.judging import Judging, differences
from tests.kb.meaning.test_meaning import TESTS

# The rows of the table and what works on it, then the rules by which models are specialised.
FILES = (
    "meaning/forms.pl",
    "meaning/say.pl",
    "meaning/compare.pl",
    "meaning/quantities.pl",
    "batch/partial.pl",
    "batch/branches.pl",
    "batch/loops.pl",
    "batch/arithmetic.pl",
)
SCENES = 60
SECONDS = 30  # for the tests of a scene: a mutant that never ends is seen, too

# What may be written for what: whole words and operators of clauses.
CHANGES = (
    (r"\bholds\b", "fails"),
    (r"\bfails\b", "unknown"),
    (r"\bunknown\b", "holds"),
    (r"\bmax\(", "min("),
    (r"\bmin\(", "max("),
    (r" is 1 - ", " is 1 + "),
    (r" - ", " + "),
    (r" \+ ", " - "),
    (r"(?<=[A-Za-z0-9)])\*(?=[A-Z(])", "+"),
    (r"(?<=[A-Za-z0-9)])/(?=[A-Z(0-9])", "*"),
    (r" >= ", " < "),
    (r" < ", " >= "),
    (r" > ", " =< "),
    (r" == ", " \\== "),
    (r"\bstate\b(?=[,)])", "full"),
    (r"\bbelow\b", "above"),
    (r"\babove\b", "below"),
)  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One change of one line of a file."""

    file: str
    line: int
    before: str
    after: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.before.strip()}  →  {self.after.strip()}"


def mutants(root: Path, file: str) -> Iterator[Mutant]:
    """All single changes of the clauses of a file: not of comments, directives and headers."""
    in_header = in_comment = False
    for number, line in enumerate((root / file).read_text(encoding="utf-8").splitlines(), 1):
        if "/*" in line:
            in_comment = True
        in_header = in_header or (not in_comment and line.startswith(":-"))
        if not (in_header or in_comment) and line.strip() and not line.lstrip().startswith("%"):
            body = re.split(r"\s%", line)[0]
            for pattern, new in CHANGES:
                for found in re.finditer(pattern, body):
                    after = body[: found.start()] + new + body[found.end() :]
                    yield Mutant(file, number, body, after)
        if in_header and line.rstrip().endswith("."):
            in_header = False
        if "*/" in line:
            in_comment = False


def killed(mutant: Mutant | None, scenes: int) -> bool:
    """Whether the oracle sees that something is wrong; without a mutant, of what is there."""
    with tempfile.TemporaryDirectory() as name:
        for part in ("kb/prolog", "rules"):
            shutil.copytree(house(part.partition("/")[0]).parent / part, Path(name) / part)
        if mutant is not None:
            path = Path(name) / "kb" / "prolog" / mutant.file
            lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
            lines[mutant.line - 1] = mutant.after + "\n"
            path.write_text("".join(lines), encoding="utf-8")
        judging = Judging(Path(name) / "kb" / "prolog")
        try:
            return any(_differs(judging, seed) for seed in range(scenes))
        finally:
            judging.kill()


def _differs(judging: Judging, seed: int) -> bool:
    case = random_case(seed, TESTS)
    answer: SimpleQueue[bool] = SimpleQueue()

    def ask() -> None:
        try:
            answer.put(bool(differences(case, judging.said(case))))
        except (OSError, ValueError, LookupError):
            answer.put(True)  # it died, or writes what nobody can read

    Thread(target=ask, daemon=True).start()
    try:
        return answer.get(timeout=SECONDS)
    except Empty:
        return True


def main() -> int:
    """Prints the survivors."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--scenes", type=int, default=SCENES, help="that each mutant is tried on")
    parser.add_argument("--only", action="append", help="a file, such as meaning/forms.pl")
    parser.add_argument("--every", type=int, default=1, help="one of so many mutants")
    options = parser.parse_args()
    root = house("kb") / "prolog"
    found = [one for file in options.only or FILES for one in mutants(root, file)]
    found = found[:: options.every]
    if killed(None, options.scenes):
        raise SystemExit("the program itself differs from the reference: run the test first")
    survivors = []
    for mutant in found:
        if not killed(mutant, options.scenes):
            survivors.append(mutant)
            print(f"survives: {mutant}", flush=True)
    print(f"{len(found)} mutants, {len(survivors)} survive")
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main())
