"""From joystick and keys to velocities: symmetric, limited, none in the dead zone, none without hands."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.view.driving.hands import DEAD_ZONE, KEYS, PATIENCE, REST, Hands, Wish, wish_from, wish_of

share = st.floats(-1.5, 1.5)
keys = st.sets(st.sampled_from("wasdqe"))
MIRRORED = str.maketrans("adqe", "daeq")
BACKWARDS = str.maketrans("ws", "sw")


@given(share, share, share, keys)
def test_left_and_right_are_mirror_images(right: float, up: float, turn: float, held: set[str]) -> None:
    one = wish_of(right, up, turn, held)
    other = wish_of(-right, up, -turn, {key.translate(MIRRORED) for key in held})
    assert (one.forward, one.lateral, one.turn) == (other.forward, -other.lateral, -other.turn)


@given(share, share, share, keys)
def test_forward_and_back_are_mirror_images(right: float, up: float, turn: float, held: set[str]) -> None:
    one = wish_of(right, up, turn, held)
    other = wish_of(right, -up, turn, {key.translate(BACKWARDS) for key in held})
    assert (one.forward, one.lateral, one.turn) == (-other.forward, other.lateral, other.turn)


@given(share, share, share, keys, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_no_more_than_the_limits_is_asked_for(
    right: float, up: float, turn: float, held: set[str], speed: float, rate: float
) -> None:
    command = wish_of(right, up, turn, held).velocity(speed, rate)
    assert math.hypot(command.forward, command.lateral) <= speed * (1.0 + 1e-12)
    assert abs(command.turn_rate) <= rate


@given(st.floats(0.0, DEAD_ZONE - 1e-9), st.floats(-math.pi, math.pi), st.floats(-DEAD_ZONE, DEAD_ZONE))
def test_the_dead_zone_does_nothing(way: float, angle: float, turn: float) -> None:
    assert wish_of(way * math.sin(angle), way * math.cos(angle), turn).rests


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(-math.pi, math.pi))
def test_farther_is_faster_in_the_direction_of_the_stick(a: float, b: float, angle: float) -> None:
    near, far = (wish_of(way * math.sin(angle), way * math.cos(angle), 0.0) for way in (min(a, b), max(a, b)))
    slow, fast = (math.hypot(wish.forward, wish.lateral) for wish in (near, far))
    assert slow <= fast + 1e-12
    if fast > 0.0:
        assert fast * math.cos(angle) == pytest.approx(far.forward, abs=1e-9)
        assert fast * math.sin(angle) == pytest.approx(-far.lateral, abs=1e-9)


def test_the_end_of_the_way_is_the_whole_speed_and_the_stick_starts_gently() -> None:
    assert wish_of(0.0, 1.0, 0.0) == Wish(forward=1.0)
    assert wish_of(0.0, 0.0, 1.0) == Wish(turn=-1.0)
    assert 0.0 < wish_of(0.0, DEAD_ZONE + 1e-3, 0.0).forward < 0.01  # no jump at the edge of the dead zone


@pytest.mark.parametrize("key", KEYS)
def test_a_key_is_the_end_of_one_way(key: str) -> None:
    wish = wish_of(0.0, 0.0, 0.0, {key})
    assert (wish.forward, wish.lateral, wish.turn) == KEYS[key]


@given(
    st.recursive(st.none() | st.booleans() | st.floats() | st.text(), st.lists)
    | st.dictionaries(
        st.sampled_from(["stick", "turn", "keys"]),
        st.none() | st.floats() | st.lists(st.floats() | st.text()),
    )
)
def test_messages_of_any_kind_give_a_wish_within_the_limits(message: Any) -> None:
    wish = wish_from(message)
    assert math.hypot(wish.forward, wish.lateral) <= 1.0 + 1e-12
    assert abs(wish.turn) <= 1.0


class Clock:
    """Time that passes when told."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


FORWARD, LEFT = Wish(forward=1.0), Wish(lateral=1.0)


def test_who_is_silent_has_let_go() -> None:
    clock = Clock()
    hands = Hands(clock=clock)
    hands.report("a", FORWARD)
    clock.now = PATIENCE
    assert hands.wish == FORWARD
    clock.now = PATIENCE + 0.01
    assert hands.wish == REST
    hands.report("a", FORWARD)
    assert hands.wish == FORWARD


def test_who_leaves_has_let_go_and_the_other_one_has_the_robot() -> None:
    hands = Hands(clock=Clock())
    hands.report("a", FORWARD)
    hands.report("b", LEFT)
    assert hands.wish == LEFT
    hands.leave("b")
    assert hands.wish == FORWARD
    hands.leave("a")
    hands.leave("a")
    assert hands.wish == REST


def test_after_a_stop_everybody_must_let_go_first() -> None:
    hands = Hands(clock=Clock())
    hands.report("a", FORWARD)
    hands.stop()
    assert hands.wish == REST
    hands.report("a", FORWARD)  # still held
    assert hands.wish == REST
    hands.report("a", REST)
    hands.report("a", FORWARD)
    assert hands.wish == FORWARD
