"""Settings that reach a robot which acknowledges nothing."""

from collections.abc import Sequence
from dataclasses import replace

from facetlog.robot.pioneer.limits import Limits, make_limit_settings, send_until_confirmed
from facetlog.robot.pioneer.packets.commands import name_command
from facetlog.robot.pioneer.packets.packet import Packet
from facetlog.robot.pioneer.packets.reports import Configuration
from tests.robot.pioneer.scripted import CONFIGURATION

OWN = make_limit_settings(Limits(), CONFIGURATION)
TAKEN = replace(
    CONFIGURATION, speed_max=300, turning_max=30, deceleration=1200, turning_deceleration=120
)


def sent(*told: Configuration | None) -> list[list[str]]:
    """What goes out each time, where CONFIG says this one after the other."""
    rounds: list[list[str]] = []
    answers = iter(told)

    def send(packets: Sequence[Packet]) -> None:
        rounds.append([name_command(packet) for packet in packets])

    send_until_confirmed(OWN, send, lambda: next(answers))
    return rounds


ALL = ["BUMPSTALL 3", "SETV 300", "SETRV 30", "SETA -1200", "SETRA -120"]


def test_what_config_shows_is_sent_once_and_the_bumpers_setting_three_times() -> None:
    assert sent(TAKEN, TAKEN) == [ALL, ["BUMPSTALL 3"], ["BUMPSTALL 3"]]


def test_what_did_not_arrive_is_sent_again_until_it_shows() -> None:
    lacks = replace(TAKEN, turning_max=100, deceleration=300)
    again = ["BUMPSTALL 3", "SETRV 30", "SETA -1200"]
    assert sent(lacks, TAKEN) == [ALL, again, ["BUMPSTALL 3"]]
    assert sent(lacks, lacks) == [ALL, again, again]


def test_where_config_is_not_answered_all_is_sent_three_times_and_no_more() -> None:
    assert sent(None, None) == [ALL] * 3
