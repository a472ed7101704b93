"""The result of recognition as an object: verdicts, reasons, and a page with the scene."""

import html
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from facetlog.errors import InputError
from facetlog.kb.engine.closing import Closing
from facetlog.kb.explaining.verdict_text import format_holding

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition, Verdict
    from facetlog.kb.knowledge_base import KnowledgeBase
    from facetlog.page.contents import Subject
    from facetlog.perception.reading.read_views import ViewSet
    from facetlog.perception.scene import Scene

__all__ = ["Reason", "Result"]

PAGE_HEIGHT_PX = 720
MOST_PAGE_BYTES = 8_000_000
"""Largest page within a notebook, which keeps it."""


@dataclass(frozen=True, eq=False, slots=True)
class Reason:
    """Why a model holds of a thing, or why not: printed, it is what the command line prints."""

    verdicts: "tuple[Verdict, ...]"
    """The verdicts that it is about, the nearest first."""

    lines: tuple[str, ...]
    """The reason in words, as the command line prints it."""

    @property
    def holds(self) -> bool:
        """Whether the first of the verdicts holds."""
        return bool(self.verdicts) and self.verdicts[0].state.value == "holds"

    def to_dict(self) -> list[dict[str, Any]]:
        """Return the verdicts with their whole proofs, as in verdicts.json."""
        return [verdict.to_json(full=True) for verdict in self.verdicts]

    def __str__(self) -> str:
        return "\n".join(self.lines)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


@dataclass(eq=False, slots=False)
class Result(Closing):
    """A scene and what all models say of each thing in it.

    Lengths are metres where `scene.metric` is true. The first reason opens a knowledge base: it
    ends with the result, or with `close` or a `with` statement.
    """

    scene: "Scene"
    """The measured vertices, edges and faces, with their uncertainty."""

    recognition: "Recognition"
    """The verdicts of all models on each thing."""

    models: tuple[Path, ...] = ()
    """The user's models that were asked as well."""

    trust: bool = False
    """Whether those models are the user's own."""

    raw: bool = False
    """Whether verdicts have degrees alone, and no confidence."""

    _view_set: "ViewSet | None" = field(default=None, repr=False)

    _lock: Any = field(default_factory=threading.Lock, repr=False)

    @property
    def best(self) -> "tuple[Verdict, ...]":
        """The verdicts that hold, the likeliest first."""
        return self.recognition.best

    @property
    def verdicts(self) -> "tuple[Verdict, ...]":
        """The verdict of each model on each thing."""
        return self.recognition.verdicts

    @property
    def warnings(self) -> tuple[str, ...]:
        """Doubts about the scene, and which pictures were left out, and why."""
        return self.scene.warnings

    def why(
        self,
        model: str,
        *,
        thing: str | None = None,
        parts: Mapping[str, str] = MappingProxyType({}),
        full: bool = False,
    ) -> Reason:
        """Explain why the model holds, or what it lacks, for one thing or for the best.

        `parts` gives faces to roles, as {"top": "f1"}. Raise QueryError for a model, thing, role
        or face that there is not.
        """
        _check_parts(parts)
        with self._lock:
            verdict = self._base.why(self.scene.name, model, thing=thing, parts=parts)
        return Reason((verdict,), tuple(verdict.lines(full=full)))

    def why_not(
        self,
        model: str,
        *,
        thing: str | None = None,
        parts: Mapping[str, str] = MappingProxyType({}),
        count: int = 3,
    ) -> Reason:
        """Explain what comes nearest to the model without holding, and by how much it misses.

        At most `count` verdicts, or the line that there is none. Raise errors as `why` does.
        """
        from facetlog.query_shell.explaining import explain_nothing_near

        _check_parts(parts)
        if count < 1:
            raise InputError(f"count {count}: give a number above 0")
        name = self.scene.name
        with self._lock:
            found = self._base.why_not(name, model, thing=thing, parts=parts, count=count)
            none = () if found else explain_nothing_near(self._base, name, model)
        return Reason(
            found, none or tuple(line for miss in found for line in miss.iter_miss_lines())
        )

    @cached_property
    def _base(self) -> "KnowledgeBase":
        from facetlog.pipeline import load_scene, open_models

        base = open_models(self.models, trusted=self.trust, raw=self.raw)
        load_scene(base, self.scene)
        return base

    def close(self) -> None:
        """Close the knowledge base in which reasons are found; a later reason opens it again."""
        with self._lock:
            base = self.__dict__.pop("_base", None)
        if base is not None:
            base.close()

    def __getstate__(self) -> dict[str, Any]:
        # Neither a lock nor a knowledge base goes into a file: reasons open one anew.
        kept = {"scene", "recognition", "models", "trust", "raw"}
        return {name: value for name, value in self.__dict__.items() if name in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _lock=threading.Lock())

    def to_dict(self, *, full: bool = False) -> dict[str, Any]:
        """Return the verdicts as in verdicts.json, with `full` the whole proofs."""
        return self.recognition.to_json(full=full)

    def __str__(self) -> str:
        return "\n".join(self.recognition.lines())

    def __repr__(self) -> str:
        found = format_holding(verdict.summary for verdict in self.best)
        return f"<{self.scene.name}: {found}>"

    def _repr_html_(self) -> str:
        subject = self._subject
        # Pictures are most of a page.
        for shown in (subject, replace(subject, views=())) if subject.views else (subject,):
            text = _make_page(shown)
            if len(text.encode()) <= MOST_PAGE_BYTES:
                return (
                    f'<iframe sandbox="allow-scripts" srcdoc="{html.escape(text, quote=True)}" '
                    f'title="{html.escape(subject.title, quote=True)}" '
                    f'style="width: 100%; height: {PAGE_HEIGHT_PX}px; border: 0"></iframe>'
                )
        return f"<pre>{html.escape(str(self))}</pre>"

    def write_page(self, path: str | Path) -> None:
        """Write a page that needs no other file, as `recognize -o` writes report.html.

        It has the scene in 3-D, the verdicts with proofs whose lines light up faces, and the
        pictures if there were any. Raise InputError for a path that does not end with .html or
        cannot be written.
        """
        from facetlog.page.page_path import check_page
        from facetlog.perception.atomic_write import write_atomically

        place = Path(path)
        check_page(place, "path", overwrite=True)
        try:
            write_atomically(place, _make_page(self._subject).encode())
        except OSError as exc:
            raise InputError(
                f"{place} cannot be written: {exc.strerror or exc}: give another file"
            ) from exc

    @property
    def _subject(self) -> "Subject":
        from facetlog.page.contents import Subject
        from facetlog.perception.facts.pieces.piece_facts import shown_pieces
        from facetlog.pipeline import placed_views

        given = self._view_set
        return Subject(
            self.scene,
            shown_pieces(self.scene),
            self.best,
            tuple(verdict for verdict in self.verdicts if verdict not in self.best),
            views=() if given is None else placed_views(given, self.scene),
            warnings=(*(() if given is None else given.problems), *self.scene.warnings),
        )


def _make_page(subject: "Subject") -> str:
    from facetlog.page.write import page

    return page(subject)


def _check_parts(parts: Mapping[str, str]) -> None:
    for role, face in parts.items():
        if not isinstance(role, str) or not isinstance(face, str):
            raise InputError(f"part {role!r:.40}: {face!r:.40}: give the name of a face, as 'f1'")


def model_paths(models: str | Path | Sequence[str | Path]) -> tuple[Path, ...]:
    """Return the paths of the given models, one or several.

    >>> [path.name for path in model_paths("gate.model")]
    ['gate.model']
    """
    given = (models,) if isinstance(models, str | Path) else models
    return tuple(map(Path, given))
