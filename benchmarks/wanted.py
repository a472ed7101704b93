"""What is wanted of the eyes, all at once and on line, and what the kept reports say of it.

What is wanted of the judge stands in wanted_of_the_judge.py.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

from benchmarks.common import Cell, Row, shown

__all__ = ["WANTED", "Place", "Wanted", "wanted_rows"]

Plain = Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Place:
    """Cells of a report: the columns `of` a row of the table with that title, which may be cut.

    The row is the first that has the values of `where`. `name` stands before a cell in place of its
    column's.
    """

    benchmark: str
    title: str
    of: tuple[str, ...]
    where: tuple[tuple[str, Cell], ...] = ()
    name: str = ""

    def cells(self, reports: Mapping[str, Plain]) -> tuple[Cell, ...] | None:
        """Their values; None where the report or the row is missing."""
        report = reports.get(self.benchmark)
        if report is None:
            return None
        for table in cast(Sequence[Plain], report["tables"]):
            if str(table["title"]).startswith(self.title):
                for row in cast(Sequence[Row], table["rows"]):
                    if all(row[key] == value for key, value in self.where):
                        return tuple(row.get(column) for column in self.of)
        return None

    def shown(self, reports: Mapping[str, Plain]) -> str:
        """Their names and values."""
        cells = self.cells(reports) or (None,) * len(self.of)
        named = zip(self.of, cells, strict=True)
        return "; ".join(f"{self.name or column} {shown(cell)}" for column, cell in named)


@dataclass(frozen=True, slots=True)
class Wanted:
    """A figure, what is wanted of it, and where it is measured."""

    figure: str
    wanted: str
    places: tuple[Place, ...]


def _at(benchmark: str, title: str, *of: str, **where: Cell) -> Place:
    return Place(benchmark, title, of, tuple(where.items()))


def _of_set(name: str, title: str, *of: str) -> Place:
    case = {"case": "as it is"} if title.startswith("Front") else {}
    return _at("accuracy_pictures", title, *of, set=name, **case)


def _noise(changed: str) -> Place:
    where = (("changed", changed),)
    return Place("accuracy_noise", "Front end: lines", ("verdicts",), where, changed)


def _fault(fault: str, *of: str) -> Place:
    where = (("fault", fault), ("front end", "lines"))
    return Place("accuracy_noise", "Faults", of, where)


def _poses(degrees: float, stated: str) -> Place:
    columns = ("answered", "rms mm", "peer's rms mm", "NEES/3")
    return _at("accuracy_poses", "Errors of each pose", *columns, degrees=degrees, stated=stated)


def _corners(light: str) -> Place:
    where = (("light", light), ("front end", "lines"))
    columns = ("recall", "of the block", "over the bound")
    return Place("accuracy_front_end", "Corners of all", columns, where)


def _points(arc: float) -> Place:
    where = (("arc, degrees", arc), ("views", 24), ("wrong matches", "40%"))
    columns = ("refused %", "over 6 sd off")
    return Place("accuracy_estimation", "Many points", columns, where)


def _rate(wrong: str) -> Place:
    where = (("wrong matches", wrong), ("what", "estimate_points"))
    return Place("time_estimation", "CPU time a point", ("times filterpy",), where)


def _online(views: int, *of: str) -> Place:
    where = (("views", views),)
    return Place("accuracy_online", "the block's corners", of, where, f"after {views} views")


FACES, EDGES = "True faces", "Front end: lines"
EDGE_FIGURES = ("edges", "median %", "worst %")
FACE_FIGURES = ("true faces", "covered", "faces", "other faces", "NEES/3")

LINE_FIGURES = ("recursion / all at once", "NEES / n of the recursion")
LINES = (
    "line in a picture, of 20 pixels",
    "line in space, of 8 points",
    "line in space, of 12 views",
    "plane, of 5 lines",
)

WANTED = (
    Wanted(
        "27 third-party sets, by area",
        "recall ≥ .70; precision ≥ .95; ground 0",
        (_at("accuracy_faces", "All sets", "recall", "precision", "ground"),),
    ),
    Wanted("the cuboids beside them", "recall ≥ .75", (_at("accuracy_faces", "All", "boxes"),)),
    Wanted(
        "22 of these sets, four answers; the 23 cuboids, held to be boxes",
        "right ≥ 17 of 22; wrong ≤ 1; boxes beside ≥ 18 of 23",
        (_at("accuracy_furniture", "Four", "right", "of", "wrong", "boxes beside"),),
    ),
    Wanted(
        "eight own worlds, 20 seeds each",
        "recall ≥ .90; precision ≥ .98",
        (_at("accuracy_worlds", "All worlds", "recall", "precision"),),
    ),
    Wanted(
        "visp_cube",
        "edges ≥ 9 of 12; median ≤ .5 %; worst ≤ 3 %; NEES/3 ≤ 1.5",
        (_of_set("visp_cube", EDGES, *EDGE_FIGURES), _of_set("visp_cube", FACES, *FACE_FIGURES)),
    ),
    Wanted(
        "visp_teabox_table",
        "box; three faces measured or implied; no others; NEES/3 ≤ 2",
        (
            _of_set("visp_teabox_table", EDGES, "verdicts"),
            _of_set("visp_teabox_table", FACES, *FACE_FIGURES),
        ),
    ),
    Wanted(
        "desk; other faces are real things, too",
        "top and both side panels",
        (_of_set("desk", FACES, *FACE_FIGURES),),
    ),
    Wanted(
        "vgg_merton1: share of the published points",
        "on planes, which have no end here: ≥ .60",
        (_of_set("vgg_merton1", "Published", "on their planes", "within their outlines"),),
    ),
    Wanted(
        "corners at contrast 10, noise 5",
        "recall ≥ .75; of the box .90; error ≤ 2 × the bound",
        (_corners("in steps of 10 grey levels"),),
    ),
    Wanted(
        "corners at noise 5",
        "recall ≥ .90; of the box 1; error ≤ 1.8 × the bound",
        (_corners("as it is"),),
    ),
    Wanted(
        "plain box, noise",
        "box; box",
        (_noise("noise of 10 grey levels"), _noise("noise of 20 grey levels")),
    ),
    Wanted(
        "plain box, narrow arcs",
        "box; honest unknown",
        (_noise("an arc of 45 deg"), _noise("an arc of 20 deg")),
    ),
    Wanted(
        "plain box, few views and small pictures",
        "box; box; box",
        (
            _noise("4 of the views"),
            _noise("3 of the views"),
            _noise("pictures of 320 x 240"),
        ),
    ),
    *(
        Wanted(
            f"poses off by {degrees:g}° and {mm} mm, {told}",
            "box; rms ≤ 1.5 × the peer's; NEES/3 ≤ 1.5",
            (_poses(degrees, stated),),
        )
        for degrees, mm in ((0.3, 5), (1.0, 10))
        for told, stated in (("not stated", "no"), ("stated", "yes"))
    ),
    Wanted(
        "one wrong pose of 24",
        "named, the rest as before",
        (_fault("one pose of 24 wrong", "named", "box"),),
    ),
    Wanted(
        "one picture of another size; 24 black ones",
        "named, the rest as before; named",
        (
            _fault("one picture of 24 of another size", "named", "box"),
            _fault("24 black pictures", "named"),
        ),
    ),
    Wanted(
        "40 % wrong matches; arcs of 30°, 10°, 3°",
        "refused ≤ 5 %; none wrong",
        (_points(30.0), _points(10.0), _points(3.0)),
    ),
    Wanted(
        "24 views of 640 × 480 to the verdict, CPU s of one core",
        "≤ .8",
        (_at("time_demo", EDGES, "median", step="pictures to verdict"),),
    ),
    Wanted(
        "200 views of 12 megapixels",
        "CPU ≤ 1.5 s a view; memory ≤ 1500 MB",
        (
            _at(
                "time_large",
                "200 views",
                "read CPU s/view",
                "to faces CPU s/view",
                "peak memory MB",
            ),
        ),
    ),
    Wanted(
        "10,000 points × 24 views, right matches; 10 % wrong",
        "≥ 150 and ≥ 40 times as fast as a filterpy loop",
        (_rate("0%"), _rate("10%")),
    ),
    Wanted(
        "on line, the block's corners: rms ÷ that of all views at once",
        "≤ 1.1 after the last view",
        (_online(24, "rms ratio, corners of both"),),
    ),
    Wanted(
        "on line, the block's corners: NEES/3",
        ".8 to 1.3 from the fourth view on",
        tuple(_online(views, "NEES / 3, one at a time") for views in (4, 8, 16, 24)),
    ),
    Wanted(
        "on line, random worlds: points that diverge; NEES/3",
        "0 of 10,000; .8 to 1.3",
        tuple(
            _at("accuracy_recursion", "after so many", "diverged", "NEES / 3", cameras=c, views=24)
            for c in ("all round", "arc of 60 degrees")
        ),
    ),
    Wanted(
        "twenty orders of the views: spread of points (99 %); of a block's corners, polished",
        "≤ .1 sd",
        (
            _at("accuracy_recursion", "twenty", "spread, sd (99 %)", cameras="all round"),
            _at("accuracy_online", "one block's", "spread, sd (worst corner)", block="polished"),
        ),
    ),
    Wanted(
        "lines in pictures and space, planes of lines: recursion ÷ all at once; NEES",
        "≤ 1.05; .9 to 1.1",
        tuple(
            Place("accuracy_lines", "the recursion", LINE_FIGURES, (("construction", what),))
            for what in LINES
        ),
    ),
    Wanted(
        "on line, CPU ms of a view with detection: without a search; mean of 200 with searches",
        "≤ 120; the same at view 10 and 200",
        (
            *(
                _at("accuracy_online", "a ring", "ms a view, median", views=views)
                for views in ("10 to 30", "180 to 200")
            ),
            _at("accuracy_online", "all 200", "mean ms a view, with searches"),
        ),
    ),
    Wanted(
        "10,000 points × one view, CPU ms",
        "≤ 100",
        (_at("accuracy_recursion", "ten thousand", "ms a view, median", views="180 to 200"),),
    ),
)


def wanted_rows(
    reports: Mapping[str, Plain],
    wanted: Sequence[Wanted] = WANTED,
    before: Mapping[str, str] | None = None,
) -> tuple[Row, ...]:
    """The rows of the table, from the reports by name; only those that something is known of.

    `before` has what was measured of each figure once, which then stands beside it.
    """
    rows: list[Row] = []
    for one in wanted:
        if all(place.cells(reports) is None for place in one.places):
            continue
        rows.append(
            {
                "figure": one.figure,
                "wanted": one.wanted,
                **({"before": before[one.figure]} if before else {}),
                "measured": "; ".join(place.shown(reports) for place in one.places),
                "by": ", ".join(dict.fromkeys(place.benchmark for place in one.places)),
            }
        )
    return tuple(rows)
