"""The commands of the shell, which begin with a colon."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from facetlog.errors import InputError
from facetlog.kb.engine.terms import Atom, Term
from facetlog.perception.facts.fact_schema import FACT_SCHEMA, ArgumentKind, FactKind
from facetlog.query_shell.asking import Outcome
from facetlog.query_shell.meanings import length_unit, meanings
from facetlog.query_shell.scene_names import kind_of, list_names_of_kind, scene_names
from facetlog.query_shell.session import Session
from facetlog.query_shell.shell import Shell
from facetlog.query_shell.table import Table
from facetlog.query_shell.words import described, format_fact_signature, nearest, plain, summary

SCHEMA = "facetlog-command/1"
"""Schema of the lines that a command prints."""

FACTS_SHOWN = 8
"""Number of facts of one kind that :facts shows."""

MORE = "  … "
"""Beginning of the line with the number of facts of a kind that were left out."""

LINE = 44
"""Number of cells for a single fact, before its meaning."""

GUIDE = """\
A goal is written as in Prolog: angle(A, B, Deg, _), Deg < 80
Names that begin with a capital letter are variables; , means and; \\+ means not.
  why MODEL [THING] [PART=FACE …]      why the model holds, or what is missing
  why_not MODEL [THING] [PART=FACE …]  what comes nearest to it and does not hold
  why NAME, why FACT                   where a face, edge, vertex, thing or fact comes from"""

GUIDE_END = """\
Tab completes. :help WORD explains a word, :words lists all. Ctrl-C stops a question."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command of the shell; one that `asks` writes answers itself, as text or as JSON."""

    name: str
    arguments: str
    meaning: str
    run: Callable[[Shell, str], Outcome]
    asks: bool = False

    @property
    def signature(self) -> str:
        """The command as it is typed."""
        return f":{self.name} {self.arguments}".rstrip()


def run_command(shell: Shell, text: str) -> Outcome:
    """Run a command, given without its colon.

    Raise FacetlogError if there is no such command or it cannot be done, EOFError to leave.
    """
    name, _, rest = text.strip().partition(" ")
    command = COMMANDS.get(name)
    if command is not None and command.asks:
        return command.run(shell, rest.strip())
    with shell.report_errors_as_json(f":{text}"):
        return _print_lines(shell, text, command, rest.strip())


def _print_lines(shell: Shell, text: str, command: Command | None, rest: str) -> Outcome:
    """Run a command that has no answers; write what it prints as text or as a JSON object."""
    if command is None:
        name = text.strip().partition(" ")[0]
        meant = nearest(name, COMMANDS)
        guess = f"did you mean :{meant}?" if meant else ":help lists them"
        raise InputError(f"there is no command :{name}; {guess}")
    if not shell.as_json:
        return command.run(shell, rest)
    with shell.screen.keeping() as lines:
        outcome = command.run(shell, rest)
    place = {} if shell.line is None else {"line": shell.line}
    found = {"schema": SCHEMA, "goal": f":{text}", **place, "ok": outcome <= Outcome.NO}
    shell.screen.say(json.dumps({**found, "lines": lines}))
    return outcome


def _run_load(shell: Shell, text: str) -> Outcome:
    if not text:
        raise InputError(":load needs a file: a scene, or models")
    try:
        path = Path(text).expanduser()
    except RuntimeError:  # ~ of somebody who is not there
        path = Path(text)
    shell.screen.remark(shell.session.load(path))
    return Outcome.YES


def _run_reload(shell: Shell, text: str) -> Outcome:
    _check_no_arguments("reload", text)
    problems = shell.session.reload()
    shell.screen.remark(*(problems or ("loaded all models and scenes again",)))
    return Outcome.FAULT if problems else Outcome.YES


def _run_models(shell: Shell, text: str) -> Outcome:
    _check_no_arguments("models", text)
    own = shell.session.model_files
    rows = []
    for name, rules in shell.session.base.models.items():
        rows.append((name, str(rules.path) if rules.path in own else "built in"))
    shell.screen.say(*_align(rows))
    return Outcome.YES


def _run_scenes(shell: Shell, text: str) -> Outcome:
    _check_no_arguments("scenes", text)
    rows = []
    for file in shell.session.scene_files:
        mark = "*" if file.name in shell.session.scenes else " "
        facts = shell.session.base.scenes[file.name].facts
        rows.append((f"{mark} {file.name}", f"{facts:,} facts, {file.path}"))
    shell.screen.say(*_align(rows))
    if rows:
        shell.screen.remark("* is asked; :use SCENE … asks others")
    return Outcome.YES


def _run_use(shell: Shell, text: str) -> Outcome:
    shell.session.use(text.split())
    shell.screen.remark(f"asked: {', '.join(shell.session.scenes)}")
    return Outcome.YES


def _run_facts(shell: Shell, text: str) -> Outcome:
    if not text or len(text.split()) > 1:
        raise InputError(":facts needs one name, as in :facts f1")
    lines = _collect_facts(shell, text, None if shell.as_json else FACTS_SHOWN)
    if not lines:
        raise InputError(f"no scene that is asked has a {text!r}")
    shell.screen.say(*lines)
    if any(line.startswith(MORE) for line in lines):
        shell.show_all = partial(_page_facts, shell, text)
        shell.screen.say("… :all shows all of them")
    return Outcome.YES


def _page_facts(shell: Shell, name: str) -> Outcome:
    shell.screen.page(_collect_facts(shell, name, None))
    return Outcome.YES


def _collect_facts(shell: Shell, name: str, most: int | None) -> list[str]:
    """Return the facts of all scenes that are asked; of several, each below its name."""
    found = []
    for scene in shell.session.scenes:
        lines = format_facts(shell.session, scene, name, most=most, width=shell.screen.width)
        own = list(lines)
        if own and len(shell.session.scenes) > 1:
            found.append(f"{scene}:")
        found.extend(own)
    return found


def format_facts(
    session: Session, scene: str, name: str, *, most: int | None, width: int | None
) -> Iterator[str]:
    """Format the facts that mention a name, by kind, with meaning and units; `most` of each kind.

    No lines if the scene has no such name.
    """
    names = scene_names(session.base, (scene,))
    if kind_of(names, name) is None:
        return
    length = session.base.scenes[scene].length_unit or length_unit([None])
    for kind in FACT_SCHEMA:
        rows = _find_facts(session, scene, name, names, kind)
        columns = [argument.name for argument in kind.arguments]
        room = None if width is None else width - len("  ")
        table = Table(columns, meanings(format_fact_signature(kind)), length, width=room)
        if len(rows) == 1:  # with its units, and its meaning beside it
            fact = f"{kind.functor}({', '.join(table.values(rows[0]))})"
            yield f"{fact:<{LINE}}  {plain(kind.meaning)}"
        elif rows:
            yield f"{format_fact_signature(kind)}: {plain(kind.meaning)}"
            shown = rows[:most]
            block = table.block(shown)
            yield from (f"  {line}" for line in (*table.head(shown), *block))
            if len(shown) < len(rows):
                yield f"{MORE}{len(rows) - len(shown):,} more"


def _find_facts(
    session: Session,
    scene: str,
    name: str,
    names: Mapping[ArgumentKind, tuple[str, ...]],
    kind: FactKind,
) -> tuple[tuple[Term, ...], ...]:
    """Return the arguments of the facts of a kind that mention the name, each once."""
    rows: dict[tuple[Term, ...], None] = {}
    variables = [f"A{i}" for i in range(kind.arity)]
    goal = f"{kind.functor}({', '.join(variables)})"
    for place, argument in enumerate(kind.arguments):
        if not (argument.kind.is_name and name in list_names_of_kind(names, argument.kind)):
            continue
        given = {variables[place]: Atom(name)}
        with session.base.query(goal, scenes=(scene,), bindings=given) as answers:
            rows.update(dict.fromkeys((*row[:place], Atom(name), *row[place:]) for row in answers))
    return tuple(rows)


def _run_words(shell: Shell, text: str) -> Outcome:
    found = [word for word in shell.words if word.name.startswith(text)]
    if not found:
        raise InputError(f"no word begins with {text!r}")
    kinds = dict.fromkeys(word.kind for word in found)
    for kind in kinds:
        shell.screen.say(f"{kind}:", style="bold")
        shell.screen.say(*(f"  {summary(word)}" for word in found if word.kind == kind))
    return Outcome.YES


def _run_help(shell: Shell, text: str) -> Outcome:
    if not text:
        rows = [(command.signature, command.meaning) for command in COMMANDS.values()]
        shell.screen.say(*GUIDE.splitlines(), *(f"  {line}" for line in _align(rows)), GUIDE_END)
        return Outcome.YES
    lines = list(_explain_word(shell, text.removeprefix(":")))
    if not lines:
        meant = nearest(text, [word.name for word in shell.words])
        raise InputError(f"there is no word {text!r}" + (f"; did you mean {meant}?" * bool(meant)))
    shell.screen.say(*lines)
    return Outcome.YES


def _explain_word(shell: Shell, name: str) -> Iterator[str]:
    if name in COMMANDS:
        yield f"{COMMANDS[name].signature}: {COMMANDS[name].meaning}"
    for word in shell.words:
        if word.name == name:
            yield from described(word)
    if name in shell.session.base.models:
        yield f"{name}: a model; why {name} says what it asks for"


def _run_limit(shell: Shell, text: str) -> Outcome:
    if text and not (text.isdecimal() and int(text) > 0):
        raise InputError(":limit needs a number above 0, or nothing to show all answers")
    shell.limit = int(text) if text else None
    shell.screen.remark(f"at most {text} answers are shown" if text else "all answers are shown")
    return Outcome.YES


def _run_all(shell: Shell, text: str) -> Outcome:
    with shell.report_errors_as_json(f":all {text}".rstrip()):
        _check_no_arguments("all", text)
        if shell.show_all is None:
            raise InputError("nothing was asked yet")
    return shell.show_all()


def _run_quit(shell: Shell, text: str) -> Outcome:
    del shell
    _check_no_arguments("quit", text)
    raise EOFError


def _check_no_arguments(name: str, text: str) -> None:
    if text:
        raise InputError(f":{name} takes no arguments")


def _align(rows: list[tuple[str, str]]) -> Iterator[str]:
    width = max((len(left) for left, _ in rows), default=0)
    return (f"{left:<{width}}  {right}" for left, right in rows)


_ALL_COMMANDS = (
    Command("all", "", "shows all of what was last shown in part", _run_all, asks=True),
    Command(
        "facts", "NAME", "shows all facts that mention a face, edge, vertex or thing", _run_facts
    ),
    Command("help", "[WORD]", "explains the shell, or a word", _run_help),
    Command("limit", "[N]", "shows at most N answers, or all", _run_limit),
    Command("load", "PATH", "loads a scene, or a file or folder of models", _run_load),
    Command("models", "", "lists the models", _run_models),
    Command("quit", "", "leaves the shell, as Ctrl-D does", _run_quit),
    Command("reload", "", "loads all models and scenes again", _run_reload),
    Command("scenes", "", "lists the scenes", _run_scenes),
    Command("use", "[SCENE …]", "asks only these scenes, or all again", _run_use),
    Command("words", "[PREFIX]", "lists the words that a goal may use", _run_words),
)
COMMANDS = {command.name: command for command in _ALL_COMMANDS}
