"""Which unit a number lacks."""

import math
from collections.abc import Iterable

from facetlog.grammar import syntax as s
from facetlog.grammar.fixing.fix import Fix, insertion
from facetlog.grammar.units import UNITS, Dimension

__all__ = ["missing_unit"]

_USUAL = {
    Dimension.ANGLE: ("deg",),
    Dimension.LENGTH: ("cm", "m", "mm"),
    Dimension.AREA: ("m2", "cm2"),
}


def missing_unit(
    node: s.Expression, wanted: Dimension, beside: Iterable[s.Expression | None]
) -> tuple[Fix, ...]:
    """The fixes that give a number a unit; `beside` are the quantities that it stands with.

    Sure if these have one unit of that dimension among them, and of an angle that is more than the
    full turn in radians.
    """
    if not isinstance(node, s.Quantity) or node.unit is not None:
        return ()
    near = {
        one.unit.text
        for one in beside
        if isinstance(one, s.Quantity) and one.unit is not None
        if one.unit.text in UNITS and UNITS[one.unit.text].dimension is wanted
    }
    units = (*sorted(near), *(u for u in _USUAL.get(wanted, ()) if u not in near))
    sure = len(near) == 1
    if not near and wanted is Dimension.ANGLE:
        sure = node.value > 2 * math.pi
    return tuple(
        insertion(f"write the unit `{unit}`", node.span.end, f" {unit}", sure=sure and i == 0)
        for i, unit in enumerate(units)
    )
