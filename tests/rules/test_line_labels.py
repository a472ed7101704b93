"""The catalogue of junctions is what solid corners show; labels of known solids are true."""

from collections import defaultdict
from collections.abc import Iterator
from itertools import product

import numpy as np
import pytest

from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.all_facts import facts_on_demand
from facetlog.perception.facts.part_facts import drawing_rows
from facetlog.perception.line_drawing import LineDrawing
from facetlog.perception.scene import Scene
from facetlog.perception.surfaces.exact_solids.polyhedra import (
    cuboid,
    l_block,
    table,
    wedge,
)
from tests.drawn_scenes import find_true_labels, viewed

from .test_plunit import BRIDGE

Octant = tuple[int, int, int]
OCTANTS: tuple[Octant, ...] = tuple(product((-1, 1), repeat=3))  # type: ignore[assignment]


@pytest.fixture(scope="module")
def base() -> Iterator[KnowledgeBase]:
    with KnowledgeBase() as base:
        yield base


def quarters(filled: set[Octant], axis: int, sign: int) -> dict[tuple[int, int], bool]:
    """Return which of the four octants round a half axis are filled, by their signs on the
    others."""
    found = {}
    for signs in product((-1, 1), repeat=2):
        octant = list(signs)
        octant.insert(axis, sign)
        found[signs[0], signs[1]] = tuple(octant) in filled
    return found


def label(filled: set[Octant], axis: int, sign: int, eye: Octant) -> tuple[str, int] | None:
    """Return the label of the half axis for an eye in that octant, and which other axis bounds its
    one seen face; None if nothing is seen there."""
    round_it = quarters(filled, axis, sign)
    side = tuple(eye[k] for k in range(3) if k != axis)
    if sum(round_it.values()) not in (1, 3) or round_it[side]:  # type: ignore[index]
        return None
    if sum(round_it.values()) == 3:
        return "concave", -1
    solid = next(signs for signs, is_filled in round_it.items() if is_filled)
    seen = [side[k] != solid[k] for k in range(2)]
    if all(seen):
        return "convex", -1
    return ("occluding", seen.index(False)) if any(seen) else None


def shown_by_corners() -> dict[str, set[tuple[str, ...]]]:
    """Return junctions that corners where three planes meet at right angles show to eyes in all
    empty octants.

    Of the eight octants some are solid, so that three edges meet (Huffman 1971).
    """
    rng = np.random.default_rng(5)
    found: dict[str, set[tuple[str, ...]]] = defaultdict(set)
    for chosen in product((False, True), repeat=8):
        filled = {octant for octant, is_filled in zip(OCTANTS, chosen, strict=True) if is_filled}
        halves = list(product(range(3), (-1, 1)))
        counts = [quarters(filled, *half) for half in halves]
        if any(q[1, 1] == q[-1, -1] != q[1, -1] == q[-1, 1] for q in counts):
            continue  # two bodies that touch along an edge
        if len(filled) % 2 == 0 or sum(sum(q.values()) in (1, 3) for q in counts) != 3:
            continue
        for eye in OCTANTS:
            if eye in filled:
                continue
            towards = np.array(eye) * rng.uniform(0.3, 1.0, 3)
            right = np.cross([0.0, 0.0, 1.0], towards)
            up = np.cross(towards, right)
            rays = []
            for axis, sign in halves:
                seen = label(filled, axis, sign, eye)
                if seen is None:
                    continue
                along = np.eye(3)[axis] * sign
                angle = np.arctan2(
                    along @ up / np.linalg.norm(up), along @ right / np.linalg.norm(right)
                )
                word = seen[0]
                if word == "occluding":
                    # the seen face reaches along the other axis, to the solid's side
                    others = [k for k in range(3) if k != axis]
                    solid = next(s for s, f in quarters(filled, axis, sign).items() if f)
                    reach = np.eye(3)[others[seen[1]]] * solid[seen[1]]
                    to_left = np.cross(along, reach) @ towards > 0
                    word = "in" if to_left else "out"
                rays.append((angle % (2 * np.pi), word))
            rays.sort()
            angles = np.array([angle for angle, _ in rays])
            gaps = np.append(angles[1:], angles[:1] + 2 * np.pi) - angles
            if len(rays) < 2:
                continue
            first = (int(np.argmax(gaps)) + 1) % len(rays)
            words = tuple(word for _, word in rays[first:] + rays[:first])
            kind = "l" if len(rays) == 2 else "arrow" if gaps.max() > np.pi else "fork"
            found[kind].add(words)
    return found


def test_the_catalogue_is_what_corners_of_three_planes_show(base: KnowledgeBase) -> None:
    source = BRIDGE.parents[2] / "rules" / "line_labels.pl"
    stated: dict[str, set[tuple[str, ...]]] = defaultdict(set)
    for line in source.read_text(encoding="utf-8").splitlines():
        if line.startswith("legal(") and line.endswith("]).") and "[" in line:
            kind, _, labels = line.removeprefix("legal(").partition(",")
            stated[kind].add(tuple(w.strip() for w in labels.strip(" []).").split(",")))
    shown = shown_by_corners()
    assert {kind: stated[kind] for kind in ("l", "arrow", "fork")} == shown
    assert {kind: len(found) for kind, found in stated.items()} == {
        "l": 6,
        "arrow": 3,
        "fork": 5,
        "t": 4,
    }


def labelled(base: KnowledgeBase, scene: Scene) -> dict[str, dict[str, str]]:
    """Return the label of each labelled edge, by view."""
    facts = [fact.row for fact in facts_on_demand(scene)]
    views = [("view", f"view{i}", name) for i, name in enumerate(scene.views, 1)]
    base.load_scene("drawn", [*views, *facts])
    found: dict[str, dict[str, str]] = defaultdict(dict)
    for view, edge, word in base.query("line_label(V, E, L)"):
        assert str(edge) not in found[str(view)], "an edge has one label in a view"
        found[str(view)][str(edge)] = str(word)
    return found


@pytest.mark.parametrize("build", [cuboid, wedge, l_block, table])
def test_labels_of_solids_are_what_their_faces_are_to_each_other(
    base: KnowledgeBase, build: object
) -> None:
    scene = viewed(build(), views=5)  # type: ignore[operator]
    truth = find_true_labels(scene)
    found = labelled(base, scene)
    assert list(base.query("impossible_drawing(V, J)")) == []
    wrong = [
        (view, edge, word, truth[view][edge])
        for view, words in found.items()
        for edge, word in words.items()
        if word != truth[view][edge]
    ]
    assert wrong == []
    known = sum(len(words) for words in found.values())
    assert known >= 0.9 * sum(len(words) for words in truth.values())


def possible(base: KnowledgeBase, points: object, lines: object) -> bool:
    """Return whether a drawing has a labelling when nothing is known of what is behind it."""
    drawing = LineDrawing.between(np.array(points, dtype=np.float64), np.array(lines))
    names = [f"x{i}" for i in range(1, len(drawing.points) + 1)]
    rows = drawing_rows("view1", drawing, names, [f"e{i}" for i in range(1, 99)])
    facts = [(name, *row) for name, found in rows.items() for row in found]
    base.load_scene("drawing", [("view", "view1", "by hand"), *facts])
    return not list(base.query("impossible_drawing(V, J)", scenes=("drawing",)))


CUBE = (
    [[0, 0], [2, -1], [4, 0], [4, 2], [2, 3], [0, 2], [2, 1]],
    [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [6, 0], [6, 2], [6, 4]],
)


def test_a_cube_can_be_and_one_that_lacks_a_line_cannot(base: KnowledgeBase) -> None:
    points, lines = CUBE
    assert possible(base, points, lines)
    for missing in (6, 7, 8):
        assert not possible(base, points, lines[:missing] + lines[missing + 1 :])


def test_huffmans_block_whose_notch_runs_out_of_it_cannot_be(base: KnowledgeBase) -> None:
    # A slab seen from above: where its right end is cut off, the upper edge becomes the lower one.
    points = [[0, 0], [6, 0], [7, 1], [1, 1], [1, 2], [6, 2]]
    honest = [[0, 1], [1, 2], [2, 3], [3, 0], [3, 4], [0, 6], [6, 4], [4, 5], [5, 2]]
    points = [[0, 0], [6, 0], [7, 1], [1, 1], [1, 2], [7, 2], [0, 1]]
    assert possible(base, points, honest)
    twisted = [[0, 1], [1, 5], [2, 3], [3, 0], [3, 4], [0, 6], [6, 4], [4, 5], [5, 2]]
    assert not possible(base, points, twisted)
