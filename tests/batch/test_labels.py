"""Tables of labels, and how labels count."""

from pathlib import Path

import pytest

from facetlog.batch.labels import (
    Label,
    Truth,
    find_labelled_classes,
    iter_unknown_labels,
    read_labels,
)
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
        ("file,label\na,\n", "labels.csv:2: has no label"),
        ("file,label\n,box\n", "labels.csv:2: has no file"),
        ("file,label\na\n", "labels.csv:2: has no label"),
        ("file,label\na,box,b\n", "labels.csv:2: has more cells"),
        ('file,label\na,"box\nb,box\nc,table\n', "is no line of a CSV: .*close quotes"),
        ('file,label\na,"box\nb,"box"\nc,table\n', "is no line of a CSV: .*close quotes"),
    ],
)
def test_a_table_that_cannot_be_used_is_one_line(text: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=says):
        read_labels(_table(tmp_path, text))


def test_labels_that_are_no_models_are_named_with_what_was_meant() -> None:
    models = ("box", "table", "step_stool")
    labels = ("box", "none", "Box", "tabel", "step stool", "near table", "lamp", "desk")
    said = list(iter_unknown_labels(labels, models, {"desk": Truth("table")}))
    meant = [line.partition("mean ")[2].partition("?")[0] for line in said[:-1]]
    assert meant == ["box", "table", "step_stool"]
    assert said[-1].endswith("none: near table, lamp")


def test_models_that_are_labels_or_what_labels_count_as_can_be_the_answer() -> None:
    models = ("desk", "box", "chair", "table")
    labels = [Label("a", "chair"), Label("b", "box"), Label("c", "lamp")]
    assert find_labelled_classes(models, labels, {}) == ("box", "chair")
    counted_as = {"lamp": Truth("table", frozenset({"none"})), "box": Truth(None)}
    assert find_labelled_classes(models, labels, counted_as) == ("box", "chair", "table")
    assert find_labelled_classes(models, [], {}) == ()
    with pytest.raises(InputError, match=r"no label is the name of a model \(desk, box, chair"):
        find_labelled_classes(models, labels[2:], {})
