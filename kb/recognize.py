"""Facts into verdicts: what all models say of all things of a scene."""

import logging
from collections.abc import Iterable, Sequence
from pathlib import Path

from facetlog.errors import LimitError, RuleSyntaxError
from facetlog.kb.calibration import Calibration
from facetlog.kb.engine.terms import Atom
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Recognition, Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.rule_source import RULE_SUFFIXES, has_only_words, lacks_models
from facetlog.kb.loading.scene_facts import FactMaker

__all__ = [
    "judge_loaded_scene",
    "judge_scene",
    "list_rule_files",
    "open_knowledge_base",
    "recognize",
    "rule_files",
    "too_large",
]

_LOG = logging.getLogger(__name__)

NEAR_MISSES = 3
"""Verdicts of a scene that say what comes nearest to their sets: as many as a reader looks at."""


def list_rule_files(folder: Path) -> tuple[Path, ...]:
    """Return the model files of a folder, in the model language or in Prolog, in alphabetical
    order.

    Prolog files that hold words for models alone are none: who uses them loads them. Nor are files
    without any model, such as empty ones.
    """
    found = (p for p in sorted(folder.glob("*")) if p.suffix in RULE_SUFFIXES)
    return tuple(p for p in found if not has_only_words(p) and not lacks_models(p))


def rule_files(paths: Iterable[Path]) -> tuple[Path, ...]:
    """Return the files of models that these files and folders name, folders in alphabetical order.

    Raise RuleSyntaxError for a path that is not there and for a folder without models.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        inside = list_rule_files(path) if path.is_dir() else (path,)
        if not path.exists():
            raise RuleSyntaxError(f"{path}: there is no such file or folder")
        if not inside:
            named = " or ".join(RULE_SUFFIXES)
            raise RuleSyntaxError(f"{path}: the folder has no {named} files")
        found.extend(inside)
    return tuple(dict.fromkeys(p.resolve() for p in found))


def open_knowledge_base(
    model_paths: Sequence[Path] = (),
    *,
    trusted: bool = False,
    limits: Limits | None = None,
    crisp: bool = False,
    raw: bool = False,
) -> KnowledgeBase:
    """Return a knowledge base with the built-in models and the user's files and folders of rules.

    Files that are not `trusted` must be in the model language. A `crisp` one ignores standard
    deviations; verdicts of a `raw` one have degrees alone, no confidence. Raises
    RuleSyntaxError for a faulty file, EngineError if SWI-Prolog is missing or too old.
    """
    files = rule_files(model_paths)
    base = KnowledgeBase(limits, crisp=crisp)
    if raw:
        base.calibration = Calibration()
    try:
        for path in files:
            base.load_rules(path, trusted=trusted)
    except BaseException:
        base.close()
        raise
    return base


def judge_scene(
    base: KnowledgeBase, name: str, facts: Iterable[Fact], *, on_demand: FactMaker | None = None
) -> Recognition:
    """Return the verdicts of all models on each thing of a scene, which is then forgotten.

    `on_demand` as for `KnowledgeBase.load_scene`. Where a model reaches a limit on
    a thing, that verdict is unknown.
    """
    base.load_scene(name, facts, on_demand=on_demand)
    try:
        return judge_loaded_scene(base, name)
    finally:
        base.drop_scene(name)


def judge_loaded_scene(base: KnowledgeBase, name: str, *, near: bool = False) -> Recognition:
    """Return the verdicts on a loaded scene; where something was not seen, with the cause.

    With `near` the first near misses have what comes nearest to their sets.
    """
    with base.query("thing(T)", scenes=(name,)) as answers:
        things = tuple(str(thing) for (thing,) in answers if isinstance(thing, Atom))
    verdicts = [_judged(base, name, model, thing) for thing in things for model in base.models]
    if near:
        verdicts = _add_near(base, name, verdicts)
    return Recognition(name, base.add_unseen_causes(verdicts, name))


def _add_near(base: KnowledgeBase, scene: str, verdicts: Sequence[Verdict]) -> list[Verdict]:
    """Return the verdicts; those that come nearest to holding have what comes nearest to sets."""
    misses = [v for v in verdicts if v.state is not State.HOLDS and v.conditions]
    misses.sort(key=lambda v: -len(v.list_conditions_in_state(State.HOLDS)) / len(v.conditions))
    near = {
        (v.model, v.thing): _judged(base, scene, v.model, v.thing, near=True)
        for v in misses[:NEAR_MISSES]
    }
    return [near.get((v.model, v.thing), v) for v in verdicts]


def _judged(
    base: KnowledgeBase, scene: str, model: str, thing: str, *, near: bool = False
) -> Verdict:
    """Return the verdict of a model on a thing; beyond a limit unknown, with a logged warning."""
    try:
        return base.judge(scene, model, thing, near=near)
    except LimitError as exc:
        _LOG.warning("%s: %s", scene, too_large([model], thing, str(exc)))
        return Verdict(model, thing, State.UNKNOWN, 0.0, 1.0, (), (), ())


def too_large(models: Sequence[str], thing: str, limit: str) -> str:
    """Return what to say of a thing that has too many faces for these models."""
    unknown = "which is unknown" if len(models) == 1 else "which are unknown"
    return (
        f"{thing} has too many faces to be judged as {', '.join(models)}, {unknown} ({limit}): "
        "cut it into its objects, or give a mesh of fewer faces"
    )


def recognize(
    facts: Iterable[Fact],
    *,
    scene_name: str,
    model_paths: Sequence[Path] = (),
    trusted: bool = False,
    limits: Limits | None = None,
) -> Recognition:
    """Return the verdicts of the built-in and the user's models on each thing of a scene.

    `model_paths` are files and folders of models, as for `open_knowledge_base`. `limits` holds
    for each model on each thing.
    """
    with open_knowledge_base(model_paths, trusted=trusted, limits=limits) as base:
        return judge_scene(base, scene_name, facts)
