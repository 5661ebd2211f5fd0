"""What is estimated is what is true, as far as the sensors let it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rollgait.hardware.estimation import BodyEstimator, base_rotation
from rollgait.hardware.measured import Imu, Joints, Odometry, Sensors
from rollgait.hardware.simulated import SensorNoise, SimulatedRobot
from rollgait.hardware.topics import encoded
from rollgait.hardware.transports.loopback import Loopback
from rollgait.mpc.mpc import Mpc
from rollgait.plant.stance import standing_state
from rollgait.robot.urdf_model import load_model
from rollgait.robot.whole_body import find_whole_body
from rollgait.ros.messages import joint_state
from rollgait.ros.topics import JOINT_STATES
from rollgait.tracking.follower import Follower
from tests.hardware.rig import Rig

SILENT = SensorNoise(
    joint_position=0.0,
    joint_velocity=0.0,
    effort=0.0,
    tilt=0.0,
    angular_velocity=0.0,
    acceleration=0.0,
    place=0.0,
    yaw=0.0,
    velocity=0.0,
    latency=0.0,
)


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (3.0, -2.0, 2.5)])
def test_without_noise_the_state_is_the_true_one(mpc: Mpc, place: tuple[float, float, float]) -> None:
    loopback = Loopback()
    robot = SimulatedRobot(mpc.robot, loopback.end(), noise=SILENT, place=place)
    loopback.each_tick(lambda _: robot.tick())
    end = loopback.end()
    model = load_model(find_whole_body(mpc.robot))
    sensors = Sensors(end, model.joint_names, lambda: loopback.time, 0.01)
    estimator = BodyEstimator(model, mpc.robot, 0.01)
    robot.push((60.0, 40.0, 0.0), 0.05)
    for _ in range(8):
        while loopback.time < 0.0095 or round(1e3 * loopback.time) % 10:
            loopback.pass_time()
        truth = robot.truth
        end.receive(0.0)
        assert sensors.joints is not None
        assert sensors.imu is not None
        assert sensors.odometry is not None
        found = estimator.estimate(loopback.time, sensors.joints, sensors.imu, sensors.odometry)
        for name in ("com_position", "foot_position", "euler", "heading"):
            np.testing.assert_allclose(getattr(found, name), getattr(truth, name), atol=1e-6, err_msg=name)
        for name in ("com_velocity", "euler_rate", "speed"):
            np.testing.assert_allclose(getattr(found, name), getattr(truth, name), atol=1e-3, err_msg=name)
        loopback.pass_time()


def test_a_robot_at_rest_weighs_what_its_feet_bear(mpc: Mpc) -> None:
    """Its joints bear what its weight on four feet asks of them: forces sum up to it."""
    robot = mpc.robot
    body = find_whole_body(robot)
    follower, model = Follower(body), load_model(body)
    follower.reset(standing_state(robot))
    q = follower.state.q
    state = model.state(q)
    force = np.zeros((4, 3))
    force[:, 2] = robot.static_forces(state.p_foot - state.p_com)
    need = model.inverse_dynamics(q, np.zeros(model.nv), np.zeros(model.nv))
    effort = (need - np.einsum("lij,li->j", state.J_contact, force))[6:]
    still = np.zeros(model.nv - 6)
    estimator = BodyEstimator(model, robot, 0.01)
    odometry = Odometry(0.0, q[:3], q[3:7], np.zeros(3))
    estimator.estimate(0.0, Joints(0.0, q[7:], still, effort), Imu(0.0, q[3:7], np.zeros(3)), odometry)
    np.testing.assert_allclose(estimator.contact_force, force, atol=1e-6 * robot.weight)
    assert estimator.touching.all()


def test_feet_that_bear_nothing_do_not_press(mpc: Mpc) -> None:
    model = load_model(find_whole_body(mpc.robot))
    q = model.posture
    need = model.inverse_dynamics(q, np.zeros(model.nv), np.zeros(model.nv))  # hanging from its base
    estimator = BodyEstimator(model, mpc.robot, 0.01)
    joints = Joints(0.0, q[7:], np.zeros(model.nv - 6), need[6:])
    estimator.estimate(0.0, joints, Imu(0.0, q[3:7], np.zeros(3)), Odometry(0.0, q[:3], q[3:7], np.zeros(3)))
    assert not estimator.touching.any()


def test_yaw_is_the_odometrys_and_tilt_the_imus() -> None:
    drifted = Rotation.from_euler("ZYX", [2.0, 0.1, -0.2]).as_quat()
    known = Rotation.from_euler("ZYX", [0.5, 0.0, 0.0]).as_quat()
    imu, odometry = Imu(0.0, drifted, np.zeros(3)), Odometry(0.0, np.zeros(3), known, np.zeros(3))
    wanted = Rotation.from_euler("ZYX", [0.5, 0.1, -0.2]).as_matrix()
    np.testing.assert_allclose(base_rotation(imu, odometry), wanted, atol=1e-12)


def test_contacts_of_a_crawl_are_known(mpc: Mpc) -> None:
    rig = Rig(mpc, gait="crawl")
    rig.enable()
    rig.until("active", 3.0)
    wrong, force = [], []

    def each() -> None:
        rig.drive(0.1)
        wrong.append(rig.bridge.plant.touching != rig.robot.touching)
        force.append((rig.bridge.plant.contact_force - rig.robot.contact_force)[:, 2])

    rig.run(6.0, each)
    assert rig.bridge.phase == "active"
    assert np.mean(wrong) < 0.1
    assert np.sqrt(np.mean(np.square(force))) < 0.05 * mpc.robot.weight


# -- messages that are wrong, old or lost -----------------------------------------------------------------


def heard(mpc: Mpc) -> tuple[Loopback, Sensors, tuple[str, ...]]:
    loopback = Loopback()
    names = ("a", "b", "c")
    return loopback, Sensors(loopback.end(), names, lambda: loopback.time, 0.01), names


def test_messages_that_are_lost_are_counted(mpc: Mpc) -> None:
    loopback, sensors, names = heard(mpc)
    hand = loopback.end()
    row = np.arange(3.0)
    for k in (0, 1, 2, 5, 6, 9):
        hand.publish(
            JOINT_STATES, encoded(JOINT_STATES, joint_state(10**9 + k * 10**7, names, row, row, row))
        )
        loopback._ends[0].receive(0.0)
    assert sensors.lost == 4
    assert sensors.streams["/joint_states"].count == 6


def test_joints_are_put_in_order_and_what_is_older_is_left_out(mpc: Mpc) -> None:
    loopback, sensors, _ = heard(mpc)
    hand = loopback.end()

    def say(stamp: int, names: tuple[str, ...], row: list[float]) -> None:
        values = np.array(row)
        hand.publish(JOINT_STATES, encoded(JOINT_STATES, joint_state(stamp, names, values, values, values)))
        loopback._ends[0].receive(0.0)

    say(10**9, ("c", "x", "a", "b"), [3.0, 9.0, 1.0, 2.0])
    assert sensors.joints is not None
    np.testing.assert_array_equal(sensors.joints.position, [1.0, 2.0, 3.0])
    say(10**9 - 5, ("a", "b", "c"), [7.0, 7.0, 7.0])
    say(10**9 + 10**7, ("a", "b"), [7.0, 7.0])
    say(10**9 + 2 * 10**7, ("a", "b", "c"), [7.0, np.nan, 7.0])
    np.testing.assert_array_equal(sensors.joints.position, [1.0, 2.0, 3.0])
    assert sensors.streams["/joint_states"].refused == 3
