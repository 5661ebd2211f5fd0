"""What feet of each kind can do in a gait: laws of what is cut, and how far steps carry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rollgait as rg
from rollgait.mpc.footwork import ANYWHERE, FELT, Footwork, stride_share
from rollgait.mpc.gaits import GAITS

ROVER, STRIDER, CENTAURO = (rg.find_robot(name) for name in ("rover", "strider", "centauro"))
ROBOTS = {"rover": ROVER, "strider": STRIDER, "locked": CENTAURO.with_feet("point")}
twists = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
gaits = st.sampled_from(sorted(GAITS))


def with_box(robot: rg.Robot, aside: float, up: float = 0.1) -> rg.Robot:
    """The same robot whose legs reach so far to either side, and up and down, m."""
    legs = {
        name: leg | {"box": [[-0.1, 0.1], [-aside, aside], [-up, up]]}
        for name, leg in robot.model_dump(mode="json")["legs"].items()
    }
    return rg.Robot.model_validate(robot.model_dump(mode="json") | {"legs": legs})


PLANAR = with_box(ROVER, 0.002)
"""Legs that only move ahead and back, over wheels that do not steer."""
MIRROR = np.array([1.0, -1.0, -1.0])
"""Of forward, lateral velocity and yaw rate."""


def velocities(robot: rg.Robot, twist: tuple[float, float, float]) -> np.ndarray:
    """Of the nominal places of the feet, (2, 4), m/s."""
    x, y = robot.stance[:, :2].T
    return np.stack([twist[0] - twist[2] * y, twist[1] + twist[2] * x])


@given(gaits.filter(lambda name: GAITS[name].wheels == "rolling"), twists)
def test_wheels_that_steer_can_go_anywhere(gait: str, twist: tuple[float, float, float]) -> None:
    feet = Footwork(CENTAURO)
    assert feet.within(GAITS[gait], twist) == pytest.approx(twist)
    assert not feet.note(GAITS[gait], twist)


@pytest.mark.parametrize("name", ROBOTS)
@given(gait=gaits, twist=twists)
def test_what_is_cut_is_not_cut_again_and_keeps_its_signs(
    name: str, gait: str, twist: tuple[float, float, float]
) -> None:
    feet = Footwork(ROBOTS[name])
    cut = feet.within(GAITS[gait], twist)
    assert feet.within(GAITS[gait], cut) == pytest.approx(cut, abs=1e-9)
    assert np.all(np.abs(cut) <= np.abs(twist) + np.finfo(float).eps)
    assert np.all(np.sign(cut) * np.sign(twist) >= 0.0)


@given(gaits, twists)
def test_it_is_the_same_in_a_mirror(gait: str, twist: tuple[float, float, float]) -> None:
    feet = Footwork(ROVER)
    cut = MIRROR * feet.within(GAITS[gait], twist)
    np.testing.assert_allclose(feet.within(GAITS[gait], MIRROR * twist), cut, atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
@given(gait=gaits, twist=twists)
def test_a_stance_fits_into_the_box(name: str, gait: str, twist: tuple[float, float, float]) -> None:
    """A foot that is dragged for a stance moves no farther than to the shorter of its sides, both ways."""
    robot, used = ROBOTS[name], GAITS[gait]
    feet = Footwork(robot)
    cut = feet.within(used, twist)
    dragged = feet.dragged(velocities(robot, cut)[..., None], used.wheels == "locked")[..., 0]
    way = 0.5 * (used.period - used.swing) * np.abs(dragged.T) * (used.swing > 0.0)
    low, high = np.moveaxis(robot.foot_boxes()[:, :, :2], 1, 0)
    assert np.all(way <= stride_share(used) * np.minimum(-low, high) + 1e-9)
    if used.swing == 0.0:
        np.testing.assert_allclose(dragged, 0.0, atol=10.0 * FELT)


@given(twists)
def test_what_a_wheel_does_not_roll_it_is_dragged(twist: tuple[float, float, float]) -> None:
    velocity = velocities(ROVER, twist)[..., None]
    feet = Footwork(ROVER)
    dragged, rolled = feet.dragged(velocity), feet.rolling(velocity)
    np.testing.assert_allclose(dragged[0], 0.0, atol=1e-12)  # its wheels point ahead
    np.testing.assert_allclose(rolled, velocity[0], atol=1e-12)
    np.testing.assert_allclose(dragged[1], velocity[1], atol=1e-12)
    np.testing.assert_allclose(Footwork(STRIDER).dragged(velocity), velocity)


def test_who_cannot_roll_there_begins_with_steps_and_is_told() -> None:
    ahead, turning = (0.2, 0.0, 0.0), (0.0, 0.0, 0.2)
    assert Footwork(ROVER).fitting([ahead]) == "drive"
    assert Footwork(ROVER).fitting([ahead, turning]) == "trot"
    assert Footwork(STRIDER).fitting([ahead]) == "trot"
    assert Footwork(CENTAURO).fitting([ahead, turning]) == "drive"
    assert "turn rate 0.2 rad/s is cut to 0 rad/s: wheels that do not steer" in Footwork(ROVER).note(
        GAITS["drive"], turning
    )
    assert "point feet do not roll" in Footwork(STRIDER).note(GAITS["drive"], ahead)


@given(gaits)
def test_legs_that_reach_nothing_aside_keep_all_feet_down(gait: str) -> None:
    instead = Footwork(PLANAR).carried(GAITS[gait])
    assert instead.swing == 0.0
    assert instead.wheels == "rolling" or instead.brakes
    for robot in (ROVER, STRIDER, CENTAURO):
        assert Footwork(robot).carried(GAITS[gait]) == GAITS[gait]


def test_who_gets_no_farther_by_steps_begins_without_and_is_told() -> None:
    feet = Footwork(PLANAR)
    assert feet.fitting(ANYWHERE) == "drive"
    assert feet.able(GAITS["drive"]) == (True, False, False)
    assert feet.unfit().startswith(
        "the robot cannot go sideways or turn in any gait: wheels that do not steer"
    )
    assert "2 mm aside" in feet.unfit()
    for robot, gait in ((ROVER, "trot"), (STRIDER, "trot"), (CENTAURO, "drive")):
        assert Footwork(robot).fitting(ANYWHERE) == gait
        assert Footwork(robot).able(GAITS[gait]) == (True, True, True)
        assert not Footwork(robot).unfit()


@given(st.floats(0.005, 0.2), st.floats(-0.3, 0.3))
def test_the_body_rises_and_sinks_as_far_as_legs_reach(up: float, change: float) -> None:
    feet = Footwork(with_box(ROVER, 0.1, up))
    cut = feet.within_height(change)
    assert abs(cut) <= up + 1e-12
    assert cut == pytest.approx(change) or abs(cut) == pytest.approx(up)
    assert feet.within_height(-change) == pytest.approx(-cut)
