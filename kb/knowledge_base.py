"""The knowledge base: scenes and models loaded, questions asked, verdicts with their reasons.

It works on any thread, and on several at once. Whatever crosses to Prolog is a typed term or a
checked text: no text of a user is ever put into a goal.
"""

import logging
import sys
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from time import perf_counter
from types import MappingProxyType

from facetlog.errors import EngineError, QueryError
from facetlog.kb.calibration import Calibration, InputKind, shipped_calibration
from facetlog.kb.engine.answers import Answers
from facetlog.kb.engine.closing import Closing
from facetlog.kb.engine.columns import decode_chunk
from facetlog.kb.engine.door import LOAD_SECONDS, Door, Replies, ask, checked, clean_up
from facetlog.kb.engine.engine_pool import engine_pool
from facetlog.kb.engine.isolated_process import IsolatedProcess
from facetlog.kb.engine.leftovers import (
    Leftovers,
    clear,
    clear_all,
    destroy_scene,
    leave,
    scene_module,
)
from facetlog.kb.engine.python_predicates import PythonPredicate, remember
from facetlog.kb.engine.terms import Atom, Struct, Term, term_text
from facetlog.kb.explaining.decode_origin import decode_origin
from facetlog.kb.explaining.decode_verdict import decode_verdict, decode_verdicts
from facetlog.kb.explaining.origin import Origin
from facetlog.kb.explaining.sight import Sight, decode_sight
from facetlog.kb.explaining.unseen import unseen
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.limits import Limits
from facetlog.kb.loading.builtin_rules import BUILTIN_MODELS, builtin_rules
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.loaded import LoadedScene, RuleFile
from facetlog.kb.loading.promised_facts import FactMaker
from facetlog.kb.loading.rule_files import RuleFiles
from facetlog.kb.loading.scene_facts import SceneFacts
from facetlog.kb.loading.schema import declarations
from facetlog.kb.loading.words import Word, decode_words

__all__ = ["BUILTIN_MODELS", "KnowledgeBase"]

_LOG = logging.getLogger(__name__)

_bases = count(1)


class KnowledgeBase(Closing):
    """Scenes and models, and questions about them; `calibration` is at first the shipped one.

    `isolated` puts Prolog into a process of its own with `memory_mb` of memory, for rules that
    strangers wrote. A `crisp` one takes all values as exact: conditions hold, fail or are open, and
    there are no degrees between. A context manager; what was loaded is forgotten at its end.
    """

    def __init__(
        self,
        limits: Limits | None = None,
        *,
        isolated: bool = False,
        memory_mb: int = 1024,
        crisp: bool = False,
    ) -> None:
        began = perf_counter()
        self.limits = limits or Limits()
        self.calibration = Calibration() if crisp else shipped_calibration()
        self._name = f"base{next(_bases)}"
        self._lock = threading.RLock()
        self._scenes: dict[str, LoadedScene] = {}
        self._functions: list[int] = []
        self._closed = True  # until there is a door
        self._process = IsolatedProcess(memory_mb) if isolated else None
        self._door: Door = self._process or engine_pool()
        self._rules = RuleFiles(self._name, self._door, self._lock)
        self._facts = SceneFacts(self._request, lambda: self._rules.on_demand)
        self._closed = False
        self._request("declare_facts", declarations(), state=self._name)
        if crisp:
            self._request("be_crisp", term_text(Atom(self._name)), state=self._name)
        rules = builtin_rules()
        for name in BUILTIN_MODELS:
            self._rules.load_builtin(rules / f"{name}.pl")
        _LOG.info(
            "load %d built-in models took %.3f s", len(BUILTIN_MODELS), perf_counter() - began
        )

    def close(self) -> None:
        """Forgets all scenes and rules; what is still being asked is forgotten afterwards."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            left = self._leftovers()
        if self._process is not None:
            self._process.close()
        else:
            clear(left)

    def _leftovers(self) -> Leftovers:
        modules = tuple(scene.module for scene in self._scenes.values())
        functions = tuple(self._functions)
        return Leftovers(self._name, self._door, modules, self._rules.modules, functions)

    def __del__(self) -> None:
        # Nothing may be waited for here: the collector runs at any time, on any thread, with any
        # lock held. At the end of the process everything is forgotten anyway.
        if getattr(self, "_closed", True) or sys.is_finalizing():
            return
        if self._process is not None:
            self._process.kill()
        else:
            leave(self._leftovers())

    @property
    def isolated(self) -> bool:
        """Whether Prolog runs in a process of its own."""
        return self._process is not None

    @property
    def process_id(self) -> int | None:
        """Of the isolated process, if one is running."""
        return None if self._process is None else self._process.process_id

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
        """The scene with these facts; it takes the place of one of the same name, if it loads.

        `cache_key` says what the facts are made from and by what: if facts of that key were loaded
        before, compiled ones are taken, and `facts` is not read at all. `on_demand` makes those
        that `facts` leaves out, once they are asked for. Raises EngineError, and leaves nothing
        behind, if a fact is not one of the schema.
        """
        began, module = perf_counter(), scene_module()
        self._request("new_scene", term_text(Atom(module)), state=module)
        # An isolated process writes no files, and may have to load again when ours are gone.
        key = None if self.isolated else cache_key
        try:
            total = self._facts.load(module, facts, key)
            said = self._request("known_of_scene", term_text(Atom(module)))
            known = said if isinstance(said, tuple) else ()
            unit = "m" if Atom("metric") in known else None
            surfaces = {
                str(thing): InputKind(kind)
                for term in known
                if isinstance(term, Struct)
                for kind, (thing,) in [(term.functor, term.args)]
            }
            scene = LoadedScene(name, module, total, unit, MappingProxyType(surfaces))
            with self._lock:
                named = _terms("named", self._name, name, module)
                self._request("name_scene", named, state=module)
                old = self._scenes.pop(name, None)
                self._scenes[name] = scene
                self._facts.promise(module, on_demand)
        except BaseException:
            self._facts.forget(module)
            destroy_scene(self._door, module)
            raise
        if old is not None:
            self._forget(old)
        _LOG.info("load scene %s took %.3f s", name, perf_counter() - began)
        return scene

    def drop_scene(self, name: str) -> None:
        """Forgets the scene. Raises KeyError if there is none of that name."""
        with self._lock:
            scene = self._scenes.pop(name)
            self._check_open()
            clean_up(self._door, "unname_scene", _terms("named", self._name, name))
        self._forget(scene)

    def _forget(self, scene: LoadedScene) -> None:
        self._facts.forget(scene.module)
        destroy_scene(self._door, scene.module)

    def load_rules(self, path: Path, *, trusted: bool = False) -> RuleFile:
        """The models of a user's file, loaded into a module of their own.

        A model takes the place of a built-in one of the same name, and the file that of the same
        file loaded before. A file in the model language is compiled to clauses that have no
        effect; the files whose models it asks about are loaded before it, unless they are already.
        A file in Prolog is a program, which may do anything: it must be `trusted`.
        Raises RuleSyntaxError, naming file and line, if the file cannot be read, uses a word that
        there is not, is in Prolog and not trusted, or defines a model that another user's file
        defines.
        """
        self._check_open()
        return self._rules.load(Path(path), trusted=trusted)

    def unload_rules(self, rules: RuleFile) -> None:
        """Forgets a user's file."""
        self._check_open()
        self._rules.unload(rules)

    @property
    def models(self) -> Mapping[str, RuleFile]:
        """Each model and the file that defines it; the one loaded last wins."""
        return self._rules.by_model

    @property
    def rule_files(self) -> tuple[Path, ...]:
        """All files that the users' rules were made from."""
        return self._rules.files

    def words(self) -> tuple[Word, ...]:
        """The words that a question may use, facts among them."""
        return decode_words(self._request("question_words", ""))

    def define(self, name: str, arity: int, function: PythonPredicate) -> None:
        """Makes a Python function a predicate that questions may call; see PythonPredicate.

        Raises ValueError in an isolated knowledge base: the function lives in this process.
        """
        if self.isolated:
            raise ValueError("an isolated knowledge base cannot call functions of this process")
        key = remember(function)
        self._functions.append(key)
        self._request(
            "define_python",
            term_text(Struct("define", (Atom(self._name), Struct("/", (Atom(name), arity)), key))),
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
        """The answers to a question, which stream as they are read; at most `most` of them.

        `goal` is written as in docs/queries.md. `bindings` gives values to its variables. It is
        about all scenes, or those named. Raises QueryError for a question that cannot be asked, and
        from the answers EngineError where a limit is reached.
        """
        limits = limits or self.limits
        if most is not None and most < 0:
            raise ValueError(f"at most {most} answers cannot be asked for")
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
            text = term_text(Struct("query", question))
            replies = self._door.replies("query", text, seconds=limits.seconds)
        return _read_answers(replies, goal)

    def judge(self, scene: str, model: str, thing: str) -> Verdict:
        """What a model says of a thing of a scene: the best assignment of its parts."""
        about = (Atom(self._model(model).module), Atom(model), Atom(thing))
        verdict = self._verdict("judge", scene, about)
        return self._calibrated(verdict, scene)

    def why(
        self,
        scene: str,
        model: str,
        *,
        thing: str | None = None,
        parts: Mapping[str, str] = MappingProxyType({}),
    ) -> Verdict:
        """The verdict on the best assignment that agrees with `parts` (role to face).

        Of one thing, or of whichever fits best; without confidence if parts are given. Raises
        QueryError for a model, a role, a thing or a face that there is not.
        """
        verdict = self._verdict("why", scene, self._about(model, thing, parts))
        sight = self._sight(scene, verdict.thing)
        if verdict.is_unseen:
            missed = unseen(sight, verdict.thing, self._scene(scene).length_unit)
            verdict = replace(verdict, unseen=missed)
        verdict = replace(verdict, assumed=sight.assumed)
        return verdict if parts else self._calibrated(verdict, scene)

    def _calibrated(self, verdict: Verdict, scene: str) -> Verdict:
        kind = self._scene(scene).kind_of(verdict.thing)
        return self.calibration.applied(verdict, self._model(verdict.model).judging, kind)

    def with_unseen(self, verdicts: Sequence[Verdict], scene: str) -> tuple[Verdict, ...]:
        """The verdicts, where something was not seen with why, and from where it could be."""
        unit = self._scene(scene).length_unit
        missed = {
            thing: unseen(self._sight(scene, thing), thing, unit)
            for thing in dict.fromkeys(found.thing for found in verdicts if found.is_unseen)
        }
        return tuple(
            replace(found, unseen=missed[found.thing]) if found.is_unseen else found
            for found in verdicts
        )

    def _sight(self, scene: str, thing: str) -> Sight:
        return decode_sight(self._explained("sight", scene, (Atom(thing),)))

    def _verdict(self, operation: str, scene: str, about: tuple[Term, ...]) -> Verdict:
        answer = self._explained(operation, scene, about)
        verdict = decode_verdict(answer, length_unit=self._scene(scene).length_unit)
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
        """At most `count` assignments that the model does not hold for, the nearest miss first.

        Arguments and errors as for `why`.
        """
        about = (*self._about(model, thing, parts), int(count))
        found = self._explained("why_not", scene, about)
        verdicts = decode_verdicts(found, length_unit=self._scene(scene).length_unit)
        return self.with_unseen(verdicts, scene)

    def origin(self, scene: str, about: str) -> Origin:
        """Where something of a scene, or a fact, comes from: down to views and pixels.

        `about` is the name of a face, edge, vertex, thing, piece, opening or view, or the fact as
        text, of which later arguments may be left out: "angle(f1, f2)". Raises QueryError if the
        scene has nothing of that name.
        """
        return decode_origin(self._explained("origin", scene, (about,)))

    def _about(self, model: str, thing: str | None, parts: Mapping[str, str]) -> tuple[Term, ...]:
        things: Term = Atom("all") if thing is None else (Atom(thing),)
        given = tuple(Struct("-", (Atom(role), Atom(face))) for role, face in parts.items())
        return (Atom(self._model(model).module), Atom(model), things, given)

    def _explained(self, operation: str, scene: str, about: tuple[Term, ...]) -> Term:
        limits = self.limits
        with self._lock:
            self._check_open()
            # The scene must still be the one of this module when the request begins.
            module = Atom(self._scene(scene).module)
            request = (Atom(self._name), module, limits.bounds, Struct(operation, about))
            text = term_text(Struct("request", request))
            self._facts.keep(text, (module.name,))
            replies = self._door.replies(operation, text, seconds=limits.seconds)
        try:
            return checked(next(iter(replies), ()))[0]
        finally:
            replies.close()

    def request(
        self, operation: str, about: Struct, columns: str = "", *, keep: str | None = None
    ) -> Term:
        """The result of a request of a batch (batch_judge.py), within the limits of one question.

        What is to `keep` is what later requests rest on, under that name until it is forgotten.
        """
        self._check_open()
        text = term_text(Struct(about.functor, (Atom(self._name), *about.args)))
        text = f"{text}\n{columns}" if columns else text
        seconds = self.limits.seconds if keep is None else LOAD_SECONDS
        return ask(self._door, operation, text, seconds=seconds, state=keep)

    def send(self, operation: str, text: str) -> Term:
        """The result of a request that needs no more than this text (scene_cache.py)."""
        return self._request(operation, text)

    def forget(self, operation: str, kept: str) -> bool:
        """Sends the request that forgets what was kept, when all that is asked now has ended.

        Returns whether it is forgotten already.
        """
        if self._closed:
            return False
        return self._door.when_quiet(operation, term_text(Atom(kept)), state=kept)

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

    def _request(self, operation: str, text: str, *, state: str | None = None) -> Term:
        self._check_open()
        return ask(self._door, operation, text, state=state)

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


def _terms(functor: str, *names: str) -> str:
    return term_text(Struct(functor, tuple(map(Atom, names))))
