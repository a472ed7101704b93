"""Verdicts on ideal solids."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from facetlog.errors import RuleSyntaxError
from facetlog.kb.explaining.proof import State
from facetlog.kb.explaining.verdict import Recognition, Verdict
from facetlog.kb.knowledge_base import BUILTIN_MODELS
from facetlog.kb.recognize import open_knowledge_base, recognize, rule_files

Build = Callable[..., Any]


def verdict(recognition: Recognition, model: str) -> Verdict:
    return next(v for v in recognition.verdicts if v.model == model)


@pytest.mark.parametrize("name", ["box", "table", "chair"])
@pytest.mark.slow
def test_each_model_recognises_its_thing_and_nothing_else_does(facts_of: Build, name: str) -> None:
    found = recognize(facts_of(name), scene_name=name)
    assert found.models == {name}
    assert found.best[0].degree > 0.95


@pytest.mark.parametrize(
    "name", ["wedge", "ramp", "pyramid", "cylinder", "room", "table", "chair", "step"]
)
@pytest.mark.slow
def test_what_is_no_box_is_never_called_one(facts_of: Build, name: str) -> None:
    for up in ((0.0, 0.0, 1.0), None):
        box = verdict(recognize(facts_of(name, up=up), scene_name=name), "box")
        # The notch of a step may be space that was not seen: its solidity has two readings.
        allowed = {State.FAILS, State.UNKNOWN} if name == "step" else {State.FAILS}
        assert box.state in allowed, box.summary


def test_three_faces_without_up_or_scale_are_a_box(facts_of: Build) -> None:
    found = recognize(facts_of("box", seen=(1, 2, 3), up=None, metric=False), scene_name="s")
    box = verdict(found, "box")
    assert box.state is State.HOLDS
    assert [s.name for s in box.sizes] == ["length", "width", "height"]
    assert [s.value for s in box.sizes] == pytest.approx([0.254, 0.2032, 0.1524])
    assert box.length_unit is None
    assert len(box.angles) == 3
    assert all(a.value == pytest.approx(90) for a in box.angles)
    assert verdict(found, "table").state is State.UNKNOWN


@pytest.mark.parametrize("seen", [(1,), (2, 4)])
def test_one_direction_leaves_a_box_open(facts_of: Build, seen: tuple[int, ...]) -> None:
    box = verdict(recognize(facts_of("box", seen=seen), scene_name="s"), "box")
    assert box.state is State.UNKNOWN
    assert "at least 2 are wanted, but there may be more" in box.summary


@pytest.mark.parametrize("seen", [(1, 2), (1, 2, 4)])
def test_two_directions_are_a_box_half_as_sure_as_three(
    facts_of: Build, seen: tuple[int, ...]
) -> None:
    two, three = (
        verdict(recognize(facts_of("box", seen=faces), scene_name="s"), "box")
        for faces in (seen, (1, 2, 3))
    )
    assert (two.state, three.state) == (State.HOLDS, State.HOLDS)
    assert two.degree == pytest.approx(0.5 * three.degree, abs=0.02)


def test_implied_faces_are_no_evidence(facts_of: Build) -> None:
    facts = facts_of("box", seen=(1, 2, 3), implied=(2, 3))
    assert verdict(recognize(facts, scene_name="s"), "box").state is State.UNKNOWN


@pytest.mark.parametrize("name", ["box", "table", "chair"])
@pytest.mark.slow
def test_verdicts_do_not_depend_on_the_frame_or_scale(
    facts_of_solid: Build, solid: Build, name: str
) -> None:
    rotation = Rotation.random(random_state=5).as_matrix()
    turned = solid(name).turned(rotation, scale=1000.0)
    up = rotation @ np.array([0.0, 0.0, 1.0])
    found = recognize(facts_of_solid(turned, up=up, metric=False), scene_name=name)
    assert found.models == {name}


def test_verdicts_do_not_depend_on_the_order_of_facts(facts_of: Build) -> None:
    facts = list(facts_of("box"))
    ordered = recognize(facts, scene_name="s")
    np.random.default_rng(1).shuffle(facts)
    assert recognize(facts, scene_name="s").to_json() == ordered.to_json()


def test_degree_falls_with_uncertainty(facts_of: Build) -> None:
    degrees = [
        verdict(recognize(facts_of("box", angle_sd=sd), scene_name="s"), "box").degree
        for sd in (0.5, 5.0, 10.0)
    ]
    assert degrees[0] > 0.99 > degrees[1] > 0.9 > degrees[2] > 0.5


def test_degree_is_the_probability_of_the_tolerances_that_fade(facts_of: Build) -> None:
    facts = facts_of("box", seen=(1, 2, 3), angle_sd=7.5)  # three angles within 2 sd
    box = verdict(recognize(facts, scene_name="s"), "box")
    square = next(c for c in box.conditions if c.label == "square")
    # The mean over limits from a tenth nearer than 15 degrees to a tenth farther.
    limits = [15.0 * (0.9 + 0.2 * (i + 0.5) / 1000) for i in range(1000)]
    within = math.fsum(math.erf(limit / 7.5 / math.sqrt(2)) for limit in limits) / len(limits)
    assert square.proof.low == pytest.approx(within**3, rel=1e-6)


def test_json_of_a_verdict_names_parts_sizes_angles_and_proof(facts_of: Build) -> None:
    found = recognize(facts_of("box", seen=(1, 2, 3)), scene_name="s")
    data = found.to_json()
    assert data["schema"] == "facetlog-verdicts/2"
    assert data["recognised"] == [{"thing": "t1", "model": "box"}]
    first = next(k for k, each in enumerate(data["verdicts"]) if each["model"] == "box")
    box = data["verdicts"][first]
    assert box["parts"] == {"a": ["f1"], "b": ["f2"], "c": ["f3"]}
    assert box["length_unit"] == "m"
    short = {"label", "reason", "place", "state", "degree", "because"}
    assert all(set(condition) == short for condition in box["conditions"])
    assert box["conditions"][0]["because"]["text"].startswith("3 were found, at least 2 are wanted")
    whole = found.to_json(full=True)["verdicts"][first]["conditions"]
    assert all(set(condition) == short | {"text", "proof"} for condition in whole)
    assert whole[0]["proof"]["state"] == whole[0]["state"] == "holds"


@pytest.mark.slow
def test_a_users_model_stands_beside_the_built_in_ones(facts_of: Build, tmp_path: Path) -> None:
    (tmp_path / "slab.pl").write_text(SLAB)
    found = recognize(facts_of("table"), scene_name="s", model_paths=[tmp_path], trusted=True)
    assert "slab" in found.models
    assert "slab" not in {v.model for v in recognize(facts_of("table"), scene_name="s").verdicts}


def test_a_users_model_takes_the_place_of_a_built_in_one(facts_of: Build, tmp_path: Path) -> None:
    (tmp_path / "box.pl").write_text(SLAB.replace("slab", "box"))
    found = recognize(
        facts_of("table"), scene_name="s", model_paths=[tmp_path / "box.pl"], trusted=True
    )
    assert found.models == {"box", "table"}
    assert len(found.verdicts) == len(BUILTIN_MODELS)


def test_two_files_with_one_model_are_refused(facts_of: Build, tmp_path: Path) -> None:
    for stem in "ab":
        (tmp_path / f"{stem}.pl").write_text(SLAB)
    with pytest.raises(
        RuleSyntaxError, match=r"b\.pl: the model slab is already defined in .*a\.pl"
    ):
        recognize(facts_of("box"), scene_name="s", model_paths=[tmp_path], trusted=True)
    assert recognize(facts_of("box"), scene_name="s").models == {"box"}


def test_a_folder_without_rules_is_named(tmp_path: Path) -> None:
    with pytest.raises(RuleSyntaxError, match=r"has no .model or .pl files"):
        recognize([], scene_name="s", model_paths=[tmp_path])
    with pytest.raises(RuleSyntaxError, match="no such file or folder"):
        recognize([], scene_name="s", model_paths=[tmp_path / "absent"])


SLAB = """
:- module(slab, []).
:- use_module(facetlog(vocabulary)).

model(slab, "A level board.", [board]).
tolerance(flat, 5).
candidate(slab, Thing, [Board]) :- face_of(Thing, Board).
condition(slab, flat, "it lies level", _, [Board], at_most(tilt(Board), tolerance(flat))).
condition(slab, face_up, "it faces up", _, [Board], upward(Board)).
condition(slab, big, "it covers the thing", _, [Board], at_least(share(Board), 0.9)).
"""


def test_files_without_a_model_are_left_out_of_a_folder_and_refused_alone(tmp_path: Path) -> None:
    for name, text in (("a", ""), ("b", "# nothing yet\n"), ("c", "let wide = 5 cm\n")):
        (tmp_path / f"{name}.model").write_text(text)
    with pytest.raises(RuleSyntaxError, match="folder has no"):
        rule_files([tmp_path])
    (tmp_path / "d.model").write_text("model d\n  face a where a is level\n\n  up: a is upward\n")
    assert [path.name for path in rule_files([tmp_path])] == ["d.model"]
    for name in "abc":
        with (
            pytest.raises(RuleSyntaxError, match="no model"),
            open_knowledge_base([tmp_path / f"{name}.model"]),
        ):
            pass
