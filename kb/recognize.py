"""Facts into verdicts: the one entry point of the knowledge base."""

from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path

from facetlog.errors import RuleSyntaxError
from facetlog.kb.encode import Fact
from facetlog.kb.engine import Engine, Limits
from facetlog.kb.verdict import Recognition

__all__ = ["check_rules", "recognize", "rule_files"]

RULE_SUFFIX = ".pl"


def rule_files(paths: Iterable[Path]) -> tuple[Path, ...]:
    """The files of rules that these files and folders name, folders in alphabetical order.

    Raises RuleSyntaxError for a path that is not there and for a folder without rules.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        inside = sorted(path.glob(f"*{RULE_SUFFIX}")) if path.is_dir() else [path]
        if not path.exists():
            raise RuleSyntaxError(f"{path}: there is no such file or folder")
        if not inside:
            raise RuleSyntaxError(f"{path}: the folder has no {RULE_SUFFIX} files")
        found.extend(inside)
    return tuple(dict.fromkeys(p.resolve() for p in found))


def check_rules(model_paths: Sequence[Path]) -> None:
    """Raises what `recognize` would raise for these models, without a scene."""
    engine = Engine()
    with ExitStack() as stack:
        for path in rule_files(model_paths):
            stack.callback(engine.unload_rules, engine.load_rules(path))


def recognize(
    facts: Iterable[Fact],
    *,
    scene_name: str,
    model_paths: Sequence[Path] = (),
    limits: Limits | None = None,
) -> Recognition:
    """What the built-in models and the user's say of each thing in a scene.

    `model_paths` are files and folders of rules (docs/models.md). `limits` holds for each model on
    each thing. Raises RuleSyntaxError for a faulty file, EngineError if SWI-Prolog is missing, too
    old, or reaches a limit.
    """
    scene_facts = tuple(facts)
    things = tuple(str(f[1]) for f in scene_facts if f[0] == "thing")
    length_unit = "m" if ("scale", "metric") in scene_facts else None
    files = rule_files(model_paths)
    engine = Engine(limits)
    with ExitStack() as stack:
        for path in files:
            stack.callback(engine.unload_rules, engine.load_rules(path))
        scene = stack.enter_context(engine.load_scene(scene_name, scene_facts))
        return Recognition(
            scene_name,
            tuple(
                engine.judge(scene, model, thing, length_unit=length_unit)
                for thing in things
                for model in engine.models
            ),
        )
