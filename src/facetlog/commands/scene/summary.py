"""What a scene holds, as plain data and as text: things and faces as models see them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from facetlog.commands.scene.shape import Shape
from facetlog.counted import many
from facetlog.perception.facts.all_facts import FactRows, fact_rows
from facetlog.perception.facts.fact_schema import Value

__all__ = ["Summary"]

FORMAT = "facetlog-scene-summary/1"

FACES_SHOWN = 10
"""Of the faces, in the text; the largest tell what a thing is."""

DIGITS = 4

Rows = dict[Value, tuple[Value, ...]]


@dataclass(frozen=True)
class Summary:
    """A shape's things and faces, with the names that verdicts give them (t1, f1)."""

    shape: Shape

    @cached_property
    def _facts(self) -> FactRows:
        return fact_rows(self.shape.scene)

    def _of(self, functor: str) -> Rows:
        """The arguments of a fact's rows after the first, by the first."""
        return {row[0]: row[1:] for row in self._facts.get(functor, ())}

    @cached_property
    def _owners(self) -> dict[Value, Value]:
        return {part: thing for part, (thing,) in self._of("part_of").items()}

    def things(self) -> list[dict[str, Any]]:
        """The things: how many faces each has, its size, and what is known of its surface."""
        sizes, curved, whole = self._of("thing_size"), self._of("curved"), self._of("whole")
        faces = [self._owners.get(name) for name in self._of("face")]
        found = []
        for thing in self._of("thing"):
            length, width, height = sizes.get(thing, (None, None, None))
            found.append(
                {
                    "name": thing,
                    "faces": faces.count(thing),
                    "length": length,
                    "width": width,
                    "height": height,
                    "curved": curved[thing][0] if thing in curved else None,
                    "whole": thing in whole,
                }
            )
        return found

    def faces(self) -> list[dict[str, Any]]:
        """The faces, the largest first; without a known up they have no tilt."""
        functors = ("area", "length", "width", "tilt", "coverage")
        columns = {functor: self._of(functor) for functor in functors}
        sights = self._sights()
        found: list[dict[str, Any]] = []
        for face in self._of("face"):
            values = {f: rows[face][0] if face in rows else None for f, rows in columns.items()}
            thing = self._owners.get(face)
            found.append({"name": face, "thing": thing, **values, "sights": sights[face]})
        # areas that read the same are the same: rounding orders nothing
        return sorted(found, key=lambda face: -float(f"{face['area']:.{DIGITS}g}"))

    def _sights(self) -> dict[Value, list[dict[str, Any]]]:
        """By face: each view before it, what this shows of it, and which faces hide it there."""
        scene = self.shape.scene
        return {
            f"f{number}": [
                {
                    "view": scene.views[sight.view],
                    "seen": sight.seen,
                    "hidden": {f"f{by + 1}": share for by, share in sight.hidden},
                    "outside": sight.outside,
                }
                for sight in face.sights
            ]
            for number, face in enumerate(scene.faces, start=1)
        }

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data: lengths in metres if `unit` is "m", angles in degrees."""
        scene = self.shape.scene
        return {
            "schema": FORMAT,
            "name": scene.name,
            "unit": "m" if scene.metric else None,
            "unit_known": self.shape.unit_known,
            "up": None if scene.up is None else scene.up.tolist(),
            "up_known": self.shape.up_known,
            "views": len(scene.views),
            "vertices": len(scene.vertices),
            "edges": len(scene.edges),
            "patches": len(scene.patches),
            "things": self.things(),
            "faces": self.faces(),
            "warnings": list(scene.warnings),
        }

    def lines(self) -> Iterator[str]:
        """The same as text, of the faces the largest."""
        scene, things, faces = self.shape.scene, self.things(), self.faces()
        yield (
            f"{scene.name}: {many(len(things), 'object')}, {many(len(faces), 'face')}, "
            f"{many(len(scene.edges), 'edge')}, {many(len(scene.vertices), 'vertex', 'vertices')}"
        )
        unit = "metres" if scene.metric else "unknown, only ratios of lengths mean something"
        yield f"unit  {unit}{_how(self.shape.unit_known)}"
        up = "unknown" if scene.up is None else " ".join(f"{x:.3g}" for x in scene.up + 0.0)
        yield f"up    {up}{_how(self.shape.up_known)}"
        if scene.views:
            yield f"seen  in {many(len(scene.views), 'view')}"
        sign = " (m)" if scene.metric else ""
        if things:
            heads = ("object", "faces", *(f"{n}{sign}" for n in ("longest", "middle", "shortest")))
            yield ""
            yield from _table((*heads, "curved", "whole"), [_thing_row(thing) for thing in things])
        if faces:
            heads = ("face", "object", f"area{sign.replace('m', 'm²')}")
            heads = (*heads, f"length{sign}", f"width{sign}", "tilt", "seen")
            yield ""
            yield from _table(heads, [_face_row(face) for face in faces[:FACES_SHOWN]])
            if len(faces) > FACES_SHOWN:
                yield f"and {len(faces) - FACES_SHOWN} smaller"


def _how(known: str) -> str:
    return "" if known == "not known" else f", {known}"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.{DIGITS}g}"


def _share(value: float | None) -> str:
    return "–" if value is None else f"{value:.0%}"


def _thing_row(thing: dict[str, Any]) -> tuple[str, ...]:
    sizes = (_number(thing[name]) for name in ("length", "width", "height"))
    whole = "yes" if thing["whole"] else "no"
    return (str(thing["name"]), str(thing["faces"]), *sizes, _share(thing["curved"]), whole)


def _face_row(face: dict[str, Any]) -> tuple[str, ...]:
    sizes = (_number(face[name]) for name in ("area", "length", "width"))
    tilt = "–" if face["tilt"] is None else f"{face['tilt']:.1f}°"
    return (face["name"], face["thing"] or "–", *sizes, tilt, _share(face["coverage"]))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines with columns of equal width, names to the left and numbers to the right."""
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    for row in (heads, *rows):
        cells = (
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        yield "  ".join(cells).rstrip()
