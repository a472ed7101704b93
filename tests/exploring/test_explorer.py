"""The loop of an exploration with a robot in simulated time, and what may end it."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from facetlog.errors import InputError
from facetlog.exploring.explorer import Explorer
from facetlog.exploring.open_questions import Interest
from facetlog.judging.view_verdicts import ViewVerdict
from facetlog.robot.collecting.next_stop import Around
from facetlog.robot.collecting.record import read_record
from facetlog.robot.collecting.request import Request
from facetlog.robot.collecting.run import plan_rings
from facetlog.robot.collecting.steering import Pace
from facetlog.robot.collecting.tour_file import Tour
from facetlog.robot.mount.mount import DEFAULT_MOUNT
from facetlog.robot.pose2 import Pose2
from facetlog.stream import Goal
from tests.exploring.explorations import (
    FORBIDDEN,
    REACH,
    START,
    TARGET,
    Exploration,
    all_open,
    judged,
    led,
    log_of,
)

GOAL = Goal("table", 0.9)


def test_it_explores_until_the_goal_is_reached_and_says_why_each_view(tmp_path: Path) -> None:
    asked: list[Interest] = []

    def judge(views: int, interest: Interest) -> ViewVerdict:
        asked.append(interest)
        return ViewVerdict(views, ("t1 is a table",), needs=led(0.95 if views >= 5 else 0.7))

    explorer = Explorer(judge, goal=GOAL, most=24)
    exploration = Exploration(tmp_path, explorer)
    ended = exploration.run()
    assert (ended.taken, ended.fault) == (5, None)
    assert explorer.reached
    assert exploration.stops.reason == (
        "table holds to 95%, 90% wanted; another name may stand first by what was not seen (0%)"
    )
    assert [len(interest.places) for interest in asked] == [3, 4, 5]
    results = [line["result"] for line in log_of(tmp_path)[1:]]
    assert results == ["chosen", "taken"] * 5 + ["explored", "ended"]
    chosen = [line for line in log_of(tmp_path) if line.get("result") == "chosen"]
    assert all(line["why"] for line in chosen)
    assert chosen[3]["undecided"]
    said = exploration.heard.lines
    assert any(line.startswith("next view004.png: ") for line in said)
    assert any(line.startswith("of 4 views: t1 is a table") for line in said)
    nearest = min(math.dist((p.x, p.y), TARGET[:2]) for p in exploration.robot.true_path)
    assert nearest > FORBIDDEN[0].radius


def test_a_goal_that_is_reached_does_not_end_it_while_another_name_may_overtake(
    tmp_path: Path,
) -> None:
    judge = judged(lambda views: ViewVerdict(views, needs=led(0.95, wrong=0.2 / (views - 2))))
    explorer = Explorer(judge, goal=GOAL, most=24)
    exploration = Exploration(tmp_path, explorer)
    assert exploration.run().taken == 4
    assert explorer.reached
    assert "another name may stand first by what was not seen (10%)" in exploration.stops.reason
    said = exploration.heard.lines
    assert any("table holds to 95%, 90% wanted; another name" in line for line in said)


def test_a_name_that_the_views_before_the_last_one_ruled_out_is_not_settled_by_it(
    tmp_path: Path,
) -> None:
    def judge(views: int) -> ViewVerdict:
        if views % 2 and views < 6:
            return replace(all_open(views), excluded=("table", "desk"))
        return ViewVerdict(views, needs=led(0.95))

    exploration = Exploration(tmp_path, Explorer(judged(judge), most=24))
    # At 4 and at 6 views a table leads, of which those before said that it is none.
    assert exploration.run().taken == 7
    said = exploration.heard.lines
    assert said.count("before this view it was no table: more views are to say which") == 2


def test_an_interrupted_exploration_goes_on_where_the_robot_stands(tmp_path: Path) -> None:
    def interrupted(views: int) -> ViewVerdict:
        if views == 4:
            raise KeyboardInterrupt
        return all_open(views)

    first = Exploration(tmp_path, Explorer(judged(interrupted), most=6))
    with pytest.raises(KeyboardInterrupt):
        first.run()
    assert first.robot.stops > 0
    last = log_of(tmp_path)[-1]
    assert (last["fault"], last["taken"]) == ("interrupted", 4)
    assert "go on with --resume --start" in first.heard.lines[-1]

    here = first.robot.true
    second = Exploration(tmp_path, Explorer(judged(all_open), most=6), start=here, resume=True)
    assert second.run().taken == 2
    _, taken = read_record(tmp_path)
    assert [view.name for view in taken] == [f"view{n:03d}.png" for n in range(1, 7)]


def test_who_resumes_elsewhere_has_the_same_places_to_choose_from(tmp_path: Path) -> None:
    tour = Tour("explore", (), TARGET)
    asked = Request("tcp:nobody", tour, tmp_path, None, None, DEFAULT_MOUNT, START)
    began = plan_rings(asked, REACH, Pace())
    later = replace(asked, start=Pose2(2.9, 0.9, 2.0))
    lines = [{"explore": began.to_json()}]
    resumed = plan_rings(later, REACH, Pace(), lines)
    assert resumed.first == began.first
    places = [
        {tuple(c.pose.centre.round(6).tolist()) for c in each.candidates(4)}
        for each in (began, resumed)
    ]
    assert places[0] == places[1]
    other = replace(later, tour=Tour("explore", (), TARGET + 0.1))
    assert plan_rings(other, REACH, Pace(), lines).first != began.first


def test_the_rings_are_written_and_read_back(tmp_path: Path) -> None:
    exploration = Exploration(tmp_path, Explorer(judged(all_open), most=24))
    around = Around.from_json(json.loads(json.dumps(exploration.around.to_json())))
    for found, wanted in zip(around.candidates(1), exploration.around.candidates(1), strict=True):
        assert found.stop.robot == wanted.stop.robot
        assert found.seconds == wanted.seconds
    for line in ({"explore": None}, {"tour": "paper"}):
        with pytest.raises(InputError, match="give a folder that was collected by --explore"):
            Around.recorded([line])
    for bad in (None, {}, {"target": [1.0]}, [1, 2]):
        with pytest.raises(InputError, match="give a folder that was collected by --explore"):
            Around.from_json(bad)
