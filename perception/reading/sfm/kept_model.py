"""A folder in which a COLMAP model is kept, and what it was made from: it is made once."""

import hashlib
import importlib.metadata
import json
import shutil
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from facetlog.errors import InputError
from facetlog.perception.atomic_write import write_whole
from facetlog.perception.reading.sfm.outcome import Outcome
from facetlog.perception.reading.sfm.request import Settings
from facetlog.perception.reading.shots import Shot
from facetlog.regular_file import read_regular_text

__all__ = ["KeptModel", "check_keep", "keep_model", "kept_outcome", "made_from"]

RECORD = "facetlog.json"
SCHEMA = "facetlog-cameras/1"


@dataclass(frozen=True, slots=True)
class KeptModel:
    """The record beside a model: what it was made from, and how that went."""

    made_from: str
    outcome: Outcome
    schema: str = SCHEMA


def made_from(shots: tuple[Shot, ...], settings: Settings) -> str:
    """What differs when the pictures do, the settings, or the version of COLMAP."""
    total = hashlib.sha256()
    about = {**asdict(settings), "pycolmap": importlib.metadata.version("pycolmap")}
    total.update(json.dumps(about).encode())
    for path in sorted({shot.path for shot in shots}):
        with path.open("rb") as file:
            total.update(f"{path.name}\0{hashlib.file_digest(file, 'sha256').hexdigest()}".encode())
    return total.hexdigest()


def kept_outcome(folder: Path, key: str) -> Outcome | None:
    """The outcome whose model is in the folder, if it was made from the same."""
    record = _record(folder)
    return record.outcome if record is not None and record.made_from == key else None


def keep_model(folder: Path, model: Path, key: str, outcome: Outcome) -> None:
    """Puts the files of a model into the folder, in place of an older one, and the record beside.

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
    """Raises InputError unless the folder is absent, empty, or holds a model of ours."""
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
    write_whole(folder / RECORD, TypeAdapter(KeptModel).dump_json(record, indent=1) + b"\n")


def _record(folder: Path) -> KeptModel | None:
    try:
        text = read_regular_text(folder / RECORD)
        record = TypeAdapter(KeptModel).validate_json(text)
    except (OSError, ValueError, ValidationError, InputError):
        return None
    return record if record.schema == SCHEMA else None
