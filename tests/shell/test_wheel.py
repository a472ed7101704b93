"""The wheel works outside of the repository, with all the data that it needs."""

import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# What the program reads besides Python: models, their Prolog, the page, and the types' marker.
DATA = ("facetlog/rules/box.model", "facetlog/page/page.html.jinja", "facetlog/py.typed")


def _run(*argv: object, cwd: Path, path: Path | None = None) -> str:
    without = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    env = without | ({"PYTHONPATH": str(path)} if path else {})
    run = subprocess.run(
        [sys.executable, *map(str, argv)], cwd=cwd, env=env, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


def _built(kind: str, source: Path, folder: Path) -> Path:
    _run("-m", "hatchling", "build", "-t", kind, "-d", folder, cwd=source)
    (made,) = folder.glob("*.whl" if kind == "wheel" else "*.tar.gz")
    return made


@pytest.mark.slow
def test_the_wheel_works_outside_of_the_repository(tmp_path):
    wheel = _built("wheel", ROOT, tmp_path / "wheel")
    place, elsewhere = tmp_path / "place", tmp_path / "elsewhere"
    elsewhere.mkdir()
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        assert names >= set(DATA)
        archive.extractall(place)  # noqa: S202 – made just now
    where = _run("-c", "import facetlog.kb; print(facetlog.kb.__file__)", cwd=elsewhere, path=place)
    assert Path(where.strip()) == place / "facetlog" / "kb" / "__init__.py"
    made = (
        "from pathlib import Path; from facetlog.perception.surfaces.scene_file import write_scene;"
        "from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid;"
        "write_scene(cuboid(0.3, 0.2, 0.1), Path('block.json'))"
    )
    _run("-c", made, cwd=elsewhere, path=place)
    said = _run("-m", "facetlog", "why", "block.json", "box", cwd=elsewhere, path=place)
    assert said.startswith("t1 is a box")
    _run(
        "-m", "facetlog", "why", "block.json", "box", "--html", "a.html", cwd=elsewhere, path=place
    )
    assert "<h1>t1 is a box" in (elsewhere / "a.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_source_distribution_builds_the_same_wheel(tmp_path):
    with tarfile.open(_built("sdist", ROOT, tmp_path / "sdist")) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    (source,) = (tmp_path / "source").iterdir()
    wheels = [_built("wheel", ROOT, tmp_path / "one"), _built("wheel", source, tmp_path / "other")]
    one, other = (set(zipfile.ZipFile(wheel).namelist()) for wheel in wheels)
    assert one == other
