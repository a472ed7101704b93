"""`facetlog model words`: the words of models and questions, and what they mean."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from difflib import get_close_matches
from textwrap import TextWrapper
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shared import YES, AsJson, command
from facetlog.errors import InputError
from facetlog.terminal import one_line

if TYPE_CHECKING:
    from facetlog.glossary import Entry

__all__ = ["words_command"]

_WRAPPER = TextWrapper(100, subsequent_indent="    ", break_on_hyphens=False)


@command
def words_command(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[WORD|TOPIC]...", help="Words, or topics such as measures."),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Explains the words of models and questions; without a word it lists them by topic."""
    from facetlog.glossary import list_entries

    entries = list_entries()
    chosen = [e for name in names for e in _find_entries(name, entries)] if names else entries
    if as_json:
        typer.echo(json.dumps([asdict(entry) for entry in chosen], indent=1))
    elif names:
        for line in _format_entries(names, chosen):
            typer.echo(line)
    else:
        for line in _format_topics(chosen):
            typer.echo(line)
    return YES


def _find_entries(name: str, entries: Sequence["Entry"]) -> list["Entry"]:
    """Return the entries of a topic or word; raise InputError if there are none."""
    found = [entry for entry in entries if name in (entry.topic, entry.name)]
    if found:
        return found
    known = {text for entry in entries for text in (entry.topic, entry.name)}
    near = get_close_matches(name, known, n=1)
    hint = f"did you mean {near[0]}?" if near else "facetlog model words lists all words"
    raise InputError(f"{one_line(name)}: no such word or topic; {hint}")


def _format_topics(entries: Sequence["Entry"]) -> Iterator[str]:
    names: dict[str, dict[str, None]] = {}
    for entry in entries:
        names.setdefault(entry.topic, {})[entry.name] = None
    for topic, words in names.items():
        yield _WRAPPER.fill(f"{topic}: {', '.join(words)}")


def _format_entries(names: Sequence[str], entries: Sequence["Entry"]) -> Iterator[str]:
    """Format each entry of a topic in short, and each entry of a word with its remarks."""
    for entry in entries:
        yield _WRAPPER.fill(f"{entry.usage}: {entry.meaning}")
        if entry.name in names:
            for label, text in {"topic": entry.topic, **entry.notes}.items():
                yield _WRAPPER.fill(f"  {label}: {text}")
