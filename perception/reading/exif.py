"""EXIF of pictures: the lens that took them, and their orientation."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import ExifTags, Image, UnidentifiedImageError

SMALL_FILM_MM = float(np.hypot(36.0, 24.0))
"""The diagonal to which focal lengths "in 35 mm film" refer."""
USUAL_FOCAL = 0.8
"""Usual focal length in diagonals: phones have 13 to 77 mm on small film."""


TURNS = {3: 2, 6: 1, 8: 3}
"""Quarter turns by EXIF's number of an orientation; cameras write none that is mirrored."""


@dataclass(frozen=True, slots=True)
class TakenWith:
    """A camera and its zoom: `camera` by maker and model, focal length in mm, and as it would be on
    35 mm film; empty or None where EXIF does not have it.
    """

    camera: str = ""
    focal_mm: float | None = None
    film_mm: float | None = None

    def compute_focal_px(self, width: int, height: int) -> float | None:
        """Return the focal length in pixels of a picture of this size, to some percent; None if
        unknown.

        >>> round(TakenWith(film_mm=26.0).compute_focal_px(4000, 3000))
        3005
        """
        if self.film_mm is None:
            return None
        return self.film_mm / SMALL_FILM_MM * float(np.hypot(width, height))


def taken_with(path: Path) -> TakenWith:
    """Return camera and zoom by the EXIF of a picture; empty where it has none that can be read."""
    exif = _read_exif(path)
    more = exif.get_ifd(ExifTags.IFD.Exif)
    names = (exif.get(tag) for tag in (ExifTags.Base.Make, ExifTags.Base.Model))
    return TakenWith(
        " ".join(str(name).strip() for name in names if name),
        _length(more.get(ExifTags.Base.FocalLength)),
        _length(more.get(ExifTags.Base.FocalLengthIn35mmFilm)),
    )


def read_quarter_turns(path: Path) -> int:
    """Return by how many quarter turns to the right a picture is shown, by its EXIF."""
    return TURNS.get(_read_exif(path).get(ExifTags.Base.Orientation, 1), 0)


def _read_exif(path: Path) -> Image.Exif:
    with suppress(ImportError):  # then EXIF of HEIC is not read, and neither is the picture
        from pillow_heif import register_heif_opener

        register_heif_opener()
    try:
        with Image.open(path) as picture:
            exif = picture.getexif()
            exif.get_ifd(ExifTags.IFD.Exif)  # which reads on in the file
            return exif
    except (OSError, ValueError, SyntaxError, UnidentifiedImageError):
        return Image.Exif()


def _length(value: object) -> float | None:
    try:
        length = float(value)  # type: ignore[arg-type] # a ratio of Pillow's, or what a file has
    except (TypeError, ValueError, ZeroDivisionError):
        return None
    return length if np.isfinite(length) and length > 0 else None
