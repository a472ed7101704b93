"""The rule files that a knowledge base has loaded: the built-in ones and the users'."""

import re
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from threading import RLock
from types import MappingProxyType

from facetlog.errors import RuleSyntaxError
from facetlog.kb.calibration import compute_judging_key, content_key
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.kb.engine.transport import ask, forget_in_prolog
from facetlog.kb.loading.loaded import RuleFile, decode_rule_file
from facetlog.kb.loading.rule_source import (
    MODEL_SUFFIX,
    RuleSource,
    read_rule_sources,
    read_rule_text,
)
from facetlog.kb.loading.scene_facts import needs_facts_on_demand
from facetlog.plain_text import plain_text

__all__ = ["RuleFiles"]


def _replace_places(message: str, source: RuleSource) -> str:
    """Return the faults of compiled text, reported for the files that it was made from."""
    place = re.compile(rf"^{re.escape(plain_text(str(source.path)))}:(\d+)", re.MULTILINE)
    return place.sub(lambda found: source.place(int(found[1])), message)


class RuleFiles:
    """The rule files of the knowledge base of that name; `lock` is held while they change."""

    def __init__(self, base: str, lock: RLock) -> None:
        self._base, self._lock = base, lock
        self._numbers = count(1)
        self._builtin: list[RuleFile] = []
        self._users: dict[Path, RuleFile] = {}

    @property
    def modules(self) -> tuple[str, ...]:
        """The Prolog modules of the users' files."""
        return tuple(rules.module for rules in self._users.values())

    @property
    def files(self) -> tuple[Path, ...]:
        """All files that the users' rules were made from."""
        return tuple(path for rules in self._users.values() for path in rules.files)

    @property
    def on_demand(self) -> bool:
        """Whether a file may ask for facts that are made on demand."""
        return any(rules.on_demand for rules in (*self._builtin, *self._users.values()))

    @property
    def builtin(self) -> Mapping[str, RuleFile]:
        """The models that belong to facetlog, and their files."""
        return {model: rules for rules in self._builtin for model in rules.models}

    @property
    def by_model(self) -> Mapping[str, RuleFile]:
        """Each model and the file that defines it; the one loaded last wins."""
        files = (*self._builtin, *self._users.values())
        return MappingProxyType({model: rules for rules in files for model in rules.models})

    def load_builtin(self, path: Path) -> None:
        """Load a file that belongs to facetlog."""
        source, name = RuleSource(path, read_rule_text(path), ()), Atom(plain_text(str(path)))
        rules = self._read("load_builtin", name, source)
        self._name_models(rules)
        self._builtin.append(replace(rules, own=False))

    def load(self, path: Path, *, trusted: bool) -> RuleFile:
        """Load a user's file, before it those that it needs: see KnowledgeBase.load_rules."""
        with ExitStack() as undo:
            for source in read_rule_sources(path, present=self._users):
                loaded = self._load(source, trusted=trusted)
                undo.callback(self._unload, loaded)
            undo.pop_all()
        return loaded

    def _load(self, source: RuleSource, *, trusted: bool) -> RuleFile:
        path = source.path
        if source.prolog_file is not None and not trusted:
            raise RuleSyntaxError(
                f"{source.prolog_file}: rules in Prolog are a program, which may do anything. "
                "Load them with --trust (in Python trust=True) if you trust their author, or "
                "write them in the model language"
            )
        operation = "load_compiled" if source.prolog_file is None else "load_prolog"
        module = f"{self._base}:rules{next(self._numbers)}"
        rules = Struct("rules", (Atom(module), Atom(plain_text(str(path))), source.text))
        loaded = self._read(operation, rules, source)
        with self._lock:
            before = self._users.get(path)
            others = [rules for rules in self._users.values() if rules is not before]
            twice = [(m, o.path) for o in others for m in o.models if m in loaded.models]
            if not twice:
                self._users.pop(path, None)
                self._users[path] = loaded
                self._name_models(loaded)
        if twice:
            self._drop(loaded)
            model, other = twice[0]
            raise RuleSyntaxError(f"{path}: the model {model} is already defined in {other}")
        if before is not None:
            self._drop(before)
        return loaded

    def _unload(self, rules: RuleFile) -> None:
        with self._lock:
            if self._users.get(rules.path) is rules:
                del self._users[rules.path]
        self._drop(rules)

    def _read(self, operation: str, rules: Term, source: RuleSource) -> RuleFile:
        try:
            loaded = ask(operation, format_prolog_term(rules))
        except RuleSyntaxError as error:
            if source.path.suffix != MODEL_SUFFIX:
                raise
            raise RuleSyntaxError(_replace_places(str(error), source)) from None
        rules_file = decode_rule_file(loaded, source.path, source.files)
        return replace(
            rules_file,
            content=content_key(source.text),
            judging=compute_judging_key(source.text),
            on_demand=needs_facts_on_demand(source.text),
        )

    def _name_models(self, rules: RuleFile) -> None:
        models = tuple(map(Atom, rules.models))
        named = Struct("named", (Atom(self._base), models, Atom(rules.module)))
        ask("name_models", format_prolog_term(named))

    def _drop(self, rules: RuleFile) -> None:
        module = Atom(rules.module)
        named = Struct("named", (Atom(self._base), module))
        forget_in_prolog("unname_models", format_prolog_term(named))
        engine_pool().send_when_quiet("drop_rules", format_prolog_term(module))
