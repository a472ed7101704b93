"""Protocol of a found face: its corners and normal."""

from typing import Protocol

from facetlog.perception.types import FloatArray


class OutlinedFace(Protocol):
    """A polygon (k, 3) across its normal (3,)."""

    @property
    def corners(self) -> FloatArray: ...

    @property
    def normal(self) -> FloatArray: ...
