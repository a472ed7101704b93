"""Which files are meant by what is given."""

import os
from pathlib import Path

import pytest

from facetlog.batch.inputs import find_scene_paths, read_path_list
from facetlog.errors import InputError
from facetlog.output_folder import output_folder


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("b.json", "a.json", "deep/er/c.JSON", "deep/notes.txt", "out/run.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("sources", "found"),
    [
        (("b.json", "a.json"), ["b.json", "a.json"]),
        ((".",), ["a.json", "b.json", "deep/er/c.JSON"]),
        (("*.json",), ["a.json", "b.json"]),
        (("**/*.JSON",), ["deep/er/c.JSON"]),
        (("de*",), ["deep/er/c.JSON"]),
        (("b.json", "./b.json", "deep/../b.json", "*.json"), ["b.json", "a.json"]),
        (("absent.json", "a.json"), ["absent.json", "a.json"]),
    ],
)
def test_files_come_once_in_the_order_given(sources: tuple[str, ...], found: list[str]) -> None:
    assert [os.path.normpath(path) for path in find_scene_paths(sources)] == found


def test_what_a_run_wrote_is_one_scene_and_other_files_beside_it_are_scenes(folder: Path) -> None:
    out = folder / "runs" / "block"
    with output_folder(out, {}) as made:
        for name in ("scene.json", "verdicts.json", "faces.ply", "faces.glb", "pieces.glb"):
            (made / name).touch()
    (out / "own.ply").touch()
    for source in ("runs", "runs/block", "ru*"):
        found = [os.path.normpath(path) for path in find_scene_paths((source,))]
        assert found == ["runs/block/own.ply", "runs/block/scene.json"]
    assert find_scene_paths(("runs/block/faces.ply",)) == ("runs/block/faces.ply",)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("sources", "says"),
    [
        ((), "there is no scene to classify"),
        (("x*.json",), "no file is called so"),
        (("out",), "out: the folder has no scene, mesh or cloud$"),
    ],
)
def test_sources_that_find_nothing_are_refused(sources: tuple[str, ...], says: str) -> None:
    with pytest.raises(InputError, match=says):
        find_scene_paths(sources)


@pytest.mark.parametrize("name", ["pipe", "/dev/zero"])
def test_a_list_that_never_ends_is_refused_at_once(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    with pytest.raises(InputError, match=r"it is a pipe, .*\(- is standard input\)$"):
        read_path_list(name)


def test_a_glob_over_folders_follows_no_links_among_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two links of a folder to itself would be 2^40 paths."""
    monkeypatch.chdir(tmp_path)
    for name in ("a/b/c.json", "a/d.json", "a/.hidden/e.json"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).touch()
    for link in ("one", "two"):
        Path("a", link).symlink_to(".")
    found = ("a/b/c.json", "a/d.json")
    for pattern in ("a/**/*.json", "**/*.json", "a/**", "**/a/**/*.json"):
        assert find_scene_paths([pattern]) == found
    assert find_scene_paths([f"{tmp_path}/**/*.json"]) == tuple(
        f"{tmp_path}/{name}" for name in found
    )


@pytest.mark.parametrize(
    ("data", "paths"),
    [
        (b"a b\n# no\n\nc\r\n", ("a b", "c")),
        (b"\xef\xbb\xbfa\nb\n", ("a", "b")),
        ("a\r\nü\r\n".encode("utf-16"), ("a", "ü")),
        (b"a\nb\0#c\0", ("a\nb", "#c")),
    ],
)
def test_lists_end_paths_by_lines_or_nuls_in_what_editors_write(
    data: bytes, paths: tuple[str, ...], tmp_path: Path
) -> None:
    (tmp_path / "list").write_bytes(data)
    assert read_path_list(str(tmp_path / "list")) == paths
