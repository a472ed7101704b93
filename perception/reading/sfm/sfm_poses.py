"""Cameras and poses by structure from motion: made once, and read as any COLMAP model is.

COLMAP runs in a process of its own (mapper.py). Neither the unit nor the axes of the world are
known then: they are those of a picture that COLMAP began with. A kept model has a record beside it
of what it was made from.
"""

import hashlib
import importlib.metadata
import json
import logging
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TypeAlias

from pydantic import TypeAdapter, ValidationError

from facetlog.errors import EngineError, InputError
from facetlog.perception.atomic_write import write_atomically
from facetlog.perception.reading.image_sources import Shot, list_shots
from facetlog.perception.reading.pose_files.colmap_poses import read_colmap_poses
from facetlog.perception.reading.pose_files.pose_reader import PoseOptions
from facetlog.perception.reading.pose_files.poses_file import PosesFile
from facetlog.perception.reading.sfm.outcome import (
    LEAST_PICTURES,
    Outcome,
    Request,
    Settings,
    explain_failure,
    left_out,
)
from facetlog.python_process import make_importing_environment, make_module_command
from facetlog.safe_read import read_regular_text

SETTINGS = Settings()

_LOG = logging.getLogger(__name__)
PROGRAM = make_module_command("facetlog.perception.reading.sfm.mapper")
LAST_WORDS = 300
"""Characters of what a program that failed wrote at the end."""

Progress: TypeAlias = Callable[[str, int, int], None]
RECORD = "facetlog.json"
SCHEMA = "facetlog-cameras/1"


class NothingPlacedError(InputError):
    """No pictures could be placed together; the message says why, and the way out."""


def has_kept_cameras(folder: Path, options: PoseOptions) -> bool:
    """Return whether `options.keep` has the cameras of just these pictures."""
    if options.keep is None or not options.keep.is_dir() or not can_map():
        return False
    key = made_from(tuple(shot.upright for shot in list_shots(folder)), SETTINGS)
    return load_kept_outcome(options.keep, key) is not None


def read_by_motion(folder: Path, options: PoseOptions) -> PosesFile:
    """Return cameras and poses of the pictures in a folder by what they have in common.

    Where `options.keep` has those of the same pictures they are taken from there.
    NothingPlacedError where no pictures can be placed together, InputError for what does not go
    with this way, EngineError if COLMAP dies.
    """
    if options.axis:
        raise InputError(
            "up: no axis of a world that structure from motion makes can be known: leave it out "
            "(up is that of the ground then), or give none"
        )
    # As EXIF turns them: which way the ground lies is known from how cameras were held.
    shots = tuple(shot.upright for shot in list_shots(folder))
    if len(shots) < LEAST_PICTURES:
        raise NothingPlacedError(explain_failure(Outcome({shot.name: 0 for shot in shots})))
    keep = options.keep
    if keep is None:
        return _mapped(folder, shots, options)
    check_keep(keep)
    key = made_from(shots, SETTINGS)
    outcome = load_kept_outcome(keep, key)
    if outcome is None:
        return _mapped(folder, shots, options, key)
    _LOG.info("%s has the cameras of these pictures: not made again", keep)
    return _read(keep, folder, shots, outcome)


def _mapped(
    folder: Path, shots: tuple[Shot, ...], options: PoseOptions, key: str = ""
) -> PosesFile:
    with tempfile.TemporaryDirectory(prefix="facetlog-cameras-") as name:
        model = Path(name)
        outcome = map_pictures(shots, model, SETTINGS, options.progress)
        _LOG.debug("features of each picture: %s", dict(outcome.features))
        _LOG.info(
            "structure from motion: %d pairs of pictures have points in common, groups of %s "
            "pictures were placed",
            len(outcome.pairs),
            [len(group) for group in outcome.groups],
        )
        if not outcome.groups:
            raise NothingPlacedError(explain_failure(outcome))
        if options.keep is not None:
            keep_model(options.keep, model, key, outcome)
            _LOG.info("cameras are kept in %s", options.keep)
        return _read(model, folder, shots, outcome)


def _read(model: Path, folder: Path, shots: tuple[Shot, ...], outcome: Outcome) -> PosesFile:
    file = read_colmap_poses(model / "images.bin")
    picture_of = {picture.name: picture for picture in file.pictures}
    placed = tuple(
        replace(picture_of[shot.name], path=shot.path, frame=shot.frame, turns=shot.turns)
        for shot in shots
        if shot.name in picture_of
    )
    return replace(
        file,
        folder=folder,
        pictures=placed,
        left_out=left_out(outcome, {shot.name: shot.place for shot in shots}),
        kind=f"structure from motion (its points fit to {outcome.error_px:.2g} px)",
    )


def can_map() -> bool:
    """Return whether the package that does it is there (extra facetlog[sfm])."""
    return find_spec("pycolmap") is not None


def map_pictures(
    shots: tuple[Shot, ...], model: Path, settings: Settings, progress: Progress | None
) -> Outcome:
    """Place pictures together; the largest group is a COLMAP model in the folder `model` then.

    The same pictures give the same model. `progress` is called with a step's name, how much of it
    is done, and of how much. Raise EngineError if the process dies. Ctrl-C ends it.
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
            env=make_importing_environment(),
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
    """Return the answer of the process; None if it ends without one."""
    outcome = None
    for line in process.stdout or ():
        said = json.loads(line)
        if "outcome" in said:
            outcome = TypeAdapter(Outcome).validate_python(said["outcome"])
        elif progress is not None:
            progress(*said["progress"])
    return outcome


@dataclass(frozen=True, slots=True)
class KeptModel:
    """The record beside a model: what it was made from, and how that went."""

    made_from: str
    outcome: Outcome
    schema: str = SCHEMA


def made_from(shots: tuple[Shot, ...], settings: Settings) -> str:
    """Return a key that differs when the pictures do, the settings, or the version of COLMAP."""
    total = hashlib.sha256()
    about = {**asdict(settings), "pycolmap": importlib.metadata.version("pycolmap")}
    total.update(json.dumps(about).encode())
    for path in sorted({shot.path for shot in shots}):
        with path.open("rb") as file:
            total.update(f"{path.name}\0{hashlib.file_digest(file, 'sha256').hexdigest()}".encode())
    return total.hexdigest()


def load_kept_outcome(folder: Path, key: str) -> Outcome | None:
    """Return the outcome whose model is in the folder, if it was made from the same."""
    record = _record(folder)
    return record.outcome if record is not None and record.made_from == key else None


def keep_model(folder: Path, model: Path, key: str, outcome: Outcome) -> None:
    """Put the files of a model into the folder, in place of an older one, and the record beside.

    InputError where that cannot be written. What is left of an attempt that was ended stays ours,
    and is of no use.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        _write_record(folder, KeptModel("", outcome))
        for path in folder.iterdir():
            if path.name != RECORD:
                path.unlink()
        for path in model.iterdir():
            shutil.copyfile(path, folder / path.name)
    except OSError as exc:
        raise InputError(f"{folder} cannot be written: {exc.strerror or exc}") from exc
    _write_record(folder, KeptModel(key, outcome))


def check_keep(folder: Path) -> None:
    """Raise InputError unless the folder is absent, empty, or holds a model of ours."""
    try:
        foreign = folder.exists() and (
            not folder.is_dir() or (any(folder.iterdir()) and _record(folder) is None)
        )
    except OSError as exc:
        raise InputError(f"{folder} cannot be used: {exc.strerror or exc}") from exc
    if foreign:
        raise InputError(
            f"{folder}, where the cameras of these pictures are to be kept, was not written by "
            "facetlog: give another name with -o"
        )


def _write_record(folder: Path, record: KeptModel) -> None:
    write_atomically(folder / RECORD, TypeAdapter(KeptModel).dump_json(record, indent=1) + b"\n")


def _record(folder: Path) -> KeptModel | None:
    try:
        text = read_regular_text(folder / RECORD)
        record = TypeAdapter(KeptModel).validate_json(text)
    except (OSError, ValueError, ValidationError, InputError):
        return None
    return record if record.schema == SCHEMA else None
