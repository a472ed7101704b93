"""Terms of Prolog as the records that their dataclasses describe."""

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from facetlog.errors import EngineError
from facetlog.kb.engine.terms import Atom, Struct, Term
from facetlog.kb.explaining.wording import readable

__all__ = ["decode_record", "unreadable"]

Decoders = Mapping[type, Callable[[Term], object]]


def decode_record(term: Term, kind: Any, decoders: Decoders | None = None) -> Any:
    """Return the value of type `kind` that the term stands for.

    A compound is a dataclass (or a tuple of fixed length) whose fields are its arguments in order,
    a list is a tuple of any length, and what may be None is a list of at most one value. Of several
    dataclasses that one is meant whose `functor` the compound has. `decoders` decode other types.
    Raise EngineError for a term of another form.
    """
    return _decode_value(term, kind, decoders or {})


def unreadable(term: Term) -> EngineError:
    """Return the error for a term that is not of the form that is wanted."""
    return EngineError(f"Prolog's answer cannot be read: {readable(term)[:80]}")


def _decode_value(term: Term, kind: Any, decoders: Decoders) -> Any:
    if kind in decoders:
        return decoders[kind](term)
    arguments = get_args(kind)
    origin = get_origin(kind)
    if origin is tuple:
        return _decode_tuple(term, arguments, decoders)
    if origin in (Union, UnionType):
        return _decode_union(term, arguments, decoders)
    if isinstance(term, Struct) and isinstance(kind, type) and is_dataclass(kind):
        record: Any = kind
        types = _list_field_types(kind)
        if len(term.args) <= len(types):
            pairs = zip(term.args, types, strict=False)
            return record(*(_decode_value(argument, one, decoders) for argument, one in pairs))
    if kind is str:
        return readable(term)
    if kind in (int, float) and isinstance(term, int | float) and kind(term) == term:
        return kind(term)
    if isinstance(term, Atom):
        if kind is bool and term.name in ("true", "false"):
            return term.name == "true"
        if isinstance(kind, type) and issubclass(kind, Enum):
            return kind(term.name)
    raise unreadable(term)


def _decode_tuple(term: Term, kinds: tuple[Any, ...], decoders: Decoders) -> tuple[Any, ...]:
    if isinstance(term, tuple) and kinds[1:] == (...,):
        return tuple(_decode_value(item, kinds[0], decoders) for item in term)
    if isinstance(term, Struct) and len(term.args) == len(kinds):
        pairs = zip(term.args, kinds, strict=True)
        return tuple(_decode_value(argument, kind, decoders) for argument, kind in pairs)
    raise unreadable(term)


def _decode_union(term: Term, kinds: tuple[Any, ...], decoders: Decoders) -> Any:
    if NoneType in kinds and isinstance(term, tuple):
        return _decode_value(term[0], kinds[0], decoders) if term else None
    if isinstance(term, Struct):
        for kind in kinds:
            if getattr(kind, "functor", None) == term.functor:
                return _decode_value(term, kind, decoders)
    if isinstance(term, int | float):
        return term
    if str in kinds:
        return readable(term)
    raise unreadable(term)


@cache
def _list_field_types(kind: type) -> tuple[Any, ...]:
    hints = get_type_hints(kind)
    return tuple(hints[field.name] for field in fields(kind) if field.init)
