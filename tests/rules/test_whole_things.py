"""Things known from all sides, as meshes are: what box, table and chair make of them."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from facetlog.kb.batch_judge import BatchJudge
from facetlog.perception.facts.all_facts import fact_rows
from facetlog.perception.reading.shape_files.meshes.mesh_files import Mesh
from facetlog.perception.scene import Scene
from facetlog.perception.shapes.meshes.mesh_scene import make_mesh_scene

UP = np.array([0.0, 0.0, 1.0])


def block(low: Iterable[float], high: Iterable[float]) -> trimesh.Trimesh:
    return trimesh.creation.box(bounds=[list(low), list(high)])


def pole(x: float, y: float, radius: float, low: float, high: float) -> trimesh.Trimesh:
    made = trimesh.creation.cylinder(radius=radius, height=high - low, sections=24)
    made.apply_translation([x, y, (low + high) / 2])
    return made


def scene(*parts: trimesh.Trimesh) -> Scene:
    joined = trimesh.util.concatenate(list(parts))
    return make_mesh_scene(Mesh.of(joined.vertices, joined.faces, name="made"), up=UP)


def pedestal_table() -> Scene:
    return scene(
        pole(0, 0, 0.5, 0.72, 0.75), pole(0, 0, 0.04, 0.02, 0.72), pole(0, 0, 0.25, 0, 0.02)
    )


def round_legs() -> list[trimesh.Trimesh]:
    return [pole(x, y, 0.02, 0, 0.43) for x in (0.04, 0.4) for y in (0.04, 0.4)]


def spindle_chair() -> Scene:
    spindles = [pole(x, 0.42, 0.01, 0.45, 0.85) for x in np.linspace(0.03, 0.41, 6)]
    rail = block((0.0, 0.4, 0.85), (0.44, 0.44, 0.92))
    return scene(block((0, 0, 0.42), (0.44, 0.44, 0.46)), *round_legs(), *spindles, rail)


def slatted_chair() -> Scene:
    slats = [block((0, y, 0.43), (0.44, y + 0.06, 0.45)) for y in np.arange(0.0, 0.42, 0.075)]
    rails = [block((x, 0, 0.40), (x + 0.03, 0.435, 0.43)) for x in (0.02, 0.39)]
    back = [block((0, 0.42, z), (0.44, 0.44, z + 0.06)) for z in (0.6, 0.7, 0.8)]
    posts = [block((x, 0.42, 0.40), (x + 0.03, 0.45, 0.88)) for x in (0.0, 0.41)]
    return scene(*slats, *rails, *back, *posts, *round_legs())


def armchair() -> Scene:
    return scene(
        block((0, 0, 0), (0.8, 0.8, 0.4)),
        block((0, 0, 0.4), (0.12, 0.8, 0.6)),
        block((0.68, 0, 0.4), (0.8, 0.8, 0.6)),
        block((0, 0.65, 0.4), (0.8, 0.8, 0.9)),
    )


def open_box() -> Scene:
    walls = [
        block((0, 0, 0), (0.4, 0.3, 0.01)),
        block((0, 0, 0), (0.01, 0.3, 0.3)),
        block((0.39, 0, 0), (0.4, 0.3, 0.3)),
        block((0, 0, 0), (0.4, 0.01, 0.3)),
        block((0, 0.29, 0), (0.4, 0.3, 0.3)),
    ]
    return scene(*walls)


@pytest.fixture(scope="module")
def judge() -> Iterator[BatchJudge]:
    with BatchJudge() as opened:
        yield opened


def holding(judge: BatchJudge, made: Scene) -> set[str]:
    """Return which of box, table and chair hold."""
    verdicts = judge.judge(fact_rows(made))
    return {v.model for v in verdicts if v.state == "holds"} & {"box", "table", "chair"}


@pytest.mark.parametrize(
    ("made", "answer"),
    [
        (pedestal_table, {"table"}),
        (spindle_chair, {"chair"}),
        (slatted_chair, {"chair"}),
        (armchair, {"chair"}),
        (open_box, set()),
    ],
)
@pytest.mark.slow
def test_furniture_is_told_by_the_space_that_it_leaves(judge, made, answer) -> None:  # type: ignore[no-untyped-def]
    assert holding(judge, made()) == answer


def test_a_closed_box_is_one_and_a_door_is_none(judge: BatchJudge) -> None:
    assert holding(judge, scene(block((0, 0, 0), (0.4, 0.3, 0.2)))) == {"box"}
    assert holding(judge, scene(block((0, 0, 0), (0.9, 0.04, 2.0)))) == set()


def test_without_up_a_table_is_unknown_and_a_box_is_one(judge: BatchJudge) -> None:
    table = judge.judge(fact_rows(replace(pedestal_table(), up=None)))
    assert {v.state for v in table if v.model == "table"} == {"unknown"}
    box = replace(scene(block((0, 0, 0), (0.4, 0.3, 0.2))), up=None)
    assert "box" in holding(judge, box)


def test_verdicts_do_not_depend_on_frame_or_unit(judge: BatchJudge) -> None:
    turn = trimesh.transformations.rotation_matrix(0.7, [1.0, 2.0, 0.5])
    parts = trimesh.util.concatenate(
        [
            block((0, 0, 0.42), (0.44, 0.44, 0.46)),
            *round_legs(),
            block((0, 0.4, 0.46), (0.44, 0.44, 0.9)),
        ]
    )
    parts.apply_transform(turn)
    parts.apply_scale(1000.0)
    mesh = Mesh.of(parts.vertices, parts.faces, name="turned")
    assert holding(judge, make_mesh_scene(mesh, up=turn[:3, :3] @ UP)) == {"chair"}
