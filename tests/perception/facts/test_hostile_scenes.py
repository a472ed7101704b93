"""Scenes with any numbers are refused, or have facts of finite numbers, unwarned."""

import json
import math
import random
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from facetlog.perception.facts.all_facts import facts_on_demand, scene_facts
from facetlog.perception.surfaces.exact_solids.builders import build
from facetlog.perception.surfaces.scene_file import SceneFileError, decode_scene, encode_scene

NAMES = ("cuboid", "table", "stairs")
NUMBERS = (0.0, 1e-300, 1e-160, 1e-30, 1e-9, 0.5, 2.0, 1e6, 1e15, 1e20, 1e30, 1e300)
Place = tuple[str | int, ...]


def _content(name: str) -> dict[str, Any]:
    made: dict[str, Any] = json.loads(encode_scene(build(name, {})))
    return made


def _numbers(node: object, place: Place = ()) -> Iterator[Place]:
    if isinstance(node, float):
        yield place
    items = node.items() if isinstance(node, dict) else ()
    items = enumerate(node) if isinstance(node, list) else items
    for key, value in items:
        yield from _numbers(value, (*place, key))


def _set(node: Any, place: Place, value: float) -> None:
    for key in place[:-1]:
        node = node[key]
    node[place[-1]] = value


def _some_numbers(content: dict[str, Any], rng: random.Random) -> None:
    places = list(_numbers(content))
    for _ in range(rng.randint(1, 5)):
        _set(content, rng.choice(places), rng.choice((1.0, -1.0)) * rng.choice(NUMBERS))


def _other_unit(content: dict[str, Any], rng: random.Random) -> None:
    unit = 10 ** rng.uniform(-22.0, 21.0)
    levers = (1.0, 1.0, 1.0, unit)
    for vertex in content["vertices"]:
        vertex["point"] = [unit * x for x in vertex["point"]]
        vertex["cov"] = [[unit**2 * x for x in row] for row in vertex["cov"]]
    for face in content["faces"]:
        face["plane"]["offset"] *= unit
        cov = face["plane"]["cov"]
        face["plane"]["cov"] = [
            [x * levers[i] * levers[j] for j, x in enumerate(row)] for i, row in enumerate(cov)
        ]


def _far_away(content: dict[str, Any], rng: random.Random) -> None:
    shift = [rng.choice((1.0, -1.0)) * 10 ** rng.uniform(0.0, 20.0) for _ in range(3)]
    for vertex in content["vertices"]:
        vertex["point"] = [x + off for x, off in zip(vertex["point"], shift, strict=True)]
    for face in content["faces"]:
        normal = face["plane"]["normal"]
        face["plane"]["offset"] -= sum(n * off for n, off in zip(normal, shift, strict=True))


def _pressed_flat(content: dict[str, Any], rng: random.Random) -> None:
    axis, factor = rng.randrange(3), 10 ** rng.uniform(-200.0, 0.0)
    for vertex in content["vertices"]:
        vertex["point"][axis] *= factor
    for face in content["faces"]:
        if abs(face["plane"]["normal"][axis]) > 0.5:
            face["plane"]["offset"] *= factor


def _other_noise(content: dict[str, Any], rng: random.Random) -> None:
    factor = rng.choice((0.0, 1e-300, 1e-100, 1e10, 1e40))
    for holder in (*content["vertices"], *(face["plane"] for face in content["faces"])):
        holder["cov"] = [[factor * x for x in row] for row in holder["cov"]]


def _nearly_parallel(content: dict[str, Any], rng: random.Random) -> None:
    off = 10 ** rng.uniform(-17.0, -1.0)
    for vertex in content["vertices"]:
        vertex["point"] = [x + rng.uniform(-off, off) for x in vertex["point"]]


def _two_in_one(content: dict[str, Any], rng: random.Random) -> None:
    one, two = rng.sample(content["vertices"], 2)
    one["point"] = list(two["point"])


CHANGES = (
    _some_numbers,
    _other_unit,
    _far_away,
    _pressed_flat,
    _other_noise,
    _nearly_parallel,
    _two_in_one,
)


@settings(max_examples=40)
@given(st.sampled_from(NAMES), st.sampled_from(CHANGES), st.integers(0, 2**32 - 1))
@pytest.mark.slow
def test_facts_are_finite_or_the_scene_is_refused(name: str, change: Any, seed: int) -> None:
    content = _content(name)
    change(content, random.Random(seed))
    try:
        scene = decode_scene(json.dumps(content))
    except SceneFileError:
        return
    for fact in (*scene_facts(scene), *facts_on_demand(scene)):
        assert all(math.isfinite(arg) for arg in fact.args if isinstance(arg, float)), fact
