"""Units of length, as options, labels and poses files name them."""

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["METRES_PER"]

METRES_PER: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
)
