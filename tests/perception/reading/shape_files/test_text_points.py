"""Points in text: which columns they are in, as the tools of others say it."""

from pathlib import Path

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.clouds import text_points
from facetlog.perception.reading.shape_files.clouds.point_table import PointTable
from facetlog.perception.reading.shape_files.shape_file import Limits, ShapeFile
from facetlog.perception.types import FloatArray


def read(name: str, content: bytes) -> PointTable:
    shape = ShapeFile(Path(name), "cloud", Limits(points=100))
    return text_points.read_text_points(shape, content)


ROWS = np.arange(40.0 * 6).reshape(40, 6)


def text(head: str, columns: int, separator: str = " ") -> bytes:
    rows = (separator.join(map(str, row[:columns])) for row in ROWS.tolist())
    return "\n".join([*([head] if head else []), *rows, ""]).encode()


@pytest.mark.parametrize(
    "head",
    [
        "",
        "# x y z",
        "#x y z",
        "//X Y Z",
        "//X Y Z\n40",
        "40",
        "# made on a Monday\n# x y z",
        "\n# x, y, z",
        "# x y z (metres)",
        "# columns: x y z",
        "# a fine scan",
        '"x" "y" "z"',
        "\ufeffx y z",
    ],
)
def test_place_is_in_the_first_columns(head: str) -> None:
    table = read("a.xyz", text(head, 3))
    np.testing.assert_array_equal(table.points, ROWS[:, :3])
    assert table.normals is None


def test_columns_are_found_by_their_names() -> None:
    table = read("a.xyz", text("//Nx Ny Nz Z Y X", 6))
    np.testing.assert_array_equal(table.points, ROWS[:, [5, 4, 3]])
    assert table.normals is not None
    np.testing.assert_array_equal(table.normals, ROWS[:, :3])


def test_names_with_blanks_leave_the_first_three_where_they_are() -> None:
    table = read("a.xyz", text("//X Y Z Original cloud index", 4))
    np.testing.assert_array_equal(table.points, ROWS[:, :3])


@pytest.mark.parametrize("head", ["id,east,north,height", "# id,east,north,height"])
def test_names_without_a_place_are_refused_and_quoted(head: str) -> None:
    with pytest.raises(InputError, match=r"a\.csv: has no columns x, y, z but id, east, north"):
        read("a.csv", text(head, 4, ","))


RNG = np.random.default_rng(0)
PLACES = RNG.uniform(-2.0, 9.0, (60, 3)).round(4)
COUNT = np.arange(60.0)[:, None]
TIME = np.sort(RNG.uniform(0.0, 9.0, (60, 1)), axis=0)
LABEL, COLOUR = RNG.integers(0, 5, (60, 1)), RNG.integers(0, 256, (60, 3))
SHARE = RNG.uniform(0.0, 1.0, (60, 1))
NORMAL = PLACES / np.linalg.norm(PLACES, axis=1)[:, None]


def table(*columns: FloatArray, separator: str = " ", mark: str = ".", end: str = "") -> str:
    """Rows of columns (n, k), whole numbers without a fraction."""
    rows = np.hstack(columns).tolist()
    words = ([f"{v:.0f}" if v == round(v) else f"{v:.4f}" for v in row] for row in rows)
    return "".join(separator.join(row).replace(".", mark) + end + "\n" for row in words)


READ = {
    "decimal commas, semicolons": table(PLACES, separator=";", mark=","),
    "decimal commas, tabs": table(PLACES, separator="\t", mark=","),
    "decimal commas, blanks": table(PLACES, separator="  ", mark=","),
    "decimal commas below names": "x;y;z;i\n" + table(PLACES, SHARE, separator=";", mark=","),
    "comma at the end": table(PLACES, separator=",", end=","),
    "semicolon at the end": table(PLACES, separator=";", mark=",", end=";"),
    "tab at the end": table(PLACES, separator="\t", end="\t"),
    "names with a comma at the end": "x,y,z,\n" + table(PLACES, separator=",", end=","),
    "quoted numbers": '"x","y","z"\n' + table(PLACES, separator='","').replace("\n", '"\n"')[:-1],
    "time first, named": "# time x y z\n" + table(TIME, PLACES),
    "label first, named": "label x y z\n" + table(LABEL, PLACES),
    "words first, named": "what,x,y,z\na," + table(PLACES, separator=",").replace("\n", "\na,"),
    "colour first, named": "r g b z y x\n" + table(COLOUR, PLACES[:, ::-1]),
    "intensity": table(PLACES, SHARE),
    "colour": table(PLACES, COLOUR),
    "normals": table(PLACES, NORMAL),
    "pandas": ",x,y,z\n" + table(COUNT, PLACES, separator=","),
    "R": '"x" "y" "z"\n' + table(COUNT + 1.0, PLACES),
    "PTS": "60\n" + table(PLACES, LABEL, COLOUR),
    "remarks between and after": table(PLACES).replace("\n", "\n// a\n# b\n"),
    "line ends of CR": table(PLACES).replace("\n", "\r"),
}
READ["words first, named"] = READ["words first, named"].removesuffix("a,")
READ["quoted numbers"] = READ["quoted numbers"].replace('z"\n', 'z"\n"', 1).removesuffix('"')


@pytest.mark.parametrize("case", READ)
def test_columns_of_any_usual_table_are_read(case: str) -> None:
    found = read("a.csv", READ[case].encode())
    np.testing.assert_allclose(found.points, PLACES)
    assert found.warnings == ()


@pytest.mark.parametrize("columns", [(COUNT,), (COUNT + 1.0,), (10.0 * COUNT,)])
def test_an_index_first_is_left_out_and_said(columns: tuple[FloatArray, ...]) -> None:
    found = read("a.txt", table(*columns, PLACES).encode())
    np.testing.assert_allclose(found.points, PLACES)
    assert "counts the rows" in found.warnings[0]


DEGREES = PLACES * [1e-5, 1e-5, 1.0] + [8.5, 47.3, 400.0]
REFUSED = {
    "commas for both": (table(PLACES + 3.0, separator=",", mark=","), "columns separated by"),
    "commas for both, named": ("x,y,z\n" + table(PLACES, separator=",", mark=","), "separated by"),
    "thousands": ("1,234.5;2,345.6;3,456.7\n" * 20, "thousands separators"),
    "thousands or decimals": ("1,234;2,345;3,456\n" * 20, "one of thousands"),
    "thousands and columns": ("1,234.5,2,345.6,3,456.7\n" * 20, "between thousands"),
    "time first": (table(TIME, PLACES), "never falls"),
    "label first": (table(LABEL, PLACES), "whole numbers alone"),
    "index in any order": (table(RNG.permutation(COUNT), PLACES), "whole numbers alone"),
    "colour first": (table(COLOUR, PLACES), "whole numbers alone"),
    "shares of colour first": (table(COLOUR / 255.0, PLACES), "colours or normals"),
    "normals first": (table(NORMAL, PLACES), "colours or normals"),
    "names of fewer columns": ("x y z\n" + table(PLACES, SHARE), "names 3 columns"),
    "names of more columns": ("x,y,z,i\n" + table(PLACES, separator=","), "names 4 columns"),
    "words first": (table(PLACES).replace("\n", "\nchair "), "no table of numbers"),
    "words last": ("1 2 3 red\n" * 40, "no table of numbers"),
    "prose": (
        "Permission is granted, free of charge,\nto any person, who\n",
        "no table|no x, y, z",
    ),
    "degrees, named": ("lon,lat,height\n" + table(DEGREES, separator=","), "no lengths"),
    "fewer points than claimed": ("61\n" + table(PLACES), "60 of 61 points"),
    "PTX": (
        "6\n10\n" + "0 0 0\n" * 4 + "1 0 0 0\n" * 4 + table(PLACES, SHARE),
        "PTX scan",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_columns_that_are_not_sure_are_refused(case: str) -> None:
    text, message = REFUSED[case]
    with pytest.raises(InputError, match=message):
        read("a.csv", text.encode())
