"""The plainest of several outlines that are nearly equal."""

import numpy as np
import pytest

from facetlog.perception.detection.line_front_end.candidates import Candidate, penalty, simplest
from facetlog.perception.detection.line_front_end.evidence.face_evidence import FaceEvidence
from facetlog.perception.types import FloatArray

PIXEL = 0.002
UP = np.array([0.0, 0.0, 1.0])


def candidate(flat: list[tuple[float, float]], score: float, plane: int = 1) -> Candidate:
    corners = np.column_stack([np.array(flat), np.zeros(len(flat))])
    sides = score + penalty(corners, moved=False)
    evidence = FaceEvidence(
        np.ones(9), 1.0, sides, 1.0, np.ones(4, dtype=bool), 1.0, np.zeros((9, 3))
    )
    return Candidate(corners, UP, evidence, plane, moved=False, after=0)


def as_it_was(corners: FloatArray, instead: Candidate) -> Candidate | None:
    """A judge who finds no face in fewer corners, and what was found before in the same."""
    return instead if len(corners) == len(instead.corners) else None


RECTANGLE = [(0.0, 0.0), (0.4, 0.0), (0.4, 0.2), (0.0, 0.2)]
SLANTED = [(0.0, 0.0), (0.4, 0.0), (0.407, 0.2), (0.007, 0.2)]


@pytest.mark.parametrize(
    ("score", "chosen"), [(130.0, RECTANGLE), (100.0, SLANTED)], ids=["as good", "worse"]
)
def test_a_right_angled_outline_is_preferred_to_a_slanted_one_that_is_hardly_better(
    score: float, chosen: list[tuple[float, float]]
) -> None:
    found = simplest(candidate(SLANTED, 145.0), [candidate(RECTANGLE, score)], PIXEL, as_it_was)
    assert found.corners[:, :2] == pytest.approx(np.array(chosen))


def test_a_slant_below_the_resolution_is_none() -> None:
    nearly = [(0.0, 0.0), (0.4, 0.0), (0.401, 0.2), (0.001, 0.2)]
    found = simplest(candidate(nearly, 145.0), [candidate(RECTANGLE, 140.0)], PIXEL, as_it_was)
    assert found.corners[:, :2] == pytest.approx(np.array(nearly))


def test_a_rectangle_of_another_plane_takes_no_place() -> None:
    other = candidate(RECTANGLE, 140.0, plane=2)
    found = simplest(candidate(SLANTED, 145.0), [other], PIXEL, as_it_was)
    assert found.corners[:, :2] == pytest.approx(np.array(SLANTED))
