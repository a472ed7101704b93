"""What any found face has, whatever else is known of it."""

from typing import Protocol

from facetlog.perception.types import FloatArray


class OutlinedFace(Protocol):
    """A polygon (k, 3) across its normal (3,)."""

    @property
    def corners(self) -> FloatArray: ...

    @property
    def normal(self) -> FloatArray: ...
