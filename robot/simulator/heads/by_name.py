"""The simulated camera heads by the names that a world file has for them."""

from facetlog.robot.simulator.device import Device
from facetlog.robot.simulator.heads.canon import CanonHead
from facetlog.robot.simulator.heads.sony import SonyHead

__all__ = ["make_head"]


def make_head(kind: str) -> Device | None:
    """A head of this kind at rest; None for `none`."""
    match kind:
        case "sony-evi-d30":
            return SonyHead()
        case "canon-vc-c4":
            return CanonHead()
        case _:
            return None
