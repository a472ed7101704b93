"""A line of the shell: goals, a command, or a question for reasons."""

import re
from collections.abc import Iterable
from contextlib import suppress

from facetlog.errors import FacetlogError
from facetlog.query_shell.asking import Outcome, get_outcome
from facetlog.query_shell.commands import run_command
from facetlog.query_shell.goal_text import COMMAND, goals, split_goals
from facetlog.query_shell.shell import Shell

# These words begin a question of the shell, not of Prolog.
_EXPLAIN = re.compile(r"(why_not|why-not|why)(?:\s+(?P<about>.*?))?[\s.]*", re.DOTALL)


def run_line(shell: Shell, line: str, *, where: str = "") -> Outcome:
    """Run a line and return the outcome; show an error, `where` before it. EOFError leaves the
    shell.
    """
    try:
        return execute(shell, line)
    except FacetlogError as exc:
        shell.screen.complain(exc, where=where)
        return get_outcome(exc)


def execute(shell: Shell, line: str) -> Outcome:
    """Run a line and return the outcome: of several goals, that of the last.

    Models whose files have changed are loaded again first. Raise FacetlogError for a line that
    cannot be done, EOFError to leave the shell.
    """
    text = line.strip()
    if text.startswith(COMMAND):
        return run_command(shell, text.removeprefix(COMMAND))
    if text:
        shell.screen.remark(*shell.session.reload_changed_models())
    explain = _EXPLAIN.fullmatch(text)
    if explain is not None:
        with shell.report_errors_as_json(text):
            return shell.explain(explain.group(1) != "why", explain.group("about") or "", text)
    outcome = Outcome.YES
    for goal, _ in split_goals(text):
        outcome = shell.ask(goal)
    return outcome


def run_batch(shell: Shell, lines: Iterable[str]) -> Outcome:
    """Run the goals and commands of a file or pipe; return the worst fault, else the best outcome.

    Report a faulty goal with the number of its line and go on with the others.
    """
    outcomes: list[Outcome] = []
    with suppress(EOFError):  # :quit
        for goal in goals(lines):
            shell.line = goal.line
            outcomes.append(run_line(shell, goal.text, where=f"line {goal.line}: "))
    worst = max(outcomes, default=Outcome.YES)
    return worst if worst > Outcome.NO else min(outcomes, default=Outcome.YES)
