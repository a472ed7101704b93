"""What a poses file in JSON holds, with faults named by their place."""

import json
from collections.abc import Mapping
from pathlib import Path

from facetlog.errors import InputError
from facetlog.perception.reading.pose_files.pose_checks import EXPORT
from facetlog.perception.reading.pose_files.poses_file import read_text

__all__ = ["read_json", "taken"]


def read_json(path: Path) -> object:
    """The value in a file; InputError with line and column for what is not JSON."""
    text = read_text(path)
    try:
        return json.loads(text)
    except json.JSONDecodeError as exc:
        raise InputError(
            f"{path}:{exc.lineno}:{exc.colno}: not JSON: {exc.msg}: correct it there, or {EXPORT}"
        ) from exc
    except (RecursionError, ValueError) as exc:  # nested or long beyond what Python reads
        raise InputError(f"{path}: not JSON that can be read: too deep or too long") from exc


def taken(value: object, where: str, *keys: str) -> object:
    """What is reached from a value by these keys; InputError names the first that is missing."""
    for key in keys:
        if not isinstance(value, Mapping) or key not in value:
            raise InputError(f"{where}: no {key!r}: {EXPORT}")
        value = value[key]
    return value
