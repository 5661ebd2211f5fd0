"""The rigid body with four feet as a plant, integrated by SciPy's DOP853: not by the planner's step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.foot import planar_motion
from rollgait.dynamics.step import Figures, angular_momentum, euler_rate, rotation
from rollgait.dynamics.wrench import external, mean_wrench
from rollgait.mpc.footwork import Footwork
from rollgait.plant.control import Control
from rollgait.plant.fall import is_fallen
from rollgait.plant.stance import standing_state
from rollgait.plant.state import RobotState
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import GRAVITY, FootKind, Robot

if TYPE_CHECKING:
    from rollgait.terrain.terrain import Terrain
    from rollgait.terrain.wheel_surface import WheelSurface

Array = NDArray[np.float64]

TOLERANCE: Final = 1e-8


class RigidPlant:
    """Equations 1 to 4 of the paper in continuous time; feet do what they are told, as their kind allows.

    On the ground point feet stand still, and wheels that do not steer go nowhere but along their heading.
    Legs are as long as they need to be: `rollgait.mpc.log.MpcReport.outside` says by how much too long.

    Args:
        robot: whose figures it has (they need not be the controller's).
        start: where it begins; it stands at the origin if not given.
        noise: standard deviation of a random velocity change in each period, m/s (and rad/s).
        seed: of the noise.
        terrain: the ground; level, as high as the controller has it, if not given.
        wrenches: what pulls at the base.
    """

    name = "rigid"

    def __init__(
        self,
        robot: Robot,
        start: RobotState | None = None,
        noise: float = 0.0,
        seed: int = 0,
        terrain: Terrain | None = None,
        wrenches: Sequence[Wrench] = (),
    ) -> None:
        from scipy.integrate import solve_ivp  # takes a tenth of a second to load

        self._solve_ivp = solve_ivp
        self._robot, self._noise = robot, noise
        self._state = standing_state(robot, terrain=terrain) if start is None else start
        self._random = np.random.default_rng(seed)
        legs = robot.leg_list
        self._figures = Figures(
            robot.mass,
            np.linalg.inv(robot.inertia_matrix).tolist(),
            [leg.foot for leg in legs],
            [leg.heading for leg in legs],
        )
        self._legs_by_kind: dict[FootKind, list[int]] = {}
        for i, leg in enumerate(legs):
            self._legs_by_kind.setdefault(leg.foot, []).append(i)
        self._heading_offset = np.array([leg.heading for leg in legs])
        self._pinned = Footwork(robot).pinned()
        self._surfaces = None if terrain is None else _surfaces(terrain, robot)
        self._wrenches = tuple(wrenches)
        self._pushes: list[tuple[float, Array]] = []
        self.fallen = False

    @property
    def state(self) -> RobotState:
        """The state now."""
        return self._state

    def push(self, force: Array, duration: float) -> None:
        """From now on a force on the CoM, N, for a time, s."""
        self._pushes.append((self._state.time + duration, np.asarray(force, dtype=float)))

    def step(self, control: Control) -> None:
        """One period."""
        x, period = self._state, control.period
        self._pushes = [push for push in self._pushes if push[0] > x.time + 1e-9]
        pushing = np.sum([force for _, force in self._pushes], axis=0) if self._pushes else np.zeros(3)
        pulled = mean_wrench(self._wrenches, self._robot.com_offset, x.time, x.time + period)
        I_B = self._robot.inertia_matrix.tolist()
        L = np.array(angular_momentum(np, x.euler.tolist(), x.euler_rate.tolist(), I_B))
        height = control.end.foot_position[:, 2]
        lift_rate = (height - x.foot_position[:, 2]) / period
        y0 = np.concatenate(
            [x.com_position, x.euler, x.com_velocity, L, x.foot_position[:, :2].ravel(), x.heading]
        )
        z0 = x.foot_position[:, 2]
        offset = self._touch(x.foot_position)[1] * control.contact[:, None]
        motion = np.where(control.contact[:, None] & self._pinned, 0.0, control.motion)

        def rate(t: float, y: Array) -> Array:
            theta, momentum, heading = y[3:6], y[9:12], y[20:24]
            p = np.column_stack([y[12:20].reshape(4, 2), z0 + lift_rate * t])
            acceleration = (control.force.sum(axis=0) + pushing) / self._robot.mass
            acceleration[2] -= GRAVITY
            torque = np.cross(p + offset - y[:3], control.force).sum(axis=0)
            if pulled is not None:
                force, turning = external(pulled, rotation(np, list(theta)))
                acceleration += np.array(force) / self._robot.mass
                torque += turning
            rates = self._euler_rate(theta, momentum)
            velocity, turn = self._feet(motion, heading, theta[0], rates[0])
            return np.concatenate([y[6:9], rates, acceleration, torque, velocity.ravel(), turn])

        found = self._solve_ivp(rate, (0.0, period), y0, method="DOP853", rtol=TOLERANCE, atol=TOLERANCE)
        y = found.y[:, -1]
        if self._noise:
            y[6:9] += self._noise * self._random.normal(size=3)
            y[9:12] += self._noise * self._robot.inertia_matrix @ self._random.normal(size=3)
        feet = np.column_stack([y[12:20].reshape(4, 2), height])
        if self._surfaces is not None:  # a foot that stands is on the ground, where the others are is told
            feet[control.contact, 2] = self._touch(feet)[0][control.contact]
        self._state = RobotState(
            time=x.time + period,
            com_position=y[:3],
            euler=y[3:6],
            com_velocity=y[6:9],
            euler_rate=self._euler_rate(y[3:6], y[9:12]),
            foot_position=feet,
            heading=y[20:24],
            speed=motion[:, 0].copy(),
        )
        self.fallen |= self._has_fallen()

    def _touch(self, feet: Array) -> tuple[Array, Array]:
        """z of the ground under feet (4, 3), (4,), and from there to the contacts, (4, 3), m."""
        if self._surfaces is None:
            return feet[:, 2], np.zeros((4, 3))
        height, offset = np.empty(4), np.empty((4, 3))
        for surface, legs in self._surfaces:
            touch = surface.touch(feet[legs, :2])
            height[legs] = touch.height
            offset[legs] = touch.contact - np.column_stack([feet[legs, :2], touch.height])
        return height, offset

    def _feet(self, motion: Array, heading: Array, yaw: float, yaw_rate: float) -> tuple[Array, Array]:
        """Planar velocities (4, 2), m/s, and heading rates (4,), rad/s, of the feet."""
        velocity, turn = np.empty((4, 2)), np.empty(4)
        for kind, legs in self._legs_by_kind.items():
            foot = planar_motion(
                np, kind, motion[legs].T, heading[legs], yaw, yaw_rate, self._heading_offset[legs]
            )
            velocity[legs], turn[legs] = np.column_stack(foot.velocity), foot.heading_rate
        return velocity, turn

    def _has_fallen(self) -> bool:
        x = self._state
        tilt = np.cos(x.euler[1]) * np.cos(x.euler[2])
        height = x.com_position[2] - x.foot_position[:, 2].min()
        return is_fallen(tilt, height, self._robot.height)

    def _euler_rate(self, theta: Array, L: Array) -> Array:
        return np.array(euler_rate(np, list(theta), list(L), self._figures))


def _surfaces(terrain: Terrain, robot: Robot) -> list[tuple[WheelSurface, list[int]]]:
    """The surface of each radius of wheels, and which legs have it."""
    from rollgait.terrain.wheel_surface import WheelSurface

    radii = [leg.wheel_radius or 0.0 for leg in robot.leg_list]
    return [
        (WheelSurface(terrain, radius), [i for i, own in enumerate(radii) if own == radius])
        for radius in sorted(set(radii))
    ]
