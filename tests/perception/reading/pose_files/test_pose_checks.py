"""Numbers that no camera has: views are plausible, or one line names file and frame."""

import copy
import json
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facetlog.errors import CalibrationError, FacetlogError
from facetlog.perception.reading.read_views import ViewSet, read_views
from tests.perception.reading.view_folders import (
    colmap_rows,
    transforms,
    write_colmap_text,
    write_pictures,
    write_transforms,
)

HOSTILE = st.one_of(
    st.sampled_from(
        [0, -1, 1e-320, 1e-200, 1e-5, 2, 1e5, 1e12, 1e16, 1e200, 1e308, 10**400, -(10**400)]
    ),
    st.floats(allow_nan=True, allow_infinity=True),
    st.integers(-(10**320), 10**320),
    st.booleans(),
    st.none(),
    st.sampled_from(["", "x", "../images/0.png", "OPENCV_FISHEYE"]),
    st.lists(st.integers(), max_size=4),
    st.dictionaries(st.sampled_from(["file_path", "transform_matrix"]), st.none()),
)


def whole() -> dict[str, Any]:
    """A document with all that has numbers."""
    document = transforms()
    document |= {"up": [0.0, 1.0, 0.0], "k1": 0.01, "k2": 0.0, "k3": 0.0, "k4": 0.0}
    document |= {"p1": 0.0, "p2": 0.0}
    for frame in document["frames"]:
        frame["covariance"] = (1e-4 * np.eye(6)).tolist()
    return document


def places(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the keys that lead to each value of a document."""
    keys = value if isinstance(value, dict) else range(len(value) if isinstance(value, list) else 0)
    below = [place for key in keys for place in places(value[key], (*at, key))]
    return [at, *below] if at else below


PLACES = places(whole())


def check_plausible(found: ViewSet) -> None:
    for view in found.views:
        camera = view.camera
        assert np.isfinite([camera.fx, camera.fy, camera.cx, camera.cy]).all()
        assert 1 < np.degrees(2 * np.arctan(camera.width / 2 / camera.fx)) < 176
        assert np.abs(view.pose.centre).max() <= 1e12
        np.testing.assert_allclose(view.pose.rotation @ view.pose.rotation.T, np.eye(3), atol=1e-9)
        assert np.isfinite(view.projection).all()
        assert view.pose_cov is None or np.abs(view.pose_cov).max() <= 1e24
    assert found.up is None or np.linalg.norm(found.up) == pytest.approx(1.0)


def read_or_refuse(folder: Path) -> str:
    """Read plausible views without a warning, or return the one line of the error."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            check_plausible(read_views(folder))
        except FacetlogError as exc:
            line = str(exc)
        else:
            return ""
    assert "\n" not in line
    return line


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_transforms(tmp_path_factory.mktemp("hostile"), whole())


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.tuples(st.sampled_from(PLACES), HOSTILE), min_size=1, max_size=3))
def test_any_numbers_give_plausible_views_or_one_line(
    folder: Path, changes: list[tuple[tuple[Any, ...], Any]]
) -> None:
    document = copy.deepcopy(whole())
    for keys, value in changes:
        inside: Any = document
        with suppress(TypeError, LookupError):  # of places within what was replaced
            for key in keys[:-1]:
                inside = inside[key]
            inside[keys[-1]] = value
    (folder / "transforms.json").write_text(json.dumps(document))
    line = read_or_refuse(folder)
    assert not line or "transforms.json" in line


@pytest.mark.parametrize("places", [[0, 1e-200, 2e-200], [0, 1e200, 2e200], [1e6, 1e6, 1e6]])
def test_worlds_of_no_size_are_refused(places: list[float], tmp_path: Path) -> None:
    document = transforms()
    for frame, x in zip(document["frames"], places, strict=True):
        frame["transform_matrix"][0][3] = x
    with pytest.raises(CalibrationError, match=r"transforms\.json"):
        read_views(write_transforms(tmp_path, document))


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"fl_x": None, "fl_y": None, "cx": None, "cy": None}, "no intrinsics"),
        ({"cx": None}, "no cx"),
        ({"fl_x": -1}, "above 0"),
        ({"fl_x": 10**400}, "finite"),
        ({"cx": True}, "finite"),
        ({"k1": "0.1"}, "finite"),
        ({"w": 640.5}, "whole"),
        ({"camera_model": "EQUIRECTANGULAR"}, "PINHOLE"),
        ({"camera_model": ["OPENCV"]}, "PINHOLE"),
        ({"k1": -1e9}, "folds"),
        ({"fl_x": 1e-320}, r"frame 1 \('images/0.png'\): .* view angle"),
        ({"fl_x": 1.04, "fl_y": 1.06}, "a share of the picture .* = 49.92 px are 51 degrees"),
        ({"fl_x": 1e7, "fl_y": 1e7}, "view angle"),
        ({"cx": 1e5}, "principal point"),
        ({"fl_y": 5e4}, "times apart"),
        ({"w": None, "h": None, "cx": 49.0, "cy": 33.0}, "of a camera for pictures of 97 x 65"),
        ({"fl_x": 30.0, "fl_y": 30.0, "k1": 2}, r"distortion \(2, .* moves the picture's corners"),
        ({"up": [0, 0, 0.0]}, "up is not three numbers"),
        ({"up": [1, 2]}, "up is not three numbers"),
        ({"up": "z"}, "up is not three numbers"),
        ({"up": [0, 0, 10**400]}, "up is not three numbers"),
        ({"is_fisheye": "yes"}, "is_fisheye is 'yes': give true or false"),
        ({"is_fisheye": True}, "is_fisheye is true, yet camera_model"),
    ],
)
def test_numbers_of_no_camera_are_named(change: dict[str, Any], line: str, tmp_path: Path) -> None:
    with pytest.raises(CalibrationError, match=line) as caught:
        read_views(write_transforms(tmp_path, transforms() | change))
    assert str(tmp_path / "transforms.json") in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "rows", "line"),
    [
        ("transform_matrix", np.diag([2.0, 2.0, 2.0, 1.0]).tolist(), "rotation"),
        ("transform_matrix", np.diag([-1.0, 1.0, 1.0, 1.0]).tolist(), "rotation"),
        ("transform_matrix", np.diag([1e308, 1e308, 1e308, 1.0]).tolist(), "rotation"),
        ("transform_matrix", np.diag([1.0, 1.0, 1.0, 2.0]).tolist(), "0 0 0 1"),
        ("transform_matrix", [[float("nan")] * 4] * 4, "finite"),
        ("transform_matrix", [[10**400] * 4] * 4, "finite"),
        ("transform_matrix", None, "missing"),
        ("covariance", (1e308 * np.eye(6)).tolist(), "the covariance has"),
        ("covariance", [[1.0] * 6] * 5, "covariance"),
        ("covariance", np.triu(np.ones((6, 6))).tolist(), "symmetric"),
        ("covariance", (-np.eye(6)).tolist(), "positive"),
        ("covariance", "six", "covariance"),
    ],
)
def test_matrices_of_no_pose_are_named(key: str, rows: object, line: str, tmp_path: Path) -> None:
    document = whole()
    document["frames"][1][key] = rows
    with pytest.raises(CalibrationError, match=rf"frame 2 \('images/1.png'\): .*{line}"):
        read_views(write_transforms(tmp_path, document))


@pytest.mark.parametrize("change", [(0, 1e200), (4, 1e30)])
def test_colmaps_numbers_are_checked_as_well(change: tuple[int, float], tmp_path: Path) -> None:
    rows = colmap_rows()
    at, value = change
    rows[1][1][at] = value
    write_colmap_text(tmp_path / "sparse", rows)
    write_pictures(tmp_path / "images")
    line = read_or_refuse(tmp_path)
    assert not line or "1.png" in line
