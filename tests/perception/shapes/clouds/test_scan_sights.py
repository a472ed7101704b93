"""Lines of sight of scans, from where their points were seen."""

import numpy as np

from facetlog.perception.reading.shape_files.clouds.point_cloud import Cloud
from facetlog.perception.shapes.clouds.cloud_scene import make_cloud_scene, make_scan_sights
from facetlog.perception.surfaces.scene_file import decode_scene, encode_scene
from facetlog.perception.types import FloatArray

EYE = np.array([0.0, 0.0, 5.0])


def wall(height: float, count: int = 30) -> FloatArray:
    x, y = np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count))
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, height)], axis=1)


def scan(points: FloatArray, *eyes: FloatArray) -> Cloud:
    seen_from = np.repeat(np.array(eyes), len(points) // len(eyes), axis=0)
    return Cloud.of(points, seen_from=seen_from)


def test_a_scan_without_a_place_has_no_lines_of_sight() -> None:
    assert make_scan_sights(Cloud.of(wall(0.0))) == ()
    unknown = np.full((900, 3), np.nan)
    assert make_scan_sights(Cloud.of(wall(0.0), seen_from=unknown)) == ()


def test_they_end_at_points_of_the_scan() -> None:
    (lines,) = make_scan_sights(scan(wall(0.0), EYE))
    assert lines.view is None
    np.testing.assert_allclose(lines.origin, EYE)
    apart = np.linalg.norm(lines.ends[:, None] - wall(0.0), axis=-1).min(axis=1)
    assert apart.max() < 1e-6
    assert 200 < len(lines.ends) <= 900


def test_what_lies_behind_other_points_is_left_out() -> None:
    both = np.concatenate([wall(0.0), wall(-1.0) * [1.2, 1.2, 1.0]])
    (lines,) = make_scan_sights(scan(both, EYE))
    assert (lines.ends[:, 2] > -0.5).mean() > 0.95


def test_each_place_has_its_own() -> None:
    both = np.concatenate([wall(0.0), wall(0.1)])
    one, other = make_scan_sights(scan(both, EYE, -EYE))
    assert {tuple(one.origin), tuple(other.origin)} == {tuple(EYE), tuple(-EYE)}


def test_the_scenes_file_keeps_them() -> None:
    scene = make_cloud_scene(scan(wall(0.0), EYE))
    assert len(scene.sights) == 1
    (kept,) = decode_scene(encode_scene(scene)).sights
    np.testing.assert_allclose(kept.ends, scene.sights[0].ends, atol=1e-3)
