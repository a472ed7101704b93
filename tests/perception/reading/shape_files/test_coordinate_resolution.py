"""Shapes far from the origin: refused where rounding has changed them, kept where it has not."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from facetlog.errors import InputError
from facetlog.perception.reading.shape_files.clouds.cloud_files import read_cloud
from facetlog.perception.reading.shape_files.coordinate_resolution import (
    check_degrees,
    check_resolution,
)
from facetlog.perception.reading.shape_files.meshes.mesh_files import read_mesh

CORNERS = np.array([[x, y, z] for x in (0.0, 0.3) for y in (0.0, 0.2) for z in (0.0, 0.1)])


@given(st.floats(-9.0, 30.0), st.sampled_from([np.float32, np.float64]))
def test_what_is_at_the_origin_passes_whatever_its_unit(power: float, kind: type) -> None:
    check_resolution((CORNERS * 10.0**power).astype(kind).astype(np.float64), "a.ply")


@pytest.mark.parametrize("far", [1e7, 1e9, 1e12])
def test_32_bit_numbers_far_away_are_refused_and_64_bit_ones_kept(far: float) -> None:
    moved = CORNERS + np.array([far, 0.0, 0.0])
    check_resolution(moved, "a.obj")
    with pytest.raises(InputError, match=r"a\.ply: lies .* from the origin, .* move it to"):
        check_resolution(moved.astype(np.float32).astype(np.float64), "a.ply")


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_a_survey_in_kilometres_passes(kind: type) -> None:
    survey = 100.0 * CORNERS + np.array([4.5e5, 5.4e6, 300.0])
    check_resolution(survey.astype(kind).astype(np.float64), "a.las")


def test_meshes_and_clouds_are_judged_as_they_are_read(tmp_path: Path) -> None:
    block = trimesh.creation.box((0.3, 0.2, 0.1))
    block.apply_translation((1e9, 0.0, 0.0))
    block.export(tmp_path / "mesh.ply")
    with pytest.raises(InputError, match=r"mesh\.ply: lies 1e\+09 from the origin"):
        read_mesh(tmp_path / "mesh.ply")
    trimesh.PointCloud(block.sample(500).astype(np.float32)).export(tmp_path / "cloud.ply")
    with pytest.raises(InputError, match=r"cloud\.ply: lies 1e\+09 from the origin"):
        read_cloud(tmp_path / "cloud.ply")


@pytest.mark.parametrize("unit", [0.001, 1.0, 1000.0])
@pytest.mark.parametrize("place", [(8.5, 47.3), (-122.4, 37.8), (47.3, 8.5)])
def test_degrees_of_longitude_and_latitude_are_refused(
    place: tuple[float, float], unit: float
) -> None:
    scale = np.array([unit / 80_000.0, unit / 111_000.0, unit])
    with pytest.raises(InputError, match="are degrees"):
        check_degrees(CORNERS * scale + [*place, 400.0], "a.csv")


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (1.0, 1.0, 0.001), (0.02, 0.02, 20.0)])
def test_sheets_and_poles_in_metres_pass_anywhere(scale: tuple[float, float, float]) -> None:
    for place in ((0.0, 0.0, 0.0), (8.5, 47.3, 400.0), (2_600_000.0, 1_200_000.0, 400.0)):
        check_degrees(CORNERS * scale + place, "a.csv")
