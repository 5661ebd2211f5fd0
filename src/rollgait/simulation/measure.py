"""What is read from the physics: contact forces, slip, falls, and the planner's state of the robot."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from rollgait.angles import euler_angles, euler_rates, near
from rollgait.plant.fall import is_fallen
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES
from rollgait.robot.urdf_model import WholeBodyModel
from rollgait.simulation.world import World
from rollgait.terrain.terrain import Terrain

Array = NDArray[np.float64]

_AXES: Final = np.arange(3)
_UP: Final = np.array([0.0, 0.0, 1.0])


class Contacts(NamedTuple):
    """What touches the ground.

    Attributes:
        force: of the ground on each foot, (4, 3), N.
        others: what else touches it: number of the body in MuJoCo's model, and size of the force on it, N.
    """

    force: Array
    others: list[tuple[int, float]]


def contacts_of(world: World, data: Any) -> Contacts:
    """Forces of the ground in the step that has just been solved."""
    result = np.zeros((len(LEG_NAMES), 3))
    others: list[tuple[int, float]] = []
    if data.ncon == 0:
        return Contacts(result, others)
    contact = data.contact
    address = contact.efc_address
    active = address >= 0
    if not active.all():
        address = address[active]
    # with elliptic cones the solver's forces are those along the axes of the contact's frame
    local = data.efc_force[address[:, None] + _AXES]
    pairs, frames = contact.geom[active], contact.frame[active].reshape(-1, 3, 3)
    force = np.einsum("ci,cij->cj", local, frames)
    for pair, value in zip(pairs.tolist(), force, strict=True):
        geom = max(pair)  # those of the ground come first
        foot = world.foot_of[geom]
        if foot >= 0:
            result[foot] += value if pair[1] == geom else -value  # acts on the second geom
        else:
            others.append((int(world.model.geom_bodyid[geom]), float(np.linalg.norm(value))))
    return Contacts(result, others)


def slip(world: World, data: Any) -> Array:
    """Speed of the feet's material contact points along the ground, (4,), m/s; NaN in the air."""
    result, twist = np.full(len(LEG_NAMES), np.nan), np.zeros(6)
    for number in range(data.ncon):
        contact = data.contact[number]
        geom = max(contact.geom1, contact.geom2)
        foot = world.foot_of[geom]
        if foot < 0:
            continue
        mujoco.mj_objectVelocity(world.model, data, mujoco.mjtObj.mjOBJ_GEOM, geom, twist, 0)
        velocity = twist[3:] + np.cross(twist[:3], contact.pos - data.geom_xpos[geom])
        normal = contact.frame[:3]
        along = velocity - (velocity @ normal) * normal
        result[foot] = np.fmax(result[foot], np.linalg.norm(along))
    return result


def ground_under(world: World, data: Any, terrain: Terrain | None, height: float) -> float:
    """z of the ground under the robot, m; NaN where it is not known.

    It is the median under its feet, so that a ditch under one of them does not count.

    Args:
        world: where the feet are.
        data: MuJoCo's data.
        terrain: the ground.
        height: of the plane that is the ground where there is no terrain, m.
    """
    if terrain is None:
        return height
    under = terrain.height(*data.geom_xpos[list(world.feet), :2].T)
    known = under[np.isfinite(under)]
    return float(np.median(known)) if known.size else np.nan


def has_fallen(world: World, data: Any, ground: float, height: float) -> bool:
    """Whether the robot has fallen, or the simulation has become unstable.

    Args:
        world: where the base is.
        data: MuJoCo's data.
        ground: z of the ground, m.
        height: of the base above the ground as it should be, m.
    """
    return is_fallen(data.xmat[world.base][8], data.qpos[2] - ground, height)


class StateReader:
    """Reads the planner's state of the robot. Angles go on from the last reading and do not jump.

    Args:
        world: where things are.
        axle_left: unit vectors along the axles, to the left, in the frames of the feet's geoms, (4, 3); zero
            for a point foot.
        state: near the first reading.

    Attributes:
        last: the last reading.
    """

    def __init__(self, world: World, axle_left: Array, state: RobotState) -> None:
        self._world, self._axle_left = world, axle_left
        self._feet = list(world.feet)
        self._bodies = world.model.geom_bodyid[self._feet]
        self._wheels = np.any(axle_left != 0.0, axis=1)
        self.last = state

    def read(self, data: Any, time: float) -> RobotState:
        """The state at the data's positions and velocities; brings what follows from them up to date."""
        world, model = self._world, self._world.model
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_subtreeVel(model, data)
        R_world_base = data.xmat[world.base].reshape(3, 3)
        euler = euler_angles(R_world_base)
        euler[0] = near(euler[0], self.last.euler[0])
        axle = (data.geom_xmat[self._feet].reshape(-1, 3, 3) @ self._axle_left[..., None])[..., 0]
        lying = axle * axle[:, 2:] - _UP
        down = lying / np.sqrt(np.maximum(1.0 - axle[:, 2:] ** 2, 1e-6))
        heading = np.where(self._wheels, np.arctan2(-axle[:, 0], axle[:, 1]), self.last.heading)
        turning = np.sum(axle * data.cvel[self._bodies, :3], axis=1)
        self.last = RobotState(
            time=time,
            com_position=data.subtree_com[world.base].copy(),
            euler=euler,
            com_velocity=data.subtree_linvel[world.base].copy(),
            euler_rate=euler_rates(euler, R_world_base @ data.qvel[3:6]),
            foot_position=data.geom_xpos[self._feet] + world.radius[:, None] * down,
            heading=near(heading, self.last.heading),
            speed=world.radius * turning,
        )
        return self.last


def reader_at(world: World, data: Any, model: WholeBodyModel, state: RobotState) -> StateReader:
    """Reads on from a pose in which the headings are known; which way the axles point is told from it.

    Args:
        world: where things are.
        data: MuJoCo's data at this pose.
        model: which legs have wheels.
        state: the headings there; near the first reading.
    """
    axle = data.geom_xmat[list(world.feet)].reshape(-1, 3, 3)[:, :, 2]
    left = np.stack([-np.sin(state.heading), np.cos(state.heading)], axis=1)
    sign = np.where(np.sum(axle[:, :2] * left, axis=1) < 0.0, -1.0, 1.0)
    wheels = np.array([leg.wheel is not None for leg in model.legs])
    return StateReader(world, np.asarray((sign * wheels)[:, None] * _UP), state)
