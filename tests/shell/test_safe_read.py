"""Pipes, sockets and devices that are called like files are refused before they can block."""

import os
import socket
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import pytest

from facetlog.batch.content import hash_content
from facetlog.batch.labels import read_labels
from facetlog.errors import InputError
from facetlog.grammar.analysis import analyse
from facetlog.kb.labelled_scenes import read_labelled_cases
from facetlog.kb.loading.rule_source import read_rule_text
from facetlog.perception.reading.picture_file import read_picture
from facetlog.perception.reading.pose_files.file_values import read_text
from facetlog.perception.shapes.read_shape import ShapeOptions, read_shape
from facetlog.perception.surfaces.scene_file import read_scene
from facetlog.query_shell.model_files import read_stamp
from facetlog.query_shell.scene_files import scene_file
from facetlog.robot.collecting.tour_file import read_tour
from facetlog.robot.mount.mount import read_mount
from facetlog.robot.simulator.world_file import read_world
from facetlog.safe_read import read_regular, read_regular_text


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(os.path.relpath(path))  # such a name must not be long


@pytest.fixture(params=[os.mkfifo, _socket])
def make(request, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    called: Callable[[Path], None] = request.param
    return called


@pytest.mark.parametrize("name", ["x.ply", "x.obj", "x.json", "x.las", "x.xyz"])
def test_what_is_no_regular_file_is_refused_at_once(name, make, tmp_path):
    path = tmp_path / name
    make(path)
    for read in (hash_content, lambda file: read_shape(file, ShapeOptions())):
        with pytest.raises(InputError, match=rf"{name}: .*is .*; give a"):
            read(path)


@pytest.mark.parametrize(
    "read",
    [
        read_scene,
        read_picture,
        read_rule_text,
        read_labels,
        read_world,
        read_mount,
        lambda path: tuple(read_tour(path).views),
        read_text,
        lambda path: read_labelled_cases(path, lambda _: (), known=()),
    ],
)
def test_every_reader_takes_regular_files_alone(read, make, tmp_path):
    make(tmp_path / "x.csv")
    with pytest.raises(InputError, match="it is a pipe, a socket or a device; give a file"):
        read(tmp_path / "x.csv")
    assert read_stamp(tmp_path / "x.csv") is None
    make(tmp_path / "x.json")
    with pytest.raises(InputError, match="it is a pipe, a socket or a device; give a file"):
        scene_file(tmp_path / "x.json")


@pytest.mark.parametrize("name", ["x.pl", "x.model"])
def test_a_model_and_what_it_uses_are_regular_files(name, make, tmp_path):
    make(tmp_path / name)
    main = tmp_path / "main.model"
    main.write_text(f'use "{name}"\nmodel slab\n  face a\n  wide: area(a) at least 1 m2\n')
    for path in (main, tmp_path / name):
        found = analyse(path)
        assert any("it is a pipe, a socket or a device" in f.message for f in found.faults)


def test_what_is_longer_than_may_be_is_not_read_whole(tmp_path):
    (tmp_path / "x").write_bytes(b"\xef\xbb\xbfabc")
    assert read_regular(tmp_path / "x", 6) == b"\xef\xbb\xbfabc"
    assert read_regular_text(tmp_path / "x", 6) == "abc"
    with pytest.raises(OSError, match="it is too long: at most 5 bytes"):
        read_regular(tmp_path / "x", 5)
    with pytest.raises(OSError, match="give a file"):
        read_regular(Path("/dev/zero"), 5)
    with pytest.raises(IsADirectoryError, match="Is a directory"):
        read_regular(tmp_path, 5)
    with pytest.raises(OSError, match="null"):
        read_regular(Path("a\0b"), 5)


def test_to_read_takes_the_memory_of_the_file_and_not_of_the_longest_there_may_be(tmp_path):
    path = tmp_path / "small"
    path.write_bytes(b"small")
    tracemalloc.start()
    try:
        assert read_regular(path, 1 << 30) == b"small"
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


def test_a_file_that_says_nothing_of_its_size_is_read_to_its_end():
    path = Path("/proc/self/status")
    if not path.exists():
        pytest.skip("no such files here")
    assert read_regular(path).startswith(b"Name:")
    with pytest.raises(OSError, match="too long"):
        read_regular(path, 10)
