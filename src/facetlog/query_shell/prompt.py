"""The prompt: editing, history, completion, colours and the hint line, with prompt_toolkit."""

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TextIO

from prompt_toolkit import PromptSession
from prompt_toolkit.auto_suggest import AutoSuggestFromHistory
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.lexers import Lexer
from prompt_toolkit.output import ColorDepth, create_output
from prompt_toolkit.styles import Style
from prompt_toolkit.utils import is_dumb_terminal

from facetlog.errors import FacetlogError, InputError
from facetlog.kb.engine.terms import Atom
from facetlog.perception.facts.fact_schema import FACT_KINDS, ArgumentKind
from facetlog.query_shell.commands import COMMANDS
from facetlog.query_shell.goal_text import (
    COMMAND,
    TokenKind,
    find_call,
    is_complete,
    tokens,
    variables,
)
from facetlog.query_shell.lines import run_line
from facetlog.query_shell.scene_names import list_names_of_kind
from facetlog.query_shell.shell import Shell
from facetlog.query_shell.shown_terms import shown
from facetlog.query_shell.words import summary
from facetlog.safe_read import check_regular

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


PROMPT, CONTINUED = "?- ", "   "
GREETING = "A goal, why MODEL, or :help. Tab completes, Ctrl-D leaves."

_STYLE = Style.from_dict(
    {
        "variable": "ansicyan",
        "number": "ansimagenta",
        "text": "ansigreen",
        "comment": "ansibrightblack",
        "open": "ansired",
        "command": "bold",
        "prompt": "bold",
        "bottom-toolbar": "noreverse ansibrightblack",
    }
)
_STYLES = {
    TokenKind.VARIABLE: "class:variable",
    TokenKind.NUMBER: "class:number",
    TokenKind.TEXT: "class:text",
    TokenKind.COMMENT: "class:comment",
    TokenKind.OPEN: "class:open",
}


def find_history_path() -> Path:
    """Return the path of the history file, by the XDG base directories."""
    folder = os.environ.get("XDG_STATE_HOME", "")
    state = Path(folder) if Path(folder).is_absolute() else Path.home() / ".local" / "state"
    return state / "facetlog" / "history"


class _QuietHistory(FileHistory):
    """A file that need not be writable: what cannot be stored is remembered in this session."""

    def store_string(self, string: str) -> None:
        with suppress(OSError):
            super().store_string(string)

    def load_history_strings(self) -> Iterable[str]:
        try:
            return tuple(super().load_history_strings())
        except OSError:
            return ()


def open_history(path: Path) -> History:
    """Open the history in a file that only its owner may read, and make it if it is missing.

    In memory only, if that cannot be.
    """
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        check_regular(path)
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600))
        path.chmod(0o600)
    except (OSError, RuntimeError, InputError):
        return InMemoryHistory()
    return _QuietHistory(path)


class _GoalLexer(Lexer):
    """Colours tokens, of commands the first word."""

    def lex_document(self, document: Document) -> Callable[[int], StyleAndTextTuples]:
        styled = _colour(document.text)

        def line(number: int) -> StyleAndTextTuples:
            return styled[number] if number < len(styled) else []

        return line


def _colour(text: str) -> list[StyleAndTextTuples]:
    """Split a text into lines of pieces with their styles."""
    if text.lstrip().startswith(COMMAND):
        word = len(text) - len(text.lstrip()) + len(text.split()[0])
        return _split_lines([("class:command", text[:word]), ("", text[word:])])
    pieces: list[tuple[str, str]] = []
    at = 0
    for token in tokens(text):
        pieces.append(("", text[at : token.start]))
        pieces.append((_STYLES.get(token.kind, ""), token.text))
        at = token.end
    return _split_lines([*pieces, ("", text[at:])])


def _split_lines(pieces: Iterable[tuple[str, str]]) -> list[StyleAndTextTuples]:
    lines: list[StyleAndTextTuples] = [[]]
    for style, text in pieces:
        first, *others = text.split("\n")
        lines[-1].append((style, first))
        lines.extend([(style, other)] for other in others)
    return lines


class _Completer(Completer):
    def __init__(self, shell: Shell) -> None:
        self._shell = shell

    def get_completions(
        self, document: Document, complete_event: CompleteEvent
    ) -> Iterable[Completion]:
        del complete_event
        try:
            found = tuple(proposals(self._shell, document.text_before_cursor))
        except FacetlogError:  # a question that only serves typing must not disturb it
            return
        for proposal in found:
            yield Completion(proposal.text, -proposal.length, display_meta=proposal.about)


def _make_keys() -> KeyBindings:
    """Make Enter run what is complete, and go to a new line otherwise; a second Enter runs it
    anyway.
    """
    keys = KeyBindings()

    @keys.add("enter")
    def _enter(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        if buffer.complete_state and buffer.complete_state.current_completion:
            buffer.complete_state = None
        elif (
            buffer.text.startswith(COMMAND)
            or is_complete(buffer.text)
            or _ends_with_blank_line(buffer.text)
        ):
            buffer.validate_and_handle()
        else:
            buffer.insert_text("\n")

    return keys


def _ends_with_blank_line(text: str) -> bool:
    return not text.rpartition("\n")[2].strip()


def _make_toolbar(shell: Shell, prompt: "PromptSession[str]") -> str:
    buffer = prompt.default_buffer
    try:
        hint = find_hint(shell, buffer.text, buffer.cursor_position)
    except FacetlogError:
        hint = ""
    return hint or f"{', '.join(shell.session.scenes) or 'no scene'} · :help explains"


def _read_plain_line() -> str:
    """Read the next goal from a terminal without escape sequences; EOFError at its end.

    The terminal itself edits the line. A goal ends as it does for the Enter key.
    """
    text = ""
    terminal = _find_terminal()
    while True:
        terminal.write(CONTINUED if text else PROMPT)
        terminal.flush()
        line = sys.stdin.readline()
        if not line:
            terminal.write("\n")
            raise EOFError
        text += line
        said = text.rstrip("\n")
        if said.startswith(COMMAND) or is_complete(said) or not line.strip():
            return said


def _find_terminal() -> TextIO:
    """Return the stream that leads to the terminal, even if answers go elsewhere."""
    return sys.stdout if sys.stdout.isatty() else sys.stderr


def _make_line_reader(shell: Shell) -> Callable[[], str]:
    """Return what reads the next line, with all that the terminal is able to."""
    if is_dumb_terminal():
        return _read_plain_line
    prompt: PromptSession[str] = PromptSession(
        history=open_history(find_history_path()),
        auto_suggest=AutoSuggestFromHistory(),
        completer=_Completer(shell),
        complete_while_typing=False,
        lexer=_GoalLexer(),
        style=_STYLE,
        key_bindings=_make_keys(),
        multiline=True,
        prompt_continuation=CONTINUED,
        output=create_output(_find_terminal()),
        color_depth=ColorDepth.DEPTH_1_BIT if os.environ.get("NO_COLOR") else None,
    )
    return lambda: prompt.prompt(PROMPT, bottom_toolbar=lambda: _make_toolbar(shell, prompt))


def run_prompt(shell: Shell) -> None:
    """Read lines from the terminal and run them, until Ctrl-D or :quit.

    Ctrl-C clears the line, or stops what is being done.
    """
    read = _make_line_reader(shell)
    shell.screen.remark(GREETING)
    while True:
        try:
            line = read()
        except KeyboardInterrupt:
            continue
        except EOFError:
            return
        if sys.stdout.isatty():  # else no prompt stands between the answers
            shell.screen.begin_line()
        try:
            run_line(shell, line)
        except KeyboardInterrupt:
            shell.screen.remark("", "stopped")  # below the terminal's ^C
        except EOFError:
            return
