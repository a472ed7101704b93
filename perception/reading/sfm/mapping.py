"""Structure from motion in a process of its own (mapper.py), from our side."""

import json
import os
import subprocess
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TypeAlias

from pydantic import TypeAdapter

from facetlog.errors import EngineError
from facetlog.perception.reading.sfm.outcome import Outcome
from facetlog.perception.reading.sfm.request import Request, Settings
from facetlog.perception.reading.shots import Shot
from facetlog.python_process import importing_environment, python_module

__all__ = ["can_map", "map_pictures"]

PROGRAM = python_module("facetlog.perception.reading.sfm.mapper")
LAST_WORDS = 300
"""Characters of what a program that failed wrote at the end."""

Progress: TypeAlias = Callable[[str, int, int], None]


def can_map() -> bool:
    """Whether the package that does it is there (extra facetlog[sfm])."""
    return find_spec("pycolmap") is not None


def map_pictures(
    shots: tuple[Shot, ...], model: Path, settings: Settings, progress: Progress | None
) -> Outcome:
    """Places pictures together; the largest group is a COLMAP model in the folder `model` then.

    The same pictures give the same model. `progress` is called with a step's name, how much of it
    is done, and of how much. Raises EngineError if the process dies. Ctrl-C ends it.
    """
    with (
        tempfile.TemporaryDirectory(prefix="facetlog-sfm-") as work,
        tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as errors,
    ):
        request = Request(shots, Path(work), model, len(os.sched_getaffinity(0)), settings)
        asked = Path(work) / "request.json"
        asked.write_bytes(TypeAdapter(Request).dump_json(request))
        with subprocess.Popen(
            (*PROGRAM, str(asked)),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=errors,
            # A Ctrl-C of the terminal is for us.
            start_new_session=True,
            env=importing_environment(),
            text=True,
        ) as process:
            try:
                outcome = _answer(process, progress)
            except BaseException:
                process.kill()
                raise
        if outcome is None:
            errors.seek(0)
            last = " ".join(errors.read().split())[-LAST_WORDS:]
            raise EngineError(
                f"structure from motion (pycolmap) ended with code {process.returncode}: "
                f"{last or 'it said nothing'}: try again with fewer or smaller pictures, or use a "
                "printed mat"
            )
    return outcome


def _answer(process: "subprocess.Popen[str]", progress: Progress | None) -> Outcome | None:
    """What the process answers; None if it ends without an answer."""
    outcome = None
    for line in process.stdout or ():
        said = json.loads(line)
        if "outcome" in said:
            outcome = TypeAdapter(Outcome).validate_python(said["outcome"])
        elif progress is not None:
            progress(*said["progress"])
    return outcome
