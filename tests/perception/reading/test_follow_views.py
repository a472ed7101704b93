"""A folder that is being filled: views as they become whole, and what never did."""

import json

import cv2
import numpy as np
import pytest

from facetlog.errors import InputError
from facetlog.perception.reading.follow_views import FollowedViews
from tests.perception.reading.videos import write_video

CAMERA = {"fl_x": 60, "fl_y": 60, "cx": 32, "cy": 24, "w": 64, "h": 48}
PICTURE = np.tile(np.linspace(60, 120, 64), (48, 1)).astype(np.uint8)


class Time:
    """A clock that waiting moves on; `then` runs what happens to the folder meanwhile."""

    def __init__(self, *then):
        self.now, self.then = 0.0, list(then)

    def wait(self, seconds):
        self.now += seconds
        if self.then:
            self.then.pop(0)()


def _poses(folder, count, **more):
    frames = []
    for i in range(count):
        matrix = np.eye(4)
        matrix[0, 3] = i
        frames.append({"file_path": f"{i}.png", "transform_matrix": matrix.tolist()})
    (folder / "transforms.json").write_text(json.dumps({**CAMERA, **more, "frames": frames}))


def _picture(folder, i):
    cv2.imwrite(str(folder / f"{i}.png"), PICTURE)


def _followed(folder, time, timeout=1.0):
    return FollowedViews(folder, timeout=timeout, clock=lambda: time.now, wait=time.wait)


def test_views_come_as_pictures_and_poses_do(tmp_path):
    _poses(tmp_path, 1)
    _picture(tmp_path, 0)
    time = Time(lambda: _poses(tmp_path, 3, unit="m"), lambda: _picture(tmp_path, 2))
    time.then.append(lambda: _picture(tmp_path, 1))
    source = _followed(tmp_path, time)
    assert [view.name for view in source] == ["0.png", "2.png", "1.png"]
    assert source.metric
    assert source.ended == "no new view came for 1 s"
    assert source.problems == ()


def test_a_picture_that_stays_damaged_or_missing_is_named(tmp_path):
    _poses(tmp_path, 3)
    _picture(tmp_path, 0)
    (tmp_path / "1.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    source = _followed(tmp_path, Time())
    assert [view.name for view in source] == ["0.png"]
    assert len(source.problems) == 2
    assert "1.png is cut off" in source.problems[0]
    assert "2.png is missing" in source.problems[1]


def test_a_poses_file_that_is_being_written_is_waited_for(tmp_path):
    _picture(tmp_path, 0)
    (tmp_path / "transforms.json").write_text('{"frames": [')
    time = Time(lambda: None, lambda: _poses(tmp_path, 1))
    assert [view.name for view in _followed(tmp_path, time)] == ["0.png"]


def test_a_poses_file_that_breaks_later_leaves_what_was_read(tmp_path):
    _poses(tmp_path, 2)
    _picture(tmp_path, 0)
    time = Time(lambda: (tmp_path / "transforms.json").write_text("{"))
    time.then.append(lambda: _picture(tmp_path, 1))
    source = _followed(tmp_path, time)
    assert [view.name for view in source] == ["0.png", "1.png"]
    assert "transforms.json" in source.problems[0]


def test_a_frame_without_pose_is_named_and_left_out_alone(tmp_path):
    _poses(tmp_path, 3)
    for i in range(3):
        _picture(tmp_path, i)
    document = json.loads((tmp_path / "transforms.json").read_text())
    del document["frames"][1]["transform_matrix"]
    (tmp_path / "transforms.json").write_text(json.dumps(document))
    source = _followed(tmp_path, Time())
    assert next(iter(source)).name == "0.png"
    assert "frame 2 ('1.png'): transform_matrix is missing" in source.problems[0]
    assert [view.name for view in source] == ["2.png"]
    assert "frame 2 ('1.png'): transform_matrix is missing" in source.problems[0]


def test_a_frame_of_a_video_is_the_one_of_its_number(tmp_path):
    greys = [np.full((48, 64), 30 * i + 20, np.uint8) for i in range(6)]
    write_video(tmp_path / "walk.avi", greys)
    frames = [
        {"frame": n, "transform_matrix": np.eye(4).tolist() if n != 4 else None} for n in (5, 1, 4)
    ]
    document = {**CAMERA, "video": "walk.avi", "frames": frames}
    (tmp_path / "transforms.json").write_text(json.dumps(document))
    views = list(_followed(tmp_path, Time()))
    assert [v.name for v in views] == ["walk.avi#5", "walk.avi#1"]
    assert [round(float(v.image.mean()), -1) for v in views] == [170, 50]


def test_a_folder_that_stays_empty_is_one_line(tmp_path):
    time = Time()
    with pytest.raises(InputError, match="has no poses"):
        list(_followed(tmp_path, time))
    assert time.now >= 1.0
