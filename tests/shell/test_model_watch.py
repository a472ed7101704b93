"""--watch: what counts as a change, and how it ends."""

import os
import signal
import subprocess
import sys
from contextlib import suppress

import pytest

from facetlog.commands.model import watch
from facetlog.commands.model.watch import Ran, changes, watched
from facetlog.errors import InputError
from facetlog.query_shell.model_files import read_stamp

GOOD = 'model slab\n  "A board."\n  face top\n  level: top is level\n'
GOOD += '  example "board" of cuboid(height 2 cm) holds\n'


def steps(*actions):
    """Return what waits for changes: it does one action after the other, then presses Ctrl-C."""
    waiting = iter(actions)

    def wait(_):
        action = next(waiting, None)
        if action is None:
            raise KeyboardInterrupt
        action()

    return wait


@pytest.fixture
def path(tmp_path):
    (tmp_path / "a.model").write_text(GOOD)
    return tmp_path / "a.model"


def test_content_that_differs_and_files_that_come_and_go_are_changes(path):
    other = path.with_name("other")
    other.write_text("other")
    wait = steps(
        lambda: os.utime(path, (1, 1)),  # no change
        lambda: other.rename(path),
        path.unlink,
        lambda: path.with_name("b.model").write_text(GOOD),
        lambda: None,
    )
    found = []
    with suppress(KeyboardInterrupt):
        files = changes(
            lambda: frozenset(path.parent.glob("*.model")), {path: read_stamp(path)}, wait
        )
        found.extend({file.name for file in stamps} for stamps in files)
    assert found == [{"a.model"}, set(), {"b.model"}]


def test_a_run_is_repeated_at_each_change_and_an_error_is_no_end(path, monkeypatch, capsys):
    texts = []
    used = path.with_name("used.model")

    def run():
        texts.append(path.read_text())
        if texts[-1] == "bad":
            raise InputError("this is bad")
        if len(texts) == 1:
            path.write_text("saved meanwhile")
        return Ran(0, frozenset({path, used}))

    actions = (
        lambda: path.write_text("bad"),
        lambda: path.write_text("good"),
        lambda: used.write_text("x"),
    )
    monkeypatch.setattr(watch, "wait_for_events", steps(*actions))
    with pytest.raises(KeyboardInterrupt):
        watched(run, lambda: [path], watch=True)
    assert texts == [GOOD, "saved meanwhile", "bad", "good", "good"]
    assert "facetlog: this is bad" in capsys.readouterr().err


def test_ctrl_c_ends_with_130_and_standard_input_is_not_watched(path, monkeypatch, run):
    monkeypatch.setattr(watch, "wait_for_events", steps(lambda: path.write_text(f"{GOOD} \n")))
    code, out, _ = run("model", "test", "--watch", path)
    assert (code, len(out.splitlines())) == (130, 2)
    code, _, err = run("model", "check", "--watch", "-")
    assert (code, "read only once" in err) == (2, True)


@pytest.mark.parametrize("folder", ["", "gone"])
def test_without_events_files_are_looked_at_after_a_while(folder, path, monkeypatch):
    monkeypatch.setattr(watch, "LOOK_AGAIN_MS", 50)
    watch.wait_for_events(frozenset({path.parent / folder}))


def test_a_process_checks_again_and_ends_by_a_signal(path):
    command = [sys.executable, "-m", "facetlog", "model", "check", "--watch", str(path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=environment, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            assert process.stdout.readline() == "1 file, no faults\n"
            path.write_text(GOOD.replace("is level", "is levle"))
            assert ": error: " in process.stdout.readline()
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=20) == 130
        finally:
            process.kill()
