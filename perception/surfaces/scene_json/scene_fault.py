"""What is wrong in a scene file, and where."""

from typing import NamedTuple

from facetlog.errors import InputError

__all__ = ["Place", "SceneFault", "SceneFileError", "json_path"]

Place = tuple[int | str, ...]
"""Keys and indices, from the top down to what is meant."""


class SceneFault(NamedTuple):
    """What is wrong in a scene file, and where: a JSON path as $.faces[3].outline."""

    path: str
    message: str

    def __str__(self) -> str:
        return f"{self.path}: {self.message}"


class SceneFileError(InputError):
    """The file is no `facetlog-scene/1`: the message names the first of its `faults`."""

    def __init__(self, source: str, faults: tuple[SceneFault, ...]) -> None:
        more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
        super().__init__(f"{source}: {faults[0]}{more}")
        self.faults = faults


def json_path(place: Place) -> str:
    """As messages write it: $.faces[3].outline."""
    return "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place)
