"""The knowledge base: scenes and models loaded, questions asked, verdicts with their reasons.

It works on any thread, and on several at once. Whatever crosses to Prolog is a typed term or a
checked text: no text of a user is ever put into a goal.
"""

import logging
import re
import sys
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from time import perf_counter
from types import MappingProxyType

from facetlog.errors import EngineError, QueryError
from facetlog.kb.calibration import Calibration, load_shipped_calibration
from facetlog.kb.engine.answers import Answers
from facetlog.kb.engine.closing import Closing
from facetlog.kb.engine.columns import decode_chunk
from facetlog.kb.engine.engine_pool import Replies, engine_pool
from facetlog.kb.engine.python_predicates import PythonPredicate, remember
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.kb.engine.transport import (
    LOAD_SECONDS,
    Leftovers,
    ask,
    checked,
    clear,
    clear_all,
    destroy_scene,
    forget_in_prolog,
    leave,
    scene_module,
)
from facetlog.kb.explaining.decode_verdict import (
    decode_explained,
    decode_verdict,
    decode_verdicts,
)
from facetlog.kb.explaining.origin import Origin
from facetlog.kb.explaining.records import decode_record
from facetlog.kb.explaining.sight import OtherThing, Sight
from facetlog.kb.explaining.unseen import unseen
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.limits import Limits
from facetlog.kb.loading.builtin_rules import BUILTIN_MODELS, builtin_rules
from facetlog.kb.loading.encode import Fact, declarations
from facetlog.kb.loading.loaded import (
    LoadedScene,
    RuleFile,
    Word,
    decode_evidence,
    decode_words,
)
from facetlog.kb.loading.model_code import open_code
from facetlog.kb.loading.rule_files import RuleFiles
from facetlog.kb.loading.scene_facts import FactMaker, SceneFacts

__all__ = ["BUILTIN_MODELS", "KnowledgeBase"]

_LOG = logging.getLogger(__name__)

_bases = count(1)

ASKS_VERDICTS = re.compile(r"\b(is_a|verdict|plays|assignment|part_in)\(")
"""Predicates of questions that judge models."""


class KnowledgeBase(Closing):
    """Scenes and models, and questions about them; `calibration` is at first the shipped one.

    A `crisp` one takes all values as exact: conditions hold, fail or are open, and there are no
    degrees between. A context manager; what was loaded is forgotten at its end.
    """

    def __init__(self, limits: Limits | None = None, *, crisp: bool = False) -> None:
        began = perf_counter()
        self.limits = limits or Limits()
        self.calibration = Calibration() if crisp else load_shipped_calibration()
        self._name = f"base{next(_bases)}"
        self._lock = threading.RLock()
        self._scenes: dict[str, LoadedScene] = {}
        self._functions: list[int] = []
        self._prepared = False
        self._closed = True  # until Prolog runs
        self._pool = engine_pool()
        self._rules = RuleFiles(self._name, self._lock)
        self._facts = SceneFacts(self.send, lambda: self._rules.on_demand)
        self._closed = False
        self.send("declare_facts", declarations())
        self._crisp = crisp
        if crisp:
            self.send("be_crisp", format_prolog_term(Atom(self._name)))
        rules = builtin_rules()
        for name in BUILTIN_MODELS:
            self._rules.load_builtin(rules / f"{name}.pl")
        _LOG.info(
            "load %d built-in models took %.3f s", len(BUILTIN_MODELS), perf_counter() - began
        )

    def close(self) -> None:
        """Forget all scenes and rules; what is still being asked is forgotten afterwards."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            left = self._collect_leftovers()
        clear(left)

    def _collect_leftovers(self) -> Leftovers:
        modules = tuple(scene.module for scene in self._scenes.values())
        functions = tuple(self._functions)
        return Leftovers(self._name, modules, self._rules.modules, functions)

    def __del__(self) -> None:
        # Nothing may be waited for here: the collector runs at any time, on any thread, with any
        # lock held. At the end of the process everything is forgotten anyway.
        if getattr(self, "_closed", True) or sys.is_finalizing():
            return
        leave(self._collect_leftovers())

    @property
    def scenes(self) -> Mapping[str, LoadedScene]:
        """The loaded scenes by name, in the order of loading."""
        return MappingProxyType(self._scenes)

    def load_scene(
        self,
        name: str,
        facts: Iterable[Fact],
        *,
        cache_key: str | None = None,
        on_demand: FactMaker | None = None,
    ) -> LoadedScene:
        """Return the scene with these facts; it takes the place of one of the same name, if it
        loads.

        `cache_key` says what the facts are made from and by what: if facts of that key were loaded
        before, compiled ones are taken, and `facts` is not read at all. `on_demand` makes those
        that `facts` leaves out, once they are asked for. Raise EngineError, and leaves nothing
        behind, if a fact is not one of the schema.
        """
        began, module = perf_counter(), scene_module()
        self.send("new_scene", format_prolog_term(Atom(module)))
        try:
            total = self._facts.load(module, facts, cache_key)
            said = self.send("known_of_scene", format_prolog_term(Atom(module)))
            known = said if isinstance(said, tuple) else ()
            unit = "m" if Atom("metric") in known else None
            scene = LoadedScene(name, module, total, unit, decode_evidence(known))
            with self._lock:
                self.send("name_scene", _format_terms("named", self._name, name, module))
                old = self._scenes.pop(name, None)
                self._scenes[name] = scene
                self._facts.promise(module, on_demand)
        except BaseException:
            self._facts.forget(module)
            destroy_scene(module)
            raise
        if old is not None:
            self._forget(old)
        _LOG.info("load scene %s took %.3f s", name, perf_counter() - began)
        return scene

    def drop_scene(self, name: str) -> None:
        """Forget the scene. Raise KeyError if there is none of that name."""
        with self._lock:
            scene = self._scenes.pop(name)
            self._check_open()
            forget_in_prolog("unname_scene", _format_terms("named", self._name, name))
        self._forget(scene)

    def _forget(self, scene: LoadedScene) -> None:
        self._facts.forget(scene.module)
        destroy_scene(scene.module)

    def load_rules(self, path: Path, *, trusted: bool = False) -> RuleFile:
        """Return the models of a user's file, loaded into a module of their own.

        A model takes the place of a built-in one of the same name, and the file that of the same
        file loaded before. A file in the model language is compiled to clauses that have no
        effect; the files whose models it asks about are loaded before it, unless they are already.
        A file in Prolog is a program, which may do anything: it must be `trusted`.
        Raise RuleSyntaxError, naming file and line, if the file cannot be read, uses a word that
        there is not, is in Prolog and not trusted, or defines a model that another user's file
        defines.
        """
        self._check_open()
        return self._rules.load(Path(path), trusted=trusted)

    @property
    def models(self) -> Mapping[str, RuleFile]:
        """Each model and the file that defines it; the one loaded last wins."""
        return self._rules.by_model

    @property
    def rule_files(self) -> tuple[Path, ...]:
        """All files that the users' rules were made from."""
        return self._rules.files

    def words(self) -> tuple[Word, ...]:
        """Return the words that a question may use, facts among them."""
        return decode_words(self.send("question_words", ""))

    def define(self, name: str, arity: int, function: PythonPredicate) -> None:
        """Make a Python function a predicate that questions may call; see PythonPredicate."""
        key = remember(function)
        self._functions.append(key)
        self.send(
            "define_python",
            format_prolog_term(
                Struct("define", (Atom(self._name), Struct("/", (Atom(name), arity)), key))
            ),
        )

    def query(
        self,
        goal: str,
        *,
        scenes: Sequence[str] | None = None,
        limits: Limits | None = None,
        most: int | None = None,
        bindings: Mapping[str, Term] = MappingProxyType({}),
    ) -> Answers:
        """Return the answers to a question, which stream as they are read; at most `most` of them.

        `goal` is written as in docs/queries.md. `bindings` gives values to its variables. It is
        about all scenes, or those named. Raise QueryError for a question that cannot be asked, and
        from the answers EngineError where a limit is reached.
        """
        limits = limits or self.limits
        if most is not None and most < 0:
            raise ValueError(f"at most {most} answers cannot be asked for")
        if ASKS_VERDICTS.search(goal):
            self._prepare_builtin()
        with self._lock:
            self._check_open()
            chosen = tuple(self._scenes if scenes is None else dict.fromkeys(scenes))
            self._facts.keep(goal, [self._scene(name).module for name in chosen])
            question = (
                Atom(self._name),
                Atom("all") if scenes is None else tuple(map(Atom, chosen)),
                Atom("inf") if most is None else most,
                limits.bounds,
                tuple(Struct("=", (Atom(name), value)) for name, value in bindings.items()),
                goal,
            )
            text = format_prolog_term(Struct("query", question))
            replies = self._pool.replies("query", text, seconds=limits.seconds)
        return _read_answers(replies, goal)

    def judge(self, scene: str, model: str, thing: str, *, near: bool = False) -> Verdict:
        """Return the verdict of a model on a thing of a scene: the best assignment of its parts.

        With `near` its conditions have what comes nearest to their sets.
        """
        self.prepare(model)
        about = (Atom(self._model(model).module), Atom(model), Atom(thing))
        verdict = self._verdict("judge_near" if near else "judge", scene, about)
        return self._add_confidence(verdict, scene)

    def why(
        self,
        scene: str,
        model: str,
        *,
        thing: str | None = None,
        parts: Mapping[str, str] = MappingProxyType({}),
    ) -> Verdict:
        """Return the verdict on the best assignment that agrees with `parts` (role to face).

        Of one thing, or of whichever fits best; without confidence if parts are given. Of a role
        that is a set, the verdict's `asked` says whether that face belongs to it. Raises
        QueryError for a model, a role, a thing or a face that there is not.
        """
        verdict = self._verdict("why", scene, self._build_subject_terms(model, thing, parts))
        sight = self._sight(scene, verdict.thing)
        if verdict.is_unseen:
            missed = unseen(sight, verdict.thing, self._scene(scene).length_unit)
            verdict = replace(verdict, unseen=missed)
        verdict = self._add_others(replace(verdict, assumed=sight.assumed), scene)
        return verdict if parts else self._add_confidence(verdict, scene)

    def prepare(self, model: str) -> frozenset[str]:
        """Specialise the rules that verdicts on a model are searched by, beyond the limits of a
        question, and return the kinds of facts that they ask for.

        Those of the built-in models are made together, for they ask for each other.
        """
        self._prepare_builtin()
        about = Struct("code", (Atom(self._model(model).module), (Atom(model),)))
        kinds = self.request("prepare_code", about, seconds=LOAD_SECONDS)
        return frozenset(decode_record(kinds, tuple[str, ...]))

    def _prepare_builtin(self) -> None:
        with self._lock:
            if not self._prepared:
                code = open_code(self, self._rules.builtin, crisp=self._crisp, shared=True)
                self.request("use_code", Struct("code", (Atom(code.target),)))
                self._prepared = True

    def _add_confidence(self, verdict: Verdict, scene: str) -> Verdict:
        evidence = self._scene(scene).get_evidence(verdict.thing)
        return self.calibration.apply(verdict, self._model(verdict.model).judging, evidence)

    def add_unseen_causes(self, verdicts: Sequence[Verdict], scene: str) -> tuple[Verdict, ...]:
        """Return the verdicts; where something was not seen, with the cause and the way out."""
        unit = self._scene(scene).length_unit
        missed = {
            thing: unseen(self._sight(scene, thing), thing, unit)
            for thing in dict.fromkeys(found.thing for found in verdicts if found.is_unseen)
        }
        return tuple(
            replace(found, unseen=missed[found.thing]) if found.is_unseen else found
            for found in verdicts
        )

    def _add_others(self, verdict: Verdict, scene: str) -> Verdict:
        """Return the verdict with the other things near it, if it lacks a part."""
        if not verdict.lacks_pieces:
            return verdict
        answer = self._request_explanation("others_near", scene, (Atom(verdict.thing),))
        return replace(verdict, others=decode_record(answer, tuple[OtherThing, ...]))

    def _sight(self, scene: str, thing: str) -> Sight:
        sight: Sight = decode_record(
            self._request_explanation("sight", scene, (Atom(thing),)), Sight
        )
        return sight

    def _verdict(self, operation: str, scene: str, about: tuple[Term, ...]) -> Verdict:
        answer = self._request_explanation(operation, scene, about)
        decode = decode_explained if operation == "why" else decode_verdict
        verdict = decode(answer, length_unit=self._scene(scene).length_unit)
        rules = self._model(verdict.model)
        others = rules.rather_than.get(verdict.model, ())
        return replace(verdict, rather_than=others, own=rules.own)

    def why_not(
        self,
        scene: str,
        model: str,
        *,
        thing: str | None = None,
        parts: Mapping[str, str] = MappingProxyType({}),
        count: int = 5,
    ) -> tuple[Verdict, ...]:
        """Return at most `count` assignments that the model does not hold for, the nearest miss
        first.

        Arguments and errors as for `why`.
        """
        about = (*self._build_subject_terms(model, thing, parts), int(count))
        found = self._request_explanation("why_not", scene, about)
        verdicts = decode_verdicts(found, length_unit=self._scene(scene).length_unit)
        verdicts = tuple(self._add_others(verdict, scene) for verdict in verdicts)
        return self.add_unseen_causes(verdicts, scene)

    def origin(self, scene: str, about: str) -> Origin:
        """Return where something of a scene, or a fact, comes from: down to views and pixels.

        `about` is the name of a face, edge, vertex, thing, piece, opening or view, or the fact as
        text, of which later arguments may be left out: "angle(f1, f2)". Raise QueryError if the
        scene has nothing of that name.
        """
        origin: Origin = decode_record(self._request_explanation("origin", scene, (about,)), Origin)
        return origin

    def _build_subject_terms(
        self, model: str, thing: str | None, parts: Mapping[str, str]
    ) -> tuple[Term, ...]:
        self.prepare(model)
        things: Term = Atom("all") if thing is None else (Atom(thing),)
        given = tuple(Struct("-", (Atom(role), Atom(face))) for role, face in parts.items())
        return (Atom(self._model(model).module), Atom(model), things, given)

    def _request_explanation(self, operation: str, scene: str, about: tuple[Term, ...]) -> Term:
        limits = self.limits
        with self._lock:
            self._check_open()
            # The scene must still be the one of this module when the request begins.
            module = Atom(self._scene(scene).module)
            request = (Atom(self._name), module, limits.bounds, Struct(operation, about))
            text = format_prolog_term(Struct("request", request))
            self._facts.keep(text, (module.name,))
            replies = self._pool.replies(operation, text, seconds=limits.seconds)
        try:
            return checked(next(iter(replies), ()))[0]
        finally:
            replies.close()

    def request(
        self, operation: str, about: Struct, columns: str = "", *, seconds: float | None = None
    ) -> Term:
        """Return the result of a request of a batch (batch_judge.py).

        It may take as many `seconds`, by default as long as one question.
        """
        self._check_open()
        text = format_prolog_term(Struct(about.functor, (Atom(self._name), *about.args)))
        text = f"{text}\n{columns}" if columns else text
        return ask(operation, text, seconds=seconds or self.limits.seconds)

    def send(self, operation: str, text: str) -> Term:
        """Return the result of a request that needs no more than this text."""
        self._check_open()
        return ask(operation, text)

    def forget(self, operation: str, kept: str) -> bool:
        """Send the request that forgets what was kept, when all that is asked now has ended.

        Return whether it is forgotten already.
        """
        if self._closed:
            return False
        return self._pool.send_when_quiet(operation, format_prolog_term(Atom(kept)))

    def _scene(self, name: str) -> LoadedScene:
        try:
            return self._scenes[name]
        except KeyError:
            raise EngineError(f"no scene {name!r} is loaded") from None

    def _model(self, name: str) -> RuleFile:
        try:
            return self.models[name]
        except KeyError:
            known = ", ".join(self.models)
            raise QueryError(f"there is no model {name}; loaded are {known}") from None

    def _check_open(self) -> None:
        if self._closed:
            raise EngineError("the knowledge base is closed")
        clear_all()


def _read_answers(replies: Replies, goal: str) -> Answers:
    """Return the answers to a goal, once Prolog has checked it."""
    try:
        names, pieces = checked(next(replies, ()), goal)
        if not isinstance(names, tuple):
            raise EngineError("Prolog's answer cannot be read")
        first = decode_chunk(pieces)
        rest = (decode_chunk(checked(reply, goal)[1]) for reply in replies)
        return Answers(tuple(map(str, names)), chain((first,), rest), replies.close)
    except BaseException:
        replies.close()
        raise


def _format_terms(functor: str, *names: str) -> str:
    return format_prolog_term(Struct(functor, tuple(map(Atom, names))))
