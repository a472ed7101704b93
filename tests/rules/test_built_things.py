"""Things built of boxes, in random frames: what is level and beside, and what is said of others."""

from collections.abc import Iterator

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.kb.batch_judge import BatchJudge
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Verdict
from facetlog.kb.knowledge_base import KnowledgeBase
from facetlog.perception.facts.all_facts import fact_columns, facts_on_demand, scene_facts
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene
from facetlog.perception.types import FloatArray

MODELS = """model post_box
  "A box on one post, with a flag at its side."
  bar post where post is upright, post is on_ground
  block box where post carries box
  piece flag where flag is upright, flag joins box

  level: box is level
  side: flag beside box
  only_post: there is no bar other where other is on_ground

model horse
  "A beam on four legs that spread."
  bar beam where beam is level
  exactly 4 bars leg where leg carries beam, leg is on_ground

  splayed: each leg: tilt(leg) between 60 deg and 88 deg
  wider: width(this) at least 200 % of width(beam)

model stone
  "A block that is not tilted."
  block body where body is on_ground
  level: body is level
"""
Size = tuple[float, float, float]
Solid = tuple[Size, Size]  # middle of the lower side, and the extents
POST: Solid = (0.0, 0.0, 0.0), (0.1, 0.1, 1.0)
BOX: Solid = (0.0, 0.0, 1.0), (0.48, 0.17, 0.2)
Loaded = tuple[KnowledgeBase, BatchJudge]


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loaded]:
    path = tmp_path_factory.mktemp("built") / "built.model"
    path.write_text(MODELS, encoding="utf-8")
    with KnowledgeBase() as base, BatchJudge([path]) as judge:
        base.load_rules(path)
        yield base, judge


def flag(sunk: float) -> Solid:
    """A flag whose thickness is sunk into the box's side by that share."""
    return (0.07, 0.085 + 0.006 - 0.012 * sunk, 1.08), (0.03, 0.012, 0.24)


def build(*solids: Solid, seed: int = 0, tilt_deg: float = 0.0) -> Scene:
    """A mesh of boxes in a random frame, the first of them turned about x by `tilt_deg`."""
    import trimesh

    meshes = []
    for at, size in solids:
        mesh = trimesh.creation.box(size)
        if not meshes:
            mesh.apply_transform(
                trimesh.transformations.rotation_matrix(np.radians(tilt_deg), (1, 0, 0))
            )
        mesh.apply_translation((at[0], at[1], at[2] + size[2] / 2.0))
        meshes.append(mesh)
    mesh = trimesh.util.concatenate(meshes)
    turn: FloatArray = Rotation.random(random_state=seed).as_matrix()
    return make_mesh_scene(
        Mesh.of(mesh.vertices @ turn.T, mesh.faces, name="built"), up=turn[:, 2], metric=True
    )


def judge(loaded: Loaded, scene: Scene, model: str) -> Verdict:
    """Return the verdict on the thing that fits best; in a batch it is the same."""
    base, batch = loaded
    columns = fact_columns(scene, {kind for kind, _ in batch.needed})
    brief = {(v.model, v.thing): v for v in batch.judge_columns(columns)}
    facts = [fact.row for fact in scene_facts(scene)]
    base.load_scene("s", facts, on_demand=lambda: [f.row for f in facts_on_demand(scene)])
    verdict = base.why("s", model)
    other = brief[model, verdict.thing]
    assert other.state is verdict.state
    assert other.degree == pytest.approx(verdict.degree, abs=1e-12)
    return verdict


def said(verdict: Verdict) -> str:
    return "\n".join(verdict.lines())


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sunk", [0.0, 0.25, 0.5])
def test_a_box_that_lies_square_is_level_and_a_sunk_flag_is_beside_it(
    loaded: Loaded, sunk: float, seed: int
) -> None:
    verdict = judge(loaded, build(POST, BOX, flag(sunk), seed=seed), "post_box")
    assert verdict.state is State.HOLDS


def test_a_flag_over_the_box_is_not_beside_it_and_how_far_is_said(loaded: Loaded) -> None:
    over: Solid = (0.07, 0.0, 1.2), (0.03, 0.012, 0.24)
    verdict = judge(loaded, build(POST, BOX, over), "post_box")
    (line,) = verdict.list_conditions_in_state(State.FAILS)
    assert line.label == "side"
    assert "overlap of p3 and p1 from above = 100 %, needs at most 10 %" in said(verdict)


def test_what_stands_on_the_ground_and_should_not_is_the_reason(loaded: Loaded) -> None:
    legs: list[Solid] = [((x, 0.0, 0.0), (0.05, 0.05, 1.0)) for x in (-0.2, 0.0, 0.2)]
    verdict = judge(loaded, build(*legs, BOX, flag(0.5)), "post_box")
    (line,) = verdict.list_conditions_in_state(State.FAILS)
    assert line.label == "only_post"
    assert "stands on the ground, which should not be" in said(verdict)
    assert "is no board" not in "\n".join(verdict.lines(full=True))


def test_for_which_part_nothing_is_left_is_said(loaded: Loaded) -> None:
    text = said(judge(loaded, build(POST, BOX), "post_box"))
    assert "nothing is left for flag: t1 has but 2 pieces for 3 parts" in text


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("size", [(0.5, 0.2, 0.25), (0.25, 0.5, 0.2), (0.2, 0.25, 0.5)])
@pytest.mark.parametrize(("tilt_deg", "state"), [(0.0, State.HOLDS), (30.0, State.FAILS)])
def test_a_block_is_level_on_any_of_its_sides(
    loaded: Loaded, size: Size, seed: int, tilt_deg: float, state: State
) -> None:
    verdict = judge(loaded, build(((0.0, 0.0, 0.0), size), seed=seed, tilt_deg=tilt_deg), "stone")
    assert verdict.state is state
    if state is State.FAILS:
        assert "tilt of p1's most level side = 30.00°" in said(verdict)


@pytest.mark.parametrize("width", [0.33, 0.35, 0.37])
def test_between_bar_and_block_the_degree_is_soft(loaded: Loaded, width: float) -> None:
    upright = judge(loaded, build(((0.0, 0.0, 0.0), (0.3, width, 1.0))), "stone")
    (body,) = (line for line in upright.conditions if line.label == "level")
    assert 0.0 < body.proof.low < 1.0


def test_a_missing_set_comes_first_and_other_objects_are_named(loaded: Loaded) -> None:
    beam: Solid = (0.0, 0.0, 0.65), (1.0, 0.1, 0.1)
    post: Solid = (0.0, 0.0, 0.0), (0.08, 0.08, 0.65)
    away: Solid = (0.0, 0.5, 0.0), (0.05, 0.05, 0.6)
    verdict = judge(loaded, build(beam, post, away), "horse")
    lines = said(verdict).splitlines()
    assert "exactly 4 bars leg" in lines[0]
    assert lines[2].startswith("  - leg")
    assert any("other objects near it: t2 (1 bar)" in line for line in lines)
    assert "thing_" not in said(verdict)
