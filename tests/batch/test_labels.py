"""Tables of labels, and how labels count."""

from pathlib import Path

import pytest

from facetlog.batch.labels import Truth, read_labels, truths
from facetlog.errors import InputError


def _table(folder: Path, text: str) -> Path:
    path = folder / "labels.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_table_says_what_is_there_and_how_it_is_read(tmp_path: Path) -> None:
    path = _table(
        tmp_path,
        "\ufefffile,label,up_axis,units,note,kind\n"
        "a/b.ply,chair,z (from table plane),mm,x,mesh\n"
        "c.ply,table,unknown,scaled-down (not real metres),,points\n"
        "d.ply,box,,,,\n",
    )
    found = read_labels(path)
    assert list(found) == [str(tmp_path / name) for name in ("a/b.ply", "c.ply", "d.ply")]
    read = [(x.label, x.up, x.unit, x.kind) for x in found.values()]
    assert read == [
        ("chair", "z", "mm", "mesh"),
        ("table", "none", "none", "points"),
        ("box", None, None, ""),
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "lacks the column file and label"),
        ("file,what\na,b\n", "lacks the column label"),
        ("file,label\na,b\n./a,c\n", "labels.csv:3: ./a is there twice"),
    ],
)
def test_a_table_that_cannot_be_used_is_one_line(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=says):
        read_labels(_table(tmp_path, text))


def test_a_table_that_is_not_there_or_no_text_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_labels(tmp_path / "absent.csv")
    (tmp_path / "labels.csv").write_bytes(b"file,label\n\xff,\xfe\n")
    with pytest.raises(InputError, match="is no CSV of labels"):
        read_labels(tmp_path / "labels.csv")


def test_labels_count_as_they_are_told_to() -> None:
    found = truths(["armchair=chair", "desk=", "cabinet=none|box"], ["chair", "box"])
    assert found == {
        "armchair": Truth("chair"),
        "desk": Truth(None),
        "cabinet": Truth("none", frozenset({"box"})),
    }


@pytest.mark.parametrize("text", ["desk", "=chair", "desk=sofa"])
def test_a_way_to_count_that_cannot_be_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=f"--count-as {text}"):
        truths([text], ["chair"])
    assert text != "desk=sofa" or truths([text], None)["desk"] == Truth("sofa")
