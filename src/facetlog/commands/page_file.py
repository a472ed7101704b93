"""The option --html: the answer about a scene, as a page that needs no other file."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Verdict
    from facetlog.page.contents import Answers
    from facetlog.query_shell.scene_files import SceneFile
    from facetlog.query_shell.session import Session

__all__ = ["Html", "answers_to", "write_page"]

Html = Annotated[
    Path | None,
    typer.Option("--html", metavar="FILE", help="Also a page, with the scene in 3-D, to look at."),
]


def write_page(
    path: Path,
    file: "SceneFile",
    *,
    verdicts: "tuple[Verdict, ...]" = (),
    answers: "Answers | None" = None,
) -> None:
    """Writes the page of verdicts or of answers, whole or not at all."""
    from facetlog.kb.explaining.proof import State
    from facetlog.page.contents import Subject
    from facetlog.page.write import page
    from facetlog.perception.atomic_write import write_whole
    from facetlog.perception.facts.pieces.piece_facts import shown_pieces

    scene = file.scene()
    best = tuple(verdict for verdict in verdicts if verdict.state is State.HOLDS)
    others = tuple(verdict for verdict in verdicts if verdict.state is not State.HOLDS)
    subject = Subject(scene, shown_pieces(scene), best, others, answers, warnings=scene.warnings)
    write_whole(path, page(subject).encode())


def answers_to(session: "Session", goal: str, limit: int | None) -> "Answers":
    """The answers to a goal as texts, at most `limit`; errors as those of the question."""
    from facetlog.page.contents import Answers
    from facetlog.query_shell.meanings import meanings
    from facetlog.query_shell.table import Table

    with session.base.query(goal, scenes=session.scenes, most=limit) as answers:
        if not answers.names:
            said = "yes" if next(iter(answers), None) is not None else "no"
            return Answers(goal, ("answer",), ((said,),))
        table = Table(answers.names, meanings(goal), session.length, scenes=session.base.scenes)
        heads, rows = table.cells(list(answers))
    return Answers(goal, heads, rows)
