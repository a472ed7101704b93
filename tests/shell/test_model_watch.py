"""--watch: what counts as a change, and how it ends."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Thread

import pytest

from facetlog.cli import main
from facetlog.commands.model import watch
from facetlog.commands.model.watch import Ran, changes, watched
from facetlog.errors import InputError
from facetlog.query_shell.model_files import stamp_of

GOOD = (
    'model slab\n  "A board."\n  face top\n  level: top is level\n'
    '  example "board" of cuboid(height 2 cm) holds\n'
)


class Steps:
    """What happens while changes are awaited, one thing at a time."""

    def __init__(self, *steps: object) -> None:
        self.steps = iter(steps)
        self.waits = 0

    def __call__(self, _: frozenset[Path]) -> None:
        self.waits += 1
        step = next(self.steps, None)
        if step is None:
            raise KeyboardInterrupt
        step()  # type: ignore[operator]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "a.model").write_text(GOOD)
    return tmp_path / "a.model"


def _count(path: Path, *steps: object) -> int:
    """How many changes there are before Ctrl-C."""
    found = 0
    wait = Steps(*steps)
    with suppress(KeyboardInterrupt):
        for _ in changes(lambda: frozenset({path}), {path: stamp_of(path)}, wait):
            found += 1
    assert wait.waits == len(steps) + 1
    return found


def test_another_content_is_a_change_and_another_time_is_none(path: Path) -> None:
    assert _count(path, lambda: path.write_text("other"), lambda: None) == 1
    assert _count(path, lambda: os.utime(path, (1, 1)), lambda: path.write_text("other")) == 0


def test_a_file_that_another_replaces_goes_or_comes_is_a_change(path: Path) -> None:
    other = path.with_name("other")
    other.write_text("other")
    assert _count(path, lambda: other.rename(path), path.unlink, lambda: path.write_text("x")) == 3


def test_a_new_file_in_a_folder_is_a_change(path: Path) -> None:
    folder = path.parent
    before = {path: stamp_of(path)}
    wait = Steps(lambda: (folder / "b.model").write_text(GOOD))
    found = changes(lambda: frozenset(folder.glob("*.model")), before, wait)
    assert set(next(found)) == {path, folder / "b.model"}


def test_a_run_is_repeated_at_each_change_and_an_error_is_no_end(
    path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    texts: list[str] = []

    def run() -> Ran:
        texts.append(path.read_text())
        if texts[-1] == "bad":
            raise InputError("this is bad")
        return Ran(0, frozenset({path, path.with_name("used.model")}))

    steps = Steps(
        lambda: path.write_text("bad"),
        lambda: path.write_text("good"),
        lambda: path.with_name("used.model").write_text("x"),
    )
    monkeypatch.setattr(watch, "wait_for_events", steps)
    with pytest.raises(KeyboardInterrupt):
        watched(run, lambda: [path], watch=True)
    assert texts == [GOOD, "bad", "good", "good"]
    err = capsys.readouterr().err
    assert "facetlog: this is bad" in err
    assert "Ctrl-C ends it" in err


def test_a_change_during_a_run_is_run_again(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[str] = []

    def run() -> Ran:
        runs.append(path.read_text())
        if len(runs) == 1:
            path.write_text("saved meanwhile")
        return Ran(0, frozenset({path}))

    monkeypatch.setattr(watch, "wait_for_events", Steps())
    with pytest.raises(KeyboardInterrupt):
        watched(run, lambda: [path], watch=True)
    assert runs == [GOOD, "saved meanwhile"]


@pytest.mark.parametrize("name", ["check", "test"])
def test_ctrl_c_ends_with_130(
    name: str, path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(watch, "wait_for_events", Steps(lambda: path.write_text(f"{GOOD} \n")))
    assert main(["model", name, "--watch", str(path)]) == 130
    out = capsys.readouterr().out
    assert len(out.splitlines()) == 2
    assert "\x1b" not in out


def test_standard_input_is_not_watched(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "check", "--watch", "-"]) == 2
    assert "read only once" in capsys.readouterr().err


def test_events_wake_before_the_time_is_over(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "LOOK_AGAIN_MS", 60_000)

    def save() -> None:
        # Until the folder is watched a change wakes nobody.
        for number in range(100):
            time.sleep(0.1)
            path.write_text(str(number))
            if not waiting.is_alive():
                return

    waiting = Thread(target=watch.wait_for_events, args=(frozenset({path.parent}),), daemon=True)
    waiting.start()
    save()
    waiting.join(timeout=10)
    assert not waiting.is_alive()


@pytest.mark.parametrize("folder", ["", "gone"])
def test_without_events_files_are_looked_at_after_a_while(
    folder: str, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watch, "LOOK_AGAIN_MS", 50)
    watch.wait_for_events(frozenset({path.parent / folder}))


@pytest.fixture
def watching(path: Path) -> Iterator["subprocess.Popen[str]"]:
    command = [sys.executable, "-m", "facetlog", "model", "check", "--watch", str(path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        yield process
        process.kill()


def test_a_real_process_checks_again_and_ends_by_a_signal(
    path: Path, watching: "subprocess.Popen[str]"
) -> None:
    assert watching.stdout is not None
    assert watching.stdout.readline() == "1 file, no faults\n"
    path.write_text(GOOD.replace("is level", "is levle"))
    assert ": error: " in watching.stdout.readline()
    watching.send_signal(signal.SIGINT)
    assert watching.wait(timeout=20) == 130
