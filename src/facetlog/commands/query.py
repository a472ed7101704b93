"""`facetlog query`: evaluate goals in scenes: one, many, or at a prompt."""

import sys
from typing import Annotated

import typer

from facetlog.commands.page_options import PageOptions, collect_answers
from facetlog.commands.shape_options import StatedOptions
from facetlog.commands.shared import ModelOptions, command
from facetlog.errors import InputError

__all__ = ["query_command"]

SHOWN = 20
"""Number of answers that the prompt shows of each goal, unless --limit says otherwise."""


@command
def query_command(
    arguments: Annotated[
        list[str],
        typer.Argument(
            metavar="SCENE... [GOAL]",
            help="Scenes, meshes, clouds or folders written by -o; then a quoted Prolog goal.",
            show_default=False,
        ),
    ],
    models: ModelOptions,
    page: PageOptions,
    stated: StatedOptions,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object per goal, each on one line.")
    ] = False,
    limit: Annotated[
        int | None, typer.Option("--limit", metavar="N", help="Largest number of answers per goal.")
    ] = None,
    timeout: Annotated[
        float | None, typer.Option("--timeout", metavar="SECONDS", help="Time limit per goal.")
    ] = None,
) -> int:
    """Ask scenes questions. Without a goal: a prompt, or goals from standard input.

    Exit code 0: there are answers, 1: there are none, 2: a goal is faulty, 3: a limit was reached.
    """
    from facetlog.kb.limits import Limits
    from facetlog.query_shell.asking import Outcome
    from facetlog.query_shell.goal_text import split_goals
    from facetlog.query_shell.lines import run_batch, run_line
    from facetlog.query_shell.scene_files import split_scenes_and_goal
    from facetlog.query_shell.screen import Screen
    from facetlog.query_shell.session import Session
    from facetlog.query_shell.shell import Shell

    if limit is not None and limit < 1:
        raise InputError(f"--limit {limit}: give a number above 0")
    if timeout is not None and not timeout > 0:
        raise InputError(f"--timeout {timeout:g}: give seconds above 0")
    paths, goal = split_scenes_and_goal(arguments)
    if goal is not None and not any(split_goals(goal)):
        raise InputError("the goal is empty: give one as face(F), or none for a prompt")
    if page.html is not None:
        page.check((*paths, *models.paths))
        if goal is None or len(paths) != 1 or len(list(split_goals(goal))) != 1:
            raise InputError("--html is of one scene and one goal: give both")
    limits = Limits() if timeout is None else Limits(seconds=timeout)
    with Session(trust=models.trust, limits=limits, options=stated.find_given()) as session:
        session.load_models(models.paths)
        session.load_scenes(paths)
        shell = Shell(session, Screen(), limit, as_json=as_json)
        if goal is not None:
            outcome = run_line(shell, goal)
            if page.html is not None and outcome in (Outcome.YES, Outcome.NO):
                (file,) = session.scene_files
                page.write(file, answers=collect_answers(session, goal, limit))
            return outcome
        # A prompt needs a terminal on both sides; what it asks for must not get among the answers.
        if not (sys.stdin.isatty() and (sys.stdout.isatty() or sys.stderr.isatty())):
            return run_batch(shell, sys.stdin)
        if as_json:
            raise InputError("--json needs a goal: give one, or goals on standard input")
        from facetlog.query_shell.prompt import run_prompt

        shell.limit, shell.at_prompt = limit or SHOWN, True
        run_prompt(shell)
    return 0
