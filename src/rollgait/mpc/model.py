"""The robot in the controller's hands: a state as a node of the problem, and the state one period later."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import POINTS, Figures, angular_momentum, euler_rate
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.ground.level import GroundUnderfoot
from rollgait.plant.state import RobotState
from rollgait.robot.robot import Robot
from rollgait.transcription.layout import StageLayout
from rollgait.transcription.one_step import OneStep

Array = NDArray[np.float64]


class RobotModel:
    """The planner's step with the figures of one robot.

    Args:
        robot: the robot.
        layout: of the controller's nodes.
        on_slopes: whether the ground has any.
        pulled: whether there are wrenches from outside.
    """

    def __init__(
        self, robot: Robot, layout: StageLayout, on_slopes: bool = False, pulled: bool = False
    ) -> None:
        self._inertia = robot.inertia_matrix.tolist()
        self._momentum = robot.mean_inertia
        self._steerable = list(layout.steerable)
        inverse = np.linalg.inv(robot.inertia_matrix).tolist()
        legs = robot.leg_list
        self._figures = Figures(
            robot.mass, inverse, [leg.foot for leg in legs], [leg.heading for leg in legs]
        )
        figures = self._figures
        self._step = OneStep(
            figures.kinds, robot.mass, robot.inertia_matrix, figures.heading_offset, on_slopes, pulled
        )

    def node(self, state: RobotState) -> Array:
        """The state as a node vector, in the units of the variables."""
        L = angular_momentum(math, state.euler.tolist(), state.euler_rate.tolist(), self._inertia)
        return np.concatenate(
            [
                state.euler,
                np.array(L) / self._momentum,
                state.com_position,
                state.com_velocity,
                state.foot_position[:, :2].ravel(),
                state.heading[self._steerable],
            ]
        )

    def state(self, node: Array, time: float, foot_position: Array, speed: Array) -> RobotState:
        """The state that a node vector means: the inverse of `node`.

        Args:
            node: in the units of the variables.
            time: s.
            foot_position: (4, 3), m; a node knows no heights.
            speed: of the wheels, (4,), m/s; of point feet nothing.
        """
        theta, L = node[:3], self._momentum * node[3:6]
        figures, kinds = self._figures, self._figures.kinds
        heading = np.array([theta[0] + offset for offset in figures.heading_offset])
        heading[self._steerable] = node[20:]
        return RobotState(
            time=time,
            com_position=node[6:9].copy(),
            euler=theta.copy(),
            com_velocity=node[9:12].copy(),
            euler_rate=np.array(euler_rate(math, theta.tolist(), L.tolist(), figures)),
            foot_position=foot_position,
            heading=heading,
            speed=np.where([kind == "point" for kind in kinds], 0.0, speed),
        )

    def after(
        self,
        state: RobotState,
        force: Array,
        motion: Array,
        period: float,
        clock: GaitClock,
        ground: GroundUnderfoot,
        wrench: Sequence[float] | None = None,
    ) -> RobotState:
        """The state one period later: the planner's step.

        Args:
            state: at its beginning.
            force: on the feet, (4, 3), N.
            motion: (v, σ̇) of the feet, (4, 2), m/s and rad/s.
            period: s.
            clock: how high each foot is when.
            ground: under the feet.
            wrench: from outside, as `dynamics.wrench` has it; None where there is none.
        """
        t = state.time
        points = np.array([t, t + period, *(t + period * point for point in POINTS)])
        height, rate = ground.foot_heights(clock, points, state.foot_position[:, :2])
        under = ground.under(clock, t, state.foot_position[:, :2], height[0])
        given = self._step.given
        given["period"][0] = period
        given["r"][:], given["theta"][:] = state.com_position, state.euler
        given["dr"][:], given["dtheta"][:] = state.com_velocity, state.euler_rate
        given["p"][:], given["sigma"][:] = state.foot_position.ravel(), state.heading
        given["p"][2::3] = height[0]
        given["force"][:], given["motion"][:] = force.ravel(), motion.ravel()
        given["lift_rate"][:] = rate[2:].T.ravel()
        if wrench is not None:
            given["wrench"][:] = wrench
        if under is not None:
            self._step.put_ground(under)
        end = self._step()
        foot_position = end["p"].reshape(4, 3)
        if under is not None:  # another place has another height
            height, _ = ground.foot_heights(clock, points[1:2], foot_position[:, :2])
        foot_position[:, 2] = height[1 if under is None else 0]
        return RobotState(
            time=t + period,
            com_position=end["r"],
            euler=end["theta"],
            com_velocity=end["dr"],
            euler_rate=end["dtheta"],
            foot_position=foot_position,
            heading=end["sigma"],
            speed=motion[:, 0].copy(),
        )
