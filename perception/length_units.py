"""Units of length, as options, labels and poses files name them."""

import math
import re
from collections.abc import Mapping
from types import MappingProxyType

from facetlog.errors import InputError

__all__ = ["METRES_PER", "stated_length"]

METRES_PER: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
)
_LENGTH = re.compile(r"\s*([0-9.]+)\s*([a-z]+)\s*")


def stated_length(text: str | None, option: str) -> float | None:
    """The metres in a number with its unit; None for None, InputError for another text.

    >>> stated_length("17.6mm", "--square")
    0.0176
    """
    if text is None:
        return None
    match = _LENGTH.fullmatch(text)
    try:
        length = float(match[1]) * METRES_PER[match[2]] if match else 0.0
    except (KeyError, ValueError):
        length = 0.0
    if not (math.isfinite(length) and length > 0):
        units = ", ".join(METRES_PER)
        raise InputError(f"{option} {text!r:.40}: give a length above 0 with its unit ({units})")
    return round(length, 12)
