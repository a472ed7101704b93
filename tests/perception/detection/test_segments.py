"""Straight segments of drawn pictures."""

import numpy as np
import pytest

from facetlog.perception.detection.segments import detect_segments
from facetlog.perception.types import FloatArray, Image
from tests.perception.detection.drawings import flat, polygon, with_noise

QUADRANGLE = np.array([[60.0, 50.0], [250.0, 70.0], [230.0, 190.0], [80.0, 160.0]])


def found_share(segments: FloatArray, start: FloatArray, end: FloatArray) -> float:
    """Share of a drawn line that lies within 1.5 px of segments as parallel as 3 degrees."""
    places = start + np.linspace(0.05, 0.95, 50)[:, None] * (end - start)
    unit = (end - start) / np.linalg.norm(end - start)
    found = np.zeros(len(places), np.bool_)
    for u0, v0, u1, v1 in segments:
        run = np.array([u1 - u0, v1 - v0])
        reach = np.linalg.norm(run)
        run = run / reach
        if abs(run @ unit) < np.cos(np.radians(3.0)):
            continue
        t = (places - [u0, v0]) @ run
        off = np.abs((places - [u0, v0]) @ [-run[1], run[0]])
        found |= (off < 1.5) & (t > -1) & (t < reach + 1)
    return float(found.mean())


def shares(image: Image) -> list[float]:
    segments = detect_segments(image)
    following = np.roll(QUADRANGLE, -1, axis=0)
    return [found_share(segments, a, b) for a, b in zip(QUADRANGLE, following, strict=True)]


@pytest.mark.parametrize("sd", [0.0, 5.0])
def test_drawn_sides_are_found(sd: float) -> None:
    assert min(shares(with_noise(polygon(QUADRANGLE), sd))) > 0.9


@pytest.mark.parametrize(("sd", "contrast"), [(5.0, 10.0), (20.0, 60.0)])
def test_faint_sides_of_a_noisy_picture_are_found(sd: float, contrast: float) -> None:
    faint = polygon(QUADRANGLE, low=100, high=100 + contrast)
    for seed in range(2):
        assert np.mean(shares(with_noise(faint, sd, seed))) > 0.75


@pytest.mark.parametrize(("low", "high"), [(200.0, 250.0), (5.0, 40.0)])
def test_bright_and_dark_pictures_are_treated_alike(low: float, high: float) -> None:
    assert min(shares(polygon(QUADRANGLE, low=low, high=high))) > 0.9


@pytest.mark.parametrize("sd", [0.0, 15.0])
def test_an_empty_picture_has_no_segments(sd: float) -> None:
    assert detect_segments(with_noise(flat(), sd)).shape == (0, 4)
