"""Draws the words for furniture into docs/pictures/vocabulary.svg, with values that facts have.

With `--check` nothing is written: the exit code is 1 if the picture is not up to date.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from facetlog.perception.facts.all_facts import FactRows, fact_rows
from facetlog.perception.facts.thing_facts import RIM_SHARE
from facetlog.perception.scene import Body, Scene
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.types import FloatArray

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "vocabulary.svg"

# Oblique projection: depth (y) goes to the right and upwards, at this share of its length.
RIGHT, UPWARDS = 0.38, 0.30
TOWARD = np.array([RIGHT, -1.0, UPWARDS])  # all that is on such a line falls on one point
COLUMNS = 4
PANEL_WIDTH, PANEL_HEIGHT, DRAWN_WIDTH, DRAWN_HEIGHT = 230, 262, 170, 150
TOP = 62  # px of a panel above the drawing

STYLE = """
.sheet { fill: #fbfaf6; stroke: #d8d4c8 }
.face { fill: #e9e6dc; stroke: #6b6a66; stroke-width: 1; stroke-linejoin: round }
.meant { fill: #8fb8de; stroke: #2c5d8a; stroke-width: 1.2; stroke-linejoin: round }
.space { fill: #f2b263; fill-opacity: 0.5; stroke: #b06a10; stroke-width: 1 }
.box { fill: none; stroke: #b06a10; stroke-width: 1.2; stroke-dasharray: 4 3 }
.length { stroke: #b3261e; stroke-width: 1.8; marker-start: url(#a); marker-end: url(#a) }
.point { fill: #b3261e }
text { font-family: sans-serif; fill: #22211f; font-size: 12px }
.word { font-weight: bold; font-size: 15px }
.value { fill: #b3261e; font-size: 13px }
"""

LEGEND: Mapping[str, str] = MappingProxyType(
    {
        "meant": "the face that is asked about, or those of which the word is true",
        "space": "the space or area that is meant",
        "box": "the footprint, the box round it, or the rim",
    }
)

Point = Sequence[float]


@dataclass(frozen=True, eq=False)
class Thing:
    """A scene of one thing known from all sides, its facts, and how it is put on the sheet."""

    scene: Scene
    facts: FactRows

    @classmethod
    def built(cls, name: str, **sizes: float) -> "Thing":
        """What a builder makes."""
        scene = build(name, sizes)
        whole = Body(tuple(range(len(scene.faces))), whole=True)
        scene = replace(scene, bodies=(whole,))
        return cls(scene, fact_rows(scene))

    def value(self, functor: str, of: str) -> float:
        """Return the first number that a fact says of a face or thing."""
        return next(float(row[1]) for row in self.facts[functor] if row[0] == of)

    def named(self, functor: str, *last: str) -> set[int]:
        """Numbers of the faces that a fact names first, with these further arguments."""
        rows = self.facts[functor]
        return {
            int(row[0][1:]) - 1
            for row in rows
            if isinstance(row[0], str) and row[0][0] == "f" and row[1:] == last
        }

    @property
    def size(self) -> FloatArray:
        """Its extents; the builders' things begin at the origin."""
        return np.asarray(self.scene.points.max(axis=0))


class Drawing:
    """One thing on a panel, and what is drawn over it."""

    def __init__(self, thing: Thing, meant: set[int]) -> None:
        self.thing, self.lines = thing, list[str]()
        x, y, z = thing.size
        width, height = x + RIGHT * y, z + UPWARDS * y
        self._px = min(DRAWN_WIDTH / width, DRAWN_HEIGHT / height)
        self._left = (PANEL_WIDTH - width * self._px) / 2
        self._floor = TOP + (DRAWN_HEIGHT + height * self._px) / 2
        self._draw_faces(meant)

    def at(self, point: Point) -> str:
        """Return a point of the scene as SVG has it."""
        x, y, z = point
        column = self._left + self._px * (x + RIGHT * y)
        row = self._floor - self._px * (z + UPWARDS * y)
        return f"{column:.1f},{row:.1f}"

    def _draw_faces(self, meant: set[int]) -> None:
        """Faces that look this way, the farthest first."""
        scene = self.thing.scene
        seen = [i for i, f in enumerate(scene.faces) if f.plane.normal @ TOWARD > 1e-9]
        corners = {i: scene.points[list(scene.faces[i].outline)] for i in seen}
        for i in sorted(seen, key=lambda i: float((corners[i] @ TOWARD).mean())):
            self.polygon(corners[i].tolist(), "meant" if i in meant else "face")

    def polygon(self, points: Sequence[Point], style: str) -> None:
        """Return a closed line, filled as its style says."""
        self.lines.append(f'<polygon class="{style}" points="{" ".join(map(self.at, points))}"/>')

    def level(self, low: Point, high: Point, height: float, style: str) -> None:
        """Return a level rectangle between two corners of the plan."""
        (a, b), (c, d) = low[:2], high[:2]
        corners = [(a, b, height), (c, b, height), (c, d, height), (a, d, height)]
        self.polygon(corners, style)

    def length(self, start: Point, end: Point) -> None:
        """Return a line with an arrow at both ends; a dot where it has no length."""
        (a, b), (c, d) = self.at(start).split(","), self.at(end).split(",")
        if (a, b) == (c, d):
            self.lines.append(f'<circle class="point" cx="{a}" cy="{b}" r="4"/>')
        else:
            self.lines.append(f'<line class="length" x1="{a}" y1="{b}" x2="{c}" y2="{d}"/>')


@dataclass(frozen=True)
class Panel:
    """A word, the value to show, what it means in two short lines, and the drawing."""

    word: str
    value: str
    meaning: tuple[str, str]
    drawing: Drawing


def panels() -> Iterator[Panel]:
    """Return all panels in the order of the vocabulary."""
    table, chair, shelf = Thing.built("table"), Thing.built("chair"), Thing.built("shelf", boards=4)
    top, seat, board = "f2", "f2", "f18"
    length, width, _ = table.size
    x, y, z = chair.size
    height = chair.value("elevation", seat)

    d = Drawing(chair, {1})
    d.level((0, 0), (x, y), 0.0, "box")
    yield Panel(
        "cover", _share(chair, "cover", seat), ("share of the footprint", "that the level takes"), d
    )
    d = Drawing(shelf, {17})
    middle = (shelf.size[0] / 2, shelf.size[1] / 2)
    low = shelf.value("elevation", board)
    d.length((*middle, low), (*middle, low + shelf.value("room_above", board)))
    yield Panel(
        "built_over",
        _share(shelf, "built_over", board),
        ("share of the level that", "has something above it"),
        d,
    )
    d = Drawing(table, {1})
    under = table.value("elevation", top)
    d.length((length / 2, 0.0, under - table.value("room_below", top)), (length / 2, 0.0, under))
    yield Panel(
        "room_below",
        _metres(table, "room_below", top),
        ("free height beneath", "the level, on average"),
        d,
    )
    d = Drawing(chair, {1})
    d.length((x / 2, y / 2, height), (x / 2, y / 2, height + chair.value("room_above", seat)))
    yield Panel(
        "room_above",
        _metres(chair, "room_above", seat),
        ("free height above it, up to", "the highest point, on average"),
        d,
    )
    d = Drawing(table, {1})
    d.polygon([(0, 0, 0), (length, 0, 0), (length, 0, 0.7), (0, 0, 0.7)], "space")
    yield Panel(
        "see_through",
        _share(table, "see_through", top),
        ("share of the space beneath", "that one sees through"),
        d,
    )
    d = Drawing(chair, {1})
    d.length((x / 2, y / 2, height), (x / 2, y, height))
    value = f"{chair.value('rise_side', seat):.2f} of half the level"
    yield Panel("rise_side", value, ("how far to one side stands", "what rises high above it"), d)
    d = Drawing(chair, {1})
    d.length((x / 2, y, height), (x / 2, y, height))
    value = f"{chair.value('rise_off_middle', seat):.2f} of half the side"
    yield Panel("rise_off_middle", value, ("how far that is from the", "middle of this side"), d)
    d = Drawing(chair, {1})
    d.length((0.0, y, z), (x, y, z))
    yield Panel(
        "rise_span",
        _share(chair, "rise_span", seat),
        ("how much of the side's", "length it takes"),
        d,
    )
    d = Drawing(table, set())
    d.level((0, 0), (length, width), 0.0, "space")
    value = f"{table.value('footprint', 't1'):.2f} m²"
    yield Panel("footprint", value, ("area of the plan,", "hollows filled"), d)
    d = Drawing(table, set())
    _box(d)
    yield Panel(
        "solidity",
        _share(table, "solidity", "t1"),
        ("share that it takes of the", "upright box round it"),
        d,
    )
    d = Drawing(table, table.named("on_ground"))
    yield Panel(
        "on_ground", "faces of the legs", ("its lowest point is level", "with that of its thing"), d
    )
    d = Drawing(table, table.named("at_rim", top))
    rim = RIM_SHARE * min(length, width)
    d.level((rim, rim), (length - rim, width - rim), table.size[2], "box")
    yield Panel(
        "at_rim",
        f"within {RIM_SHARE:.0%} of the width",
        ("stands upright at the rim", "of a level face"),
        d,
    )
    d = Drawing(shelf, {17, 21})
    yield Panel("congruent", "two boards", ("lengths, widths and areas", "equal within 5 %"), d)


def _box(d: Drawing) -> None:
    x, y, z = d.thing.size
    d.level((0, 0), (x, y), 0.0, "box")
    d.level((0, 0), (x, y), z, "box")
    for a, b in ((0, 0), (x, 0), (x, y), (0, y)):
        d.polygon([(a, b, 0), (a, b, z)], "box")


def _share(thing: Thing, functor: str, of: str) -> str:
    return f"{thing.value(functor, of):.0%}"


def _metres(thing: Thing, functor: str, of: str) -> str:
    return f"{thing.value(functor, of):.2f} m"


def picture() -> str:
    """Return the sheet as SVG."""
    shown = list(panels())
    rows = -(-len(shown) // COLUMNS)
    width, height = COLUMNS * PANEL_WIDTH + 20, rows * PANEL_HEIGHT + 20
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
        f'width="{width}" height="{height}">',
        f"<style>{STYLE}</style>",
        '<defs><marker id="a" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="4" '
        'markerHeight="4" orient="auto-start-reverse">'
        '<path d="M0,0 L8,4 L0,8 z" fill="#b3261e"/></marker></defs>',
        f'<rect class="sheet" x="1" y="1" width="{width - 2}" height="{height - 2}" rx="14"/>',
    ]
    for i, panel in enumerate(shown):
        row, column = divmod(i, COLUMNS)
        lines.append(
            f'<g transform="translate({10 + column * PANEL_WIDTH},{10 + row * PANEL_HEIGHT})">'
        )
        lines += [
            f'<text class="word" x="16" y="26">{panel.word}</text>',
            f'<text class="value" x="16" y="45">{panel.value}</text>',
            *panel.drawing.lines,
            *(
                f'<text x="16" y="{TOP + DRAWN_HEIGHT + 20 + 16 * n}">{line}</text>'
                for n, line in enumerate(panel.meaning)
            ),
            "</g>",
        ]
    row, column = divmod(len(shown), COLUMNS)
    lines += _legend(10 + column * PANEL_WIDTH + 16, 10 + row * PANEL_HEIGHT + 26)
    return "\n".join([*lines, "</svg>", ""])


def _legend(left: int, top: int) -> Iterator[str]:
    """What the colours mean, from a place on the sheet."""
    for n, (style, meaning) in enumerate(LEGEND.items()):
        y = top + 24 * n
        yield f'<rect class="{style}" x="{left}" y="{y - 11}" width="22" height="13"/>'
        yield f'<text x="{left + 32}" y="{y}">{meaning}</text>'
    y = top + 24 * len(LEGEND)
    yield f'<line class="length" x1="{left}" y1="{y - 4}" x2="{left + 22}" y2="{y - 4}"/>'
    yield f'<text x="{left + 32}" y="{y}">the length that is meant</text>'
    sizes = "Table, chair and shelf are those that examples build"
    yield f'<text x="{left}" y="{y + 34}">{sizes} (the shelf with four boards);</text>'
    values = "all values are those that models are given of them."
    yield f'<text x="{left}" y="{y + 50}">{values}</text>'


def main(arguments: list[str]) -> int:
    """Draw the picture, or say that it is not up to date; see the top of the file."""
    wanted = picture()
    if PICTURE.is_file() and PICTURE.read_text(encoding="utf-8") == wanted:
        return 0
    print(PICTURE.name)
    if "--check" in arguments:
        return 1
    PICTURE.parent.mkdir(exist_ok=True)
    PICTURE.write_text(wanted, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
