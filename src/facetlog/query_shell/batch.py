"""Goals and commands from a file or pipe."""

from collections.abc import Iterable
from contextlib import suppress

from facetlog.query_shell.asking import Outcome
from facetlog.query_shell.goal_text import goals
from facetlog.query_shell.lines import run_line
from facetlog.query_shell.shell import Shell

__all__ = ["run_batch"]


def run_batch(shell: Shell, lines: Iterable[str]) -> Outcome:
    """What came of all goals: the worst fault, else whether any had an answer.

    A faulty one is reported with the number of its line, and the others are asked nevertheless.
    """
    outcomes: list[Outcome] = []
    with suppress(EOFError):  # :quit
        for goal in goals(lines):
            shell.line = goal.line
            outcomes.append(run_line(shell, goal.text, where=f"line {goal.line}: "))
    worst = max(outcomes, default=Outcome.YES)
    return worst if worst > Outcome.NO else min(outcomes, default=Outcome.YES)
