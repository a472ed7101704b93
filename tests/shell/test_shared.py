"""Errors of a command's body become one line and an exit code."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import typer

from facetlog.commands.shared import command
from facetlog.errors import EngineError


def _raising(error: BaseException) -> Callable[[], None]:
    @command
    def body() -> int:
        raise error

    return body


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (EngineError("it stopped"), 3, "it stopped"),
        (RecursionError("maximum recursion depth"), 2, "what was given is nested too deeply"),
        (MemoryError(), 2, "what was given needs more memory than there is: give less at once"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_an_error_is_one_line_and_an_exit_code(error, code, said, capsys):
    with pytest.raises(typer.Exit) as ended:
        _raising(error)()
    assert ended.value.exit_code == code
    assert capsys.readouterr().err == f"facetlog: {said}\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a device that is full")
def test_output_for_which_there_is_no_room_is_one_line(tmp_path):
    model = tmp_path / "a.model"
    model.write_text('model a\n  "A thing."\n  face f\n  level: f is level\n')
    check = (sys.executable, "-m", "facetlog", "model", "check", str(model))
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(check, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr == (
        "facetlog: the output cannot be written: No space left on device: make room\n"
    )
