"""The camera's place of an organised cloud, whatever frame the cloud was moved into."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from facetlog.perception.reading.shape_files.clouds.pcd_points import find_camera_centre
from facetlog.perception.types import FloatArray

HEIGHT, WIDTH, FOCAL = 24, 32, 30.0


def picture(seed: int, *, flat: bool = False) -> FloatArray:
    """Points (h, w, 3) of blocks before a wall, in the camera's frame, some of them missing."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([(columns - 15.5) / FOCAL, (rows - 11.5) / FOCAL, np.ones(rows.shape)], -1)
    deep = np.full(rows.shape, 3.0) if flat else 3.0 - 0.4 * (rows // 8) - 0.5 * (columns // 11)
    points: FloatArray = rays * deep[..., None]
    points[rng.random(rows.shape) < 0.3] = np.nan
    return points


@given(st.integers(0, 1000), st.floats(0.01, 1000.0))
def test_place_follows_the_cloud_into_any_frame_and_unit(seed: int, unit: float) -> None:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(rng=rng).as_matrix()
    place = rng.uniform(-20.0, 20.0, 3)
    moved = unit * (picture(seed) @ turn.T + place)
    found = find_camera_centre(moved)
    assert found is not None
    np.testing.assert_allclose(found, unit * place, atol=1e-3 * unit)


def test_what_is_no_picture_or_leaves_the_place_open_has_none() -> None:
    sound = picture(0)
    shuffled = np.random.default_rng(0).permutation(sound.reshape(-1, 3)).reshape(sound.shape)
    for points in (picture(0, flat=True), shuffled, sound[:2, :2], np.zeros_like(sound)):
        assert find_camera_centre(points) is None
