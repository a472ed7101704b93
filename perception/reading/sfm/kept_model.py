"""A folder in which a COLMAP model is kept, and what it was made from: it is made once."""

import hashlib
import importlib.metadata
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from pydantic import TypeAdapter, ValidationError

from facetlog.errors import InputError
from facetlog.perception.reading.sfm.outcome import Outcome
from facetlog.perception.reading.sfm.request import Settings
from facetlog.perception.reading.shots import Shot
from facetlog.perception.whole_file import write_whole
from facetlog.regular_file import read_regular_text

__all__ = ["KeptModel", "check_keep", "made_from", "model_folder"]

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


def keep_outcome(folder: Path, key: str, outcome: Outcome) -> None:
    """Writes the record; last, so that it stands for a model that is whole."""
    record = TypeAdapter(KeptModel).dump_json(KeptModel(key, outcome), indent=1)
    write_whole(folder / RECORD, record + b"\n")


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


@contextmanager
def model_folder(keep: Path | None) -> Iterator[Path]:
    """The folder for a model: the one that is kept, or one that goes away."""
    if keep is None:
        with TemporaryDirectory(prefix="facetlog-cameras-") as folder:
            yield Path(folder)
        return
    try:
        keep.mkdir(parents=True, exist_ok=True)
        for path in keep.iterdir():
            path.unlink()
    except OSError as exc:
        raise InputError(f"{keep} cannot be written: {exc.strerror or exc}") from exc
    yield keep


def _record(folder: Path) -> KeptModel | None:
    try:
        text = read_regular_text(folder / RECORD)
        record = TypeAdapter(KeptModel).validate_json(text)
    except (OSError, ValueError, ValidationError, InputError):
        return None
    return record if record.schema == SCHEMA else None
