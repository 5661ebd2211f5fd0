"""The robot on terrain: where it stands, when it has fallen, and what it touches."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the extra whole-body")
pytest.importorskip("pinocchio", reason="needs the extra whole-body")
pytest.importorskip("daqp", reason="needs the extra whole-body")

import mujoco

import rollgait as rg
from rollgait.plant.control import Control
from rollgait.plant.stance import standing_control, standing_state
from rollgait.plant.state import RobotState
from rollgait.plant.unplanned import UnplannedContact
from rollgait.robot.robot import GRAVITY
from rollgait.robot.urdf import import_robot
from rollgait.robot.whole_body import WholeBody, library_whole_body, load_whole_body
from rollgait.simulation import SimulationLog
from rollgait.simulation.measure import ground_under
from rollgait.simulation.plant import MujocoPlant
from rollgait.simulation.world import build_world
from rollgait.terrain import Terrain, WheelSurface
from tests.hostile import motions

PERIOD = 0.01
RADIUS = 0.124
ROBOT = rg.find_robot("centauro")
BODY = library_whole_body("centauro")
ROLLER = Path(__file__).parent.parent / "fixtures" / "roller.yaml"


def start_on(terrain: Terrain, **place: float) -> RobotState:
    """The nominal stance with every foot on the ground, the CoM over the mean of them."""
    state = standing_state(ROBOT, **place)
    xy = state.foot_position[:, :2]
    z = WheelSurface(terrain, RADIUS).height(*xy.T)
    return replace(
        state,
        foot_position=np.column_stack([xy, z]),
        com_position=state.com_position + np.array([0.0, 0.0, z.mean()]),
    )


def stood(plant: MujocoPlant, start: RobotState, duration: float) -> RobotState:
    for _ in range(round(duration / PERIOD)):
        plant.step(standing_control(ROBOT, start.at(plant.time), PERIOD))
    return plant.state


def ramp(degrees: float) -> Terrain:
    return Terrain.from_parts(
        [{"kind": "ramp", "x": -2.0, "length": 4.0, "width": 4.0, "slope_deg": degrees}]
    )


@pytest.mark.parametrize("measured", [False, True])
@pytest.mark.parametrize("yaw", [0.0, 1.0])
def test_who_stands_on_a_ramp_of_10_degrees_stays(measured: bool, yaw: float) -> None:
    exact = ramp(10.0)
    terrain = exact.raster(0.02, (-1.5, -1.5), (1.5, 1.5)) if measured else exact
    start = start_on(exact, yaw=yaw)
    plant = MujocoPlant(BODY, ROBOT, start, terrain=terrain)
    early = stood(plant, start, 0.5)
    late = stood(plant, start, 1.0)
    assert not plant.fallen
    assert not plant.unplanned
    assert np.allclose(late.com_position, start.com_position, atol=4e-3)
    assert np.allclose(late.com_position, early.com_position, atol=1e-3)  # nor does it creep
    assert np.allclose(plant.contact_force.sum(axis=0), [0.0, 0.0, ROBOT.weight], atol=0.01 * ROBOT.weight)


def test_level_terrain_is_the_plane() -> None:
    start = standing_state(ROBOT)
    plants = [MujocoPlant(BODY, ROBOT, start, terrain=t) for t in (None, Terrain.from_parts([]))]
    for plant in plants:
        plant.push(np.array([40.0, 60.0, 0.0]), 0.1)
    one, other = (stood(plant, start, 0.3) for plant in plants)
    for name in ("com_position", "euler", "com_velocity", "foot_position"):
        assert np.allclose(getattr(one, name), getattr(other, name), atol=1e-9)


@pytest.mark.parametrize("level", [-3.0, 5.0])
def test_a_fall_is_one_over_the_ground_under_the_robot(level: float) -> None:
    terrain = Terrain.from_parts(
        [{"kind": "block", "x": 0.0, "length": 3.0, "width": 3.0, "height": level}], height=1.0
    )
    start = start_on(terrain)
    plant = MujocoPlant(BODY, ROBOT, start, terrain=terrain)
    state = stood(plant, start, 0.3)
    assert not plant.fallen
    assert state.foot_position[:, 2] == pytest.approx(1.0 + level, abs=2e-3)
    plant.push(np.array([0.0, 8000.0, 0.0]), 0.3)
    stood(plant, start, 1.5)
    assert plant.fallen


def test_a_ditch_under_one_foot_is_not_the_ground_under_the_robot() -> None:
    terrain = Terrain.from_parts(
        [{"kind": "block", "x": 0.35, "y": 0.35, "length": 0.4, "width": 0.4, "height": -2.0}]
    )
    model = MujocoPlant(BODY, ROBOT, standing_state(ROBOT)).follower.model
    world = build_world(BODY, model.joint_names, terrain=terrain)
    data = mujoco.MjData(world.model)
    q = model.posture
    world.put(data, q[:3], q[3:7], q[7:])
    mujoco.mj_forward(world.model, data)
    feet = data.geom_xpos[list(world.feet), :2]
    assert sorted(terrain.height(*feet.T)) == [-2.0, 0.0, 0.0, 0.0]
    assert ground_under(world, data, terrain, 0.0) == 0.0
    data.qpos[0] += 5000.0
    mujoco.mj_forward(world.model, data)
    assert np.isnan(ground_under(world, data, terrain, 0.0))
    assert ground_under(world, data, None, 0.7) == 0.7


def test_a_riser_stops_the_wheels() -> None:
    start = standing_state(ROBOT)
    riser, rise = float(start.foot_position[:, 0].max()) + 0.25, 0.2
    terrain = Terrain.from_parts([{"kind": "step", "x": riser, "height": rise}])
    plant = MujocoPlant(BODY, ROBOT, start, terrain=terrain)
    state, speed = start, 0.3
    still = standing_control(ROBOT, start, PERIOD)
    motion = np.stack([np.full(4, speed), np.zeros(4)], axis=1)
    for k in range(120):
        ahead = np.array([speed * (k + 1) * PERIOD, 0.0, 0.0])
        end = replace(
            start,
            time=(k + 1) * PERIOD,
            com_position=start.com_position + ahead,
            foot_position=start.foot_position + ahead,
            speed=np.full(4, speed),
        )
        plant.step(Control(state, end, still.force, motion, still.contact))
        state = end
    fronts = plant.state.foot_position[:2]
    assert np.all(fronts[:, 0] < riser - RADIUS + 5e-3)
    assert np.all(fronts[:, 0] > riser - RADIUS - 0.05)
    assert -plant.contact_force[:2, 0].sum() > 20.0  # it is pushed back


@pytest.fixture(scope="module")
def roller() -> tuple[WholeBody, rg.Robot]:
    body = load_whole_body(ROLLER)
    return body, import_robot(body, str(ROLLER)).robot


@pytest.mark.parametrize(("above", "touches"), [(-0.03, False), (0.01, True)])
def test_what_else_than_a_wheel_touches_the_ground_is_said(
    roller: tuple[WholeBody, rg.Robot], above: float, touches: bool
) -> None:
    """A block under the trunk, which is a box of the URDF, lower or higher than its underside."""
    body, robot = roller
    start = standing_state(robot)
    plane = MujocoPlant(body, robot, start)
    trunk = float(plane.pose.base_position[2]) - 0.1
    block = {"kind": "block", "x": 0.0, "length": 0.1, "width": 0.1, "height": trunk + above}
    plant = MujocoPlant(body, robot, start, terrain=Terrain.from_parts([block]))
    assert set(plant.unplanned) == ({"trunk"} if touches else set())
    if touches:
        assert plant.unplanned["trunk"].force > 0.02 * robot.mass * GRAVITY
        assert plant.unplanned["trunk"].time < 0.0  # while it settled


def test_masses_are_those_of_the_urdf_whatever_collides() -> None:
    names = MujocoPlant(BODY, ROBOT, standing_state(ROBOT)).joint_names
    flat, rough = (build_world(BODY, names, terrain=t).model for t in (None, ramp(5.0)))
    assert rough.ngeom > flat.ngeom
    bodies = [
        (model.body(name).mass[0], *model.body(name).inertia)
        for model in (flat, rough)
        for name in ("pelvis", "knee_1", "ankle2_3", "wheel_2")
    ]
    assert np.allclose(bodies[:4], bodies[4:])
    assert rough.body_mass.sum() == pytest.approx(flat.body_mass.sum())


def test_a_log_keeps_its_ground_and_what_touched_it(tmp_path: Path) -> None:
    values = np.zeros((4, 5))
    values[1, 1] = np.nan
    contact = UnplannedContact(link="knee_1", time=1.5, force=20.0)
    terrain = Terrain.from_map(values, 0.5, parts=[{"kind": "step", "x": 1.0, "height": 0.1}])
    for ground in (terrain, ramp(3.0), None):
        log = replace(motions.simulation(), terrain=ground, unplanned=(contact,))
        again = SimulationLog.load(log.save(tmp_path / "log"))
        assert again.terrain == ground
        assert again.report() == log.report()
        assert again.report().unplanned == (contact,)
        assert again.report().to_dict()["unplanned"] == [{"link": "knee_1", "time": 1.5, "force": 20.0}]
        for field in fields(SimulationLog):
            if field.name not in ("slip", "terrain"):
                assert np.all(getattr(again, field.name) == getattr(log, field.name))


@pytest.fixture(scope="module")
def drive() -> rg.JointTrajectory:
    gait = {"kind": "drive"}
    return rg.track(rg.plan(rg.Scenario(robot="centauro", goal={"x": 0.4}, horizon=2.0, gait=gait)))


def test_a_plan_is_executed_on_the_ground_that_is_given(drive: rg.JointTrajectory) -> None:
    """Level ground is the plane; a kerb that the plan does not know of stops it."""
    flat, level = (rg.simulate(drive, terrain=t) for t in (None, Terrain.from_parts([])))
    assert np.allclose(flat.base_position, level.base_position, atol=1e-9)
    assert level.terrain == Terrain.from_parts([])
    ahead = float(drive.reference.foot_position[0, :, 0].max()) + 0.2
    kerb = Terrain.from_parts([{"kind": "step", "x": ahead, "height": 0.15}])
    assert rg.simulate(drive, terrain=kerb).base_position[-1, 0] < flat.base_position[-1, 0] - 0.1
