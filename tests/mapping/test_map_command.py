"""`facetlog map`: collections' folders in, a map out, and what is refused."""

import json
import math
import re
from pathlib import Path

import pytest

from facetlog.cli import main
from facetlog.robot.rendering.worlds import INCH
from tests.mapping.rooms import write_visit


@pytest.mark.slow
def test_two_visits_of_one_block_make_one_thing_at_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, first in (("monday", 0.0), ("tuesday", 2.0)):
        write_visit(tmp_path / name, first)
    out = tmp_path / "map"
    argv = ["map", str(tmp_path / "monday"), str(tmp_path / "tuesday"), "-o", str(out), "--json"]
    assert main(argv) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == json.loads((out / "map.json").read_text(encoding="utf-8"))
    (thing,) = found["things"]
    assert thing["model"] == "box"
    pose, size = thing["pose"], thing["size"]
    for key, true in (("x", 0.0), ("y", 0.0), ("heading", 0.4)):
        index = ("x", "y", "heading").index(key)
        sd = math.sqrt(pose["covariance"][index][index])
        assert abs(pose[key] - true) < 3 * sd < 0.1
    for key, inches in (("length", 10), ("width", 8), ("height", 6)):
        assert size[key]["value"] == pytest.approx(inches * INCH, abs=0.01)
    assert {each["visit"] for each in thing["sightings"]} == {"monday", "tuesday"}
    assert found["floor"]["areas"]["free"] > 0.5
    assert {path.name for path in out.iterdir()} >= {"map.png", "map.glb", "map.pgm", "map.yaml"}


@pytest.mark.slow
def test_a_thing_that_was_moved_is_where_the_later_visit_saw_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_visit(tmp_path / "monday", 1.0, count=5)
    write_visit(tmp_path / "tuesday", 2.3, count=5, x=0.4, began=2e9)
    assert main(["map", str(tmp_path / "tuesday"), str(tmp_path / "monday"), "--json"]) == 0
    told = capsys.readouterr()
    found = json.loads(told.out)
    (thing,) = found["things"]
    assert (thing["name"], thing["model"]) == ("m1", "box")
    assert (thing["pose"]["x"], thing["pose"]["y"]) == pytest.approx((0.4, 0.0), abs=0.02)
    assert [each["visit"] for each in thing["sightings"]] == ["tuesday", "monday"]
    (note,) = found["notes"]
    at = r"-?0\.\d\d, -?0\.\d\d m"
    line = (
        rf"m1 box was moved by 0\.\d\d m: seen at {at} \(monday\), where the floor is free since, "
        rf"and later at {at} \(tuesday\)"
    )
    assert re.fullmatch(line, note)
    assert note in told.err


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    """Visits of which nobody said where their robots began."""
    for name in ("a", "b"):
        write_visit(tmp_path / name, 0.0, count=1, stated=False)
    return tmp_path / "a", tmp_path / "b"


def test_visits_whose_worlds_are_not_known_to_be_one_are_not_merged(
    two: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["map", *map(str, two)]) == 2
    said = capsys.readouterr().err
    assert "how their worlds lie to each other is not known" in said
    assert "--aligned" in said


def test_what_is_no_collection_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["map", str(tmp_path)]) == 2
    assert "holds no collection" in capsys.readouterr().err
    assert main(["map", str(tmp_path), "--resolution", "0"]) == 2
    assert "--resolution 0.0: give the side of a cell" in capsys.readouterr().err


def test_too_few_views_are_said_and_make_an_empty_map(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_visit(tmp_path / "a", 0.0, count=2)
    assert main(["map", str(tmp_path / "a")]) == 1
    out, err = capsys.readouterr()
    assert out.startswith("0 things from 2 views of 1 visit; floor free 0.0 m²")
    assert "too few views to find a face in" in err
