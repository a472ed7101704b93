"""The commands of the shell, which begin with a colon."""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from facetlog.errors import InputError
from facetlog.query_shell.asking import Outcome
from facetlog.query_shell.facts_about import MORE, fact_lines
from facetlog.query_shell.shell import Shell
from facetlog.query_shell.words import described, nearest, summary

SCHEMA = "facetlog-command/1"
"""What a command says, as JSON: its lines."""

FACTS_SHOWN = 8
"""Facts of one kind that :facts shows."""

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
    """A command: its name, its arguments, what it does, and the function that does it.

    One that `asks` writes answers, which are JSON if answers are to be.
    """

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
    """What came of a command, given without its colon.

    Raises FacetlogError if there is no such command or it cannot be done, EOFError to leave.
    """
    name, _, rest = text.strip().partition(" ")
    command = COMMANDS.get(name)
    if command is not None and command.asks:
        return command.run(shell, rest.strip())
    with shell.reporting(f":{text}"):
        return _said(shell, text, command, rest.strip())


def _said(shell: Shell, text: str, command: Command | None, rest: str) -> Outcome:
    """What came of a command that has no answers, written as text or as an object of JSON."""
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


def _load(shell: Shell, text: str) -> Outcome:
    if not text:
        raise InputError(":load needs a file: a scene, or models")
    try:
        path = Path(text).expanduser()
    except RuntimeError:  # ~ of somebody who is not there
        path = Path(text)
    shell.screen.remark(shell.session.load(path))
    return Outcome.YES


def _reload(shell: Shell, text: str) -> Outcome:
    _no_arguments("reload", text)
    problems = shell.session.reload()
    shell.screen.remark(*(problems or ("loaded all models and scenes again",)))
    return Outcome.FAULT if problems else Outcome.YES


def _models(shell: Shell, text: str) -> Outcome:
    _no_arguments("models", text)
    own = shell.session.model_files
    rows = []
    for name, rules in shell.session.base.models.items():
        rows.append((name, str(rules.path) if rules.path in own else "built in"))
    shell.screen.say(*_listed(rows))
    return Outcome.YES


def _scenes(shell: Shell, text: str) -> Outcome:
    _no_arguments("scenes", text)
    rows = []
    for file in shell.session.scene_files:
        mark = "*" if file.name in shell.session.scenes else " "
        facts = shell.session.base.scenes[file.name].facts
        rows.append((f"{mark} {file.name}", f"{facts:,} facts, {file.path}"))
    shell.screen.say(*_listed(rows))
    if rows:
        shell.screen.remark("* is asked; :use SCENE … asks others")
    return Outcome.YES


def _use(shell: Shell, text: str) -> Outcome:
    shell.session.use(text.split())
    shell.screen.remark(f"asked: {', '.join(shell.session.scenes)}")
    return Outcome.YES


def _facts(shell: Shell, text: str) -> Outcome:
    if not text or len(text.split()) > 1:
        raise InputError(":facts needs one name, as in :facts f1")
    lines = _facts_about(shell, text, None if shell.as_json else FACTS_SHOWN)
    if not lines:
        raise InputError(f"no scene that is asked has a {text!r}")
    shell.screen.say(*lines)
    if any(line.startswith(MORE) for line in lines):
        shell.show_all = partial(_all_facts, shell, text)
        shell.screen.say("… :all shows all of them")
    return Outcome.YES


def _all_facts(shell: Shell, name: str) -> Outcome:
    shell.screen.page(_facts_about(shell, name, None))
    return Outcome.YES


def _facts_about(shell: Shell, name: str, most: int | None) -> list[str]:
    """The facts of all scenes that are asked; of several, each below its name."""
    found = []
    for scene in shell.session.scenes:
        lines = fact_lines(shell.session, scene, name, most=most, width=shell.screen.width)
        own = list(lines)
        if own and len(shell.session.scenes) > 1:
            found.append(f"{scene}:")
        found.extend(own)
    return found


def _words(shell: Shell, text: str) -> Outcome:
    found = [word for word in shell.words if word.name.startswith(text)]
    if not found:
        raise InputError(f"no word begins with {text!r}")
    kinds = dict.fromkeys(word.kind for word in found)
    for kind in kinds:
        shell.screen.say(f"{kind}:", style="bold")
        shell.screen.say(*(f"  {summary(word)}" for word in found if word.kind == kind))
    return Outcome.YES


def _help(shell: Shell, text: str) -> Outcome:
    if not text:
        rows = [(command.signature, command.meaning) for command in COMMANDS.values()]
        shell.screen.say(*GUIDE.splitlines(), *(f"  {line}" for line in _listed(rows)), GUIDE_END)
        return Outcome.YES
    lines = list(_explained(shell, text.removeprefix(":")))
    if not lines:
        meant = nearest(text, [word.name for word in shell.words])
        raise InputError(f"there is no word {text!r}" + (f"; did you mean {meant}?" * bool(meant)))
    shell.screen.say(*lines)
    return Outcome.YES


def _explained(shell: Shell, name: str) -> Iterator[str]:
    if name in COMMANDS:
        yield f"{COMMANDS[name].signature}: {COMMANDS[name].meaning}"
    for word in shell.words:
        if word.name == name:
            yield from described(word)
    if name in shell.session.base.models:
        yield f"{name}: a model; why {name} says what it asks for"


def _limit(shell: Shell, text: str) -> Outcome:
    if text and not (text.isdecimal() and int(text) > 0):
        raise InputError(":limit needs a number above 0, or nothing to show all answers")
    shell.limit = int(text) if text else None
    shell.screen.remark(f"at most {text} answers are shown" if text else "all answers are shown")
    return Outcome.YES


def _all(shell: Shell, text: str) -> Outcome:
    with shell.reporting(f":all {text}".rstrip()):
        _no_arguments("all", text)
        if shell.show_all is None:
            raise InputError("nothing was asked yet")
    return shell.show_all()


def _quit(shell: Shell, text: str) -> Outcome:
    del shell
    _no_arguments("quit", text)
    raise EOFError


def _no_arguments(name: str, text: str) -> None:
    if text:
        raise InputError(f":{name} takes no arguments")


def _listed(rows: list[tuple[str, str]]) -> Iterator[str]:
    width = max((len(left) for left, _ in rows), default=0)
    return (f"{left:<{width}}  {right}" for left, right in rows)


_ALL_COMMANDS = (
    Command("all", "", "shows all of what was last shown in part", _all, asks=True),
    Command("facts", "NAME", "shows all facts that mention a face, edge, vertex or thing", _facts),
    Command("help", "[WORD]", "explains the shell, or a word", _help),
    Command("limit", "[N]", "shows at most N answers, or all", _limit),
    Command("load", "PATH", "loads a scene, or a file or folder of models", _load),
    Command("models", "", "lists the models", _models),
    Command("quit", "", "leaves the shell, as Ctrl-D does", _quit),
    Command("reload", "", "loads all models and scenes again", _reload),
    Command("scenes", "", "lists the scenes", _scenes),
    Command("use", "[SCENE …]", "asks only these scenes, or all again", _use),
    Command("words", "[PREFIX]", "lists the words that a goal may use", _words),
)
COMMANDS = {command.name: command for command in _ALL_COMMANDS}
