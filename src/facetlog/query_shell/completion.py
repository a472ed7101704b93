"""Propose what a user may type next, and explain the word at the cursor."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from facetlog.kb.engine.terms import Atom
from facetlog.perception.facts.fact_schema import FACT_KINDS, ArgumentKind
from facetlog.query_shell.commands import COMMANDS
from facetlog.query_shell.goal_text import COMMAND, find_call, variables
from facetlog.query_shell.scene_names import list_names_of_kind
from facetlog.query_shell.shell import Shell
from facetlog.query_shell.shown_terms import shown
from facetlog.query_shell.words import summary

MOST = 200
"""Proposals at once: more nobody reads."""

_BEGINNING = re.compile(r"\w*\Z")
_REST = re.compile(r"\w*")
_EXPLAIN = ("why", "why_not", "why-not")

# What the argument of a word that is no fact is, by its name in the word's signature.
_KINDS = {
    "Face": ArgumentKind.FACE,
    "Faces": ArgumentKind.FACE,
    "Side": ArgumentKind.FACE,
    "A": ArgumentKind.FACE,
    "B": ArgumentKind.FACE,
    "X": ArgumentKind.BODY,
    "Edge": ArgumentKind.EDGE,
    "Support": ArgumentKind.PART,
    "Supports": ArgumentKind.PART,
    "Thing": ArgumentKind.THING,
}


@dataclass(frozen=True, slots=True)
class Proposal:
    """A text that may stand in place of the last `length` characters before the cursor."""

    text: str
    length: int
    about: str = ""


def proposals(shell: Shell, text: str) -> Iterator[Proposal]:
    """Propose what may follow a text that ends at the cursor, the likeliest first."""
    return islice(_drop_repeated(_propose(shell, text)), MOST)


def _drop_repeated(found: Iterable[Proposal]) -> Iterator[Proposal]:
    """Yield each text once: a fact and the measure of the same name are completed alike."""
    seen = set()
    for proposal in found:
        if proposal.text not in seen:
            seen.add(proposal.text)
            yield proposal


def _propose(shell: Shell, text: str) -> Iterator[Proposal]:
    head, space, rest = text.lstrip().partition(" ")
    if not head.startswith(COMMAND):
        if space and head in _EXPLAIN and "(" not in rest:
            yield from _propose_subjects(shell, rest)
        else:
            yield from _propose_in_goal(shell, text)
    elif not space:
        for command in COMMANDS.values():
            space = " " if command.arguments else ""
            yield from _propose_matching(head, [f"{COMMAND}{command.name}{space}"], command.meaning)
    elif head == ":load":
        yield from _propose_paths(rest.lstrip())
    else:
        last = rest.split(" ")[-1]
        match head:
            case ":use":
                yield from _propose_matching(
                    last, (file.name for file in shell.session.scene_files)
                )
            case ":facts":
                yield from _propose_matching(last, _list_all_names(shell))
            case ":help" | ":words":
                yield from _propose_matching(last, dict.fromkeys(word.name for word in shell.words))


def _propose_matching(beginning: str, texts: Iterable[str], about: str = "") -> Iterator[Proposal]:
    for text in texts:
        if text.startswith(beginning):
            yield Proposal(text, len(beginning), about)


def _list_all_names(shell: Shell) -> Iterator[str]:
    return (name for names in shell.names.values() for name in names)


def _propose_subjects(shell: Shell, rest: str) -> Iterator[Proposal]:
    """Propose after `why` first a model or any name, then things, and faces for parts."""
    words = rest.split(" ")
    last = words[-1]
    if len(words) == 1:
        # A thing or parts may follow a model that is written out.
        models = (f"{name} " if name == last else name for name in shell.session.base.models)
        yield from _propose_matching(last, models, "model")
        yield from _propose_matching(last, _list_all_names(shell))
    elif "=" in last:
        face = last.rpartition("=")[2]
        yield from _propose_matching(face, list_names_of_kind(shell.names, ArgumentKind.PART))
    else:
        yield from _propose_matching(last, list_names_of_kind(shell.names, ArgumentKind.THING))


def _propose_paths(beginning: str) -> Iterator[Proposal]:
    """Propose files and folders; a folder ends with a slash."""
    folder, slash, name = beginning.rpartition("/")
    try:
        place = Path(f"{folder}{slash}" or ".").expanduser()
        found = sorted((entry.name, entry.is_dir()) for entry in place.iterdir())
    except (OSError, RuntimeError, ValueError):  # RuntimeError: no such user's home
        return
    for entry, is_folder in found:
        if entry.startswith(name) and (name.startswith(".") or not entry.startswith(".")):
            yield Proposal(f"{entry}/" if is_folder else entry, len(name))


def _propose_in_goal(shell: Shell, text: str) -> Iterator[Proposal]:
    match = _BEGINNING.search(text)
    beginning = match.group() if match else ""
    used = variables(text[: len(text) - len(beginning)])
    if beginning[:1].isupper():
        yield from _propose_matching(beginning, used, "variable")
        return
    call = find_call(text, len(text))
    if call is not None:
        yield from _propose_matching(beginning, _list_names_at(shell, *call))
        if not beginning:
            yield from _propose_matching(beginning, used, "variable")
    if not beginning:
        return
    if not text[: -len(beginning)].strip():
        about = "explains a model, a face, a fact"
        if beginning in _EXPLAIN:
            yield Proposal(f"{beginning} ", len(beginning), about)
            return
        yield from _propose_matching(beginning, ("why ", "why_not "), about)
    for word in shell.words:
        bracket = "(" if word.signature.startswith(f"{word.name}(") else ""
        yield from _propose_matching(beginning, [word.name + bracket], word.meaning)


def _list_names_at(shell: Shell, functor: str, place: int) -> Iterable[str]:
    """Return what an argument of a word may be, by the schema or by the argument's name."""
    kind = FACT_KINDS.get(functor)
    if kind is not None and place < kind.arity:
        argument = kind.arguments[place].kind
        return list_names_of_kind(shell.names, argument) if argument.is_name else ()
    name = _find_argument_name(shell, functor, place)
    if name == "Scene":
        return (_quote(file.name) for file in shell.session.scene_files)
    if name == "Model":
        return shell.session.base.models
    return list_names_of_kind(shell.names, _KINDS[name]) if name in _KINDS else ()


def _find_argument_name(shell: Shell, functor: str, place: int) -> str | None:
    for word in shell.words:
        if word.name == functor and place < word.arity:
            names = word.signature.partition("(")[2].rstrip(")").split(",")
            return names[place].strip() if place < len(names) else None
    return None


def _quote(name: str) -> str:
    return shown(Atom(name))


def find_hint(shell: Shell, text: str, place: int) -> str:
    """Return signature and meaning of the word at the cursor, or of the call around it."""
    match = _BEGINNING.search(text[:place])
    start = match.start() if match else place
    rest = _REST.match(text, place)
    word = text[start : rest.end() if rest else place]
    call = find_call(text, place)
    for name in (word, call[0] if call else ""):
        if start and text[start - 1] == COMMAND and name in COMMANDS:
            return f"{COMMANDS[name].signature}: {COMMANDS[name].meaning}"
        found = next((known for known in shell.words if known.name == name), None)
        if found is not None:
            return summary(found)
    return ""
