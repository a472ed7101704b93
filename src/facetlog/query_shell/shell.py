"""The state of the shell, and the questions that are put to its scenes."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial

from facetlog.errors import FacetlogError, InputError, QueryError
from facetlog.kb.loading.loaded import Word
from facetlog.perception.facts.fact_schema import ArgumentKind
from facetlog.query_shell.asking import (
    Outcome,
    WaysToAll,
    error_json,
    show_answers,
    show_every_answer,
    write_answers,
)
from facetlog.query_shell.explaining import (
    About,
    Explanation,
    is_origin,
    make_unknown_subject_error,
    origin,
    parse_parts,
    why,
    why_not,
)
from facetlog.query_shell.scene_names import scene_names
from facetlog.query_shell.screen import Screen
from facetlog.query_shell.session import Session
from facetlog.query_shell.words import list_words

MISSES = 5
"""Near misses that why_not shows."""

AT_PROMPT = WaysToAll(rows=":all shows them", cells=":all shows all of it")
IN_ONE_SHOT = WaysToAll(rows="without --limit all are shown", cells="--json shows all of it")

SEVERAL = "facetlog-scenes/1"
"""The schema of an explanation of each of several scenes."""

_LEAVING = frozenset({"halt", "quit", "exit", "bye"})


@dataclass(slots=True)
class Shell:
    """A session with the way its answers are shown: `limit` of them, as text or as JSON.

    At a prompt hints are shown what to do next. `line` is the number of the
    line that is being done, in a file; `show_all` shows all of what was last shown in part.
    """

    session: Session
    screen: Screen
    limit: int | None
    as_json: bool = False
    at_prompt: bool = False
    line: int | None = None
    show_all: Callable[[], Outcome] | None = None
    _names: Mapping[ArgumentKind, tuple[str, ...]] = field(default_factory=dict)
    _words: tuple[Word, ...] = ()
    _known: int = -1

    def ask(self, goal: str) -> Outcome:
        """Show the answers to a goal. Raise FacetlogError if it cannot be asked."""
        with self.report_errors_as_json(goal):
            if self.at_prompt and goal in _LEAVING:
                raise InputError("to leave the shell: :quit, or Ctrl-D")
            if not self.session.scenes:
                raise InputError("no scene is loaded: load one with :load")
        self.show_all = partial(self._ask_all, goal)
        if self.as_json:
            return self._write(goal, self.limit)
        ways = AT_PROMPT if self.at_prompt else IN_ONE_SHOT
        return show_answers(self.session, self.screen, goal, limit=self.limit, ways=ways)

    def _ask_all(self, goal: str) -> Outcome:
        if self.as_json:
            return self._write(goal, None)
        return show_every_answer(self.session, self.screen, goal)

    def _write(self, goal: str, limit: int | None) -> Outcome:
        return write_answers(self.session, self.screen, goal, limit=limit, line=self.line)

    @contextmanager
    def report_errors_as_json(self, asked: str) -> Iterator[None]:
        """Write an error raised inside also as a line of JSON, where answers are JSON."""
        try:
            yield
        except FacetlogError as exc:
            if self.as_json:
                self.screen.say(error_json(asked, exc, line=self.line))
            raise

    def explain(self, negative: bool, about: str, asked: str, *, full: bool = False) -> Outcome:
        """Explain each scene: why, why not, or where from; errors as for `ask`.

        `asked` is the whole question, which JSON repeats.
        """
        ask = self._parse_question(negative, about, full=full)
        found: list[tuple[str, Explanation]] = []
        absent: QueryError | None = None
        for scene in self.session.scenes:
            try:
                found.append((scene, ask(scene)))
            except QueryError as exc:  # of several scenes one may have it
                absent = exc
        if not found and absent is not None:
            raise absent
        if self.as_json:
            self._write_explanations(asked, [explanation for _, explanation in found])
        else:
            self._show_explanations(found)
            if any(explanation.cut for _, explanation in found):
                self.show_all = partial(self.explain, negative, about, asked, full=True)
                self.screen.remark(":all shows all of it")
        return Outcome.YES if any(e.yes for _, e in found) else Outcome.NO

    def _write_explanations(self, asked: str, found: Sequence[Explanation]) -> None:
        """Write one object, also for several scenes."""
        place = {"goal": asked, **({} if self.line is None else {"line": self.line})}
        if len(self.session.scenes) == 1:
            data = dict(found[0].data)
        else:
            data = {"schema": SEVERAL, "scenes": [dict(e.data) for e in found]}
        self.screen.say(json.dumps({"schema": data.pop("schema"), **place, **data}))

    def _show_explanations(self, found: Sequence[tuple[str, Explanation]]) -> None:
        for scene, explanation in found:
            if len(self.session.scenes) > 1:
                self.screen.say(f"{scene}:", style="bold")
            self.screen.say(*explanation.lines)
            if explanation.hint and self.at_prompt:
                self.screen.remark(f"why_not {explanation.hint}")

    def _parse_question(
        self, negative: bool, text: str, *, full: bool
    ) -> Callable[[str], Explanation]:
        """Return what explains a scene, e.g. for `table t2 top=f1` or `f3`."""
        words = re.sub(r"\s*=\s*", "=", text).split()
        command = "why_not" if negative else "why"
        if not words:
            raise InputError(f"{command} needs a model: {command} MODEL [THING] [PART=FACE …]")
        models = self.session.base.models
        if words[0] in models:
            thing = words[1] if len(words) > 1 and "=" not in words[1] else None
            parts = parse_parts(words[2 if thing else 1 :])
            about = About(words[0], thing, parts)
            if negative:
                return lambda scene: why_not(self.session, scene, about, count=MISSES, full=full)
            return lambda scene: why(self.session, scene, about, full=full)
        if not negative and is_origin(self.names, text):
            return lambda scene: origin(self.session, scene, text, full=full)
        raise make_unknown_subject_error(
            models, {} if negative or len(words) > 1 else self.names, words[0]
        )

    @property
    def names(self) -> Mapping[ArgumentKind, tuple[str, ...]]:
        """The names of the scenes that are asked, by kind."""
        self._update_names()
        return self._names

    @property
    def words(self) -> tuple[Word, ...]:
        """The words of questions."""
        self._update_names()
        return self._words

    def _update_names(self) -> None:
        if self._known != self.session.generation:
            self._names = scene_names(self.session.base, self.session.scenes)
            self._words = list_words(self.session.base.words())
            self._known = self.session.generation
