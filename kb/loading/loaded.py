"""Loaded scenes, rule files and words."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from facetlog.kb.calibration import Evidence, InputKind, make_evidence
from facetlog.kb.engine.terms import Struct, Term
from facetlog.kb.explaining.records import decode_record

__all__ = ["LoadedScene", "RuleFile", "Word", "decode_evidence", "decode_rule_file", "decode_words"]


@dataclass(frozen=True, slots=True)
class RuleFile:
    """A loaded file of rules: its Prolog module and the models that it defines.

    `warnings` are what looks like a slip of the pen, each with file, line and column. `content` is
    the digest of its text, `judging` of what its models judge by, as calibrations have it. `files`
    are all that a user's file was made from, itself first. `on_demand`: it may ask for facts that
    are made on demand. `rather_than` has by model those whose names stand after its own. `own`: it
    is a user's, not a built-in one.
    """

    path: Path
    module: str
    models: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    content: str = ""
    judging: str = ""
    files: tuple[Path, ...] = ()
    on_demand: bool = False
    rather_than: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))
    own: bool = True


@dataclass(frozen=True, slots=True)
class LoadedScene:
    """A scene whose facts are in the knowledge base.

    `facts` is how many there are; `length_unit` is 'm', or None where the scale is not known.
    `evidence` says how each thing was measured.
    """

    name: str
    module: str
    facts: int
    length_unit: str | None
    evidence: Mapping[str, Evidence]

    def get_evidence(self, thing: str) -> Evidence:
        """Return how a thing was measured; of no thing as one in no picture."""
        return self.evidence.get(thing, Evidence(InputKind.PICTURES))


def decode_evidence(known: Iterable[Term]) -> Mapping[str, Evidence]:
    """Return how each thing was measured, as known_of_scene/2 of bridge.pl tells it."""
    about: dict[str, list[tuple[Term, ...]]] = defaultdict(list)
    for term in known:
        if isinstance(term, Struct):
            about[term.functor].append(term.args)
    views = next((int(str(count)) for (count,) in about["views"]), 0)
    surfaces = {
        str(thing): kind
        for kind in (InputKind.WHOLE, InputKind.SCANNED)
        for (thing,) in about[kind.value]
    }
    return MappingProxyType(
        {
            str(thing): make_evidence(surfaces.get(str(thing)), views, float(str(share)))
            for thing, share in about["seen"]
        }
    )


def decode_rule_file(term: Term, path: Path, files: tuple[Path, ...]) -> RuleFile:
    """Return the file that Prolog has loaded, without digests; `files` is what it is from.

    Raise EngineError if the reply is something else.
    """
    names: tuple[str, ...]
    pairs: tuple[tuple[str, tuple[str, ...]], ...]
    warnings: tuple[str, ...]
    module, names, pairs, warnings = decode_record(term, _LOADED)
    return RuleFile(
        path, module, names, warnings, files=files, rather_than=MappingProxyType(dict(pairs))
    )


# loaded(Module, Models, Others, Warnings) of loader.pl.
_LOADED = tuple[str, tuple[str, ...], tuple[tuple[str, tuple[str, ...]], ...], tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Word:
    """A word of questions.

    `kind` is what it is (fact, search, measure, relation, builtin ...), `signature` the word with
    the names of its arguments, `meaning` one line for a reader, empty if there is none.
    """

    name: str
    arity: int
    kind: str
    signature: str
    meaning: str


def decode_words(term: Term) -> tuple[Word, ...]:
    """Return the words of question_words/1 of words.pl. Raise EngineError for anything else."""
    found = decode_record(term, tuple[tuple[tuple[str, int], str, str, str], ...])
    return tuple(Word(*indicator, *about) for indicator, *about in found)
