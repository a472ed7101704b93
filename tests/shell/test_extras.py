"""Commands that need a missing package name the extra that brings it, before any work."""

import sys
from pathlib import Path

import pytest

import facetlog
from facetlog.cli import main
from facetlog.errors import InputError
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.scene_file import write_scene


@pytest.fixture
def without(monkeypatch):
    """Make a package one that is not installed, and modules ones that were not imported yet."""

    def missing(package: str, *modules: str) -> None:
        for name in [*sys.modules]:
            if name == package or name.startswith((f"{package}.", *modules)):
                monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, package, None)

    return missing


@pytest.mark.parametrize(
    ("package", "module", "argv", "extra"),
    [
        ("pyarrow", "", ["classify", "a.json", "-o", "a.parquet"], "batch"),
        ("matplotlib", "", ["mat", "-o", "mat.pdf"], "plots"),
        ("pygls", "facetlog.grammar.language_server.", ["model", "lsp"], "editor"),
        ("rosbags", "facetlog.recordings.", ["record", "views", "--mcap", "a.mcap"], "mcap"),
        ("distributed", "", ["classify", "a.json", "-o", "a.csv", "--dask", "tcp://a:1"], "dask"),
    ],
)
def test_commands_name_the_extra(
    package, module, argv, extra, without, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    write_scene(cuboid(0.3, 0.2, 0.1), Path("a.json"))
    without(package, *([module] if module else ()))
    assert main(argv) == 2
    assert capsys.readouterr().err.endswith(f": pip install 'facetlog[{extra}]'\n")
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


def test_a_robot_names_its_extra(without):
    without("serial", "facetlog.robot.pioneer.line.port")
    with pytest.raises(InputError, match=r"pip install 'facetlog\[robot\]'"):
        __import__("facetlog.robot.pioneer.line.port")


def test_plots_name_their_extra(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("facetlog.degree_plot.find_spec", lambda _: None)
    assert main(["demo", "--paper", "-o", str(tmp_path / "out")]) == 2
    assert main(["recognize", str(tmp_path), "--follow", "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("plots need matplotlib: pip install 'facetlog[plots]'") == 2


def test_tables_of_many_machines_name_their_extra(without):
    without("pyarrow")
    with pytest.raises(InputError, match=r"classify_batch needs .* 'facetlog\[batch\]'"):
        facetlog.classify_batch(None)
