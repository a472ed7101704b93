"""Whether the things that examples are made of can be built."""

import math
from pathlib import Path

import pytest

from facetlog.grammar import syntax as s
from facetlog.grammar.analysis import Analysis, analyse
from facetlog.grammar.example_scenes import convert_sizes, find_scene_faults, list_examples
from facetlog.grammar.units import Dimension
from facetlog.perception.length_units import METRES_PER
from facetlog.perception.shapes.shape_options import UP_AXES

BUILDERS = {
    "ramp": {"width": Dimension.LENGTH, "slope": Dimension.ANGLE, "steps": Dimension.NUMBER},
    "ball": {"radius": Dimension.LENGTH},
}


def _analysis(scene: str) -> Analysis:
    text = f'model a\n  face top\n  level: top is level\n  example "one" of {scene} holds\n'
    return analyse(Path("a.model"), text)


def _faults(scene: str) -> list[tuple[str, str, str]]:
    """Code, the text that is blamed, and hint."""
    return [
        (fault.code, fault.source.text[fault.span.start : fault.span.end], fault.hint)
        for fault in find_scene_faults(_analysis(scene), BUILDERS)
    ]


@pytest.mark.parametrize(
    "scene",
    [
        "ball()",
        "ramp(width 40 cm, slope 0.3 rad, steps 3)",
        "ball(z 5 cm) and ramp(along 2 m, columns 3) and ball()",
    ],
)
def test_what_can_be_built_has_no_faults(scene: str) -> None:
    assert _faults(scene) == []


@pytest.mark.parametrize(
    ("scene", "code", "blamed", "hint"),
    [
        ("rampp()", "unknown-builder", "rampp", "did you mean `ramp`?"),
        ("zzz()", "unknown-builder", "zzz", "there are ramp, ball"),
        ("ramp(widht 4 cm)", "unknown-size", "widht", "did you mean `width`?"),
        (
            "ball(qq 4 cm)",
            "unknown-size",
            "qq",
            "it has radius, and a place: x, y, z, along, across, over, columns, rows, levels",
        ),
        ("ball(radius 4 cm, radius 5 cm)", "twice", "radius", ""),
        ("ball(radius 4)", "dimension", "4", "write `radius 40 cm`"),
        ("ramp(slope 4 cm)", "dimension", "4 cm", "write `slope 90 deg`"),
        ("ramp(steps 4 cm)", "dimension", "4 cm", "write `steps 4`"),
        ("ball() and ramp(over 4)", "dimension", "4", "write `over 40 cm`"),
    ],
)
def test_what_cannot_be_built_is_blamed_at_its_place(
    scene: str, code: str, blamed: str, hint: str
) -> None:
    assert _faults(scene) == [(code, blamed, hint)]


def test_a_unit_that_there_is_not_is_reported_once_by_the_checker() -> None:
    analysis = _analysis("ball(radius 4 cmm)")
    assert find_scene_faults(analysis, BUILDERS) == ()
    assert [fault.code for fault in analysis.faults] == ["unknown-unit"]


def test_all_faults_of_a_scene_are_reported_in_order() -> None:
    codes = [code for code, _, _ in _faults("ramp(slope 4 cm, steep 3, steps 4 deg)")]
    assert codes == ["dimension", "unknown-size", "dimension"]


def test_sizes_are_metres_radians_and_ones() -> None:
    analysis = _analysis("ramp(width 40 cm, slope 90 deg, steps 3)")
    ((model, example),) = list_examples(analysis)
    assert model.name.text == "a"
    assert isinstance(example.scene, s.SceneBuilt)
    (solid,) = example.scene.solids
    assert convert_sizes(solid) == {"width": 0.4, "slope": math.pi / 2, "steps": 3.0}


def _read_faults(stated: str) -> list[tuple[str, str]]:
    text = (
        f'model a\n  face top\n  level: top is level\n  example "e" from "e.ply" {stated} holds\n'
    )
    found = analyse(Path("a.model"), text).faults
    return [(f.code, f.source.text[f.span.start : f.span.end]) for f in found]


@pytest.mark.parametrize("unit", [*METRES_PER, "none"])
@pytest.mark.parametrize("up", [*UP_AXES, "auto", "none", '"0, .5,-1"'])
def test_what_options_take_can_be_stated_of_a_file(unit: str, up: str) -> None:
    assert _read_faults(f'(up {up}, unit {unit}, scale "height = 74 cm", sensor "0,-1,2")') == []


@pytest.mark.parametrize(
    ("stated", "code", "blamed"),
    [
        ("(upp z)", "stated", "upp"),
        ("(up w)", "stated", "w"),
        ("(unit inches)", "stated", "inches"),
        ('(sensor "0,1")', "stated", '"0,1"'),
        ("(up z, up y)", "twice", "up"),
    ],
)
def test_a_wrong_option_for_a_file_is_blamed_at_its_place(
    stated: str, code: str, blamed: str
) -> None:
    assert _read_faults(stated) == [(code, blamed)]
