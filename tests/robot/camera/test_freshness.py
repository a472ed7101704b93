"""Which frame counts as new; times are the test's own."""

import threading

import numpy as np

from facetlog.perception.types import Image
from facetlog.robot.camera.source import LatestFrame


def _image(value: int) -> Image:
    return np.full((2, 3), value, np.uint8)


def test_a_frame_counts_only_if_it_was_surely_exposed_after() -> None:
    newest = LatestFrame("c", latency=0.3, noisy=True)
    newest.put(_image(1), arrived=10.2)
    assert newest.taken(after=10.0) is None
    newest.put(_image(2), arrived=10.31)
    frame = newest.taken(after=10.0)
    assert frame is not None
    assert (frame.image[0, 0], frame.arrived) == (2, 10.31)


def test_a_frame_like_the_one_before_is_no_new_exposure_of_a_noisy_camera() -> None:
    newest = LatestFrame("c", latency=0.0, noisy=True)
    newest.put(_image(1), 1.0)
    newest.put(_image(1), 2.0)
    assert newest.taken(1.5) is None
    newest.put(_image(2), 3.0)
    assert newest.taken(1.5) is not None


def test_a_silence_is_said_once_with_the_next_frame_that_is_taken() -> None:
    newest = LatestFrame("c", latency=0.5, noisy=True)
    newest.put(_image(1), 1.0)
    newest.put(_image(2), 8.0, silent=7.0)
    assert newest.taken(after=7.9) is None
    newest.put(_image(3), 8.5)
    frame = newest.taken(after=7.9)
    assert frame is not None
    assert (frame.arrived, frame.silent) == (8.5, 7.0)
    newest.put(_image(4), 9.5)
    after = newest.taken(after=8.9)
    assert after is not None
    assert after.silent == 0.0


def test_a_waiter_gets_the_frame_that_comes_meanwhile() -> None:
    newest = LatestFrame("c", latency=0.0, noisy=True)
    timer = threading.Timer(0.05, newest.put, (_image(1), 5.0))
    timer.start()
    assert newest.shot(after=4.0, timeout=30.0).arrived == 5.0
    timer.join()


def test_a_frozen_camera_is_reported_as_such() -> None:
    newest = LatestFrame("hall", latency=0.0, noisy=True)
    newest.put(_image(1), 1.0)
    before = newest.count
    for at in (2.0, 3.0, 4.0):
        newest.put(_image(1), at)
    said = str(newest.complaint(before, 2.0))
    assert "frozen: its last 4 pictures are the same to the pixel" in said


def test_frames_that_may_be_old_are_reported_as_such() -> None:
    newest = LatestFrame("hall", latency=0.5, noisy=True)
    newest.put(_image(1), 1.0)
    newest.put(_image(2), 1.2)
    assert "none of them surely taken after the robot stood" in str(newest.complaint(1, 0.2))
