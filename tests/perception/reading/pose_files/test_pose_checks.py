"""Numbers that no camera has: views are plausible, or one line names file and frame."""

import copy
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from facetlog.errors import FacetlogError
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
    """The keys that lead to each number of a document."""
    if isinstance(value, dict):
        return [place for key in value for place in places(value[key], (*at, key))]
    if isinstance(value, list):
        return [place for key, each in enumerate(value) for place in places(each, (*at, key))]
    return [] if isinstance(value, str) else [at]


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
        for key in keys[:-1]:
            inside = inside[key]
        inside[keys[-1]] = value
    (folder / "transforms.json").write_text(json.dumps(document))
    line = read_or_refuse(folder)
    assert not line or "transforms.json" in line


@pytest.mark.parametrize("factor", [1e-200, 1e200])
def test_worlds_of_no_size_are_refused(factor: float, tmp_path: Path) -> None:
    document = transforms()
    for frame in document["frames"]:
        for row in frame["transform_matrix"][:3]:
            row[3] *= factor
    with pytest.raises(FacetlogError, match=r"transforms\.json"):
        read_views(write_transforms(tmp_path, document))


@pytest.mark.parametrize(
    ("change", "line"),
    [
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
    ],
)
def test_numbers_of_no_camera_are_named(change: dict[str, Any], line: str, tmp_path: Path) -> None:
    with pytest.raises(FacetlogError, match=line):
        read_views(write_transforms(tmp_path, transforms() | change))


def test_a_covariance_of_no_size_is_named(tmp_path: Path) -> None:
    document = whole()
    document["frames"][1]["covariance"] = (1e308 * np.eye(6)).tolist()
    with pytest.raises(FacetlogError, match=r"frame 2 \('images/1.png'\): the covariance has"):
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
