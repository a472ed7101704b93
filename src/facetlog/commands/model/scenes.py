"""The scenes of examples: read from files, or built to measure."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.errors import InputError
from facetlog.grammar import syntax as s
from facetlog.grammar.example_scenes import convert_sizes
from facetlog.grammar.units import Dimension
from facetlog.query_shell.scene_files import scene_file

if TYPE_CHECKING:
    from facetlog.grammar.example_scenes import Builders
    from facetlog.kb.loading.encode import Fact
    from facetlog.perception.scene import Scene

__all__ = [
    "list_builder_sizes",
    "make_example_facts",
    "make_example_on_demand",
    "read_labelled_facts",
    "read_labelled_on_demand",
]

_DIMENSIONS = {
    "length": Dimension.LENGTH,
    "angle": Dimension.ANGLE,
    "count": Dimension.NUMBER,
}


@cache
def list_builder_sizes() -> "Builders":
    """Return the sizes of all builders of exact scenes, with the dimensions of the language."""
    from facetlog.perception.surfaces.exact_solids.builders import BUILDERS

    return {
        builder.name: {p.name: _DIMENSIONS[p.kind] for p in builder.parameters}
        for builder in BUILDERS.values()
    }


def make_example_facts(scene: s.SceneFile | s.SceneBuilt, model_file: Path) -> "Iterable[Fact]":
    """Return the facts of an example's scene except those on demand; files are relative to the
    model file.

    Raise InputError for a file that is no scene, and for sizes that nothing can have.
    """
    if isinstance(scene, s.SceneFile):
        return read_labelled_facts(model_file.parent / scene.path.value)
    from facetlog.perception.facts.all_facts import scene_facts

    return tuple(fact.row for fact in scene_facts(_build_scene(scene)))


def make_example_on_demand(scene: s.SceneFile | s.SceneBuilt, model_file: Path) -> "Iterable[Fact]":
    """Return the facts that `make_example_facts` leaves out."""
    if isinstance(scene, s.SceneFile):
        return read_labelled_on_demand(model_file.parent / scene.path.value)
    from facetlog.perception.facts.all_facts import facts_on_demand

    return tuple(fact.row for fact in facts_on_demand(_build_scene(scene)))


def _build_scene(scene: s.SceneBuilt) -> "Scene":
    from facetlog.perception.surfaces.exact_solids.builders import build

    try:
        return build(scene.builder.text, convert_sizes(scene))
    except ValueError as exc:
        raise InputError(str(exc)) from exc


def read_labelled_facts(path: Path) -> "Iterable[Fact]":
    """Return the facts of a scene file, or of a folder that -o wrote, except those on demand.

    Raise InputError if it is none.
    """
    return scene_file(path).facts()


def read_labelled_on_demand(path: Path) -> "Iterable[Fact]":
    """Return the facts that `read_labelled_facts` leaves out."""
    return scene_file(path).facts_on_demand()
