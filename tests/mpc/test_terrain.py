"""The controller on terrain: it follows the ground, and level ground is level ground however it is said."""

from collections.abc import Iterator

import numpy as np
import pytest

from rollgait.angles import turned
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.ground.around import GroundAround
from rollgait.mpc.ground.raster import SLOPE as SLOPE_OF
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from rollgait.terrain import Terrain, WheelSurface, base_reference
from tests.mpc.conftest import PATIENT

FORWARD = VelocityCommand(forward=0.3)
SLOPE = 10.0


@pytest.fixture(scope="module")
def shared() -> Mpc:
    return Mpc("centauro", PATIENT, kernels=False)


@pytest.fixture
def walker(shared: Mpc) -> Iterator[Mpc]:
    shared.reset("drive")
    yield shared
    shared.set_ground(0.0)


def ramp(yaw_deg: float = 0.0) -> Terrain:
    """Without end, through the origin."""
    return Terrain.from_parts(
        [
            {
                "kind": "ramp",
                "x": -10.0 * np.cos(np.radians(yaw_deg)),
                "y": -10.0 * np.sin(np.radians(yaw_deg)),
                "z": -10.0 * np.tan(np.radians(SLOPE)),
                "length": 20.0,
                "slope_deg": SLOPE,
                "yaw_deg": yaw_deg,
            }
        ]
    )


def drive(mpc: Mpc, terrain: Terrain | None, steps: int, yaw: float = 0.0, gait: str = "drive") -> RobotState:
    """The rigid body after some steps."""
    mpc.reset(gait)
    mpc.set_ground(0.0 if terrain is None else terrain)
    plant = RigidPlant(mpc.robot, standing_state(mpc.robot, yaw=yaw, terrain=terrain), terrain=terrain)
    for _ in range(steps):
        control, prediction = mpc.step(plant.state, FORWARD)
        assert prediction.status.mode == "tracking"
        plant.step(control)
    return plant.state


@pytest.mark.parametrize("gait", ["drive", "crawl"])
def test_level_terrain_is_level_ground(walker: Mpc, gait: str) -> None:
    """But for the axes in which feet are compared with their stance, those of the tilted base."""
    level, terrain = (drive(walker, ground, 60, gait=gait) for ground in (None, Terrain()))
    np.testing.assert_allclose(terrain.com_position, level.com_position, atol=3e-3)
    np.testing.assert_allclose(terrain.foot_position, level.foot_position, atol=5e-3)


def test_a_turned_world_turns_the_motion(walker: Mpc) -> None:
    angle = np.pi / 2.0
    one, other = drive(walker, ramp(), 40), drive(walker, ramp(90.0), 40, yaw=angle)
    np.testing.assert_allclose(other.com_position, turned(one.com_position, angle), atol=1e-5)
    np.testing.assert_allclose(other.foot_position, turned(one.foot_position, angle), atol=1e-5)
    np.testing.assert_allclose(other.euler - [angle, 0.0, 0.0], one.euler, atol=1e-5)


def test_the_robot_follows_a_slope(walker: Mpc) -> None:
    terrain = ramp()
    end = drive(walker, terrain, 120)
    feet, wanted = end.foot_position, base_reference(end.foot_position, 0.0)
    assert end.com_position[0] > 0.15
    np.testing.assert_allclose(feet[:, 2], WheelSurface(terrain, 0.124).height(*feet[:, :2].T), atol=1e-6)
    assert end.com_position[2] - wanted.ground == pytest.approx(walker.robot.height, abs=0.02)
    assert end.euler[1] == pytest.approx(wanted.pitch, abs=np.radians(2.0))


def test_a_height_takes_the_terrain_away_again(walker: Mpc) -> None:
    before = drive(walker, None, 20)
    drive(walker, ramp(), 2)
    after = drive(walker, None, 20)
    np.testing.assert_allclose(after.com_position, before.com_position, atol=1e-9)


def test_rolling_wheels_of_a_stepping_gait_stay_off_a_kerb(walker: Mpc) -> None:
    terrain = Terrain.from_parts([{"kind": "step", "x": 0.45, "height": 0.1}])
    mpc = walker
    mpc.reset("crawl")
    mpc.set_ground(terrain)
    plant = RigidPlant(mpc.robot, standing_state(mpc.robot, terrain=terrain), terrain=terrain)
    for _ in range(150):  # the front wheels would reach the kerb
        control, _ = mpc.step(plant.state, VelocityCommand(forward=0.15))
        plant.step(control)
        standing = plant.state.foot_position[control.contact]
        assert (standing[:, 2] < 0.02).all() or (standing[:, 0] > 0.45).any()


def test_a_robot_that_stands_after_a_fault_stays_as_the_slope_has_it(walker: Mpc) -> None:
    terrain = ramp()
    walker.reset("drive")
    walker.set_ground(terrain)
    plant = RigidPlant(walker.robot, standing_state(walker.robot, terrain=terrain), terrain=terrain)
    wanted = plant.state.euler[1]
    assert abs(wanted) > np.radians(3.0)
    plant.step(walker.step(plant.state, VelocityCommand())[0])
    walker.stop("a test")
    for _ in range(150):
        plant.step(walker.step(plant.state, VelocityCommand())[0])
    assert plant.state.euler[1] == pytest.approx(wanted, abs=np.radians(0.3))
    assert np.hypot(*plant.state.com_velocity[:2]) < 0.02


def test_a_control_on_a_slope_has_its_forces_at_the_true_contact(walker: Mpc) -> None:
    terrain = ramp()
    walker.reset("drive")
    walker.set_ground(terrain)
    state = standing_state(walker.robot, terrain=terrain)
    control, _ = walker.step(state, FORWARD)
    touch = WheelSurface(terrain, 0.124).touch(state.foot_position[:, :2])
    assert control.contact_offset is not None
    np.testing.assert_allclose(state.foot_position + control.contact_offset, touch.contact, atol=1e-6)
    np.testing.assert_allclose(control.way_factor, 1.0 / np.cos(np.radians(SLOPE)), atol=1e-6)


def test_a_wheel_beside_a_kerb_does_not_feel_it(walker: Mpc) -> None:
    terrain = Terrain.from_parts([{"kind": "step", "x": 0.9, "height": 0.15}])
    look = GroundAround(terrain, walker.robot).look
    beside = np.array([[[x, 0.0]] * 4 for x in (0.70, 0.74, 0.759)])
    np.testing.assert_allclose(look(beside)[..., SLOPE_OF], 0.0, atol=1e-9)
