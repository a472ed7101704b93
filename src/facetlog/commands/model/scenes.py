"""The scenes of examples: read from files, or built to measure."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from facetlog.commands.shape_options import StatedOptions
from facetlog.errors import InputError
from facetlog.grammar import syntax as s
from facetlog.grammar.example_scenes import convert_sizes
from facetlog.grammar.library import BUILTIN
from facetlog.grammar.units import Dimension
from facetlog.terminal import warn

if TYPE_CHECKING:
    from facetlog.grammar.example_scenes import Builders
    from facetlog.kb.loading.encode import Fact
    from facetlog.perception.scene import Scene

__all__ = ["ExampleScenes", "list_builder_sizes"]

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


@dataclass(slots=True)
class ExampleScenes:
    """Scenes of one run of examples; the last one is kept, for the facts that come on demand.

    `stated` and `scale` say what labelled files do not. Files that a model names are in the
    model's folder, or among facetlog's own, unless it is `trusted`.
    """

    stated: StatedOptions = field(default_factory=StatedOptions)
    scale: str | None = None
    trusted: bool = False
    _last: "tuple[object, Scene] | None" = field(default=None, init=False)

    def make_facts(self, scene: s.SceneFile | s.SceneBuilt, model_file: Path) -> "Iterable[Fact]":
        """Return the facts of an example's scene except those on demand; files are relative to the
        model file.

        Raise InputError for a file that is no scene, mesh or cloud, and for sizes that nothing
        can have.
        """
        return _list_facts(self.open(scene, model_file))

    def make_on_demand(
        self, scene: s.SceneFile | s.SceneBuilt, model_file: Path
    ) -> "Iterable[Fact]":
        """Return the facts that `make_facts` leaves out."""
        return _list_on_demand(self.open(scene, model_file))

    def read_facts(self, path: Path) -> "Iterable[Fact]":
        """Return the facts of a labelled file except those on demand; InputError as for
        `make_facts`.
        """
        return _list_facts(self._read(path, self.stated, self.scale))

    def read_on_demand(self, path: Path) -> "Iterable[Fact]":
        """Return the facts that `read_facts` leaves out."""
        return _list_on_demand(self._read(path, self.stated, self.scale))

    def open(self, scene: s.SceneFile | s.SceneBuilt, model_file: Path) -> "Scene":
        """Return an example's scene; InputError as for its facts."""
        if isinstance(scene, s.SceneBuilt):
            return self._keep(scene, lambda: _build_scene(scene))
        path = model_file.parent / scene.path.value
        if not self.trusted:
            from facetlog.perception.reading.path_guard import check_inside

            own = model_file.parent, BUILTIN
            check_inside(path, own, model_file, f"file {scene.path.value!r}", "model")
        given = {one.name.text: one.value.value for one in scene.stated}
        stated = StatedOptions(given.get("up"), given.get("unit"), given.get("sensor"))
        return self._read(path, stated, given.get("scale"))

    def _read(self, path: Path, stated: StatedOptions, scale: str | None) -> "Scene":
        return self._keep((path, stated, scale), lambda: _read_scene(path, stated, scale))

    def _keep(self, key: object, make: "Callable[[], Scene]") -> "Scene":
        if self._last is None or self._last[0] != key:
            self._last = key, make()
        return self._last[1]


def _build_scene(scene: s.SceneBuilt) -> "Scene":
    from facetlog.perception.shapes.meshes.built_solids import Solid, build_solids

    try:
        return build_solids(
            [Solid(solid.builder.text, convert_sizes(solid)) for solid in scene.solids]
        )
    except ValueError as exc:
        raise InputError(str(exc)) from exc


def _read_scene(path: Path, stated: StatedOptions, scale: str | None) -> "Scene":
    from facetlog.perception.facts.known_length import KnownLength, scale_by_known_length
    from facetlog.query_shell.scene_files import scene_file

    known = None if scale is None else KnownLength.parse(scale, "scale")
    scene = scene_file(path, stated.find_given()).kept.scene()
    for line in scene.warnings:
        warn(f"{path.name}: {line}")
    return scene if known is None else scale_by_known_length(scene, known)[0]


def _list_facts(scene: "Scene") -> "Iterable[Fact]":
    from facetlog.perception.facts.all_facts import scene_facts

    return tuple(fact.row for fact in scene_facts(scene))


def _list_on_demand(scene: "Scene") -> "Iterable[Fact]":
    from facetlog.perception.facts.all_facts import facts_on_demand

    return tuple(fact.row for fact in facts_on_demand(scene))
