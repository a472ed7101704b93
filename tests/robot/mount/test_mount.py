"""The mount's file."""

import math
from dataclasses import fields, replace
from pathlib import Path

import pytest

from facetlog.errors import CalibrationError, InputError
from facetlog.robot.mount.mount import (
    DEFAULT_MOUNT,
    PARAMETERS,
    Mount,
    format_mount,
    read_mount,
)


def test_the_names_of_the_numbers_are_those_of_the_fields_in_their_order() -> None:
    assert tuple(f.name for f in fields(Mount)) == (*PARAMETERS, "sds")


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    values = tuple(0.01 * (i + 1) for i in range(len(PARAMETERS)))
    mount = replace(Mount().replace_values(values), sds=tuple(v / 10 for v in values))
    path = tmp_path / "mount.toml"
    path.write_text(format_mount(mount, remarks=("by hand",)), encoding="utf-8")
    again = read_mount(path)
    assert again.values == pytest.approx(values, abs=1e-6)
    assert again.sds == pytest.approx(mount.sds, abs=1e-6)
    assert "# by hand" in path.read_text(encoding="utf-8")


def test_angles_are_in_degrees_and_what_is_left_out_is_the_papers_mast(tmp_path: Path) -> None:
    path = tmp_path / "mount.toml"
    path.write_text("[mount]\nx = 0.1\npitch_deg = 2\n", encoding="utf-8")
    mount = read_mount(path)
    assert (mount.x, mount.pitch) == (0.1, pytest.approx(math.radians(2)))
    assert mount.z == DEFAULT_MOUNT.z == pytest.approx(0.7239)
    assert mount.sds == DEFAULT_MOUNT.sds


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("[mount]\nheight = 1", InputError, "there is no 'height'"),
        ("[mounts]\nx = 1", InputError, "there is no table 'mounts'"),
        ("x = 1", InputError, "there is no table 'x'"),
        ("mount = 3", InputError, r"\[mount\]: is no table"),
        ("[mount]\nx = '1'", CalibrationError, "x is '1': give a number"),
        ("[mount]\nx = true", CalibrationError, "x is True: give a number"),
        ("[mount]\nyaw_deg = nan", CalibrationError, "yaw_deg is nan: give a finite number"),
        ("[sd]\nx = -1", CalibrationError, "a standard deviation is not negative"),
        ("[mount", InputError, "not TOML"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(
    tmp_path: Path, text: str, kind: type[Exception], said: str
) -> None:
    path = tmp_path / "mount.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(kind, match=said) as caught:
        read_mount(path)
    assert str(path) in str(caught.value)


def test_a_missing_file_names_the_way_out(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"write it by hand .* or by `facetlog mount`"):
        read_mount(tmp_path / "mount.toml")
