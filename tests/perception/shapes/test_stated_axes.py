"""Up and unit that a file states go before the options, unless these override them."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from facetlog.perception.shapes.read_shape import read_shape
from facetlog.perception.shapes.shape_options import ShapeOptions

Z = (0.0, 0.0, 1.0)


def written(folder: Path, suffix: str, size: float) -> Path:
    path = folder / f"box{suffix}"
    trimesh.creation.box((0.4 * size, 0.3 * size, 0.25 * size)).export(path)
    return path


def test_up_and_unit_of_a_gltf_file_go_before_the_options(tmp_path: Path) -> None:
    path = written(tmp_path, ".glb", 1.0)
    scene = read_shape(path, ShapeOptions(Z, unit="mm"))
    assert scene.up == pytest.approx([0, 1, 0])
    assert np.ptp(scene.points, axis=0) == pytest.approx([0.4, 0.3, 0.25])
    (line,) = scene.warnings
    assert "up (y)" in line
    assert "--override-file" in line


def test_options_override_what_a_gltf_file_states(tmp_path: Path) -> None:
    path = written(tmp_path, ".glb", 1000.0)
    scene = read_shape(path, ShapeOptions(Z, unit="mm", override=True))
    assert scene.up == pytest.approx(Z)
    assert np.ptp(scene.points, axis=0) == pytest.approx([0.4, 0.3, 0.25])
    assert not scene.warnings


@pytest.mark.parametrize(("suffix", "unit"), [(".glb", None), (".ply", "m")])
@pytest.mark.parametrize(("size", "doubtful"), [(1000.0, True), (1.0, False), (0.001, True)])
def test_a_thing_of_implausible_size_asks_for_the_unit(
    tmp_path: Path, suffix: str, unit: str | None, size: float, doubtful: bool
) -> None:
    scene = read_shape(written(tmp_path, suffix, size), ShapeOptions(find_floor=True, unit=unit))
    assert any("--unit" in line for line in scene.warnings) == doubtful
