"""`facetlog classify`: what it writes, what it says, and how it ends."""

import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from facetlog.batch.output import read_rows, write_rows
from facetlog.cli import main
from facetlog.perception.surfaces.exact_solids.polyhedra import boxes, cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene
from tests.batch.fake_worker import PAUSE, fake_row
from tests.batch.fakes import PROGRAM, fake_workers, scene_files

NAMES = ("box-1", "table-1", "bad-1", "chair-1", "lamp-1")


@pytest.fixture(autouse=True)
def _fake(request):
    if request.node.get_closest_marker("real_engine"):
        yield
        return
    with fake_workers():
        yield


@pytest.fixture
def folder(tmp_path, monkeypatch):
    scene_files(tmp_path / "in", *NAMES)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _paths(table: str) -> list[str]:
    return [Path(row["path"]).stem for row in read_rows(Path(table))]


def test_a_folder_becomes_a_table(folder, capsys):
    assert main(["classify", "in", "-o", "r.jsonl", "--workers", "2"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert "facetlog: warning: in/bad-1.json: is bad\n" in err
    assert re.search(r"5 scenes in .* s.*: box 1, chair 1, none 1, table 1; 1 with an error", err)
    assert _paths("r.jsonl") == sorted(NAMES)
    assert sorted(path.name for path in folder.iterdir()) == ["in", "r.jsonl"]


@pytest.mark.usefixtures("folder")
def test_without_a_file_results_go_to_standard_output(capsys):
    assert main(["classify", "in/box-1.json", "in/lamp-1.json", "in/bad-1.json"]) == 0
    assert capsys.readouterr().out == (
        "in/box-1.json: box (degree 90%)\nin/lamp-1.json: none\nin/bad-1.json: error: is bad\n"
    )
    assert main(["classify", "in/box-1.json", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == fake_row("in/box-1.json", ())


@pytest.mark.usefixtures("folder")
def test_strict_ends_with_1_if_a_scene_had_an_error():
    assert main(["classify", "in/box-1.json", "--strict", "-o", "r.csv"]) == 0
    assert main(["classify", "in/bad-1.json", "--strict", "-o", "s.csv"]) == 1
    assert _paths("s.csv") == ["bad-1"]


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        ([], "there is no scene to classify"),
        (["in", "-o", "r.xls"], "tables are written as"),
        (["in", "-o", "old.csv"], "old.csv exists: give --overwrite, or --resume"),
        (["in", "-o", "half.csv"], "half.csv.partial is of a run that was stopped: give --resume"),
        (["in", "--up", "w"], "--up 'w': use one of"),
        (["in", "--report", "r.html"], "give --labels as well"),
        (["in", "--html", "p", "-o", "p/r.csv"], "p: holds pages alone: write p/r.csv elsewhere"),
        (["in", "--changed-since", "absent.csv"], "absent.csv: cannot be read"),
        (["in", "--dask", "tcp://127.0.0.1:1", "--workers", "2"], "give one of them"),
        (["in", "--dask", "tcp://127.0.0.1:1", "--profile"], "leave out --dask"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_before_the_work(argv, says, folder, capsys):
    for name in ("old.csv", "half.csv.partial"):
        (folder / name).write_text("mine")
    (folder / "p").mkdir()
    (folder / "l.csv").write_text("file,label\nin/box-1.json,box\n")
    assert main(["classify", *argv]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert says in err
    assert err.count("\n") == 1


@pytest.mark.usefixtures("folder")
def test_overwrite_replaces_and_resume_adds(capsys):
    assert main(["classify", "in/box-1.json", "-o", "r.csv"]) == 0
    assert main(["classify", "in/table-1.json", "-o", "r.csv", "--overwrite"]) == 0
    assert _paths("r.csv") == ["table-1"]
    capsys.readouterr()
    assert main(["classify", "in", "-o", "r.csv", "--resume"]) == 0
    assert "5 scenes (1 of them before)" in capsys.readouterr().err
    assert _paths("r.csv") == sorted(NAMES)


def test_a_table_that_cannot_be_written_at_the_end_keeps_the_rows(folder, monkeypatch, capsys):
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("facetlog.perception.atomic_write.os.fsync", full)
    monkeypatch.setattr("facetlog.batch.journal.Journal.sync", lambda _: None)
    assert main(["classify", "in", "-o", "r.csv"]) == 2
    assert "No space left" in capsys.readouterr().err
    assert sorted(p.name for p in folder.iterdir()) == ["in", "r.csv.partial"]
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    with fake_workers():
        assert main(["classify", "in", "-o", "r.csv", "--resume"]) == 0
    assert "(5 of them before)" in capsys.readouterr().err
    assert _paths("r.csv") == sorted(NAMES)


def test_changed_since_tells_what_differs_and_ends_with_1(folder, capsys):
    (folder / "better").touch()
    assert main(["classify", "in", "-o", "old.csv"]) == 0
    capsys.readouterr()
    assert main(["classify", "--changed-since", "old.csv"]) == 0
    assert capsys.readouterr().out == "0 verdicts of 0 scenes differ, of 5 compared\n"
    argv = ["classify", "--changed-since", "old.csv", "--models", "better"]
    assert main(argv) == 1
    out = capsys.readouterr().out
    assert "in/box-1.json\n  box t1: holds 90 % → holds 50 %\n" in out
    assert out.endswith("3 verdicts of 3 scenes differ, of 5 compared\n")
    assert main([*argv, "-o", "new.csv", "--json"]) == 1
    changes = json.loads(capsys.readouterr().out)["changed"]["changes"]
    assert changes[0]["before"] == "holds 90 %"
    assert _paths("new.csv") == sorted(NAMES)


LABELS = """file,label,up_axis
in/box-1.json,box,z
in/table-1.json,chair,z
in/bad-1.json,box,z
in/chair-1.json,armchair,z
in/lamp-1.json,desk,z
"""


def test_labels_make_a_matrix_and_a_report(folder, capsys):
    (folder / "labels.csv").write_text(LABELS)
    argv = ["classify", "in", "--labels", "labels.csv", "--classes", "chair,table,box"]
    counted = ["--count-as", "armchair=chair", "--count-as", "desk="]
    assert main([*argv, *counted, "-o", "r.csv", "--report", "r.html"]) == 0
    out = capsys.readouterr().out
    assert "accuracy 0.500 (2 of 4, 95 % 0.150–0.850)" in out
    assert "in/table-1.json: chair, answered table (degree 90%)" in out
    page = (folder / "r.html").read_text(encoding="utf-8")
    assert 'src="data:image/png;base64,UE5H"' in page
    assert "Why not chair" in page
    assert "a &lt;top&gt; &amp; legs" in page
    assert page.count('class="card"') == 2
    assert "6 faces, 1 thing<" in page
    assert not re.search(r"""(src|href)=["']?(https?:|//)|<script""", page)
    assert main([*argv, *counted, "--json", "-o", "s.csv"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["schema"] == "facetlog-classify/1"
    assert summary["confusion"]["accuracy"]["hits"] == 2


def _pages(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_each_scene_is_a_page_and_a_list_names_them(folder, capsys):
    scene_files(folder / "in" / "b", "box-1", "plain-1")
    assert main(["classify", "in", "--html", "pages", "--workers", "2", "-o", "r.csv"]) == 0
    err = capsys.readouterr().err
    assert "in/b/plain-1.json: no page: cannot be shown\n" in err
    assert "pages of all scenes are listed in pages/index.html\n" in err
    named = {"box-1": "in/box-1", "box-1-2": "in/b/box-1", "chair-1": "in/chair-1"}
    named |= {"lamp-1": "in/lamp-1", "table-1": "in/table-1"}
    for page, scene in named.items():
        assert Path(f"pages/{page}.html").read_text() == f"<p>{scene}.json</p>"
    assert _pages(folder / "pages") == sorted(
        [*(f"{name}.html" for name in named), "index.html", "run.json"]
    )
    index = Path("pages/index.html").read_text(encoding="utf-8")
    assert '<a href="box-1-2.html">in/b/box-1.json</a></th><td>box</td><td>degree 90%</td>' in index
    assert "in/bad-1.json: no page: is bad</th>" in index
    assert index.count("<a ") == 5
    assert not re.search(r"""(src|href)=["']?(https?:|//)|<script""", index)


def _started(folder: Path, *argv: str, pause: float) -> "subprocess.Popen[str]":
    """The command in a process of its own, with workers that take their time."""
    code = (
        "import sys; import facetlog.batch.pool as pool; "
        f"pool.WORKER = (sys.executable, '-S', {PROGRAM!r}); "
        "from facetlog.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    paths = os.pathsep.join(path for path in sys.path if path)
    return subprocess.Popen(
        [sys.executable, "-c", code, "classify", *argv],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths, PAUSE: str(pause)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def _rows_in(journal: Path, least: int) -> None:
    """Wait until the journal has so many rows."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        if journal.exists() and journal.read_bytes().count(b"\n") > least:
            return
        time.sleep(0.01)
    raise AssertionError("the run did not begin")


@pytest.mark.parametrize("suffix", ["jsonl", "parquet"])
@pytest.mark.slow
def test_a_run_that_was_killed_goes_on_with_nothing_lost_and_nothing_twice(
    suffix, tmp_path, monkeypatch
):
    if suffix == "parquet":
        pytest.importorskip("pyarrow")
    monkeypatch.chdir(tmp_path)
    scene_files(tmp_path / "in", *(f"box-{i:03d}" for i in range(60)))
    output = f"r.{suffix}"
    running = _started(tmp_path, "in", "-o", output, "--workers", "2", pause=0.02)
    journal = tmp_path / f"{output}.partial"
    _rows_in(journal, 10)
    running.kill()
    running.communicate()
    before = [json.loads(line) for line in journal.read_bytes().split(b"\n")[1:-1]]
    assert 10 <= len(before) < 60
    for row in before:  # what is there is not classified again
        Path(row["path"]).rename(Path(row["path"]).with_suffix(".done"))
    given = [str(Path("in", f"box-{i:03d}.json")) for i in range(60)]
    assert main(["classify", *given, "-o", output, "--resume"]) == 0
    rows = list(read_rows(tmp_path / output))
    assert [row["path"] for row in rows] == given
    assert [row["error"] for row in rows] == [None] * 60
    assert not journal.exists()


def test_ctrl_c_keeps_the_rows_and_says_how_to_go_on(tmp_path):
    scene_files(tmp_path / "in", *(f"box-{i:03d}" for i in range(60)))
    running = _started(tmp_path, "in", "-o", "r.csv", "--workers", "1", pause=0.05)
    journal = tmp_path / "r.csv.partial"
    _rows_in(journal, 3)
    running.send_signal(2)
    out, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert out == ""
    stopped = r"facetlog: stopped after \d+ of 60 scenes; go on with --resume\n"
    assert re.fullmatch(stopped + r"facetlog: interrupted\n", err)
    assert journal.read_bytes().endswith(b"}\n")


@pytest.fixture
def real_scenes(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "in").mkdir()
    write_scene(cuboid(0.3, 0.2, 0.1), tmp_path / "in" / "a.json")
    write_scene(table(), tmp_path / "in" / "b.json")
    (tmp_path / "in" / "c.json").write_text('{"schema": "facetlog-scene/1"}')
    (tmp_path / "in" / "d.json").touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.real_engine
@pytest.mark.slow
def test_scenes_are_judged_by_the_models_and_bad_ones_told(real_scenes, capsys):
    (real_scenes / "labels.csv").write_text("file,label\nin/a.json,table\nin/b.json,table\n")
    argv = ["classify", "in", "-o", "r.jsonl", "--labels", "labels.csv", "--report", "r.html"]
    assert main([*argv, "--workers", "1"]) == 0
    rows: list[dict[str, Any]] = list(read_rows(Path("r.jsonl")))
    assert [row["model"] for row in rows] == ["box", "table", None, None]
    assert "name" in rows[2]["error"]
    assert "in/d.json" in rows[3]["error"]
    assert rows[0]["metric"] is True
    assert (rows[0]["faces"], rows[0]["things"]) == (6, 1)
    verdict = next(v for v in rows[0]["verdicts"] if v["model"] == "box")
    assert verdict["state"] == "holds"
    assert verdict["parts"]
    assert sorted(round(size["value"], 3) for size in verdict["sizes"])[-1] == 0.3
    page = Path("r.html").read_text(encoding="utf-8")
    assert "Why not table" in page
    assert "data:image/png;base64,iVBOR" in page
    assert "accuracy 0.500 (1 of 2" in capsys.readouterr().out


@pytest.mark.real_engine
@pytest.mark.slow
def test_a_profile_says_what_each_model_cost(real_scenes, capsys):
    (real_scenes / "asking.pl").write_text(
        ":- module(asking, []).\n:- use_module(facetlog(vocabulary)).\n"
        'model(asking, "What another model says.", [a]).\n'
        "candidate(asking, Thing, [F]) :- face_of(Thing, F).\n"
        'condition(asking, seen, "it is seen", _, [F], measured(F)).\n'
        'condition(asking, other, "it is a box", Thing, [_], is_a(Thing, box)).\n'
    )
    argv = ["classify", "in/a.json", "in/b.json", "in/c.json", "-o", "r.jsonl", "--json"]
    assert main([*argv, "--models", "asking.pl", "--trust", "--workers", "1", "--profile"]) == 0
    out, err = capsys.readouterr()
    profile = json.loads(out)["profile"]
    assert profile["scenes"] == 2
    assert all(seconds > 0 for seconds in profile["stages"].values())
    assert profile["models"]["asking"]["conditions"] == 2
    assert profile["models"]["asking"]["interpreted"] == ["other"]
    assert profile["models"]["asking"]["candidates"] > 6
    assert profile["models"]["box"]["inferences"] > 0
    assert "left to the interpreter: asking: other" in err.splitlines()


@pytest.mark.real_engine
@pytest.mark.slow
def test_a_scene_that_would_take_all_memory_is_a_row_and_the_batch_goes_on(real_scenes, capsys):
    many = [((x, y, 0.0), (x + 0.3, y + 0.2, 0.1)) for x in range(20) for y in range(10)]
    write_scene(boxes(many, 0.001, "many"), real_scenes / "in" / "a-many.json")
    argv = ["classify", "in/a-many.json", "in/a.json", "in/b.json", "--workers", "1"]
    assert main([*argv, "--memory", "400"]) == 0
    many_told, *others = capsys.readouterr().out.splitlines()
    assert many_told == (
        "in/a-many.json: error: needs more memory than 400 MB: give more by --memory, or fewer "
        "--workers"
    )
    assert [re.sub(r" \(.*", "", line) for line in others] == [
        "in/a.json: box",
        "in/b.json: table",
    ]


def test_rows_are_in_the_order_given_each_once(folder: Path) -> None:
    given = [f"in/{name}.json" for name in reversed(NAMES)]
    assert main(["classify", *given, *given, "-o", "r.csv", "--workers", "3"]) == 0
    assert _paths("r.csv") == list(reversed(NAMES))


def test_resume_refuses_results_of_other_models(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "better").touch()
    assert main(["classify", "in", "-o", "r.csv"]) == 0
    before = (folder / "r.csv").read_bytes()
    capsys.readouterr()
    assert main(["classify", "in", "-o", "r.csv", "--resume", "--models", "better"]) == 2
    assert "r.csv: was made by other models" in capsys.readouterr().err
    assert (folder / "r.csv").read_bytes() == before
    assert not (folder / "r.csv.partial").exists()


def test_changed_since_reads_scenes_as_they_were_read_then(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "box-1.ply").touch()
    scenes = ["classify", "box-1.ply", "in/box-1.json"]
    write_rows(
        Path("old.jsonl"),
        [
            fake_row("box-1.ply", (), "up=z unit=mm crisp"),
            fake_row("in/box-1.json", (), "crisp"),
        ],
    )
    assert main(["classify", "--changed-since", "old.jsonl"]) == 0
    assert capsys.readouterr().out == "0 verdicts of 0 scenes differ, of 2 compared\n"
    assert main([*scenes, "--changed-since", "old.jsonl", "--up", "y", "-o", "new.jsonl"]) == 0
    assert capsys.readouterr().out.endswith(
        "1 scene was read with other options than then, and not compared\n"
    )
    assert [row["read_as"] for row in read_rows(Path("new.jsonl"))] == ["unit=mm crisp", "crisp"]
    assert main([*scenes[:2], "--changed-since", "old.jsonl", "--up", "y"]) == 2
    assert "up=z unit=mm crisp, now up=y unit=mm crisp" in capsys.readouterr().err


def test_what_cannot_have_changed_is_not_classified_again(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("facetlog.batch.run.hash_content", lambda path: path.read_text().strip("!"))
    assert main(["classify", "in", "-o", "old.csv"]) == 0
    (folder / "in" / "box-1.json").write_text("other")
    capsys.readouterr()
    assert main(["classify", "in", "-o", "new.csv", "--changed-since", "old.csv"]) == 0
    # Not those whose content is another, and not those that had an error.
    assert "(3 of them before)" in capsys.readouterr().err


def test_pages_replace_those_of_an_earlier_run_and_nothing_else(folder: Path) -> None:
    assert main(["classify", "in", "--html", "pages", "-o", "r.csv"]) == 0
    again = ["classify", "in/box-1.json", "--html", "pages"]
    assert main([*again, "-o", "r.csv", "--overwrite"]) == 0
    assert _pages(folder / "pages") == ["box-1.html", "index.html", "run.json"]
    (folder / "pages" / "notes.txt").touch()
    assert main(again) == 2
    assert "notes.txt" in _pages(folder / "pages")


def test_what_is_right_does_not_depend_on_what_could_be_read(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "labels.csv").write_text("file,label\nin/bad-1.json,box\n")
    assert main(["classify", "--labels", "labels.csv", "--json", "-o", "r.csv"]) == 0
    matrix = json.loads(capsys.readouterr().out)["confusion"]["matrix"]
    assert matrix["box"]["error"] == 1
