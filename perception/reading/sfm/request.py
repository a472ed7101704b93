"""What the program that does structure from motion is asked for (mapper.py)."""

from dataclasses import dataclass
from pathlib import Path

from facetlog.perception.reading.shots import Shot

__all__ = ["Request", "Settings"]


@dataclass(frozen=True, slots=True)
class Settings:
    """What decides, beside the pictures, which cameras are found."""

    camera: str = "RADIAL"
    """A focal length, k1 and k2: the lenses of phones. The principal point stays in the middle:
    pictures alone hardly say where it is."""

    most_features: int = 4096
    """Features of a picture. Poses are no better with twice as many, and worse by two fifths with
    half as many (docs/decisions.md)."""

    longest_side_px: int = 1600
    """To which larger pictures are reduced for features; the time is that of their pixels."""

    seed: int = 0


@dataclass(frozen=True, slots=True)
class Request:
    """The pictures, an empty folder to work in, one for the model, and how many threads."""

    shots: tuple[Shot, ...]
    work: Path
    model: Path
    threads: int
    settings: Settings
