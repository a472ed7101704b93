"""The prompt on a terminal, driven by its keys."""

import fcntl
import os
import pty
import re
import select
import signal
import stat
import struct
import subprocess
import sys
import termios
import time
from pathlib import Path
from typing import IO

import pytest

import facetlog
from facetlog.query_shell.prompt import find_history_path, open_history
from tests.patience import allowed

from .scenes import write_block

SECONDS = 10.0
SIZE = struct.pack("HHHH", 40, 100, 0, 0)
WHERE = b"\x1b[6n"  # asks the terminal where the cursor is
READY = ":help explains"  # the hint line, drawn when keys are awaited
ANSWERED = rf"1 answer[\s\S]*{READY}"
_CONTROLS = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\x1b[()=>][0-9A-B]?|[\r\x07]")


class Terminal:
    """A facetlog at a pseudo-terminal: keys in, and the text that appears."""

    def __init__(
        self, *arguments: str, term: str = "xterm", answers: IO[bytes] | None = None
    ) -> None:
        """Answers go to the terminal too, unless a file for them is given."""
        ours, theirs = pty.openpty()
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, SIZE)
        self._fd = ours
        source = str(Path(facetlog.__file__).parents[1])
        path = os.pathsep.join(p for p in (source, os.environ.get("PYTHONPATH", "")) if p)
        self.process = subprocess.Popen(
            [sys.executable, "-m", "facetlog", *arguments],
            stdin=theirs,
            stdout=theirs if answers is None else answers,
            stderr=theirs,
            start_new_session=True,
            preexec_fn=_own_terminal,
            env={**os.environ, "TERM": term, "PYTHONPATH": path},
        )
        os.close(theirs)
        self.text = ""
        self.raw = b""

    def keys(self, text: str) -> None:
        self.text = ""
        self.raw = b""
        os.write(self._fd, text.encode())

    def until(self, wanted: str) -> str:
        """Return what appeared since the last keys, up to the wanted text."""
        end = time.monotonic() + SECONDS
        while not re.search(wanted, self.text):
            data = self._read(end)
            assert data is not None, f"{wanted!r} did not appear in {self.text!r}"
            assert data, f"facetlog ended with {self.text!r}"
            self.raw += data
            self.text += _CONTROLS.sub("", data.decode(errors="replace"))
        return self.text

    def end(self) -> int:
        """The exit code, after whatever still appears."""
        end = time.monotonic() + SECONDS
        while self._read(end):
            pass
        return self.process.wait(timeout=1.0)

    def _read(self, end: float) -> bytes | None:
        """Read what appears next: nothing if the program has ended, None if it is silent."""
        ready, _, _ = select.select([self._fd], [], [], max(0.0, end - time.monotonic()))
        if not ready:
            return None
        try:
            data = os.read(self._fd, 65536)
        except OSError:  # the terminal closes with its program
            return b""
        if WHERE in data:
            os.write(self._fd, b"\x1b[1;1R")
        return data

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        os.close(self._fd)


def _own_terminal() -> None:
    """Make the terminal the process's own, so that its Ctrl-C arrives."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


@pytest.fixture(scope="module")
def terminal(tmp_path_factory):
    """One for all tests: starting takes a while, and each leaves an empty line behind."""
    made = Terminal("query", str(write_block(tmp_path_factory.mktemp("scene"))))
    try:
        made.until(READY)
        yield made
    finally:
        made.close()


@pytest.mark.slow
def test_goals_are_answered_and_remembered(scene):
    first = Terminal("query", str(scene))
    try:
        first.until(READY)
        first.keys("angle(f1, f2, D, _)\r")
        assert "180.0" in first.until(ANSWERED)
        first.keys("\x1b[A\x1b[D\x01face(f1), \r")  # up, left, to the beginning of the line
        assert "180.0" in first.until(ANSWERED)
        first.keys("\x04")
        assert first.end() == 0
    finally:
        first.close()
    assert "+face(f1), angle(f1, f2, D, _)" in find_history_path().read_text()


@pytest.mark.slow
def test_ctrl_c_stops_a_question_within_a_second(terminal):
    terminal.keys("between(1, inf, X), X < 0\r")
    terminal.until("X < 0")
    time.sleep(0.5)
    pressed = time.monotonic()
    terminal.keys("\x03")
    terminal.until("stopped")
    assert time.monotonic() - pressed < allowed(0.0)
    terminal.keys("face(f1)\r")
    terminal.until(rf"yes[\s\S]*{READY}")


def test_a_goal_goes_on_in_the_next_line(terminal):
    terminal.keys("findall(F,\r")
    terminal.keys("face(F), L)\r")
    assert "[f1, f2, f3, f4, f5, f6]" in terminal.until(ANSWERED)


def test_tab_completes(terminal):
    terminal.keys("dihed\t")
    terminal.until(r"dihedral\(")
    terminal.keys("f1, f3, D, _)\r")
    assert "90" in terminal.until(ANSWERED)


@pytest.mark.slow
def test_a_plain_terminal_will_do(scene):
    plain = Terminal("query", str(scene), term="dumb")
    try:
        plain.until(r"\?-")
        plain.keys("face(F), F @< f2\r")
        plain.until(r"1 answer[\s\S]*\?-")
        assert b"\x1b" not in plain.raw
        plain.keys("findall(F,\rface(F), L)\r")
        assert "[f1, f2, f3, f4, f5, f6]" in plain.until(r"1 answer[\s\S]*\?-")
        plain.keys("\x03")
        # A key that comes before the line is read leaves the prompt where it is.
        plain.keys("\r")
        plain.until(r"\?-")
        plain.keys("\x04")
        assert plain.end() == 0
    finally:
        plain.close()


def test_the_history_is_for_its_owner_only():
    path = find_history_path()
    open_history(path).store_string("face(F)")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert list(open_history(path).load_history_strings()) == ["face(F)"]


def test_a_history_that_cannot_be_written_is_no_error(tmp_path):
    (tmp_path / "file").touch()
    blocked = open_history(tmp_path / "file" / "history")
    blocked.append_string("face(F)")
    assert blocked.get_strings() == ["face(F)"]
    vanished = open_history(tmp_path / "gone" / "history")
    (tmp_path / "gone" / "history").unlink()
    (tmp_path / "gone").rmdir()
    vanished.store_string("face(F)")
    assert list(vanished.load_history_strings()) == []
