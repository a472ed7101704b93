"""`facetlog model draw`: what is drawn holds, and what cannot be met together is named."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from facetlog.cli import app

TOWER = """model tower
  "A flat thing that is high at once."

  face top

  level: top is level, top is upward
  flat: height(this) at most 40 % of width(top)
  high: elevation(top) at least 60 % of width(top)
"""

SLAB = """model slab
  "A level board."

  face top

  level: top is level, top is upward
  thin: height(this) at most 20 % of width(top)
"""

SPONGE = """model sponge
  "What fills the box round it, with a side that is deep and hollow."

  face top

  level: top is level, top is upward
  filled: solidity(this) at least 98 %
  hollow: hollow_side(this) at least 50 %
"""

PEDESTAL = """model pedestal
  "A board on one block or bar."

  board top where top is level
  piece foot where foot carries top, foot is on_ground

  narrow: width(foot) at most 50 % of width(top)
  reach: bottom_of(top) at least 60 % of width(top)
  alone: there is no bar leg where leg above top
"""


NEWCOMERS = {
    "ladder": """model ladder
  "Two long rails with rungs between them."

  bar left where left is upright
  bar right where right is upright
  at least 4 bars rung where rung is level, rung joins left, rung joins right

  beside: left beside right                           "the rails stand side by side"
  tall: height(this) at least 250 % of width(this)    "it is much higher than broad"
  flat: depth(this) at most 30 % of width(this)       "it is flat"
  bays: there are at least 3 openings bay where bay beside left  "one sees through between rungs"
""",
    "gate": """model gate
  "Two posts on the ground, and rails between them."

  at least 2 bars post where post is upright, post is on_ground
  at least 2 pieces rail where rail is level
  bar top where top is level

  flat: depth(this) at most 20 % of width(this)          "it is flat"
  broad: length(top) at least 50 % of length(this)       "a rail goes from post to post"
  held: each post: post joins top                        "the posts hold the rail"
""",
    "workbench": """model workbench
  "A heavy bench to work at, with a shelf below."

  board top where top is level
  board shelf where shelf is level, shelf below top
  at least 4 bars leg where leg carries top, leg is on_ground

  each leg: leg is upright
  high: elevation(top) at least 40 % of length(top)      "one stands at it"
  low: elevation(shelf) at most 60 % of elevation(top)   "the shelf is low"
  wide: length(shelf) at least 60 % of length(top)       "the shelf is nearly as long as the top"
  empty: there is no piece x where x above top           "nothing on it"
  one_shelf: shelves_below(top) = 1
  usual: expect: if known: top_of(top) between 75 cm and 105 cm "one stands at it"

  example "a table" of table() fails because shelf
  example "a shelf" of shelf() fails
""",
    "picnic": """model picnic
  "A table with a bench along each long side."

  board top where top is level
  at least 2 boards bench where bench is level, bench below top,
      length(bench) at least 70 % of length(top)
  at least 2 pieces leg where leg is on_ground, leg carries top

  lower: each bench: elevation(bench) between 45 % of elevation(top) and 80 % of elevation(top)
  bare: there is no piece x where x above top
""",
    "swing": """model swing
  "A seat on two ropes, which hang from a beam on posts."

  bar beam where beam is level
  at least 2 bars post where post carries beam, post is on_ground
  at least 2 bars rope where rope hangs_from beam
  board seat where seat is level, seat below beam

  held: each rope: rope joins seat
""",
    "gateway": """model gateway
  "A way through, with something in it."

  opening way
  piece cat where cat inside way
""",
}
"""Texts of models of several pieces, as their authors wrote them."""


def _run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["model", "draw", *arguments])
    return result.exit_code, result.output


@pytest.mark.slow
def test_what_is_drawn_of_a_built_in_model_holds(tmp_path: Path) -> None:
    code, output = _run("stool", "-o", str(tmp_path / "stool"), "--json")

    assert code == 0, output
    drawn = json.loads(output)
    assert drawn["verdict"]["state"] == "holds"
    written = {path.name for path in (tmp_path / "stool").iterdir()}
    assert written == {"stool.png", "stool.glb", "stool.json", "run.json"}


@pytest.mark.slow
def test_what_is_drawn_is_there_as_picture_mesh_and_scene(tmp_path: Path) -> None:
    (tmp_path / "slab.model").write_text(SLAB)

    code, output = _run(
        str(tmp_path / "slab.model"), "--effort", "15", "-o", str(tmp_path / "d"), "--json"
    )

    assert code == 0, output
    drawn = json.loads(output)
    assert (drawn["model"], drawn["verdict"]["state"]) == ("slab", "holds")
    assert all(c["state"] == "holds" for c in drawn["verdict"]["conditions"])
    assert {path.suffix for path in (tmp_path / "d").glob("slab.*")} == {".png", ".glb", ".json"}


@pytest.mark.slow
@pytest.mark.parametrize("name", NEWCOMERS)
def test_things_of_several_pieces_are_drawn(name: str, tmp_path: Path) -> None:
    (tmp_path / f"{name}.model").write_text(NEWCOMERS[name])

    code, output = _run(str(tmp_path / f"{name}.model"), "-o", str(tmp_path / "drawn"), "--json")

    assert code == 0, output
    assert json.loads(output)["verdict"]["state"] == "holds"


@pytest.mark.slow
def test_what_is_drawn_is_what_other_commands_recognise(tmp_path: Path) -> None:
    (tmp_path / "pedestal.model").write_text(PEDESTAL)
    model = str(tmp_path / "pedestal.model")

    code, output = _run(model, "-o", str(tmp_path / "drawn"))

    assert code == 0, output
    assert "t1 is a pedestal" in output
    scene = str(tmp_path / "drawn" / "pedestal.json")
    why = CliRunner().invoke(app, ["why", scene, "pedestal", "--models", model])
    assert why.exit_code == 0
    assert "t1 is a pedestal" in why.output


@pytest.mark.slow
def test_conditions_that_are_never_met_together_are_named_with_their_place(tmp_path: Path) -> None:
    (tmp_path / "sponge.model").write_text(SPONGE)

    code, output = _run(str(tmp_path / "sponge.model"), "--effort", "10", "-o", str(tmp_path / "d"))

    assert code == 1
    first, *more = output.splitlines()
    assert "none meets filled, hollow together; other things may" in first
    assert "sponge.model:7" in more[0]
    assert "sponge.model:8" in more[1]
    assert not (tmp_path / "d").exists()


def test_what_the_check_knows_to_contradict_is_not_even_tried(tmp_path: Path) -> None:
    (tmp_path / "tower.model").write_text(TOWER)

    code, output = _run(str(tmp_path / "tower.model"), "-o", str(tmp_path / "d"))

    assert code == 1
    assert "[contradiction]" in output


@pytest.mark.parametrize("name", ["no_such_model", "no_such_file.model"])
def test_a_model_that_there_is_not_is_an_input_error(name: str, tmp_path: Path) -> None:
    assert _run(name, "-o", str(tmp_path / "d"))[0] == 2


def test_a_model_with_errors_is_not_drawn(tmp_path: Path) -> None:
    (tmp_path / "slip.model").write_text("model slip\n  face top\n  low: hight(top) at most 3 cm\n")

    code, output = _run(str(tmp_path / "slip.model"))

    assert code == 1
    assert "slip.model:3" in output


def test_a_model_of_several_things_is_not_drawn(tmp_path: Path) -> None:
    (tmp_path / "place.model").write_text(
        "model place\n  one table board\n  one chair seat\n  near: gap(board, seat) at most 1 m\n"
    )

    code, output = _run(str(tmp_path / "place.model"))

    assert code == 2
    assert "several things" in output
