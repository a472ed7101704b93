"""What a knowledge base has loaded."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from facetlog.errors import EngineError
from facetlog.kb.calibration import InputKind
from facetlog.kb.engine.terms import Atom, Struct, Term

__all__ = ["LoadedScene", "RuleFile", "decode_rule_file"]


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
    `surfaces` says how things were measured that are known from a mesh or a cloud; all others were
    found in pictures.
    """

    name: str
    module: str
    facts: int
    length_unit: str | None
    surfaces: Mapping[str, InputKind]

    def kind_of(self, thing: str) -> InputKind:
        """How a thing was measured."""
        return self.surfaces.get(thing, InputKind.PICTURES)


def decode_rule_file(term: Term, path: Path, files: tuple[Path, ...]) -> RuleFile:
    """The file that Prolog has loaded, without digests; `files` is what it is from.

    Raises EngineError if the reply is something else.
    """
    match term:
        case Struct("loaded", (Atom(module), tuple(models), tuple(pairs), tuple(warnings))):
            names, said = tuple(map(str, models)), tuple(map(str, warnings))
            others = MappingProxyType(dict(map(_rather_than, pairs)))
            return RuleFile(path, module, names, said, files=files, rather_than=others)
    raise EngineError(f"{path}: no rules were loaded")


def _rather_than(pair: Term) -> tuple[str, tuple[str, ...]]:
    match pair:
        case Struct("-", (Atom(model), tuple(others))):
            return model, tuple(map(str, others))
    raise EngineError(f"no model and others: {pair!r}")
