"""Commands: what is beyond the limits is cut, and said; what is none is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.errors import InputError, UnknownNameError
from rollgait.mpc.command import PoseCommand, VelocityCommand, check_command
from rollgait.mpc.settings import CommandLimits

LIMITS = CommandLimits()
numbers = st.floats(-10.0, 10.0)


@given(numbers, numbers, numbers, numbers)
def test_a_cut_velocity_keeps_its_direction_and_the_note_says_so(
    forward: float, lateral: float, turn: float, height: float
) -> None:
    asked = VelocityCommand(forward=forward, lateral=lateral, turn_rate=turn, height_change=height)
    cut, note = asked.within(LIMITS)
    speed = math.hypot(cut.forward, cut.lateral)
    assert speed <= LIMITS.speed + 1e-9
    assert abs(cut.turn_rate) <= LIMITS.turn_rate
    assert abs(cut.height_change) <= LIMITS.height_change
    assert math.isclose(cut.forward * lateral, cut.lateral * forward, abs_tol=1e-6)
    assert cut.forward * forward >= 0.0
    assert cut.turn_rate * turn >= 0.0
    for word, changed in (
        ("speed", math.hypot(forward, lateral) > LIMITS.speed),
        ("turn rate", cut.turn_rate != turn),
        ("height change", cut.height_change != height),
    ):
        assert (word in note) == changed
    again, silence = cut.within(CommandLimits(speed=LIMITS.speed * (1.0 + 1e-9)))
    assert again == cut
    assert silence == ""


@given(numbers, numbers, st.floats(-720.0, 720.0), st.floats(0.0, 5.0))
def test_a_pose_stays_and_its_cruise_is_cut(x: float, y: float, yaw: float, cruise: float) -> None:
    asked = PoseCommand(x=x, y=y, yaw_deg=yaw, cruise=cruise)
    cut, note = asked.within(LIMITS)
    assert (cut.x, cut.y, cut.yaw_deg) == (x, y, yaw)
    assert cut.cruise == min(cruise, LIMITS.speed)
    assert ("cruise" in note) == (cruise > LIMITS.speed)


def test_what_is_within_the_limits_is_left_alone() -> None:
    asked = VelocityCommand(forward=0.3, turn_rate=-0.2, gait="crawl")
    cut, note = asked.within(LIMITS)
    assert cut is asked
    assert note == ""


@pytest.mark.parametrize("kind", [VelocityCommand, lambda **data: PoseCommand(x=0.0, **data)])
def test_an_unknown_gait_lists_the_known_ones(kind) -> None:
    with pytest.raises(UnknownNameError, match="valid: trot"):
        check_command(kind(gait="trott"))


@pytest.mark.parametrize("thing", [None, "forward", {"forward": 1.0}, (0.1, 0.0, 0.0)])
def test_what_is_no_command_is_refused(thing: object) -> None:
    with pytest.raises(InputError, match="command"):
        check_command(thing)  # type: ignore[arg-type]


@pytest.mark.parametrize("data", [{"forward": math.nan}, {"forward": "1"}, {"forwards": 1.0}])
def test_a_command_is_made_of_numbers(data: dict) -> None:
    with pytest.raises(InputError, match="forward"):
        VelocityCommand(**data)
