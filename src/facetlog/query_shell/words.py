"""The words of questions, for completion and help."""

from collections.abc import Iterable, Iterator
from difflib import get_close_matches

from facetlog.kb.loading.loaded import Word
from facetlog.perception.facts.fact_schema import FACT_KINDS, FACT_SCHEMA, FactKind


def all_words(known: Iterable[Word]) -> tuple[Word, ...]:
    """The words that the knowledge base knows, facts as the schema describes them first.

    A measure or relation that is called as its fact is left to the fact.
    """
    facts = tuple(
        Word(kind.functor, kind.arity, "fact", fact_signature(kind), plain(kind.meaning))
        for kind in FACT_SCHEMA
    )
    return (*facts, *(word for word in known if word.kind != "fact"))


def fact_signature(kind: FactKind) -> str:
    """The fact with the names of its arguments: `angle(F1, F2, Angle, Sd)`."""
    return f"{kind.functor}({', '.join(argument.name for argument in kind.arguments)})"


def plain(meaning: str) -> str:
    """A meaning without the marks that make code of a word in Markdown."""
    return meaning.replace("`", "")


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The name that was probably meant."""
    found = get_close_matches(name, set(names), n=1)
    return found[0] if found else None


def summary(word: Word) -> str:
    """The word and what it means on one line."""
    return f"{word.signature}: {word.meaning}" if word.meaning else word.signature


def described(word: Word) -> Iterator[str]:
    """What the word is and means; for a fact also what its arguments are."""
    yield f"{word.kind} {summary(word)}"
    kind = FACT_KINDS.get(word.name) if word.kind == "fact" else None
    if kind is not None:
        width = max(len(argument.name) for argument in kind.arguments)
        for argument in kind.arguments:
            yield f"  {argument.name:<{width}}  {argument.kind.value}"
        if kind.absent:
            yield f"  absent when {plain(kind.absent)}"
