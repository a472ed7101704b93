"""What goes out when: properties that hold for any program above."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from facetlog.robot.pioneer.control import LONGEST_LEASE, WATCHDOG, Motion
from facetlog.robot.pioneer.limits import Limits
from facetlog.robot.pioneer.packets.commands import Command, read_argument

ACTIONS = st.one_of(
    st.tuples(
        st.just("drive"),
        st.tuples(st.floats(-0.3, 0.3), st.floats(-0.5, 0.5), st.floats(0.01, LONGEST_LEASE)),
    ),
    st.tuples(st.sampled_from(["rest", "hard", "seen", "other"]), st.none()),
    st.tuples(st.just("time"), st.floats(0.001, 5.0)),
)


@given(st.lists(ACTIONS, max_size=60))
def test_no_speed_is_sent_without_a_lease_and_none_first_after_a_gap(
    actions: list[tuple[str, object]],
) -> None:
    now = 10.0
    motion, leased_until, last_out = Motion(now, Limits()), now, now

    def check(kinds: list[tuple[Command, object]]) -> None:
        nonlocal last_out
        if not kinds:
            return
        if now - last_out >= WATCHDOG:
            assert [k for k in kinds if k[0] is not Command.ESTOP][:2] == [
                (Command.VEL, 0),
                (Command.RVEL, 0),
            ]
        moves = any(k[0] in (Command.VEL, Command.RVEL) and k[1] for k in kinds)
        assert not moves or now < leased_until
        last_out = now

    for action, value in actions:
        match action, value:
            case "drive", (float(speed), float(turning), float(lease)):
                motion.drive(speed, turning, lease, now)
                leased_until = now + lease
            case "rest" | "hard", _:
                motion.rest(hard=action == "hard")
                leased_until = now
            case "seen", _:
                motion.saw(standing=True)
            case "other", _:
                packets = motion.list_packets_before(now)
                other = [(Command(p.kind), read_argument(p)) for p in packets]
                check([*other, (Command.CONFIG, 1)])
            case _, float(seconds):
                now += seconds
        check([(Command(p.kind), read_argument(p)) for p in motion.advance(now)])


@given(st.floats(0.02, 0.3), st.floats(0.05, LONGEST_LEASE))
def test_zeros_follow_the_end_of_a_lease_within_a_moment_of_being_due(
    speed: float, lease: float
) -> None:
    motion, now = Motion(0.0, Limits()), 0.0
    motion.drive(speed, 0.0, lease, now)
    last_speed = None
    zero_at = None
    while now < lease + 1.0:
        for packet in motion.advance(now):
            if packet.kind == Command.VEL:
                if read_argument(packet):
                    last_speed = now
                elif zero_at is None and last_speed is not None:
                    zero_at = now
        now = max(motion.due, now + 0.001)
    assert last_speed is not None
    assert zero_at is not None
    assert lease <= zero_at <= lease + 0.01
    ended = motion.take_ended()
    assert ended is not None
    assert motion.take_ended() is None


def test_an_idle_line_is_never_silent_for_half_the_watchdogs_time() -> None:
    motion, now, times = Motion(0.0, Limits()), 0.0, [0.0]
    while now < 30.0:
        if motion.advance(now):
            times.append(now)
        motion.saw(standing=True)
        now = max(motion.due, now + 0.001)
    assert max(b - a for a, b in pairwise(times)) < WATCHDOG / 2
