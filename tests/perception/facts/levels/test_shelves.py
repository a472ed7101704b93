"""How many shelves lie beneath a level, and how many may, where nobody looked."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.facts.all_facts import FactRows, fact_rows
from facetlog.perception.facts.fact_schema import Value
from facetlog.perception.facts.levels.levels import shelves_below
from facetlog.perception.facts.scene_memo import SceneMemo
from facetlog.perception.space.space import Space, State
from facetlog.perception.surfaces.exact_solids.builders import build
from tests.perception.pieces.test_openings import of_boxes

KINDS = {"shelves_below", "shelves_unseen", "elevation", "upward", "top_of"}


def _bounds(rows: FactRows) -> dict[Value, tuple[Value, Value]]:
    """The fewest and the most shelves by face."""
    bounds = {face: (fewest, most) for face, fewest, most in rows["shelves_unseen"]}
    return {face: bounds.get(face, (count, count)) for face, count in rows["shelves_below"]}


def _shelves(boards: int, height: float = 1.8) -> dict[float, tuple[Value, Value]]:
    """Fewest and most beneath each level of a shelf, by its height."""
    rows = fact_rows(build("shelf", {"boards": boards, "height": height}), KINDS)
    upward = {face for (face,) in rows["upward"]}
    heights = {face: round(h, 2) for face, h, _ in rows["elevation"] if face in upward}
    return {heights[f]: counts for f, counts in _bounds(rows).items() if f in heights}


@pytest.mark.parametrize("boards", [2, 3, 5, 7])
def test_beneath_each_board_lie_those_that_are_lower(boards: int) -> None:
    found = sorted(set(_shelves(boards).items()))
    inner = [counts for height, counts in found if height < 1.795]
    assert inner == [(i, i) for i in range(boards)]


@settings(max_examples=20)
@given(st.lists(st.floats(0.15, 0.4), min_size=1, max_size=5), st.floats(0.02, 0.04), st.booleans())
@pytest.mark.slow
def test_boards_are_counted_however_they_are_spaced(
    rooms: list[float], thickness: float, rungs: bool
) -> None:
    boxes, height = [((0.0, 0.0, 0.0), (0.8, 0.3, thickness))], thickness
    for room in rooms:
        if rungs:  # what is narrow is no shelf
            middle = height + room / 2.0
            boxes.append(((0.0, 0.0, middle), (0.8, 0.06, middle + thickness)))
        height += room + thickness
        boxes.append(((0.0, 0.0, height - thickness), (0.8, 0.3, height)))
    sides = [((x, 0.0, 0.0), (x + 0.02, 0.3, height)) for x in (-0.02, 0.8)]
    rows = fact_rows(of_boxes(*boxes, *sides), KINDS)
    heights = {face: each for face, each, _ in rows["elevation"]}
    bounds = _bounds(rows)
    topmost = max(bounds, key=heights.__getitem__)
    assert bounds[topmost] == (len(rooms), len(rooms))


def _space(name: str) -> tuple[Space, float]:
    memo = SceneMemo.of(build(name, {}))
    (filled,) = memo.filled.values()
    return filled.space, max(float(face.middle[2]) for face in filled.surface.faces)


def test_unseen_room_may_hold_shelves_and_what_was_seen_stays() -> None:
    space, top = _space("shelf")
    assert shelves_below(space, top) == (4, 4)
    cells = space.cells.copy()
    layers = cells.shape[2]
    # between the third board and the fourth: as many as find room there
    unseen = slice(layers // 2 + 3, 3 * layers // 4 - 3)
    cells[:, :, unseen] = np.where(
        cells[:, :, unseen] == State.FREE, State.UNSEEN, cells[:, :, unseen]
    )
    fewest, most = shelves_below(replace(space, cells=cells), top) or (0, 0)
    assert fewest == 4
    assert 4 < most <= 4 + (unseen.stop - unseen.start) // 2 + 1
    # half of a plan and more may be a shelf, less not
    narrow = space.cells.copy()
    third = slice(0, narrow.shape[1] // 3)
    narrow[:, third] = np.where(narrow[:, third] == State.FREE, State.UNSEEN, narrow[:, third])
    assert shelves_below(replace(space, cells=narrow), top) == (4, 4)
