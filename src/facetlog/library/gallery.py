"""Galleries: a model is judged on hundreds of scenes while its text is being written."""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from facetlog.batch.inputs import find_scene_paths
from facetlog.errors import InputError, RuleSyntaxError
from facetlog.kb.batch_judge import decode_part, split_fields
from facetlog.kb.engine.closing import Closing
from facetlog.kb.engine.terms import Atom, Struct
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.records import decode_record
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kept_scenes import SceneKeeper
from facetlog.library.calls import Models
from facetlog.library.result import model_paths
from facetlog.perception.facts.named_rows import FactColumns, convert_to_rows
from facetlog.perception.shapes.shape_options import (
    FROM_THE_FLOOR,
    ShapeOptions,
    parse_unit,
    parse_up,
)

__all__ = ["Condition", "Gallery", "GalleryVerdict", "Judgement", "Said", "Value"]

SHARE_OF_ONE = 0.01
"""What one verdict may take of the inferences of a question."""


@dataclass(frozen=True, slots=True)
class Condition:
    """A condition of a model: its label, where and what its author wrote, and each measure of
    single parts that it compares, with its limits, as rules write them."""

    label: str
    place: str
    text: str
    compared: tuple[tuple[str, str], ...]


@dataclass(frozen=True, slots=True)
class Value:
    """A measured value and its standard deviation, in metres, degrees or ratios."""

    value: float
    sd: float


@dataclass(frozen=True, slots=True)
class Said:
    """State of a condition on one thing, bounds of its degree, and the values that it compares:
    None for what is not known."""

    state: State
    degree: float
    degree_at_most: float
    values: tuple[Value | None, ...]


@dataclass(frozen=True, slots=True)
class GalleryVerdict:
    """Verdict on one thing of one scene.

    `parts` are (role, names), none for what was not seen. Where nothing was proposed, or nothing
    has a degree that counts, there are neither parts nor conditions: `Gallery.why` has the nearest.
    """

    path: str
    thing: str
    state: State
    degree: float
    degree_at_most: float
    parts: tuple[tuple[str, tuple[str, ...]], ...] = ()
    conditions: tuple[Said, ...] = ()


@dataclass(frozen=True, slots=True)
class Judgement:
    """Verdicts of a model on all scenes, in their order; `conditions` describe those of verdicts.

    `errors` says by path why a file could not be read.
    """

    model: str
    conditions: tuple[Condition, ...]
    verdicts: tuple[GalleryVerdict, ...]
    errors: Mapping[str, str]


class Gallery(Closing):
    """Scenes, meshes and clouds that a changing model is judged on, again and again.

    `paths` are files, folders or globs, `models` others that the text may ask about. What was made
    of the files before is kept in the user's cache; facts stay loaded, so that the next text costs
    little more than its compilation. It belongs to one thread.
    """

    def __init__(
        self,
        paths: str | Path | Sequence[str | Path],
        *,
        models: Models = (),
        up: str = FROM_THE_FLOOR,
        unit: str | None = None,
    ) -> None:
        given = [paths] if isinstance(paths, str | Path) else list(paths)
        self.paths = find_scene_paths([str(path) for path in given])
        options = ShapeOptions(
            parse_up(up), up == FROM_THE_FLOOR, None if unit is None else parse_unit(unit, "unit")
        )
        keeper = SceneKeeper()
        self._scenes = {path: keeper.open(Path(path), options) for path in self.paths}
        self._kinds: frozenset[str] = frozenset()
        self._errors: dict[str, str] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="facetlog-")
        self._model = ""
        self._base = KnowledgeBase()
        try:
            for path in model_paths(models):
                self._base.load_rules(path)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Forget scenes and models."""
        self._base.close()
        self._folder.cleanup()

    def judge(self, text: str) -> Judgement:
        """Return what the model that the text defines says of each thing of each scene.

        Of several models it is the last. Raise RuleSyntaxError for a text with faults.
        """
        path = Path(self._folder.name, "gallery.model")
        path.write_text(text, encoding="utf-8")
        try:
            rules = self._base.load_rules(path)
        except RuleSyntaxError as exc:
            raise RuleSyntaxError(str(exc).replace(str(path), "text")) from None
        if not rules.models:
            raise InputError("the text defines no model: begin with `model NAME`")
        model = self._model = rules.models[-1]
        self._load(self._base.prepare(model))
        about = (Atom(rules.module), Atom(model))
        described = self._base.request("gallery_conditions", Struct("gallery", about))
        conditions = tuple(Condition(*each) for each in decode_record(described, _CONDITIONS))
        limits, scenes = self._base.limits, self._base.scenes
        modules = tuple(Atom(scene.module) for scene in scenes.values())
        asked = (*about, int(SHARE_OF_ONE * limits.inferences), limits.bounds, modules)
        said = self._base.request("judge_gallery", Struct("gallery", asked))
        verdicts = tuple(_decode(iter(split_fields(said)), tuple(scenes), conditions))
        return Judgement(model, conditions, verdicts, dict(self._errors))

    def why(self, path: str, thing: str) -> Verdict:
        """Return the verdict of the text that was judged last, with its reasons; of what fails on
        the nearest miss.

        Raise QueryError for a thing that there is not.
        """
        return self._base.why(path, self._model, thing=thing)

    def _load(self, kinds: frozenset[str]) -> None:
        """Load the facts of further kinds."""
        if kinds <= self._kinds:
            return
        self._kinds |= kinds | {"thing"}
        for path, scene in self._scenes.items():
            if path in self._errors:
                continue
            try:
                facts = scene.facts(self._kinds)
            except InputError as exc:
                self._errors[path] = str(exc)
                continue
            self._base.load_scene(path, _iter_rows(facts))


def _decode(
    fields: Iterator[str], paths: Sequence[str], conditions: tuple[Condition, ...]
) -> Iterator[GalleryVerdict]:
    for number in fields:
        thing, state, low, high, more = (next(fields) for _ in range(5))
        verdict = (paths[int(number)], thing, State(state), float(low), float(high))
        if more == "0":
            yield GalleryVerdict(*verdict)
            continue
        parts = tuple(decode_part(fields) for _ in range(int(next(fields))))
        said = tuple(_decode_said(fields, len(each.compared)) for each in conditions)
        yield GalleryVerdict(*verdict, parts, said)


# condition(Label, Place, Text, Compared) of each condition.
_CONDITIONS = tuple[tuple[str, str, str, tuple[tuple[str, str], ...]], ...]


def _decode_said(fields: Iterator[str], count: int) -> Said:
    state, low, high = (next(fields) for _ in range(3))
    pairs = [(next(fields), next(fields)) for _ in range(count)]
    values = tuple(Value(float(v), float(sd)) if v else None for v, sd in pairs)
    return Said(State(state), float(low), float(high), values)


def _iter_rows(columns: FactColumns) -> Iterator[tuple[str | int | float, ...]]:
    for functor, own in columns.items():
        for row in convert_to_rows(own):
            yield (functor, *row)
