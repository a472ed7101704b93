"""What is wanted of the judge, what it was when a test's meaning was written six times (September
2026), and where it is measured now."""

from benchmarks.common import Cell
from benchmarks.wanted import Place, Wanted

__all__ = ["BEFORE", "WANTED_OF_THE_JUDGE"]


def _at(benchmark: str, title: str, *of: str, **where: Cell) -> Place:
    return Place(benchmark, title, of, tuple(where.items()))


def _answers(what: str, column: str = "ms median") -> Place:
    where = (("what", what),)
    return Place("time_answers_out", "CPU", (column,), where, f"{what}, {column}")


def _boxes(way: str, than: str) -> Place:
    where = (("n", 300), ("way", way))
    return Place("time_box_rule", "All boxes", (than,), where, f"{way}, {than}")


def _models(statements: str) -> Place:
    column = "s to parse and check: median"
    where = (("statements", statements), ("models", 1000))
    return Place("time_models", "Parsing", (column,), where, f"{statements}, s")


BEFORE = {
    "1e5 answers: two numbers to numpy ÷ forall": "8.1",
    "1e5 answers: four-tuples beside a findall": "5.5 times",
    "box rule, 300 faces": "182 ms; 7.9 × numpy; .47 × clingo, pairs first",
    "scenes a second and core, JSON to row": "15 to 20, of 9 models",
    "two workers ÷ one; start of one classify, CPU s": "1.23 to 1.45; –",
    "100,000 scenes: rows and digest, whatever is killed": "–",
    "calibration error of all verdicts, leave one source out": ".09 to .115 on unseen",
    "a thousand models checked; a look after an edit of 1,200 lines": "13.4 s; 430 ms",
}
"""The figures of then, by the name of the figure."""

WANTED_OF_THE_JUDGE = (
    Wanted(
        "1e5 answers: two numbers to numpy ÷ forall",
        "≤ 3",
        (_answers("arrays of two numbers", "÷ native"),),
    ),
    Wanted(
        "1e5 answers: four-tuples beside a findall",
        "≤ 3 times",
        (
            _answers("tuples of two names and two numbers"),
            _answers("native findall of four-tuples, swipl"),
        ),
    ),
    Wanted(
        "box rule, 300 faces",
        "≤ 2 × numpy, ≤ .1 × clingo, pairs first; a join ≤ clingo",
        (
            _boxes("each_pair, first time", "÷ numpy on arrays"),
            _boxes("each_pair, first time", "÷ clingo, pairs first"),
            _boxes("join of angles", "÷ clingo, rule on angles"),
        ),
    ),
    Wanted(
        "scenes a second and core, JSON to row",
        "≥ 100",
        (_at("time_batch", "Rates", "scenes a second and core"),),
    ),
    Wanted(
        "two workers ÷ one; start of one classify, CPU s",
        "≥ 1.8; ≤ 1.5",
        (
            _at("time_batch", "Workers", "times one", workers=2),
            _at("time_batch", "Workers", "start, CPU s", workers=1),
        ),
    ),
    Wanted(
        "100,000 scenes: rows and digest, whatever is killed",
        "the same; ≤ 200 MB a worker",
        (
            _at("time_many_scenes", "Runs", "rows", "digest", workers=1),
            _at("time_many_scenes", "Runs", "rows", "digest", workers=2),
            *(
                Place(
                    "time_many_scenes",
                    "Resident",
                    ("MB in the last",),
                    (("of", "a worker"), ("workers", workers)),
                    f"a worker's MB, {workers} of them",
                )
                for workers in (1, 2)
            ),
        ),
    ),
    Wanted(
        "calibration error of all verdicts, leave one source out",
        "≤ .04",
        (
            _at("calibration", "Expected", "ECE raw", "ECE calibrated", of="all"),
            Place(
                "calibration",
                "Expected",
                ("ECE calibrated",),
                (("of", "verdicts that hold"),),
                "of those that hold, without their own sources",
            ),
        ),
    ),
    Wanted(
        "a thousand models checked; a look after an edit of 1,200 lines",
        "≤ 4 s; ≤ 50 ms",
        (
            _models("alike"),
            _models("different"),
            Place(
                "time_models",
                "After",
                ("ms a look: median",),
                (("edits of", "lines and words"),),
            ),
        ),
    ),
)
