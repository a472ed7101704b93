"""Lengths with their unit, as options, labels and poses files state them."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from facetlog.errors import InputError

METRES_PER: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
)
_NUMBER = r"(\d+(?:\.\d*)?|\.\d+)"
_LENGTH = re.compile(rf"\s*{_NUMBER}\s*(?:(?:±|\+/?-)\s*{_NUMBER})?\s*([a-z]+)\s*")
# Metres are kept to a picometre: 17.6 mm is 0.0176 m, and not a bit beside it.
_DIGITS = 12


@dataclass(frozen=True, slots=True)
class Length:
    """A length in metres, and its standard deviation where that was stated."""

    metres: float
    sd: float | None = None


def parse_length(text: str, option: str) -> Length:
    """Return the length that a text states with its unit; InputError for another, which names the
    option.

    >>> parse_length("17.6mm", "--square")
    Length(metres=0.0176, sd=None)
    >>> parse_length("25 ± 0.5 cm", "--scale")
    Length(metres=0.25, sd=0.005)
    """
    match = _LENGTH.fullmatch(text)
    unit = METRES_PER.get(match[3], 0.0) if match else 0.0
    length = float(match[1]) * unit if match else 0.0
    if match is None or not (math.isfinite(length) and length > 0):
        units = ", ".join(METRES_PER)
        raise InputError(f"{option} {text!r:.40}: give a length above 0 with its unit ({units})")
    sd = None if match[2] is None else round(float(match[2]) * unit, _DIGITS)
    return Length(round(length, _DIGITS), sd)
