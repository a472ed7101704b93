"""The words of questions, for completion and help."""

from collections.abc import Iterable, Iterator
from difflib import get_close_matches

from facetlog.kb.loading.loaded import Word
from facetlog.perception.facts.fact_schema import FACT_KINDS, FACT_SCHEMA, FactKind


def list_words(known: Iterable[Word]) -> tuple[Word, ...]:
    """Return the words that the knowledge base knows, first facts as the schema describes them.

    A measure or relation that is called as its fact is left to the fact.
    """
    facts = tuple(
        Word(kind.functor, kind.arity, "fact", format_fact_signature(kind), plain(kind.meaning))
        for kind in FACT_SCHEMA
    )
    return (*facts, *(word for word in known if word.kind != "fact"))


def format_fact_signature(kind: FactKind) -> str:
    """Return the fact with the names of its arguments: `angle(F1, F2, Angle, Sd)`."""
    return f"{kind.functor}({', '.join(argument.name for argument in kind.arguments)})"


def plain(meaning: str) -> str:
    """Remove the marks that make code of a word in Markdown."""
    return meaning.replace("`", "")


def nearest(name: str, names: Iterable[str]) -> str | None:
    """Return the name that was probably meant."""
    found = get_close_matches(name, set(names), n=1)
    return found[0] if found else None


def summary(word: Word) -> str:
    """Format the word and its meaning on one line."""
    return f"{word.signature}: {word.meaning}" if word.meaning else word.signature


def described(word: Word) -> Iterator[str]:
    """Describe the word; for a fact also its arguments."""
    yield f"{word.kind} {summary(word)}"
    kind = FACT_KINDS.get(word.name) if word.kind == "fact" else None
    if kind is not None:
        width = max(len(argument.name) for argument in kind.arguments)
        for argument in kind.arguments:
            yield f"  {argument.name:<{width}}  {argument.kind.value}"
        if kind.absent:
            yield f"  absent when {plain(kind.absent)}"
