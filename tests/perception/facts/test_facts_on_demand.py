"""Facts that are worked out when someone asks for them: a kind that fails ends nothing."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from shapely.errors import GEOSException

from facetlog.perception.facts import part_facts
from facetlog.perception.facts.all_facts import facts_on_demand
from facetlog.perception.surfaces.exact_solids.polyhedra import cuboid
from facetlog.perception.types import Camera, Pose

# A view from a metre beneath it, upwards.
SCENE = replace(
    cuboid(0.3, 0.2, 0.1),
    views=("view.png",),
    cameras=(Camera(320, 240, 450.0, 450.0, 159.5, 119.5),),
    poses=(Pose(np.eye(3), np.array([0.1, 0.05, -1.0])),),
)
DRAWN = {"junction", "line_at", "contour"}


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise GEOSException("side location conflict")

    monkeypatch.setattr(part_facts, "drawing_rows", fail)


@pytest.mark.usefixtures("failing")
def test_what_fails_is_named_and_all_else_is_there(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, logger="facetlog"):
        found = {fact.functor for fact in facts_on_demand(SCENE)}
    assert not found & DRAWN
    assert {"piece", "piece_size"} <= found
    (line,) = caplog.messages
    assert "side location conflict" in line
    assert all(kind in line for kind in DRAWN)
