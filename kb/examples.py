"""Examples of models, run: what is expected of a scene, and what came out."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from facetlog.errors import FacetlogError, LimitError
from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis
from facetlog.grammar.constants import quantity
from facetlog.grammar.example_scenes import convert_sizes, list_examples
from facetlog.kb.engine.terms import Atom
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.scene_facts import FactMaker
from facetlog.kb.overlaps import Overlaps

__all__ = ["Case", "CaseResult", "Expected", "SceneMaker", "list_example_cases", "run_cases"]

SceneMaker: TypeAlias = Callable[[s.SceneFile | s.SceneBuilt, Path], Iterable[Fact]]
"""The facts of an example's scene; the path is that of the model file.

Raise InputError for a file that is no scene, and for sizes that nothing can have.
"""

SCENE = "example"
"""Name of the scene that is being asked."""


@dataclass(frozen=True, slots=True)
class Expected:
    """Expected verdict: the state, its degree at least, and lines that are in that state."""

    state: State
    at_least: float | None = None
    because: tuple[str, ...] = ()

    def text(self) -> str:
        """Return the expectation as an example writes it: 'fails because room, legs'."""
        degree = "" if self.at_least is None else f" at least {self.at_least:.4g}"
        because = f" because {', '.join(self.because)}" if self.because else ""
        return f"{self.state}{degree}{because}"

    def problems(self, verdict: Verdict) -> tuple[str, ...]:
        """Return a sentence for each unmet expectation."""
        if verdict.state is not self.state:
            return (
                f"it {_describe_state(verdict.state)}, expected was that it "
                f"{_describe_state(self.state)}",
            )
        found = []
        if self.at_least is not None and verdict.degree < self.at_least:
            found.append(f"it holds by {verdict.degree:.4g} only, expected was {self.at_least:.4g}")
        states = {c.label: c.proof.state for c in verdict.conditions}
        for label in self.because:
            state = states.get(label)
            if state is None:
                found.append(
                    f"`{label}` was not asked, expected was that it {_describe_state(self.state)}"
                )
            elif state is not self.state:
                found.append(
                    f"`{label}` {_describe_state(state)}, expected was that it "
                    f"{_describe_state(self.state)}"
                )
        return tuple(found)


def _describe_state(state: State) -> str:
    return "is unknown" if state is State.UNKNOWN else state.value


@dataclass(frozen=True, slots=True)
class Case:
    """One expectation: of which model, on which thing of which scene, and where it is written.

    Without `thing` it is the main one: that which fits best, or the largest where the model should
    fail. `scene` names the scene in words, the same for the same scene; `facts` makes it, and
    `on_demand` those of its facts that only some models need; `file` is what it is read from.
    What `is_labelled` is one of many files, of which each has a line in the report.
    """

    title: str
    place: str
    model: str
    expected: Expected
    scene: str
    facts: Callable[[], Iterable[Fact]] = field(compare=False, repr=False)
    thing: str | None = None
    on_demand: FactMaker | None = field(default=None, compare=False, repr=False)
    file: Path | None = None
    is_labelled: bool = False


@dataclass(frozen=True, slots=True)
class CaseResult:
    """Result of a case: the verdict, if it could be asked, and what is not as expected."""

    case: Case
    verdict: Verdict | None
    problems: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether all is as expected."""
        return not self.problems

    def lines(self) -> Iterator[str]:
        """Return the problem with its place, and why the verdict is as it is; one line if it
        passed."""
        case = self.case
        if self.passed:
            yield f'{case.place}: passed: {case.model} "{case.title}" {case.expected.text()}'
            return
        yield f'{case.place}: failed: {case.model} "{case.title}": {"; ".join(self.problems)}'
        if self.verdict is not None:
            holds = self.verdict.state is State.HOLDS
            yield from self.verdict.lines() if holds else self.verdict.iter_miss_lines()

    @property
    def line(self) -> str:
        """One line: what came out, and why it is not as expected."""
        first = next(iter(self.lines()))
        return f"{first}; {self.verdict.summary}" if not self.passed and self.verdict else first

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain data."""
        case = self.case
        return {
            "title": case.title,
            "place": case.place,
            "model": case.model,
            "scene": case.scene,
            "thing": self.verdict.thing if self.verdict else case.thing,
            "expected": {
                "state": case.expected.state.value,
                "at_least": case.expected.at_least,
                "because": list(case.expected.because),
            },
            "passed": self.passed,
            "problems": list(self.problems),
            "verdict": self.verdict.to_json() if self.verdict else None,
        }


def list_example_cases(
    analysis: Analysis, make: SceneMaker, on_demand: SceneMaker | None = None
) -> tuple[Case, ...]:
    """Return the examples of a model file without faults, in the order of the text.

    `on_demand` makes the facts that `make` leaves out.
    """
    path = Path(analysis.file.source.name)
    return tuple(
        _build_case(model, example, analysis, path, make, on_demand)
        for model, example in list_examples(analysis)
    )


def _build_case(
    model: s.Model,
    example: s.Example,
    analysis: Analysis,
    path: Path,
    make: SceneMaker,
    on_demand: SceneMaker | None,
) -> Case:
    degree = None if example.at_least is None else quantity(example.at_least)
    expected = Expected(
        State(example.outcome.value),
        None if degree is None else degree.value,
        tuple(label.text for label in example.because),
    )
    return Case(
        example.title.value,
        analysis.file.source.place(example.span.start),
        model.name.text,
        expected,
        _describe_scene(example.scene, path),
        lambda: make(example.scene, path),
        on_demand=None if on_demand is None else lambda: on_demand(example.scene, path),
        file=path.parent / example.scene.path.value
        if isinstance(example.scene, s.SceneFile)
        else None,
    )


def _describe_scene(scene: s.SceneFile | s.SceneBuilt, path: Path) -> str:
    if isinstance(scene, s.SceneFile):
        stated = ", ".join(f"{one.name} {one.value.value}" for one in scene.stated)
        return str(path.parent / scene.path.value) + (f" ({stated})" if stated else "")
    return " and ".join(map(_describe_solid, scene.solids))


def _describe_solid(solid: s.Solid) -> str:
    sizes = ", ".join(f"{name} {value!r}" for name, value in sorted(convert_sizes(solid).items()))
    return f"{solid.builder}({sizes})"


def run_cases(
    base: KnowledgeBase, cases: Sequence[Case], overlaps: Overlaps | None = None
) -> Iterator[CaseResult]:
    """Return the results of cases, those of one scene together: each scene is made and loaded once.

    What is wrong with a scene, or a limit that a model reaches, is a problem of its cases. Of what
    a user's model rightly holds `overlaps` counts the built-in ones that hold as well.
    """
    of_scene: dict[str, list[Case]] = {}
    for case in cases:
        of_scene.setdefault(case.scene, []).append(case)
    for together in of_scene.values():
        try:
            base.load_scene(SCENE, together[0].facts(), on_demand=together[0].on_demand)
        except FacetlogError as exc:
            yield from (CaseResult(case, None, (f"the scene: {exc}",)) for case in together)
            continue
        try:
            for case in together:
                result = _run_case(base, case)
                if overlaps is not None and case.expected.state is State.HOLDS:
                    overlaps.add(_list_holding(base, result.verdict))
                yield result
        finally:
            base.drop_scene(SCENE)


def _run_case(base: KnowledgeBase, case: Case) -> CaseResult:
    try:
        verdict = base.why(SCENE, case.model, thing=case.thing or _find_main_thing(base, case))
    except FacetlogError as exc:
        return CaseResult(case, None, (str(exc),))
    return CaseResult(case, verdict, case.expected.problems(verdict))


def _list_holding(base: KnowledgeBase, verdict: Verdict | None) -> list[tuple[str, str, float]]:
    """Return what holds of the verdict's thing, if that does: itself and the built-in models."""
    if verdict is None or verdict.state is not State.HOLDS or not base.models[verdict.model].own:
        return []
    found = [verdict]
    for model, rules in base.models.items():
        if not rules.own:
            with suppress(LimitError):
                found.append(base.judge(SCENE, model, verdict.thing))
    return [(v.thing, v.model, v.degree) for v in found if v.state is State.HOLDS]


def _find_main_thing(base: KnowledgeBase, case: Case) -> str | None:
    """Return the largest thing where the model should fail; None, for whichever fits best,
    elsewhere.

    That one of many fits badly says nothing of the others.
    """
    if case.expected.state is not State.FAILS:
        return None
    with base.query("thing_size(T, L, W, H)", scenes=(SCENE,)) as answers:
        sizes = {
            str(t): _square_diagonal(lengths) for t, *lengths in answers if isinstance(t, Atom)
        }
    # The first of equals, as facts name them.
    return max(sizes, key=lambda thing: sizes[thing], default=None)


def _square_diagonal(lengths: Sequence[object]) -> float:
    """Return the squared diagonal of the least box round a thing: a flat one has a size as well."""
    return sum(float(x) ** 2 for x in lengths if isinstance(x, int | float))
