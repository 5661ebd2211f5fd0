"""The robot in the controller's hands: a state as a node of the problem, and the state one period later."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import (
    POINTS,
    Figures,
    FootInput,
    FootState,
    State,
    angular_momentum,
    euler_rate,
    step,
)
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.ground.level import GroundUnderfoot
from rollgait.plant.state import RobotState
from rollgait.robot.robot import Robot
from rollgait.transcription.layout import StageLayout

Array = NDArray[np.float64]


class RobotModel:
    """The planner's step with the figures of one robot.

    Args:
        robot: the robot.
        layout: of the controller's nodes.
    """

    def __init__(self, robot: Robot, layout: StageLayout) -> None:
        self._inertia = robot.inertia_matrix.tolist()
        self._momentum = robot.mean_inertia
        self._steerable = list(layout.steerable)
        inverse = np.linalg.inv(robot.inertia_matrix).tolist()
        legs = robot.leg_list
        self._figures = Figures(
            robot.mass, inverse, [leg.foot for leg in legs], [leg.heading for leg in legs]
        )

    def node(self, state: RobotState) -> Array:
        """The state as a node vector, in the units of the variables."""
        L = angular_momentum(np, state.euler.tolist(), state.euler_rate.tolist(), self._inertia)
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
        """The state one period later: the planner's step with Python's numbers, which are the quickest.

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
        points = [t, t + period, *(t + period * point for point in POINTS)]
        height, rate = ground.foot_heights(clock, np.array(points), state.foot_position[:, :2])
        theta, p = state.euler.tolist(), state.foot_position.tolist()
        z, heading = height[0].tolist(), state.heading.tolist()
        under = ground.under(clock, t, state.foot_position[:, :2], height[0])
        L = angular_momentum(math, theta, state.euler_rate.tolist(), self._inertia)
        feet = tuple(FootState([p[i][0], p[i][1], z[i]], heading[i]) for i in range(4))
        x = State(state.com_position.tolist(), theta, state.com_velocity.tolist(), L, feet)
        rates = rate[2:].T.tolist()
        given = zip(force.tolist(), motion.tolist(), rates, strict=True)
        end, _ = step(math, x, [FootInput(*values) for values in given], period, self._figures, under, wrench)
        foot_position = np.array([foot.p for foot in end.feet])
        reached = ground.foot_heights(clock, np.array([t + period]), foot_position[:, :2])
        foot_position[:, 2] = reached[0][0]
        return RobotState(
            time=t + period,
            com_position=np.array(end.r),
            euler=np.array(end.theta),
            com_velocity=np.array(end.dr),
            euler_rate=np.array(euler_rate(math, end.theta, end.L, self._figures)),
            foot_position=foot_position,
            heading=np.array([foot.sigma for foot in end.feet]),
            speed=motion[:, 0].copy(),
        )
