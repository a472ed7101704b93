"""A line of the shell: goals, a command, or a question for reasons."""

import re

from facetlog.errors import FacetlogError
from facetlog.query_shell.asking import Outcome, outcome_of
from facetlog.query_shell.commands import run_command
from facetlog.query_shell.goal_text import COMMAND, split_goals
from facetlog.query_shell.shell import Shell

__all__ = ["execute", "run_line"]

# These words begin a question of the shell, not of Prolog.
_EXPLAIN = re.compile(r"(why_not|why-not|why)(?:\s+(?P<about>.*?))?[\s.]*", re.DOTALL)


def run_line(shell: Shell, line: str, *, where: str = "") -> Outcome:
    """What came of a line; an error is shown, `where` before it. EOFError to leave the shell."""
    try:
        return execute(shell, line)
    except FacetlogError as exc:
        shell.screen.complain(exc, where=where)
        return outcome_of(exc)


def execute(shell: Shell, line: str) -> Outcome:
    """What came of a line: of several goals, the last.

    Models whose files have changed are loaded again first. Raises FacetlogError for a line that
    cannot be done, EOFError to leave the shell.
    """
    text = line.strip()
    if text.startswith(COMMAND):
        return run_command(shell, text.removeprefix(COMMAND))
    if text:
        shell.screen.remark(*shell.session.changed_models())
    explain = _EXPLAIN.fullmatch(text)
    if explain is not None:
        with shell.reporting(text):
            return shell.explain(explain.group(1) != "why", explain.group("about") or "", text)
    outcome = Outcome.YES
    for goal, _ in split_goals(text):
        outcome = shell.ask(goal)
    return outcome
