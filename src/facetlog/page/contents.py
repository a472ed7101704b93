"""Contents of a page, as plain values for its template."""

import base64
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2

from facetlog import __version__
from facetlog.kb.explaining.near import format_nearest
from facetlog.kb.explaining.proof import MARKS, State
from facetlog.kb.explaining.trace import Step, steps
from facetlog.kb.explaining.verdict_text import (
    format_holding,
    format_origin,
    format_parts,
    format_sizes,
    mark,
)
from facetlog.page.model_view import loose_edges, model_view
from facetlog.page.seen_outlines import seen_outlines
from facetlog.page.uncertainty import compute_ellipsoid_scale
from facetlog.perception.surfaces.drawing.upright import upright
from facetlog.pipeline import Recognised
from facetlog.plurals import many

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Condition, Verdict
    from facetlog.perception.pieces.shown_pieces import ShownPieces
    from facetlog.perception.scene import Scene
    from facetlog.perception.types import View

PICTURE_PX = 720  # the longer side of a picture in the page
JPEG_QUALITY = 72
# Names of faces, edges, vertices and pieces, and runs of them as f2–f8.
_NAMES = re.compile(r"\b([a-z])(\d+)(?:–\1(\d+))?\b")
_NAMED = "fevp"
MOST_IN_A_RUN = 500
STANDS = {State.HOLDS: "holds", State.FAILS: "fails", State.UNKNOWN: "open"}


@dataclass(frozen=True, slots=True)
class Answers:
    """The answers to a goal as texts: a head for each column, and the cells of each row."""

    goal: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False, slots=True)
class Subject:
    """Subject of a page: a scene, and what was asked of it.

    `best` are the verdicts that hold, `others` those that do not. `views` have the poses with which
    the scene was found. `times` are names and seconds.
    """

    scene: "Scene"
    pieces: "ShownPieces"
    best: "tuple[Verdict, ...]" = ()
    others: "tuple[Verdict, ...]" = ()
    answers: Answers | None = None
    views: "tuple[View, ...]" = ()
    warnings: tuple[str, ...] = ()
    times: tuple[tuple[str, float], ...] = ()

    @classmethod
    def of_run(cls, found: Recognised, pieces: "ShownPieces") -> "Subject":
        """Return the whole run, from its pictures to its verdicts."""
        best = found.recognition.best
        return cls(
            found.scene,
            pieces,
            best,
            tuple(v for v in found.recognition.verdicts if v not in best),
            views=found.placed_views,
            warnings=(*found.view_set.problems, *found.scene.warnings),
            times=tuple((t.name, t.wall) for t in (*found.clock.times, found.clock.total)),
        )

    @property
    def title(self) -> str:
        """Heading: the result, or the goal that was asked."""
        if self.answers is not None:
            return self.answers.goal
        one = self.best or (self.others if len(self.others) == 1 else ())
        return format_holding(verdict.summary for verdict in one)


def contents(subject: Subject) -> dict[str, Any]:
    """Return all that the template (page.html.jinja) names."""
    scene = subject.scene
    spaces = _name_unseen_spaces(subject.pieces)
    best, others = ([_verdict(v, spaces) for v in some] for some in (subject.best, subject.others))
    answers = None if subject.answers is None else _answers(subject.answers)
    _drop_unknown_names((best, others, answers), scene, subject.pieces)
    named = frozenset(_iter_lit_names((best, others, answers)))
    return {
        "version": __version__,
        "name": scene.name,
        "answer": subject.title,
        "seen": _seen(scene),
        "best": best,
        "others": others,
        "answers": answers,
        "model_view": model_view(scene, subject.pieces, subject.views, named),
        "kinds": _kinds(scene, subject.pieces, subject.views),
        "pictures": list(_pictures(subject, named)),
        "warnings": subject.warnings,
        "times": [(name, f"{seconds:.1f}") for name, seconds in subject.times],
    }


def _seen(scene: "Scene") -> str:
    counts = (
        many(len(scene.views), "view"),
        many(len(scene.faces), "face"),
        many(len(scene.edges), "edge"),
        many(len(scene.vertices), "vertex", "vertices"),
    )
    unit = "lengths in metres" if scene.metric else "scale not known"
    up = "up known" if scene.up is not None else "up not known"
    return f"{', '.join(counts)}; {unit}, {up}"


def _answers(answers: Answers) -> dict[str, Any]:
    rows = [[_mark_names(cell) for cell in row] for row in answers.rows]
    return {"heads": answers.heads, "rows": rows, "count": many(len(rows), "answer")}


def _kinds(
    scene: "Scene", pieces: "ShownPieces", views: "Sequence[View]"
) -> list[tuple[str, str, bool]]:
    """Return what can be shown in 3-D: the letter of its nodes, what it is called, and whether it
    is.
    """
    unseen = any(space.unseen > 0.0 for space in pieces.spaces)
    larger = compute_ellipsoid_scale(scene)
    drawn = f", × {larger}" if larger and larger > 1 else ""
    there = (
        ("f", "faces", True, bool(scene.faces)),
        ("e", "edges without a face", True, any(True for _ in loose_edges(scene))),
        ("p", "pieces", False, bool(pieces)),
        ("v", f"uncertainty of vertices (2 sd{drawn})", False, larger is not None),
        ("unseen", "what nobody saw", False, unseen and bool(pieces)),
        ("view", "cameras", False, bool(views)),
    )
    return [(letter, called, on) for letter, called, on, is_there in there if is_there]


def _name_unseen_spaces(pieces: "ShownPieces") -> dict[str, str]:
    """Return the name of the node of each thing's unseen space, by thing."""
    numbered = enumerate(zip(pieces.things, pieces.spaces, strict=True), start=1)
    return {thing: f"unseen{n}" for n, (thing, space) in numbered if space.unseen > 0.0}


def _verdict(verdict: "Verdict", spaces: dict[str, str]) -> dict[str, Any]:
    parts, sizes = format_parts(verdict), format_sizes(verdict)
    origin = format_origin(verdict) if verdict.state is State.HOLDS else ""
    faces = " ".join(face for part in verdict.parts for face in part.faces)
    return {
        "summary": verdict.summary,
        "state": STANDS[verdict.state],
        "lines": [
            *([_mark_names(origin)] if origin else ()),
            *([{"text": f"parts: {parts}", "names": faces}] if verdict.parts else ()),
            *([_mark_names(f"sizes: {', '.join(sizes)}")] if sizes else ()),
        ],
        "conditions": [_condition(c, verdict, spaces) for c in verdict.conditions],
        "unseen": list(_unseen(verdict, spaces)),
    }


def _unseen(verdict: "Verdict", spaces: dict[str, str]) -> Iterator[dict[str, Any]]:
    """Yield why parts may have been missed; a line about unseen space lights it up."""
    roles = verdict.unseen_roles
    for found in verdict.unseen:
        said = "; ".join(line.strip() for line in found.lines(roles))
        space = spaces.get(verdict.thing) if found.space else None
        yield _mark_names(said, (space,) if space else ())
        roles = ()


def _condition(
    condition: "Condition", verdict: "Verdict", spaces: dict[str, str]
) -> dict[str, Any]:
    proof = condition.proof
    space = spaces.get(verdict.thing)
    open_space = (space,) if space and condition.may_be_settled else ()
    nearest = format_nearest(condition.nearest, verdict.length_unit)[:1]
    return {
        "state": STANDS[proof.state],
        "mark": mark(condition),
        "label": condition.label,
        "said": condition.said,
        "degree": f"{proof.low:.0%}",
        "origin": condition.origin,
        "steps": [
            *_tree(steps(proof, verdict.length_unit), open_space),
            *({**_mark_names(text), "steps": []} for text in nearest),
        ],
    }


def _tree(found: Iterable[Step], open_space: Sequence[str]) -> list[dict[str, Any]]:
    """Return steps with those that they rest on; open ones that name nothing are about
    `open_space`.
    """
    top: list[dict[str, Any]] = []
    open_ones: list[tuple[int, list[dict[str, Any]]]] = [(-1, top)]
    for depth, text in found:
        while open_ones[-1][0] >= depth:
            open_ones.pop()
        step = {**_mark_names(text), "steps": []}
        if not step["names"] and text.startswith(MARKS[State.UNKNOWN]):
            step["names"] = " ".join(open_space)
        open_ones[-1][1].append(step)
        open_ones.append((depth, step["steps"]))
    return top


def _mark_names(line: str, places: Sequence[str] = ()) -> dict[str, Any]:
    """Return a text, and what is to be lit up: places that it is about, and the names that
    it has.
    """
    return {"text": line, "names": " ".join(dict.fromkeys((*places, *_names(line))))}


def _names(line: str) -> Iterator[str]:
    for letter, first, last in _NAMES.findall(line):
        if letter in _NAMED:
            end = min(int(last or first), int(first) + MOST_IN_A_RUN)
            yield from (f"{letter}{number}" for number in range(int(first), end + 1))


def _iter_lit_names(shown: Any) -> Iterator[str]:
    """Yield all names that lines of the page light up."""
    if isinstance(shown, dict):
        yield from str(shown.get("names", "")).split()
        shown = tuple(shown.values())
    if isinstance(shown, list | tuple):
        for each in shown:
            yield from _iter_lit_names(each)


def _drop_unknown_names(shown: Any, scene: "Scene", pieces: "ShownPieces") -> None:
    """Drop names that the scene does not have: a letter with a number may mean other things."""
    things = zip(_NAMED, (scene.faces, scene.edges, scene.vertices, pieces.pieces), strict=True)
    there = {f"{letter}{n}" for letter, some in things for n in range(1, len(some) + 1)}

    def keep(part: Any) -> None:
        if isinstance(part, dict):
            if "names" in part:
                names = part["names"].split()
                kept = (n for n in names if n in there or not _NAMES.fullmatch(n))
                part["names"] = " ".join(kept)
            part = tuple(part.values())
        if isinstance(part, list | tuple):
            for each in part:
                keep(each)

    keep(shown)


def _pictures(subject: Subject, named: frozenset[str]) -> Iterator[dict[str, Any]]:
    scene = subject.scene
    for taken in subject.views:
        view, _ = upright(taken, scene.up)
        height, width = view.image.shape
        shrink = min(1.0, PICTURE_PX / max(height, width))
        size = max(1, round(width * shrink)), max(1, round(height * shrink))
        small = cv2.resize(view.image, size, interpolation=cv2.INTER_AREA)
        _, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        yield {
            "name": view.name,
            "width": size[0],
            "height": size[1],
            "data": base64.b64encode(data.tobytes()).decode("ascii"),
            "outlines": list(seen_outlines(view, scene, shrink, subject.pieces, named)),
        }
