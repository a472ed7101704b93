"""A camera head by the name of its kind."""

from typing import Final

from facetlog.errors import InputError
from facetlog.robot.byte_line import ByteLine
from facetlog.robot.head.canon_vcc4 import CanonVcC4
from facetlog.robot.head.head import PanTiltHead
from facetlog.robot.head.sony_evi_d30 import SonyEviD30

DRIVERS: Final[dict[str, type[SonyEviD30] | type[CanonVcC4]]] = {
    "sony-evi-d30": SonyEviD30,
    "canon-vc-c4": CanonVcC4,
}

HEAD_KINDS: Final = tuple(DRIVERS)
"""Names that `open_head` knows."""


def open_head(kind: str, line: ByteLine, *, unheard: bool = False) -> PanTiltHead:
    """Return the driver of a head of this kind, not started yet; InputError for an unknown kind.

    `unheard` allows a head to be moved open-loop if it does not answer, which only Canon's can;
    otherwise a missing head would go unnoticed.
    """
    driver = DRIVERS.get(kind)
    if driver is None:
        raise InputError(f"{kind} is no camera head known here: use one of {', '.join(HEAD_KINDS)}")
    if driver is CanonVcC4:
        return CanonVcC4(line, answers=None if unheard else True)
    if unheard:
        raise InputError(f"a {kind} is not moved unheard: leave that option out")
    return driver(line)
