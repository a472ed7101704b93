"""Brief verdicts on one scene after the other: what a batch keeps of each, and nothing else.

Verdicts have the states, degrees, parts and sizes that `KnowledgeBase.judge` gives, without their
proofs. Models are specialised once for that (prolog/batch/specialise.pl), only the facts that they
ask for are handed over, and a scene is one request.
"""

import hashlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from facetlog.kb.brief_verdict import STACKS, BriefVerdict, Conditions, Cost
from facetlog.kb.calibration import Evidence, InputKind, make_evidence
from facetlog.kb.confidence import Confidence
from facetlog.kb.engine.closing import Closing
from facetlog.kb.engine.engine import house
from facetlog.kb.engine.terms import Atom, Struct, Term, format_prolog_term
from facetlog.kb.engine.transport import LOAD_SECONDS, scene_module
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.records import decode_record
from facetlog.kb.explaining.wording import UNSEEN
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.kb.limits import Limits
from facetlog.kb.loading.encode import Fact
from facetlog.kb.loading.facts_on_demand import Columns, encode_facts
from facetlog.kb.loading.rule_source import MODEL_SUFFIX
from facetlog.kb.loading.scene_cache import SceneCache
from facetlog.kb.recognize import open_knowledge_base

__all__ = ["BatchJudge", "collect_columns", "collect_evidence"]

# What verdicts follow from beside the models: words, measures and how they are judged; of models
# that cannot be specialised also by how it is proved.
JUDGING_CODE = ("rules/*.pl", "kb/prolog/**/*.pl")
HASH_DIGITS = 16

# Facts that say how a thing was measured: the kinds of surface (without one it was found in
# pictures), and all that evidence is made of.
SURFACES = {("whole", 1): InputKind.WHOLE, ("scanned", 1): InputKind.SCANNED}
EVIDENCE = frozenset({*SURFACES, ("view", 2), ("part_of", 2), ("area", 3), ("coverage", 2)})

NAME_DIGITS = 24  # of a module's digest
# Modules of open batches that are named by what they hold.
_in_use: set[str] = set()

# Limits that one model reaches on one thing, by what Prolog calls them.
LIMITS = {"stacks": STACKS, "inferences": "the limit of inferences"}

SEPARATOR = "\x7f"  # separator/1 of batch.pl

# opened(Kinds, General): the kinds of facts that models need, and of which models some are special.
_OPENED = tuple[tuple[tuple[str, int], ...], tuple[tuple[str, tuple[str, ...]], ...]]
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
        self.models_hash = _compute_models_hash(self._base)
        self._crisp = crisp
        self._code = SceneCache()
        self._needed: frozenset[tuple[str, int]] = frozenset()
        self._batch: str | None = None
        try:
            self._batch = self._open_batch()
        except BaseException:
            self._base.close()
            raise

    def _open_batch(self) -> str:
        """Return the name of a batch whose models are ready, for the facts of a fresh module.

        What the models are specialised to is kept, under the name of that module.
        """
        of_module: dict[str, list[Atom]] = defaultdict(list)
        for model, rules in self._base.models.items():
            of_module[rules.module].append(Atom(model))
        models = tuple(Struct("-", (Atom(m), tuple(names))) for m, names in of_module.items())
        self._scene, path = self._choose_module_and_file(models)
        batch = f"{self._scene}:batch"
        loaded = self._code.load(path, self._scene, self._base.send, "load_batch")
        about = Struct("batch", (Atom(batch), Atom(self._scene), models))
        opened = self._base.request("open_batch", about, seconds=LOAD_SECONDS)
        if loaded is None:
            self._code.save(path, self._scene, self._base.send, "save_batch")
        kinds, general = decode_record(opened, _OPENED)
        self._general: dict[str, tuple[str, ...]] = dict(general)
        self._needed = frozenset(kinds) | EVIDENCE
        return batch

    def _choose_module_and_file(self, models: tuple[Term, ...]) -> tuple[str, Path | None]:
        """Return the module that the models are specialised into, and the file that keeps it, if
        any.

        The module is named by what the file depends on: clauses name it. One that is in use cannot
        be another batch's. Nothing is kept of Prolog, which may load files that nobody knows of.
        """
        paths = self._base.rule_files
        if any(path.suffix != MODEL_SUFFIX for path in paths):
            return scene_module(), None
        total = hashlib.sha256(f"{self.models_hash} crisp={self._crisp}\n".encode())
        total.update(format_prolog_term(models).encode())
        try:
            for path in paths:
                total.update(path.read_bytes())
        except OSError:
            return scene_module(), None  # it is gone by now
        name = f"facetlog_batch:{total.hexdigest()[:NAME_DIGITS]}"
        if name in _in_use:
            return scene_module(), None
        _in_use.add(name)
        identity = str(self._base.send("cache_identity", ""))
        return name, self._code.path(total.hexdigest(), identity)

    def _forget(self, batch: str) -> None:
        if self._base.forget("close_batch", batch):
            _in_use.discard(self._scene)

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
        self._batch = self._batch or self._open_batch()
        about = Struct("batch", (Atom(self._batch),))
        found = decode_record(self._base.request("batch_conditions", about), _CONDITIONS)
        return {model: Conditions(count, labels) for model, count, labels in found}

    def close(self) -> None:
        """Forget the models."""
        if self._batch is not None:
            self._forget(self._batch)
            self._batch = None
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
        batch = self._batch or self._open_batch()
        # What is stopped may be at it for a while: the next scene then has a module of its own.
        self._batch = None
        needed = {
            (name, arity): facts[name]
            for name, arity in self._needed
            if len(facts.get(name, ())) == arity
        }
        columns = encode_facts(self._scene, needed)
        about = Struct("batch", (Atom(batch), self._base.limits.bounds))
        try:
            said = self._base.request("judge_batch", about, columns)
        except BaseException:
            self._forget(batch)
            raise
        self._batch = batch
        return tuple(self._verdicts(_split_fields(said), collect_evidence(facts)))

    def _verdicts(
        self, fields: Sequence[str], evidence: Mapping[str, Evidence]
    ) -> Iterator[BriefVerdict]:
        """Decode the text of encoded_verdicts/4 of batch.pl."""
        field = iter(fields)
        for model in field:
            thing, state, low, high = (next(field) for _ in range(4))
            proposed = next(field)
            limit = LIMITS.get(proposed, "")
            count = 0 if limit else int(proposed)
            cost = Cost(count, int(next(field)), float(next(field)))
            parts = tuple(_part(field) for _ in range(int(next(field))))
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
                specialises=self._general.get(model, ()),
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


def _part(field: Iterator[str]) -> tuple[str, tuple[str, ...]]:
    kind, role, name = (next(field) for _ in range(3))
    if kind == "group":
        return role, tuple(next(field) for _ in range(int(name)))
    return role, () if name == UNSEEN else (name,)


def _split_fields(said: Term) -> Sequence[str]:
    if isinstance(said, str):
        return said.split(SEPARATOR) if said else ()
    fields: tuple[str, ...] = decode_record(said, tuple[str, ...])
    return fields


def _compute_models_hash(base: KnowledgeBase) -> str:
    """Return a digest of the models' clauses and of what they are judged by, the same on every
    machine."""
    total = hashlib.sha256()
    for model, rules in base.models.items():
        total.update(f"{model}={rules.content}\n".encode())
    root = house("rules").parent
    for pattern in JUDGING_CODE:
        for path in sorted(root.glob(pattern)):
            total.update(path.read_bytes())
    return total.hexdigest()[:HASH_DIGITS]
