"""`facetlog model draw`: what is drawn holds, and what cannot be met together is named."""

import json

import pytest

from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.surfaces.mesh_export import write_mesh

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
    "swing": """model swing
  "A seat on two ropes, which hang from a beam on posts."

  bar beam where beam is level
  at least 2 bars post where post carries beam, post is on_ground
  at least 2 bars rope where rope hangs_from beam
  board seat where seat is level, seat below beam

  held: each rope: rope joins seat
""",
}
"""Texts of models of several pieces, as their authors wrote them."""


@pytest.fixture
def draw(run, tmp_path):
    """Return a function that draws the model of a text, or of a name."""

    def call(name, text="", *options):
        if text:
            (tmp_path / f"{name}.model").write_text(text)
            name = f"{name}.model"
        return run("model", "draw", name, "-o", "drawn", *options)

    return call


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stool", *NEWCOMERS])
def test_what_is_drawn_holds_and_is_written_as_picture_mesh_and_scene(name, draw, tmp_path):
    code, out, _ = draw(name, NEWCOMERS.get(name, ""), "--json")
    assert code == 0, out
    verdict = json.loads(out)["verdict"]
    assert (verdict["model"], verdict["state"]) == (name, "holds")
    written = {path.name for path in (tmp_path / "drawn").iterdir()}
    assert written == {f"{name}.png", f"{name}.glb", f"{name}.json", "run.json"}


@pytest.mark.slow
def test_what_is_drawn_is_what_other_commands_recognise(draw, run):
    code, out, _ = draw("pedestal", PEDESTAL)
    assert (code, "t1 is a pedestal" in out) == (0, True)
    why = ("why", "drawn/pedestal.json", "pedestal", "--models", "pedestal.model")
    code, out, _ = run(*why)
    assert (code, "t1 is a pedestal" in out) == (0, True)


@pytest.mark.slow
def test_conditions_that_are_never_met_together_are_named_with_their_place(draw, tmp_path):
    code, out, _ = draw("sponge", SPONGE, "--effort", "10")
    assert code == 1
    first, *more = out.splitlines()
    assert "none meets filled, hollow together; other things may" in first
    assert "sponge.model:7" in more[0]
    assert "sponge.model:8" in more[1]
    assert not (tmp_path / "drawn").exists()


PLACE = "model place\n  one table board\n  one chair seat\n  near: gap(board, seat) at most 1 m\n"
SLIP = "model slip\n  face top\n  low: hight(top) at most 3 cm\n"


@pytest.mark.parametrize(
    ("name", "text", "code", "message"),
    [
        ("no_such_model", "", 2, "there is no model no_such_model"),
        ("no_such_file.model", "", 2, "no such file"),
        ("place", PLACE, 2, "several things"),
        ("slip", SLIP, 1, "slip.model:3"),
    ],
)
def test_what_cannot_be_drawn_is_refused(name, text, code, message, draw):
    found, out, err = draw(name, text)
    assert found == code
    assert message in out + err


@pytest.mark.parametrize(("title", "code"), [("a wheel", 0), ("a file", 1)])
def test_an_example_is_drawn_and_judged(run, tmp_path, title, code):
    write_mesh(cuboid(), tmp_path / "block.ply")
    (tmp_path / "roller.model").write_text(
        """model roller
  "Round all about."
  block body
  round: curved(this) at least 20 %
  example "a wheel" of wheel(diameter 20 cm, thickness 10 cm) holds
  example "a file" from "block.ply" (up z, unit m) fails
"""
    )
    drawn = run("model", "draw", "roller.model", "--example", title, "-o", "one.png")
    assert (drawn[0], drawn[1][:9]) == (code, "one.png: ")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    again = ("model", "draw", "roller", "--models", "roller.model", "--example", title)
    assert run(*again, "-o", "one.png")[0] == 2
    found = json.loads(run(*again, "-o", "one.png", "--overwrite", "--json")[1])
    assert (found["model"], found["example"]) == ("roller", title)
    code, _, said = run("model", "draw", "roller.model", "--example", "none")
    assert (code, '"a wheel"; "a file"' in said) == (2, True)
    assert run("model", "test", "roller.model")[0] == 0
