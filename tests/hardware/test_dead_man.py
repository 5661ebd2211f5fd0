"""Whatever fails, the robot stands; and nothing moves that was not enabled."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rollgait.hardware.last_stage import COMMAND_AGE_MAX
from rollgait.hardware.operator import COMMAND_TIMEOUT
from rollgait.hardware.topics import COMMANDS, SENSORS
from rollgait.mpc.mpc import Mpc
from tests.hardware.rig import Rig

PERIOD = 0.01


def test_nothing_is_told_to_the_joints_before_the_robot_is_enabled(rig: Rig) -> None:
    rig.run(0.3, lambda: rig.drive(0.3))
    assert rig.bridge.phase == "off"
    assert not rig.told


def test_a_switch_that_was_on_all_the_time_enables_nothing(rig: Rig) -> None:
    rig.run(0.3, lambda: rig.switch(True))
    assert rig.bridge.phase == "off"
    assert not rig.told


def test_a_robot_that_is_not_seen_is_not_enabled(rig: Rig) -> None:
    rig.cable.connected = False
    rig.run(0.2)
    rig.enable()
    assert rig.bridge.phase == "off"
    assert "not enabled: nothing comes on /joint_states" in rig.bridge.events[-1].text


def test_without_commands_the_robot_stands_and_goes_on_with_the_next(up: Rig) -> None:
    up.run(1.5, lambda: up.drive(0.3))
    assert up.speed > 0.2
    up.run(COMMAND_TIMEOUT - 2 * PERIOD)
    assert up.bridge.mpc.wanted[0] == pytest.approx(0.3, abs=0.02)
    up.run(1.2)
    assert up.stands()
    assert up.bridge.phase == "active"
    up.run(1.0, lambda: up.drive(0.3))
    assert up.speed > 0.1


def test_an_operator_who_leaves_stops_the_robot_at_once(up: Rig) -> None:
    up.run(1.0, lambda: up.drive(0.3))
    before = up.bridge.mpc.wanted[0]
    up.bridge.operator.leave()
    up.run(0.1)
    assert up.bridge.mpc.wanted[0] < before - 0.02
    up.run(1.2)
    assert up.stands()


def test_without_states_the_robot_stands_until_it_is_enabled_anew(up: Rig) -> None:
    up.run(1.0, lambda: up.drive(0.3))
    up.robot._late.clear()
    muted, up.robot._measure = up.robot._measure, lambda: None  # type: ignore[method-assign]
    assert up.until("stopped", 0.1 + 3 * PERIOD, lambda: up.drive(0.3)) >= 0.1 - PERIOD
    up.run(1.5, lambda: up.drive(0.3))
    assert up.stands()
    up.robot._measure = muted  # type: ignore[method-assign]
    up.run(0.3, lambda: up.drive(0.3))
    assert up.bridge.phase == "stopped"
    up.enable()
    up.run(1.0, lambda: up.drive(0.3))
    assert up.bridge.phase == "active"
    assert up.speed > 0.1


def test_in_the_middle_of_a_step_feet_come_down(mpc: Mpc) -> None:
    rig = Rig(mpc, gait="crawl")
    rig.enable()
    rig.until("active", 3.0)
    while rig.robot.touching.all():
        rig.run(0.01, lambda: rig.drive(0.1))
        assert rig.loopback.time < 8.0
    rig.run(0.3, lambda: rig.drive(0.1))
    assert not rig.robot.touching.all()
    rig.robot._late.clear()
    rig.robot._measure = lambda: None  # type: ignore[method-assign]
    rig.until("stopped", 0.2)
    rig.run(2.0)
    assert rig.stands()


def test_a_robot_whose_bridge_is_gone_holds(up: Rig) -> None:
    up.run(1.0, lambda: up.drive(0.3))
    for _ in range(round(1e3 * (COMMAND_AGE_MAX + 0.02))):
        up.loopback.pass_time()
    assert up.robot.held
    for _ in range(1500):
        up.loopback.pass_time()
    assert up.stands()


@pytest.mark.parametrize(("seconds", "phase"), [(0.06, "active"), (0.5, "stopped")])
def test_a_bridge_that_stalls_goes_on_or_stands(up: Rig, seconds: float, phase: str) -> None:
    up.run(1.0, lambda: up.drive(0.3))
    for _ in range(round(1e3 * seconds)):
        up.loopback.pass_time()
    up.run(0.5, lambda: up.drive(0.3))
    assert up.bridge.phase == phase
    up.run(1.5)
    assert up.stands()


def test_a_cable_that_is_pulled_stops_both_sides(up: Rig) -> None:
    up.run(1.0, lambda: up.drive(0.3))
    up.cable.connected = False
    up.until("stopped", 0.2, lambda: up.drive(0.3))
    up.run(1.0)
    assert up.robot.held
    assert up.stands()


def test_switched_off_it_lies_down_and_is_told_nothing_any_more(up: Rig) -> None:
    up.run(0.5, lambda: up.drive(0.3))
    height = up.robot.truth.com_position[2]
    up.switch(False)
    up.until("lying", 4.0)
    up.until("off", 10.0)
    assert up.robot.truth.com_position[2] < height - 0.1
    up.run(0.05)
    up.told.clear()
    up.run(0.2, lambda: up.drive(0.3))
    assert not up.told
    assert up.stands()


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from([*SENSORS, *COMMANDS]), st.binary(max_size=200))
def test_no_bytes_end_the_bridge_or_move_it(rig: Rig, topic: object, data: bytes) -> None:
    rig.hand.publish(topic, data)  # type: ignore[arg-type]
    rig.run(0.02)
    assert rig.bridge.phase == "off"
    assert not rig.told


def test_joint_targets_of_a_whole_drive_keep_every_bound(up: Rig) -> None:
    up.run(1.0, lambda: up.drive(0.6))
    up.bridge.operator.leave()
    up.run(0.5)
    bounds = up.bridge.plant._bounds
    position = np.array([each["position"] for each in up.told])
    torque = np.array([each["effort"] for each in up.told])
    assert np.all(np.abs(np.diff(position, axis=0)) <= bounds.speed * PERIOD + 1e-9)
    assert np.all(np.abs(torque) <= bounds.torque + 1e-9)
    assert up.bridge.plant.stage.cuts == 0
