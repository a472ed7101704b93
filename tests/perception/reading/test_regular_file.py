"""Pipes, sockets and devices that are called like files are refused before they can block."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from facetlog.batch.content import content_hash
from facetlog.batch.inputs import scene_paths
from facetlog.errors import InputError
from facetlog.perception.reading.regular_file import check_regular
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.surfaces.scene_file import read_scene


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(os.path.relpath(path))  # such a name must not be long


@pytest.fixture(params=[os.mkfifo, _socket])
def make(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[Path], None]:
    monkeypatch.chdir(tmp_path)
    called: Callable[[Path], None] = request.param
    return called


@pytest.mark.parametrize("name", ["x.ply", "x.obj", "x.json", "x.las", "x.xyz"])
def test_what_is_no_regular_file_is_refused_at_once(
    name: str, make: Callable[[Path], None], tmp_path: Path
) -> None:
    path = tmp_path / name
    make(path)
    for read in (content_hash, lambda file: read_shape(file, ShapeOptions())):
        with pytest.raises(InputError, match=rf"{name}: is .*; give a"):
            read(path)
    with pytest.raises(InputError, match="is a pipe, a socket or a device; give a file"):
        read_scene(path)


def test_a_link_to_a_pipe_is_one_and_a_file_is_none(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "x.ply").symlink_to("pipe")
    (tmp_path / "y.ply").write_text("ply")
    with pytest.raises(InputError, match=r"x\.ply: is a pipe"):
        check_regular(tmp_path / "x.ply")
    for name in ("y.ply", "absent", "."):
        check_regular(tmp_path / name)


def test_a_folder_names_its_pipe_so_that_a_row_can_say_it(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.ply")
    assert scene_paths([str(tmp_path)]) == (str(tmp_path / "x.ply"),)


@pytest.mark.parametrize("part", ["cameras.txt", "images.txt", "points3D.txt"])
def test_a_colmap_model_with_a_pipe_is_refused(part: str, tmp_path: Path) -> None:
    for name in {"cameras.txt", "images.txt", "points3D.txt"} - {part}:
        (tmp_path / name).touch()
    os.mkfifo(tmp_path / part)
    with pytest.raises(InputError, match=r"is a pipe|has no points3D"):
        read_shape(tmp_path, ShapeOptions())
