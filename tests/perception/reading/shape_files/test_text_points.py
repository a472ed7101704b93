"""Points in text: which columns they are in, as the tools of others say it."""

import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.text_points import points_from_text

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
    table = points_from_text("a.xyz", text(head, 3), 100)
    np.testing.assert_array_equal(table.points, ROWS[:, :3])
    assert table.normals is None


@pytest.mark.parametrize("head", ["# x y z nx ny nz", "//X Y Z Nx Ny Nz", "x y z nx ny nz"])
def test_normals_are_found_by_their_names(head: str) -> None:
    table = points_from_text("a.xyz", text(head, 6), 100)
    np.testing.assert_array_equal(table.points, ROWS[:, :3])
    assert table.normals is not None
    np.testing.assert_array_equal(table.normals, ROWS[:, 3:])


@pytest.mark.parametrize("separator", [" ", ",", ";"])
def test_names_in_a_remark_may_be_in_any_order(separator: str) -> None:
    table = points_from_text("a.xyz", text("# i z y x", 4, separator), 100)
    np.testing.assert_array_equal(table.points, ROWS[:, [3, 2, 1]])


def test_names_with_blanks_leave_the_first_three_where_they_are() -> None:
    table = points_from_text("a.xyz", text("//X Y Z Original cloud index", 4), 100)
    np.testing.assert_array_equal(table.points, ROWS[:, :3])


@pytest.mark.parametrize("head", ["id,east,north,height", "# id,east,north,height"])
def test_names_without_a_place_are_refused_and_quoted(head: str) -> None:
    with pytest.raises(InputError, match=r"a\.csv: has no columns x, y, z but id, east, north"):
        points_from_text("a.csv", text(head, 4, ","), 100)


def test_names_that_fit_no_columns_are_refused() -> None:
    with pytest.raises(InputError, match=r"names 5 columns .* of rows of 4 numbers"):
        points_from_text("a.csv", text("time,red,x,y,z", 4, ","), 100)


def test_words_within_a_row_of_numbers_are_no_names() -> None:
    with pytest.raises(InputError, match="no table of numbers"):
        points_from_text("a.xyz", b"1 2 3 red\n" * 40, 100)
