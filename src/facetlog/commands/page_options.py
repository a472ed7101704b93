"""The option --html: the answer about a scene, as a page that needs no other file."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shared import Overwrite
from facetlog.page.page_path import check_page

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Verdict
    from facetlog.page.contents import Answers
    from facetlog.query_shell.scene_files import SceneFile
    from facetlog.query_shell.session import Session

__all__ = ["PageOptions", "collect_answers"]


@dataclass(frozen=True, slots=True)
class PageOptions:
    """Whether and where to write a page."""

    html: Annotated[
        Path | None,
        typer.Option("--html", metavar="FILE", help="Also write a page with the scene in 3-D."),
    ] = None
    overwrite: Overwrite = False

    def check(self, inputs: Iterable[Path]) -> None:
        """Raise InputError if the page may not be written; to be called before the work."""
        if self.html is not None:
            check_page(self.html, "--html", inputs, overwrite=self.overwrite)

    def write(
        self,
        file: "SceneFile",
        *,
        verdicts: "tuple[Verdict, ...]" = (),
        answers: "Answers | None" = None,
    ) -> None:
        """Write the page of verdicts or of answers, whole or not at all, if it is wanted."""
        if self.html is None:
            return
        from facetlog.kb.explaining.proof import State
        from facetlog.page.contents import Subject
        from facetlog.page.write import page
        from facetlog.perception.atomic_write import write_atomically
        from facetlog.perception.facts.pieces.piece_facts import shown_pieces

        scene = file.kept.scene()
        best = tuple(verdict for verdict in verdicts if verdict.state is State.HOLDS)
        others = tuple(verdict for verdict in verdicts if verdict.state is not State.HOLDS)
        pieces = shown_pieces(scene)
        subject = Subject(scene, pieces, best, others, answers, warnings=scene.warnings)
        write_atomically(self.html, page(subject).encode())


def collect_answers(session: "Session", goal: str, limit: int | None) -> "Answers":
    """Return at most `limit` answers to a goal as texts; errors as those of the question."""
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
