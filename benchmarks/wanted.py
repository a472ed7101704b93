"""What is wanted of the eyes, from pictures to faces, and what the kept reports say of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

from benchmarks.common import Cell, Row, shown

__all__ = ["WANTED", "Place", "Wanted", "wanted_rows"]

Plain = Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Place:
    """Cells of a report: the columns `of` a row of the table with that title, which may be cut.

    The row is the first that has the values of `where`.
    """

    benchmark: str
    title: str
    of: tuple[str, ...]
    where: tuple[tuple[str, Cell], ...] = ()

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
    return _at("accuracy_noise", "Front end: lines", "verdicts", changed=changed)


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
    return Place("accuracy_estimation", "Many points", ("refused %", "over 6 sd off"), where)


def _rate(wrong: str) -> Place:
    where = (("wrong matches", wrong), ("what", "estimate_points"))
    return Place("time_estimation", "CPU time a point", ("times filterpy",), where)


FACES, EDGES = "True faces", "Front end: lines"
EDGE_FIGURES = ("edges", "median %", "worst %")
FACE_FIGURES = ("true faces", "covered", "faces", "other faces", "NEES/3")

WANTED = (
    Wanted(
        "27 third-party sets: recall; precision; ground",
        "≥ .70; ≥ .95; 0",
        (_at("accuracy_faces", "All sets", "recall", "precision", "ground"),),
    ),
    Wanted("the cuboids beside them: recall", "≥ .75", (_at("accuracy_faces", "All", "boxes"),)),
    Wanted(
        "own worlds: recall; precision",
        "≥ .90; ≥ .98",
        (_at("accuracy_worlds", "All worlds", "recall", "precision"),),
    ),
    Wanted(
        "visp_cube: edges of 12; median %; worst %; true faces; covered; faces; others; NEES/3",
        "≥ 9; ≤ .5; ≤ 3; ≤ 1.5",
        (_of_set("visp_cube", EDGES, *EDGE_FIGURES), _of_set("visp_cube", FACES, *FACE_FIGURES)),
    ),
    Wanted(
        "visp_teabox_table: verdict; true faces; covered; faces; others; NEES/3",
        "box; 3 measured or implied; no others; ≤ 2",
        (
            _of_set("visp_teabox_table", EDGES, "verdicts"),
            _of_set("visp_teabox_table", FACES, *FACE_FIGURES),
        ),
    ),
    Wanted(
        "desk: true faces; covered; faces; others (real things among them); NEES/3",
        "top and both side panels",
        (_of_set("desk", FACES, *FACE_FIGURES),),
    ),
    Wanted(
        "vgg_merton1: published points on planes found; within their outlines",
        "≥ .60",
        (_of_set("vgg_merton1", "Published", "on their planes", "within their outlines"),),
    ),
    Wanted(
        "contrast 10, noise 5: corners found, all; of the box; error over the bound",
        "≥ .75; .90; ≤ 2",
        (_corners("in steps of 10 grey levels"),),
    ),
    Wanted(
        "noise 5: corners found, all; of the box; error over the bound",
        "≥ .90; 1; ≤ 1.8",
        (_corners("as it is"),),
    ),
    Wanted(
        "plain box: noise 10; noise 20",
        "box; box",
        (_noise("noise of 10 grey levels"), _noise("noise of 20 grey levels")),
    ),
    Wanted(
        "arc of 45°; of 20°",
        "box; honest unknown",
        (_noise("an arc of 45 deg"), _noise("an arc of 20 deg")),
    ),
    Wanted(
        "4 views; 3 views; 320 × 240",
        "box; box; box",
        (
            _noise("4 of the views"),
            _noise("3 of the views"),
            _noise("pictures of 320 x 240"),
        ),
    ),
    *(
        Wanted(
            f"poses off by {degrees:g}° and {mm} mm, {told}: verdict; rms mm; peer's; NEES/3",
            "box; ≤ 1.5 × the peer's; ≤ 1.5",
            (_poses(degrees, stated),),
        )
        for degrees, mm in ((0.3, 5), (1.0, 10))
        for told, stated in (("not stated", "no"), ("stated", "yes"))
    ),
    Wanted(
        "one wrong pose of 24: named; box",
        "named, the rest as before",
        (_fault("one pose of 24 wrong", "named", "box"),),
    ),
    Wanted(
        "one picture of another size: named; box; 24 black pictures: named",
        "named, the rest as before; named",
        (
            _fault("one picture of 24 of another size", "named", "box"),
            _fault("24 black pictures", "named"),
        ),
    ),
    Wanted(
        "40 % wrong matches, arcs of 30°, 10°, 3°: points refused %; wrong ones",
        "≤ 5; 0",
        (_points(30.0), _points(10.0), _points(3.0)),
    ),
    Wanted(
        "24 views of 640 × 480 to the verdict, CPU s of one core",
        "≤ .8",
        (_at("time_demo", EDGES, "median", step="pictures to verdict"),),
    ),
    Wanted(
        "200 views of 12 megapixels: CPU s to read, and to find faces, each; peak memory MB",
        "≤ 1.5; ≤ 1500",
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
        "10,000 points × 24 views, times a filterpy loop: right matches; 10 % wrong",
        "≥ 150; ≥ 40",
        (_rate("0%"), _rate("10%")),
    ),
)


def wanted_rows(reports: Mapping[str, Plain]) -> tuple[Row, ...]:
    """The rows of the table, from the reports by name; only those that something is known of."""
    rows: list[Row] = []
    for one in WANTED:
        found = [place.cells(reports) for place in one.places]
        if not any(found):
            continue
        rows.append(
            {
                "figure": one.figure,
                "wanted": one.wanted,
                "measured": "; ".join(shown(cell) for cells in found for cell in cells or (None,)),
                "by": ", ".join(dict.fromkeys(place.benchmark for place in one.places)),
            }
        )
    return tuple(rows)
