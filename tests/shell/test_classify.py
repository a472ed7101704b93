"""`facetlog classify`: what it writes, what it says, and how it ends."""

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from facetlog.__main__ import INTERRUPTED
from facetlog.batch.output import read_rows, write_rows
from facetlog.batch.pages import scene_pages
from facetlog.cli import main
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.perception.surfaces.exact_solids.polyhedra import boxes, cuboid, table
from facetlog.perception.surfaces.scene_file import write_scene
from tests.batch.fake_worker import PAUSE, fake_row
from tests.batch.fakes import PROGRAM, fake_workers, scene_files

NAMES = ("box-1", "table-1", "bad-1", "chair-1", "lamp-1")


@pytest.fixture(autouse=True)
def _fake(request: pytest.FixtureRequest) -> Iterator[None]:
    if request.node.get_closest_marker("real_engine"):
        yield
        return
    with fake_workers():
        yield


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    scene_files(tmp_path / "in", *NAMES)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _paths(table: str) -> list[str]:
    return [Path(row["path"]).stem for row in read_rows(Path(table))]


def test_a_folder_becomes_a_table(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["classify", "in", "-o", "r.jsonl", "--workers", "2"]) == 0
    out, err = capsys.readouterr()
    assert out == ""
    assert "facetlog: warning: in/bad-1.json: is bad\n" in err
    assert re.search(r"5 scenes in .* s.*: box 1, chair 1, none 1, table 1; 1 with an error", err)
    assert _paths("r.jsonl") == sorted(NAMES)
    assert sorted(path.name for path in folder.iterdir()) == ["in", "r.jsonl"]


@pytest.mark.usefixtures("folder")
def test_one_scene_is_counted_as_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["classify", "in/box-1.json", "-o", "r.csv"]) == 0
    assert re.search(r": 1 scene in [\d.]+ s.*: box 1\n", capsys.readouterr().err)
    absent = [f"in/absent-{k}.json" for k in range(6)]
    assert main(["classify", *absent, "-o", "s.csv"]) == 0
    err = capsys.readouterr().err
    assert "1 more scene has an error\n" in err
    assert re.search(r": 6 scenes in [\d.]+ s[^:;]*: 6 with errors\n", err)


def test_rows_are_in_the_order_given_each_once(folder: Path) -> None:
    given = [f"in/{name}.json" for name in reversed(NAMES)]
    assert main(["classify", *given, *given, "-o", "r.csv", "--workers", "3"]) == 0
    assert _paths("r.csv") == list(reversed(NAMES))


@pytest.mark.usefixtures("folder")
def test_without_a_file_results_go_to_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["classify", "in/box-1.json", "in/lamp-1.json", "in/bad-1.json"]) == 0
    assert capsys.readouterr().out == (
        "in/box-1.json: box (90%)\nin/lamp-1.json: none\nin/bad-1.json: error: is bad\n"
    )
    assert main(["classify", "in/box-1.json", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == fake_row("in/box-1.json", ())


@pytest.mark.usefixtures("folder")
def test_strict_ends_with_1_if_a_scene_had_an_error() -> None:
    assert main(["classify", "in/box-1.json", "--strict", "-o", "r.csv"]) == 0
    assert main(["classify", "in/bad-1.json", "--strict", "-o", "s.csv"]) == 1
    assert _paths("s.csv") == ["bad-1"]


def test_a_path_that_vanished_is_a_row(folder: Path) -> None:
    (folder / "list").write_text("in/box-1.json\nin/gone.json\n")
    assert main(["classify", "--from", "list", "-o", "r.csv"]) == 0
    assert [bool(row["error"]) for row in read_rows(Path("r.csv"))] == [False, True]


@pytest.mark.parametrize(
    ("argv", "says"),
    [
        ([], "there is no scene to classify"),
        (["in", "-o", "r.xls"], "tables are written as"),
        (["in", "-o", "absent/r.csv"], "absent/r.csv cannot be written"),
        (["in", "-o", "old.csv"], "old.csv exists: give --overwrite, or --resume"),
        (["in", "-o", "half.csv"], "half.csv.partial is of a run that was stopped: give --resume"),
        (["in", "--models", "absent"], "absent does not exist"),
        (["in", "--up", "w"], "--up 'w': use one of"),
        (["in", "--unit", "mile"], "unit 'mile': use one of"),
        (["in", "--workers", "0"], "0 workers"),
        (["in", "--timeout", "0"], "a time limit of 0 s"),
        (["in", "--report", "r.html"], "give --labels as well"),
        (["in", "--classes", "box"], "give --labels as well"),
        (["in", "--labels", "l.csv", "--classes", "bx"], "bx is no model; there are box, table"),
        (["in", "--labels", "l.csv", "--count-as", "box=sofa"], "none of the classes box, table"),
        (["in", "--labels", "absent.csv"], "absent.csv: cannot be read"),
        (["in", "--labels", "l.csv", "--report", "no/r.html"], "no/r.html cannot be written"),
        (["in", "--html", "in"], "in holds in/bad-1.json, which is read"),
        (["in", "--html", "old.csv"], "old.csv is no folder: give another name with --html"),
        (["in", "--html", "p", "-o", "p/r.csv"], "p: holds pages alone: write p/r.csv elsewhere"),
        (["in", "--changed-since", "absent.csv"], "absent.csv: cannot be read"),
        (["in", "--dask", "tcp://127.0.0.1:1", "--workers", "2"], "give one of them"),
        (["in", "--dask", "tcp://127.0.0.1:1", "--profile"], "leave out --dask"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_before_the_work(
    argv: list[str], says: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("old.csv", "half.csv.partial"):
        (folder / name).write_text("mine")
    (folder / "p").mkdir()
    (folder / "l.csv").write_text("file,label\nin/box-1.json,box\n")
    assert main(["classify", *argv]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert says in err
    assert err.count("\n") == 1


def test_models_that_cannot_be_used_are_refused(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "refused").touch()
    assert main(["classify", "in", "--models", "refused", "-o", "r.csv"]) == 2
    assert capsys.readouterr().err == "facetlog: refused:1: no model\n"
    assert not (folder / "r.csv.partial").exists()


@pytest.mark.usefixtures("folder")
def test_overwrite_replaces_and_resume_adds(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["classify", "in/box-1.json", "-o", "r.csv"]) == 0
    assert main(["classify", "in/table-1.json", "-o", "r.csv", "--overwrite"]) == 0
    assert _paths("r.csv") == ["table-1"]
    capsys.readouterr()
    assert main(["classify", "in", "-o", "r.csv", "--resume"]) == 0
    assert "5 scenes (1 of them before)" in capsys.readouterr().err
    assert _paths("r.csv") == sorted(NAMES)


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


def test_a_table_that_cannot_be_written_at_the_end_keeps_the_rows(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
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


@pytest.mark.parametrize("stopped", [True, False])
@pytest.mark.slow
def test_resume_tries_a_scene_again_that_took_too_long(
    stopped: bool, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "in" / "slow-1.json").touch()
    argv = ["classify", "in", "-o", "r.jsonl", "--workers", "1", "--timeout", "0.5"]
    assert main(argv) == 0
    assert "slow-1.json: took longer than 2.5 s by the clock" in capsys.readouterr().err
    if stopped:  # as if it had been before the table was written
        lines = (folder / "r.jsonl").read_text().splitlines()
        head = {"journal": "facetlog-journal/1", "models": json.loads(lines[0])["models_hash"]}
        (folder / "r.jsonl.partial").write_text("\n".join([json.dumps(head), *lines, ""]))
        (folder / "r.jsonl").unlink()
    (folder / "in" / "slow-1.quick").touch()  # the machine is less busy
    assert main([*argv, "--resume"]) == 0
    err = capsys.readouterr().err
    # the one of another error is not
    assert "6 scenes (5 of them before)" in err
    assert "took longer" not in err
    assert [row["error"] for row in read_rows(Path("r.jsonl")) if "slow" in row["path"]] == [None]


def test_changed_since_tells_what_differs_and_ends_with_1(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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
    monkeypatch.setattr("facetlog.batch.run.content_hash", lambda path: path.read_text().strip("!"))
    assert main(["classify", "in", "-o", "old.csv"]) == 0
    (folder / "in" / "box-1.json").write_text("other")
    capsys.readouterr()
    assert main(["classify", "in", "-o", "new.csv", "--changed-since", "old.csv"]) == 0
    # Not those whose content is another, and not those that had an error.
    assert "(3 of them before)" in capsys.readouterr().err


LABELS = """file,label,up_axis
in/box-1.json,box,z
in/table-1.json,chair,z
in/bad-1.json,box,z
in/chair-1.json,armchair,z
in/lamp-1.json,desk,z
"""


def test_labels_make_a_matrix_and_a_report(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "labels.csv").write_text(LABELS)
    argv = ["classify", "in", "--labels", "labels.csv", "--classes", "chair,table,box"]
    counted = ["--count-as", "armchair=chair", "--count-as", "desk="]
    assert main([*argv, *counted, "-o", "r.csv", "--report", "r.html"]) == 0
    out = capsys.readouterr().out
    assert "accuracy 0.500 (2 of 4, 95 % 0.150–0.850)" in out
    assert "in/table-1.json: chair, answered table (90%)" in out
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


def test_each_scene_is_a_page_and_a_list_names_them(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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
    assert '<a href="box-1-2.html">in/b/box-1.json</a></th><td>box</td><td>90%</td>' in index
    assert "in/bad-1.json: no page: is bad</th>" in index
    assert index.count("<a ") == 5
    assert not re.search(r"""(src|href)=["']?(https?:|//)|<script""", index)


def test_pages_replace_those_of_an_earlier_run_and_nothing_else(folder: Path) -> None:
    assert main(["classify", "in", "--html", "pages", "-o", "r.csv"]) == 0
    again = ["classify", "in/box-1.json", "--html", "pages"]
    assert main([*again, "-o", "r.csv", "--overwrite"]) == 0
    assert _pages(folder / "pages") == ["box-1.html", "index.html", "run.json"]
    (folder / "pages" / "notes.txt").touch()
    assert main(again) == 2
    assert "notes.txt" in _pages(folder / "pages")


def test_a_run_that_ends_before_its_pages_leaves_none_and_may_go_on(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object, **__: object) -> Iterator[str]:
        raise KeyboardInterrupt

    argv = ["classify", "in", "--html", "pages", "-o", "r.csv"]
    with monkeypatch.context() as patch:
        patch.setattr(scene_pages, "render_page", interrupted)
        assert main(argv) == INTERRUPTED
    assert "no page is in pages" in capsys.readouterr().err
    assert sorted(path.name for path in folder.iterdir()) == ["in", "r.csv"]
    assert main([*argv, "--resume"]) == 0
    assert len(_pages(folder / "pages")) == len(NAMES) - 1 + 2


@pytest.mark.usefixtures("folder")
def test_more_pages_than_a_disk_should_hold_are_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(scene_pages, "MOST_PAGES", 4)
    assert main(["classify", "in", "--html", "pages"]) == 2
    assert "5 scenes would be as many pages" in capsys.readouterr().err


def test_what_is_right_does_not_depend_on_what_could_be_read(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "labels.csv").write_text("file,label\nin/bad-1.json,box\n")
    assert main(["classify", "--labels", "labels.csv", "--json", "-o", "r.csv"]) == 0
    matrix = json.loads(capsys.readouterr().out)["confusion"]["matrix"]
    assert matrix["box"]["error"] == 1


def test_without_scenes_those_with_a_label_are_meant(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "in" / "labels.csv").write_text("file,label\nbox-1.json,box\ntable-1.json,table\n")
    assert main(["classify", "--labels", "in/labels.csv"]) == 0
    assert "accuracy 1.000 (2 of 2" in capsys.readouterr().out


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
    """Returns when the journal has so many rows."""
    end = time.monotonic() + 60
    while time.monotonic() < end:
        if journal.exists() and journal.read_bytes().count(b"\n") > least:
            return
        time.sleep(0.01)
    raise AssertionError("the run did not begin")


@pytest.mark.parametrize("suffix", ["jsonl", "parquet"])
@pytest.mark.slow
def test_a_run_that_was_killed_goes_on_with_nothing_lost_and_nothing_twice(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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


def test_ctrl_c_keeps_the_rows_and_says_how_to_go_on(tmp_path: Path) -> None:
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
def real_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
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
def test_scenes_are_judged_by_the_models_and_bad_ones_told(
    real_scenes: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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
def test_a_page_has_all_verdicts_of_its_scene(real_scenes: Path) -> None:
    argv = ["classify", "in/a.json", "in/b.json", "in/c.json", "--html", "pages"]
    assert main([*argv, "--workers", "1"]) == 0
    assert _pages(real_scenes / "pages") == ["a.html", "b.html", "index.html", "run.json"]
    page = Path("pages/a.html").read_text(encoding="utf-8")
    assert re.search(r"<h1>t1 is a box \(\d+%\)", page)
    assert page.count('<details class="verdict ') == len(BUILTIN_MODELS)
    assert "<iframe" in page


@pytest.mark.real_engine
@pytest.mark.slow
def test_a_profile_says_what_each_model_cost(
    real_scenes: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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
def test_a_scene_that_would_take_all_memory_is_a_row_and_the_batch_goes_on(
    real_scenes: Path, capsys: pytest.CaptureFixture[str]
) -> None:
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


@pytest.mark.real_engine
@pytest.mark.parametrize("suffix", ["jsonl", "csv", "parquet"])
@pytest.mark.slow
def test_what_is_doubtful_about_a_scene_is_in_its_row(suffix: str, real_scenes: Path) -> None:
    if suffix == "parquet":
        pytest.importorskip("pyarrow")
    doubtful = replace(cuboid(0.3, 0.2, 0.1), warnings=("a \x1b[31mred\nlie",))
    write_scene(doubtful, real_scenes / "in" / "a.json")
    assert main(["classify", "in/a.json", "in/b.json", "-o", f"r.{suffix}"]) == 0
    rows = list(read_rows(Path(f"r.{suffix}")))
    assert [tuple(row["warnings"]) for row in rows] == [("a [31mred lie",), ()]


@pytest.mark.usefixtures("folder")
def test_a_label_to_count_that_does_not_occur_is_warned_of(
    capsys: pytest.CaptureFixture[str],
) -> None:
    Path("labels.csv").write_text(LABELS)
    argv = ["classify", "in", "--labels", "labels.csv", "--classes", "chair,table,box"]
    assert main([*argv, "--json"]) == 0
    plain = capsys.readouterr().out
    assert main([*argv, "--json", "--count-as", "sofa=chair"]) == 0
    out, err = capsys.readouterr()
    assert out == plain
    assert "facetlog: warning: --count-as sofa: no label is called so\n" in err
