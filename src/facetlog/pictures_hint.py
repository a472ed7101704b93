"""Hint at the command that makes a scene of pictures."""

from pathlib import Path
from shlex import quote

__all__ = ["make_pictures_hint"]


def make_pictures_hint(path: Path) -> str:
    """Return the end of a message about a picture or folder of pictures; empty for others."""
    # Loaded only now: who gives scenes does without OpenCV.
    from facetlog.perception.reading.image_sources import has_shots
    from facetlog.perception.reading.picture_file import PICTURE_SUFFIXES

    folder = path if path.is_dir() else path.parent
    shown = has_shots(path) if path.is_dir() else path.suffix.lower() in PICTURE_SUFFIXES
    if not shown:
        return ""
    return f"; of pictures facetlog recognize {quote(str(folder))} -o OUT makes one"
