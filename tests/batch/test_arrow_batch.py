"""Tables of scenes in, tables of rows out: as `classify -o x.parquet` makes them."""

import functools
import os
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import facetlog
from facetlog.batch import arrow_batch
from facetlog.batch.arrow_batch import close_idle_pools
from facetlog.batch.output import read_rows
from facetlog.cli import main
from facetlog.errors import InputError, RuleSyntaxError
from facetlog.perception.surfaces.exact_solids.polyhedra import chair, cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene
from tests.batch.fakes import fake_workers, scene_files

pa = pytest.importorskip("pyarrow")


@pytest.fixture
def _engines() -> Iterator[None]:
    """Fake engines, which do not outlive the test."""
    close_idle_pools()
    with fake_workers():
        yield
    close_idle_pools()


@pytest.fixture
def names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Files in the current folder, one given twice, one bad, one not there."""
    monkeypatch.chdir(tmp_path)
    scene_files(Path(), "chair-1", "box-1", "bad-1")
    return ["chair-1.json", "bad-1.json", "box-1.json", "gone.json", "box-1.json"]


def _encoded(names: list[str]) -> dict[str, Any]:
    text = pa.array(names)
    return {
        "plain": text,
        "chunked": pa.chunked_array([names[:2], [], names[2:]]),
        "dictionary": text.dictionary_encode(),
        "chunked dictionary": pa.chunked_array([names[:2], names[2:]]).dictionary_encode(),
        "large": text.cast(pa.large_string()),
        "view": text.cast(pa.string_view()),
    }


@pytest.mark.usefixtures("_engines")
def test_rows_come_in_the_order_of_paths_however_these_are_encoded(names: list[str]) -> None:
    for kind, column in _encoded(names).items():
        found = facetlog.classify_batch(pa.table({"n": range(5), "path": column}))
        assert found["path"].to_pylist() == names, kind
        assert found["model"].to_pylist() == ["chair", None, "box", None, "box"], kind
        bad = [error is not None for error in found["error"].to_pylist()]
        assert bad == [False, True, False, True, False], kind


@pytest.mark.usefixtures("_engines")
def test_a_row_without_a_path_is_an_error_of_its_own(names: list[str]) -> None:
    found = facetlog.classify_batch(pa.table({"path": [None, "box-1.json", ""]}))
    assert found["path"].to_pylist() == ["", "box-1.json", ""]
    assert [error or "" for error in found["error"].to_pylist()] == [
        arrow_batch.NO_PATH,
        "",
        arrow_batch.NO_PATH,
    ]


@pytest.mark.usefixtures("_engines")
def test_a_record_batch_comes_back_as_one(names: list[str]) -> None:
    batch = pa.RecordBatch.from_pydict({"path": names})
    found = facetlog.classify_batch(batch)
    assert isinstance(found, pa.RecordBatch)
    assert found.schema == facetlog.classify_batch(pa.table({"path": []})).schema


@pytest.mark.usefixtures("_engines")
def test_a_scene_that_ends_its_process_costs_no_other(names: list[str]) -> None:
    scene_files(Path(), "die-1")
    found = facetlog.classify_batch(pa.table({"path": ["box-1.json", "die-1.json", *names]}))
    assert found["model"].to_pylist() == ["box", None, "chair", None, "box", None, "box"]
    assert "the worker process died at it" in found["error"][1].as_py()


@pytest.mark.usefixtures("_engines")
def test_a_forked_process_opens_an_engine_of_its_own(names: list[str]) -> None:
    some = pa.table({"path": names})
    kept = facetlog.classify_batch(some)
    child = os.fork()
    if child == 0:
        right = not arrow_batch._idle and facetlog.classify_batch(some) == kept
        close_idle_pools()
        os._exit(0 if right else 1)
    assert os.waitpid(child, 0)[1] == 0
    (before,) = [pool for _, pool in arrow_batch._idle]
    assert facetlog.classify_batch(some) == kept
    assert [pool for _, pool in arrow_batch._idle] == [before]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ({"file": ["a"]}, "no column `path`"),
        ({}, "no column `path`"),
        ({"path": [1]}, "`path` is int64"),
        ({"path": ["a"], "up": [[0.0, 0.0, 1.0]]}, "`up` is list"),
        ({"path": ["a"], "override": ["yes"]}, "`override` is string"),
    ],
)
def test_a_table_that_cannot_be_used_is_refused(data: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        facetlog.classify_batch(pa.table(data))
    with pytest.raises(InputError, match="is no pyarrow"):
        facetlog.classify_batch(data)  # type: ignore[arg-type]


def test_a_column_that_is_there_twice_is_refused() -> None:
    twice = pa.Table.from_arrays([pa.array(["a"])] * 2, names=["path", "path"])
    with pytest.raises(InputError, match="two columns `path`"):
        facetlog.classify_batch(twice)


def test_options_and_models_that_cannot_be_used_are_refused() -> None:
    some = pa.table({"path": ["a.json"]})
    with pytest.raises(InputError, match="up"):
        facetlog.classify_batch(some, up="sideways")
    with pytest.raises(RuleSyntaxError, match=r"absent\.model"):
        facetlog.classify_batch(some, models="absent.model")


def test_it_is_pickled_by_reference() -> None:
    assert pickle.loads(pickle.dumps(facetlog.classify_batch)) is facetlog.classify_batch  # noqa: S301
    assert len(pickle.dumps(facetlog.classify_batch)) < 100
    bound = pickle.loads(pickle.dumps(functools.partial(facetlog.classify_batch, up="z")))  # noqa: S301
    assert bound.func is facetlog.classify_batch


@pytest.mark.usefixtures("_engines")
def test_an_engine_is_kept_until_its_models_change(names: list[str]) -> None:
    own = Path("own.model")
    own.write_text("model a\n")
    some = pa.table({"path": names})

    def workers() -> list[int]:
        facetlog.classify_batch(some, models=own)
        return [worker.process.pid for _, pool in arrow_batch._idle for worker in pool._crew]

    first = workers()
    assert len(first) == 1
    assert workers() == first
    own.write_text("model a # another\n")
    assert workers()[-1] not in first


@pytest.mark.slow
@pytest.mark.real_engine
def test_rows_and_schema_are_those_of_classify(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import pyarrow.parquet

    monkeypatch.chdir(tmp_path)
    for name, scene in {"chair": chair(), "box": cuboid(0.3, 0.2, 0.1), "table": table()}.items():
        write_scene(scene, Path(f"{name}.json"))
    Path("bad.json").write_text("{")
    Path("noise.ply").write_bytes(bytes(range(256)))
    names = ["box.json", "bad.json", "table.json", "gone.stl", "chair.json", "noise.ply"]
    try:
        made = facetlog.classify_batch(pa.table({"path": names}), up="z")
        own = {"path": ["noise.ply"] * 3, "up": ["x", None, "sideways"], "unit": [None, "mm", None]}
        stated = facetlog.classify_batch(pa.table(own), up="z", sensor=(0, 0, 1))
    finally:
        close_idle_pools()
    assert [text.split()[:3] for text in stated["read_as"].to_pylist()[:2]] == [
        ["up=x", "unit=none", "sensor=0.0,0.0,1.0"],
        ["up=z", "unit=mm", "sensor=0.0,0.0,1.0"],
    ]
    assert "up" in stated["error"][2].as_py()
    assert main(["classify", *names, "--up", "z", "-o", "x.parquet"]) == 0
    assert made.schema == pyarrow.parquet.read_schema("x.parquet")
    pyarrow.parquet.write_table(made, "made.parquet")
    assert _timeless("made.parquet") == _timeless("x.parquet")
    # A table that another program wrote is gone on with.
    pyarrow.parquet.write_table(made.slice(0, 3), "part.parquet")
    assert main(["classify", *names, "--up", "z", "-o", "part.parquet", "--resume"]) == 0
    assert _timeless("part.parquet") == _timeless("x.parquet")


def _timeless(path: str) -> list[dict[str, Any]]:
    return [{**row, "seconds": None} for row in read_rows(Path(path))]
