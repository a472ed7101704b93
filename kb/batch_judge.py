"""Brief verdicts on one scene after the other: what a batch keeps of each, and nothing else.

Verdicts have the states, degrees, parts and sizes that `KnowledgeBase.judge` gives, without their
proofs. Models are specialised once for that (prolog/batch/specialise.pl), only the facts that they
ask for are handed over, and a scene is one request.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from facetlog.kb.brief_verdict import STACKS, BriefVerdict, Conditions, Cost
from facetlog.kb.calibration import Evidence, InputKind, make_evidence
from facetlog.kb.confidence import Confidence
from facetlog.kb.engine.closing import Closing
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.records import decode_record
from facetlog.kb.explaining.wording import UNSEEN
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.facts_on_demand import Columns, encode_facts
from facetlog.kb.loading.model_code import (
    OpenCode,
    compute_models_hash,
    note_closed,
    open_code,
)
from facetlog.kb.recognize import open_knowledge_base

__all__ = [
    "BatchJudge",
    "collect_columns",
    "collect_evidence",
    "decode_part",
    "split_fields",
]

# Facts that say how a thing was measured: the kinds of surface (without one it was found in
# pictures), and all that evidence is made of.
SURFACES = {("whole", 1): InputKind.WHOLE, ("scanned", 1): InputKind.SCANNED}
EVIDENCE = frozenset({*SURFACES, ("view", 2), ("part_of", 2), ("area", 3), ("coverage", 2)})

# Limits that one model reaches on one thing, by what Prolog calls them.
LIMITS = {"stacks": STACKS, "inferences": "the limit of inferences"}

SEPARATOR = "\x7f"  # separator/1 of batch.pl

# conditions(Model, Count, Interpreted) of each model.
_CONDITIONS = tuple[tuple[str, int, tuple[str, ...]], ...]


class BatchJudge(Closing):
    """The built-in models and the user's, judged on many scenes; arguments as for
    `open_knowledge_base`. `limits` hold for all verdicts on one scene.

    It belongs to one thread. Raise RuleSyntaxError for a faulty file, EngineError if SWI-Prolog is
    missing or too old.
    """

    def __init__(
        self,
        model_paths: Sequence[Path] = (),
        *,
        trusted: bool = False,
        crisp: bool = False,
        raw: bool = False,
        limits: Limits | None = None,
    ) -> None:
        self._base = open_knowledge_base(
            model_paths, trusted=trusted, limits=limits, crisp=crisp, raw=raw
        )
        self.models_hash = compute_models_hash(self._base.models)
        self._crisp = crisp
        self._needed: frozenset[tuple[str, int]] = frozenset()
        self._code: OpenCode | None = None
        try:
            self._code = self._open_code()
        except BaseException:
            self._base.close()
            raise

    def _open_code(self) -> OpenCode:
        code = open_code(self._base, self._base.models, crisp=self._crisp)
        self._needed = code.needed | EVIDENCE
        return code

    def _forget(self, code: OpenCode) -> None:
        if self._base.forget("close_code", code.target):
            note_closed(code.target)

    @property
    def models(self) -> tuple[str, ...]:
        """The names of the models, in the order in which verdicts are given."""
        return tuple(self._base.models)

    @property
    def judging_keys(self) -> Mapping[str, str]:
        """The `compute_judging_key` of each model, as calibrations go by."""
        return {model: rules.judging for model, rules in self._base.models.items()}

    @property
    def needed(self) -> frozenset[tuple[str, int]]:
        """The kinds of facts that the models need, as (functor, number of arguments)."""
        return self._needed

    def conditions(self) -> dict[str, Conditions]:
        """Return how the conditions of each model are judged."""
        self._code = self._code or self._open_code()
        about = Struct("code", (Atom(self._code.target),))
        found = decode_record(self._base.request("batch_conditions", about), _CONDITIONS)
        return {model: Conditions(count, labels) for model, count, labels in found}

    def close(self) -> None:
        """Forget the models."""
        if self._code is not None:
            self._forget(self._code)
            self._code = None
        self._base.close()

    def judge(
        self, rows: Mapping[str, Sequence[Fact]] | Iterable[Fact]
    ) -> tuple[BriefVerdict, ...]:
        """Return the verdict of each model on each thing of a scene, things and models in their
        order.

        `rows` are the facts, or for each functor its rows without it. Raise EngineError if a limit
        is reached; the next scene is judged as if nothing had been.
        """
        return self.judge_columns(collect_columns(rows))

    def judge_columns(self, facts: Mapping[str, Columns]) -> tuple[BriefVerdict, ...]:
        """Return the verdicts on facts that are given by functor, column by column."""
        code = self._code or self._open_code()
        # What is stopped may be at it for a while: the next scene then has a module of its own.
        self._code = None
        needed = {
            (name, arity): facts[name]
            for name, arity in self._needed
            if len(facts.get(name, ())) == arity
        }
        columns = encode_facts(code.target, needed)
        about = Struct("batch", (Atom(code.target), self._base.limits.bounds))
        try:
            said = self._base.request("judge_batch", about, columns)
        except BaseException:
            self._forget(code)
            raise
        self._code = code
        return tuple(self._verdicts(split_fields(said), code, collect_evidence(facts)))

    def _verdicts(
        self, fields: Sequence[str], code: OpenCode, evidence: Mapping[str, Evidence]
    ) -> Iterator[BriefVerdict]:
        """Decode the text of encoded_verdicts/4 of batch.pl."""
        field = iter(fields)
        for model in field:
            thing, state, low, high = (next(field) for _ in range(4))
            proposed = next(field)
            limit = LIMITS.get(proposed, "")
            count = 0 if limit else int(proposed)
            cost = Cost(count, int(next(field)), float(next(field)))
            parts = tuple(decode_part(field) for _ in range(int(next(field))))
            sizes = tuple(
                (next(field), float(next(field)), float(next(field)))
                for _ in range(int(next(field)))
            )
            rules = self._base.models[model]
            confidence = self._base.calibration.compute(
                model,
                rules.judging,
                State(state),
                float(high),
                evidence.get(thing, Evidence(InputKind.PICTURES)),
            )
            yield BriefVerdict(
                model=model,
                thing=thing,
                state=State(state),
                degree=float(low),
                degree_at_most=float(high),
                confidence=confidence if thing else Confidence(),
                parts=parts,
                sizes=sizes,
                specialises=code.general.get(model, ()),
                rather_than=rules.rather_than.get(model, ()),
                own=rules.own,
                cost=cost,
                limit=limit,
            )


def collect_evidence(facts: Mapping[str, Columns]) -> dict[str, Evidence]:
    """Return how each thing with faces was measured."""

    def list_columns(name: str, count: int) -> Columns:
        return (facts.get(name) or ((),) * count)[:count]

    surfaces = {
        str(thing): kind
        for (name, _), kind in SURFACES.items()
        for (things,) in [list_columns(name, 1)]
        for thing in things
    }
    (views,) = list_columns("view", 1)
    owned, owners = list_columns("part_of", 2)
    areas = dict(zip(*list_columns("area", 2), strict=True))
    shares = dict(zip(*list_columns("coverage", 2), strict=True))
    sums: dict[str, list[float]] = {}
    for face, thing in zip(owned, owners, strict=True):
        if face in areas and face in shares:
            area = float(areas[face])
            total = sums.setdefault(str(thing), [0.0, 0.0])
            total[0] += area
            total[1] += area * float(shares[face])
    return {
        thing: make_evidence(surfaces.get(thing), len(views), seen / area)
        for thing, (area, seen) in sums.items()
        if area > 0.0
    }


def collect_columns(rows: Mapping[str, Sequence[Fact]] | Iterable[Fact]) -> dict[str, Columns]:
    """Return rows as columns, of functors that have any; those of other lengths are not of the
    schema."""
    kinds: Mapping[str, Sequence[Fact]]
    if isinstance(rows, Mapping):
        kinds = rows
    else:
        found: dict[str, list[Fact]] = defaultdict(list)
        for fact in rows:
            found[str(fact[0])].append(fact[1:])
        kinds = found
    return {
        name: tuple(zip(*some, strict=True))
        for name, some in kinds.items()
        if len(set(map(len, some))) == 1
    }


def decode_part(field: Iterator[str]) -> tuple[str, tuple[str, ...]]:
    """Return role and names from the fields that part_fields/3 of batch.pl writes."""
    kind, role, name = (next(field) for _ in range(3))
    if kind == "group":
        return role, tuple(next(field) for _ in range(int(name)))
    return role, () if name == UNSEEN else (name,)


def split_fields(said: Term) -> Sequence[str]:
    """Return the fields that joined_fields/2 of batch.pl joined."""
    if isinstance(said, str):
        return said.split(SEPARATOR) if said else ()
    fields: tuple[str, ...] = decode_record(said, tuple[str, ...])
    return fields
