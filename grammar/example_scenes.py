"""Whether the things that examples are made of can be built: builders, sizes and units.

Builders belong to perception, which the language does not know: who checks hands in their sizes.
"""

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TypeAlias

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.constants import quantity
from facetlog.grammar.faults import Fault, make_respelling, said, suggest_unit
from facetlog.grammar.source import Source
from facetlog.grammar.units import Dimension

Builders: TypeAlias = Mapping[str, Mapping[str, Dimension]]
"""The sizes of each builder, and what they are: a length, an angle, or a number (of pieces)."""

PLACES: Mapping[str, Dimension] = MappingProxyType(
    {
        **dict.fromkeys(("x", "y", "z", "along", "across", "over"), Dimension.LENGTH),
        **dict.fromkeys(("columns", "rows", "levels"), Dimension.NUMBER),
    }
)
"""Sizes that each solid has: where its lowest corner is, over which length of the three axes it is
repeated, and how often there."""

_AS_WRITTEN = {Dimension.LENGTH: "40 cm", Dimension.ANGLE: "90 deg", Dimension.NUMBER: "4"}


def list_examples(analysis: Analysis) -> Iterator[tuple[s.Model, s.Example]]:
    """Iterate over the examples of the file itself and their models, in the order of the text."""
    for model in analysis.file.models:
        for example in model.examples:
            yield model, example


def find_all_faults(analysis: Analysis, builders: Builders) -> tuple[Fault, ...]:
    """Return the faults of a file with those of the things that its examples build.

    Those of the file itself come first, each file's in the order of its text.
    """

    def order(fault: Fault) -> tuple[bool, str, int]:
        return fault.source is not analysis.file.source, fault.source.name, fault.span.start

    own = find_scene_faults(analysis, builders)
    return tuple(sorted((*analysis.faults, *own), key=order)) if own else analysis.faults


def find_scene_faults(analysis: Analysis, builders: Builders) -> tuple[Fault, ...]:
    """Find the faults of the solids that the examples of the file build.

    Quantities that are none are the checker's.
    """
    source = analysis.file.source
    return tuple(
        fault
        for _, example in list_examples(analysis)
        if isinstance(example.scene, s.SceneBuilt)
        for solid in example.scene.solids
        for fault in _find_solid_faults(solid, source, builders)
    )


def _find_solid_faults(solid: s.Solid, source: Source, builders: Builders) -> Iterator[Fault]:
    own = builders.get(solid.builder.text)
    if own is None:
        message = f"nothing can be built that is called `{solid.builder}`"
        hint = said(solid.builder.text, builders) or f"there are {', '.join(builders)}"
        fixes = make_respelling(solid.builder, builders)
        yield Fault("unknown-builder", message, source, solid.builder.span, hint, fixes=fixes)
        return
    sizes = {**own, **PLACES}
    given: set[str] = set()
    for setting in solid.settings:
        name = setting.name.text
        wanted = sizes.get(name)
        if wanted is None:
            message = f"a {solid.builder} has no size `{name}`"
            hint = said(name, sizes) or f"it has {', '.join(own)}, and a place: {', '.join(PLACES)}"
            fixes = make_respelling(setting.name, sizes)
            yield Fault("unknown-size", message, source, setting.name.span, hint, fixes=fixes)
        elif name in given:
            message = f"the size `{name}` is given twice"
            yield Fault("twice", message, source, setting.name.span)
        else:
            beside = tuple(other.quantity for other in solid.settings)
            yield from _find_unit_faults(setting, wanted, source, beside)
        given.add(name)


def _find_unit_faults(
    setting: s.Setting, wanted: Dimension, source: Source, beside: tuple[s.Quantity, ...]
) -> Iterator[Fault]:
    found = quantity(setting.quantity)
    if found is not None and found.dimension is not wanted:
        message = f"the {setting.name} is {wanted}, this is {found.dimension}"
        hint = f"write `{setting.name} {_AS_WRITTEN[wanted]}`"
        unitless = found.dimension is Dimension.NUMBER
        fixes = suggest_unit(setting.quantity, wanted, beside) if unitless else ()
        yield Fault("dimension", message, source, setting.quantity.span, hint, fixes=fixes)


def convert_sizes(solid: s.Solid) -> dict[str, float]:
    """Return the sizes that are given, in metres, radians or ones; of a solid without faults."""
    return {
        setting.name.text: math.radians(size.value)
        if size.dimension is Dimension.ANGLE
        else size.value
        for setting in solid.settings
        if (size := quantity(setting.quantity)) is not None
    }
