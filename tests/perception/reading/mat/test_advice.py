"""Advice on pictures of a mat: the missing side, height, distance; none where pictures suffice."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from facetlog.perception.reading.exif import TakenWith
from facetlog.perception.reading.image_sources import Shot
from facetlog.perception.reading.mat.advice import advice
from facetlog.perception.reading.mat.fit import FittedCamera, FittedPose
from facetlog.perception.reading.mat.mat_poses import MatPicture, PlacedPicture
from facetlog.perception.reading.mat.mats import MATS, Sighting
from facetlog.robot.tour import make_pose_looking_at

CAMERA = FittedCamera(1000.0, np.array([640.0, 480.0]), np.zeros(5), np.eye(8))


def placed(
    angle: float, height: float, *, square_px: float = 40.0, corners: int = 60
) -> PlacedPicture:
    """A picture from an angle and a height, in degrees, half a metre away."""
    a, h = np.radians([angle, height])
    centre = 0.5 * np.array([np.cos(h) * np.cos(a), np.cos(h) * np.sin(a), np.sin(h)])
    inside = np.ones(corners, dtype=np.bool_)
    pose = FittedPose(make_pose_looking_at(centre, [0, 0, 0]), np.eye(6), 0.2, inside)
    seen = Sighting(MATS[0], np.arange(corners), np.zeros((corners, 2)), 0.5, square_px)
    return PlacedPicture(
        MatPicture(Shot(Path("a.jpg")), (1280, 960), TakenWith(), seen), CAMERA, pose
    )


def round_it(
    angles: Sequence[float], heights: Sequence[float] = (30.0, 50.0), **how: float
) -> list[PlacedPicture]:
    return [
        placed(angle, heights[k % len(heights)], **how)  # type: ignore[arg-type]
        for k, angle in enumerate(angles)
    ]


ALL_ROUND = tuple(range(0, 360, 24))


def test_pictures_from_all_round_suffice() -> None:
    assert advice(round_it(ALL_ROUND)) == ()


@pytest.mark.parametrize(
    ("middle", "side"),
    [
        (0, "the right"),
        (90, "the far side, across from the words"),
        (180, "the left"),
        (270, "the near side, where the words are"),
        (225, "the near left corner"),
    ],
)
def test_the_side_that_is_missing_is_named(middle: float, side: str) -> None:
    seen = [middle + 60 + 20 * k for k in range(13)]
    assert advice(round_it(seen)) == (f"from one side only: take some from {side}",)


@pytest.mark.parametrize(
    ("pictures", "line"),
    [
        (round_it(range(0, 360, 60)), "too few: 6 can be used, take 6 more"),
        (round_it(ALL_ROUND, (10, 18)), "too flat: hold the camera higher"),
        (round_it(ALL_ROUND, (70, 85)), "too steep: hold the camera lower"),
        (round_it(ALL_ROUND, (40, 42)), "all from one height"),
        (round_it(ALL_ROUND, square_px=12.0), "too far: in 15 pictures"),
        (round_it(ALL_ROUND, corners=12), "the mat is hidden: in 15 pictures"),
    ],
)
def test_each_shortcoming_has_its_line(pictures: list[PlacedPicture], line: str) -> None:
    (found,) = advice(pictures)
    assert found.startswith(line)
