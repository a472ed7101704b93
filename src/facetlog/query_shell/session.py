"""A session: the knowledge base with the scenes and models that a user has loaded."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from facetlog.errors import InputError, RuleSyntaxError
from facetlog.kb.calibration import Calibration
from facetlog.kb.engine.closing import Closing
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.loaded import RuleFile
from facetlog.kb.loading.rule_source import RULE_SUFFIXES
from facetlog.kb.recognize import list_rule_files, rule_files
from facetlog.query_shell.meanings import length_unit
from facetlog.query_shell.model_files import Stamp, read_stamp
from facetlog.query_shell.scene_files import SCENE_FILE, SceneFile, make_names_distinct, scene_file
from facetlog.terminal import error_lines, warn

if TYPE_CHECKING:
    from facetlog.perception.shapes.shape_options import ShapeOptions

Stamps: TypeAlias = dict[Path, Stamp | None]
"""Stamps of all files that a model file was made from."""


class Session(Closing):
    """The knowledge base, the files that it was loaded from, and which scenes are asked.

    Models in Prolog are loaded only with `trust`. With `raw` verdicts have no confidence. `options`
    state up, unit and sensor of all files of scenes. A context manager.
    """

    def __init__(
        self,
        *,
        trust: bool = False,
        limits: Limits | None = None,
        raw: bool = False,
        options: "ShapeOptions | None" = None,
    ) -> None:
        self._options = options
        self.trust = trust
        self.raw = raw
        self.limits = limits or Limits()
        self._base: KnowledgeBase | None = None
        self._scenes: dict[str, SceneFile] = {}
        self._models: dict[Path, Stamps] = {}
        self._used: tuple[str, ...] | None = None
        self.generation = 0
        """Grows when scenes or models change, so that whoever remembers names knows."""

    def close(self) -> None:
        """Close the knowledge base, if one was made."""
        if self._base is not None:
            self._base.close()

    @property
    def base(self) -> KnowledgeBase:
        """The knowledge base, made when it is first needed."""
        if self._base is None:
            self._base = self._make_base()
        return self._base

    def _make_base(self) -> KnowledgeBase:
        base = KnowledgeBase(self.limits)
        if self.raw:
            base.calibration = Calibration()
        return base

    @property
    def scene_files(self) -> tuple[SceneFile, ...]:
        """The loaded scenes in the order of loading."""
        return tuple(self._scenes.values())

    @property
    def model_files(self) -> tuple[Path, ...]:
        """The loaded files of models, without the built-in ones."""
        return tuple(self._models)

    @property
    def scenes(self) -> tuple[str, ...]:
        """Names of the scenes that are asked."""
        return tuple(self._scenes) if self._used is None else self._used

    @property
    def length(self) -> str:
        """The unit of lengths in the scenes that are asked."""
        return length_unit([self.base.scenes[name].length_unit for name in self.scenes])

    def use(self, names: Sequence[str]) -> None:
        """Ask only these scenes, all if there are none. Raise InputError for an unknown one."""
        for name in names:
            if name not in self._scenes:
                loaded = ", ".join(self._scenes) or "none"
                raise InputError(f"there is no scene {name!r}; loaded are {loaded}")
        self._used = tuple(dict.fromkeys(names)) or None
        self.generation += 1

    def load_scenes(self, paths: Sequence[Path]) -> tuple[SceneFile, ...]:
        """Load scenes; a file that was loaded before is replaced.

        Raise InputError for what cannot be read; the scenes before it are loaded.
        """
        places = {file.path.resolve(): name for name, file in self._scenes.items()}
        found = [scene_file(path, self._options) for path in paths]
        fresh = {f.path.resolve(): f for f in found if f.path.resolve() not in places}
        named = make_names_distinct(tuple(fresh.values()), self._scenes)
        for file in found:
            if (name := places.get(file.path.resolve())) is not None:
                named += (replace(file, name=name),)
        for file in named:
            self._load(self.base, file)
            self._scenes[file.name] = file
            self.generation += 1
        return named

    @staticmethod
    def _load(base: KnowledgeBase, file: SceneFile) -> None:
        for line in file.warnings:
            warn(f"{file.path.name}: {line}")
        base.load_scene(
            file.name, file.facts(), cache_key=file.kept.key, on_demand=file.facts_on_demand
        )

    def load_models(self, paths: Iterable[Path]) -> tuple[str, ...]:
        """Load files and folders of models; return the names of the models that they define.

        Raise RuleSyntaxError for a faulty file; those before it are loaded.
        """
        loaded: list[str] = []
        for path in rule_files(paths):
            stamp = read_stamp(path)
            base = self.base
            rules = base.load_rules(path, trusted=self.trust)
            loaded.extend(rules.models)
            self._models[path] = _read_stamps(rules) | {path: stamp}
            # Files that it asks about were loaded with it, and are watched like it.
            for other in base.models.values():
                if other.files and other.path not in self._models:
                    self._models[other.path] = _read_stamps(other)
            self.generation += 1
        return tuple(loaded)

    def load(self, path: Path) -> str:
        """Load a scene or models, whichever the path holds, and return a line about it."""
        # A folder written by -o holds facts.pl beside its scene.
        models = any(list_rule_files(path)) and not (path / SCENE_FILE).exists()
        if path.suffix in RULE_SUFFIXES or models:
            return f"loaded the models {', '.join(self.load_models([path]))}"
        (file,) = self.load_scenes([path])
        return f"loaded the scene {file.name} ({self.base.scenes[file.name].facts:,} facts)"

    def reload_changed_models(self) -> tuple[str, ...]:
        """Load again every model file whose content has changed; return a line about each.

        Of a faulty file the old version stays in force. It is said once.
        """
        return tuple(
            line
            for path, before in tuple(self._models.items())
            for line in self._refresh(path, before)
        )

    def _refresh(self, path: Path, before: Stamps) -> tuple[str, ...]:
        now = {file: read_stamp(file, stamp) for file, stamp in before.items()}
        if all(now[file] is stamp for file, stamp in before.items()):
            return ()
        self._models[path] = now
        if now[path] is None:
            return (f"{path} cannot be read any more: its models stay as they were",)
        changed = [file for file, stamp in before.items() if not _is_same(stamp, now[file])]
        if not changed:
            return ()
        try:
            self._reload_models(path)
        except RuleSyntaxError as exc:
            return _explain_kept_version(exc)
        why = f"{path} has" if path in changed else f"{changed[0]}, which {path} uses, has"
        return (f"{why} changed: loaded again",)

    def _reload_models(self, path: Path) -> None:
        stamp = read_stamp(path)
        rules = self.base.load_rules(path, trusted=self.trust)
        self._models[path] = _read_stamps(rules) | {path: stamp}
        self.generation += 1

    def reload(self) -> tuple[str, ...]:
        """Load all models and scenes again from their files; return a line about each that failed.

        What cannot be loaded stays as it was.
        """
        problems: list[str] = []
        for path in tuple(self._models):
            # Faults are reported here, and not once more when the file is found to have changed.
            self._models[path] = {file: read_stamp(file) for file in self._models[path]}
            try:
                self._reload_models(path)
            except InputError as exc:
                problems.extend(_explain_kept_version(exc))
        for file in self.scene_files:
            try:
                self.load_scenes([file.path])
            except InputError as exc:
                problems.append(f"{exc} (the scene {file.name} stays as it was)")
        return tuple(problems)


def _read_stamps(rules: RuleFile) -> Stamps:
    return {file: read_stamp(file) for file in rules.files}


def _is_same(one: Stamp | None, other: Stamp | None) -> bool:
    if one is None or other is None:
        return one is other
    return one.has_same_content(other)


def _explain_kept_version(fault: InputError) -> tuple[str, ...]:
    """Return a line for each fault of a new version of a file."""
    *others, last = error_lines(fault)
    return (*others, f"{last} (the version before stays in force)")
