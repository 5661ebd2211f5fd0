"""From a command to what the horizon shall look like: poses, velocities, headings and speeds of wheels.

The reference is a pose that moves by the command, from where it was (the robot is drawn to it, and drift does
not add up), but stays near the robot. Wheels are to point along the velocity that their place on the robot
has, or against it, whichever the joints allow with less steering.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.clock import GaitClock
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.footwork import Footwork, Twist
from rollgait.mpc.settings import CommandLimits
from rollgait.plant.state import RobotState
from rollgait.robot.robot import Robot

Array = NDArray[np.float64]

LEASH: Final = 0.07
"""Farthest of the reference from the robot, m."""
TURN_LEASH: Final = 0.2
"""The same for the yaw, rad."""
APPROACH_TIME: Final = 0.5
"""Time constant of the last approach to a pose, s."""
BRAKING_SHARE: Final = 0.7
"""Share of the acceleration limit that the approach to a pose counts on."""
TURN_CRUISE: Final = 0.5
"""Largest yaw rate on the way to a pose, rad/s."""
HEIGHT_RATE: Final = 0.1
"""With which the height changes, m/s."""
SLOW: Final = 0.03
"""A foot that shall move more slowly keeps its heading, m/s."""
ARRIVED: Final = 0.01
"""A reference that moves more slowly has arrived, m/s and rad/s."""
STEERING_MARGIN: Final = 0.15
"""Distance that headings keep from the ends of the steering range, rad."""
STICKY: Final = 0.6
"""By how much nearer another direction must be before a wheel changes between forward and backward, rad."""
STEERING_SHARE: Final = 0.8
"""Share of the steering rate that is counted on."""

_HALF_TURNS: Final = np.pi * np.arange(-3, 4)[:, None]
"""From the direction of a velocity to the headings that a wheel may have along or against it, rad."""
_BACKWARD: Final = (np.arange(-3, 4) % 2).astype(bool)[:, None]
"""Which of them are against it."""
_LEGS: Final = np.arange(4)

Pose = tuple[float, float, float]
"""x, y (m), yaw (rad)."""


@dataclass(frozen=True, eq=False)
class Reference:
    """What the nodes of a horizon shall look like.

    Attributes:
        pose: (r, yaw), (4, N + 1), m and rad.
        rate: its rate, (4, N + 1).
        heading: σ, (4, N + 1), rad.
        speed: v, (4, N + 1), m/s.
        foot_velocity: of the nominal places of the feet, base-yaw frame, (2, 4, N + 1), m/s.
    """

    pose: Array
    rate: Array
    heading: Array
    speed: Array
    foot_velocity: Array


class ReferenceMaker:
    """Moves the reference pose from step to step and looks ahead from it."""

    def __init__(self, robot: Robot, limits: CommandLimits, steering_rate: float, height: float) -> None:
        self._limits, self._height, self._steering_rate = limits, height, steering_rate
        self._stance = robot.stance[:, :2]
        self._feet = Footwork(robot)
        self._offset = np.array([leg.heading for leg in robot.leg_list])
        ranges = np.array([leg.steering for leg in robot.leg_list])
        self._low, self._high = ranges[:, 0] + STEERING_MARGIN, ranges[:, 1] - STEERING_MARGIN
        self._pose: Pose = (0.0, 0.0, 0.0)
        self._twist: Twist = (0.0, 0.0, 0.0)
        self._backward = np.zeros(4, dtype=bool)
        self._height_change = 0.0

    @property
    def pose(self) -> Pose:
        """The reference pose now."""
        return self._pose

    @property
    def twist(self) -> Twist:
        """The reference twist now."""
        return self._twist

    def reset(self, state: RobotState) -> None:
        """The reference is where the robot is, at rest."""
        self._pose = (float(state.com_position[0]), float(state.com_position[1]), float(state.euler[0]))
        self._twist, self._height_change = (0.0, 0.0, 0.0), 0.0
        self._backward[:] = False

    def begin_at(self, pose: Pose, twist: Twist) -> None:
        """The reference is somewhere, and moves."""
        self._pose, self._twist, self._height_change = pose, twist, 0.0

    def look_ahead(
        self,
        state: RobotState,
        command: VelocityCommand | PoseCommand,
        clock: GaitClock,
        elapsed: float,
        count: int,
        interval: float,
    ) -> Reference:
        """Moves on by `elapsed` s, and returns the reference of the next `count` intervals."""
        aligned, wait = self._alignment(state, command, clock)
        wanted = self._wanted_by_pose(command, clock)
        here = wanted(self._pose)
        self._pose, self._twist = self._advance(self._pose, self._twist, here, elapsed, aligned)
        self._pose = self._on_leash(self._pose, state)
        change = command.height_change - self._height_change
        self._height_change += max(-HEIGHT_RATE * elapsed, min(HEIGHT_RATE * elapsed, change))
        pose, twist = self._pose, self._twist
        ahead = []
        for k in range(count + 1):
            ahead.append((*pose, *twist))
            scale = aligned if k * interval < wait else 1.0
            pose, twist = self._advance(pose, twist, wanted(pose), interval, scale)
        poses, twists = np.array(ahead).T.reshape(2, 3, count + 1)
        return self._with_wheels(state, poses, twists, interval, command, clock)

    # -- the pose ----------------------------------------------------------------------------------------

    def _advance(
        self, pose: Pose, twist: Twist, wanted: Twist, time: float, scale: float
    ) -> tuple[Pose, Twist]:
        forward, lateral, turn = (scale * value for value in wanted)
        limits = self._limits
        dx, dy = forward - twist[0], lateral - twist[1]
        change = math.hypot(dx, dy)
        share = min(1.0, limits.acceleration * time / change) if change > 0.0 else 0.0
        turn_change = limits.turn_acceleration * time
        new = (
            twist[0] + share * dx,
            twist[1] + share * dy,
            twist[2] + max(-turn_change, min(turn_change, turn - twist[2])),
        )
        yaw = pose[2] + 0.5 * time * new[2]
        c, s = math.cos(yaw), math.sin(yaw)
        moved = (
            pose[0] + time * (c * new[0] - s * new[1]),
            pose[1] + time * (s * new[0] + c * new[1]),
            pose[2] + time * new[2],
        )
        return moved, new

    def _ahead(self, state: RobotState, command: VelocityCommand | PoseCommand, clock: GaitClock) -> Twist:
        """Where the wheels are to point: where the reference goes; at its end where the robot is still to go.

        A robot at rest beside its goal would stay there: wheels across the way have no reason to turn.
        """
        arrived = max(abs(value) for value in self._twist) < ARRIVED
        if isinstance(command, PoseCommand) and arrived and clock.gait.swing == 0.0:
            here = (float(state.com_position[0]), float(state.com_position[1]), float(state.euler[0]))
            return self._wanted(here, command, clock)
        return self._wanted(self._pose, command, clock)

    def _wanted_by_pose(
        self, command: VelocityCommand | PoseCommand, clock: GaitClock
    ) -> Callable[[Pose], Twist]:
        """The twist that the command asks for, by the pose: velocities are the same everywhere."""
        if isinstance(command, PoseCommand):
            return lambda pose: self._wanted(pose, command, clock)
        everywhere = self._wanted(self._pose, command, clock)
        return lambda _: everywhere

    def _wanted(self, pose: Pose, command: VelocityCommand | PoseCommand, clock: GaitClock) -> Twist:
        """The twist that the command asks for at a pose."""
        gait = clock.gait
        if clock.brakes:
            return (0.0, 0.0, 0.0)
        if isinstance(command, VelocityCommand):
            forward, lateral, turn = command.forward, command.lateral, command.turn_rate
        else:
            limits = self._limits
            dx, dy = command.x - pose[0], command.y - pose[1]
            away = math.hypot(dx, dy)
            speed = _approach(away, command.cruise, limits.acceleration)
            share = speed / away if away > 0.0 else 0.0
            c, s = math.cos(pose[2]), math.sin(pose[2])
            forward, lateral = share * (c * dx + s * dy), share * (c * dy - s * dx)
            left = math.radians(command.yaw_deg) - pose[2]
            largest = min(TURN_CRUISE, limits.turn_rate)
            turn = math.copysign(_approach(abs(left), largest, limits.turn_acceleration), left)
        speed = math.hypot(forward, lateral)
        share = min(1.0, gait.speed_max / speed) if speed > 0.0 else 1.0
        turn = max(-gait.turn_rate_max, min(gait.turn_rate_max, turn))
        return self._feet.within(gait, (share * forward, share * lateral, turn))

    def _on_leash(self, pose: Pose, state: RobotState) -> Pose:
        x, y, yaw = float(state.com_position[0]), float(state.com_position[1]), float(state.euler[0])
        dx, dy = pose[0] - x, pose[1] - y
        away = math.hypot(dx, dy)
        share = LEASH / away if away > LEASH else 1.0
        turned = max(-TURN_LEASH, min(TURN_LEASH, pose[2] - yaw))
        return (x + share * dx, y + share * dy, yaw + turned)

    # -- the wheels --------------------------------------------------------------------------------------

    def _foot_velocity(self, twist: Array) -> Array:
        """Of the nominal places in the base-yaw frame, (2, 4, …), m/s, for a twist (3, …)."""
        x, y = self._stance.T if twist.ndim == 1 else self._stance.T[:, :, None]
        return np.array([twist[0] - twist[2] * y, twist[1] + twist[2] * x])

    def _alignment(
        self, state: RobotState, command: VelocityCommand | PoseCommand, clock: GaitClock
    ) -> tuple[float, float]:
        """How well the wheels point to where they shall go, 0 … 1, and how long until they do, s."""
        if clock.gait.wheels == "locked":
            return 1.0, 0.0
        wanted = self._foot_velocity(np.array(self._ahead(state, command, clock)))
        moves = (np.hypot(*wanted) > SLOW) & self._feet.steers
        if not moves.any():
            return 1.0, 0.0
        steering = state.heading - state.euler[0]
        goal, self._backward = self._steering(wanted, steering, moves)
        off = float(np.abs(goal - steering)[moves].max())
        return max(0.0, math.cos(min(off, 0.5 * math.pi))) ** 2, off / (STEERING_SHARE * self._steering_rate)

    def _steering(self, velocity: Array, steering: Array, moves: NDArray[np.bool_]) -> tuple[Array, Array]:
        """σ − θz along or against a velocity, and which of the two, (4,) each."""
        angle = np.arctan2(velocity[1], velocity[0])
        candidates = angle + _HALF_TURNS
        distance = np.abs(candidates - steering) + STICKY * (self._backward != _BACKWARD)
        outside = np.maximum(self._low - candidates, candidates - self._high)
        distance = distance + 100.0 * np.maximum(outside, 0.0)
        best = distance.argmin(axis=0)
        goal = candidates[best, _LEGS]
        return np.where(moves, goal, steering), np.where(moves, _BACKWARD[best, 0], self._backward)

    def _with_wheels(
        self,
        state: RobotState,
        poses: Array,
        twists: Array,
        interval: float,
        command: VelocityCommand | PoseCommand,
        clock: GaitClock,
    ) -> Reference:
        count = poses.shape[1]
        velocity = self._foot_velocity(twists)
        size = np.hypot(velocity[0], velocity[1])
        c, s = np.cos(poses[2]), np.sin(poses[2])
        steering = state.heading - state.euler[0]
        wanted = self._foot_velocity(np.array(self._ahead(state, command, clock)))
        rolls = clock.gait.wheels == "rolling"
        moves = np.hypot(*wanted) > SLOW
        goal, _ = self._steering(wanted, steering, moves)
        sign = np.where(self._backward, -1.0, 1.0)
        angle = np.arctan2(velocity[1], velocity[0]) + np.where(self._backward, np.pi, 0.0)[:, None]
        near = goal[:, None] + (angle - goal[:, None] + np.pi) % (2.0 * np.pi) - np.pi
        moving = (size > SLOW) & moves[:, None]
        ahead = np.where(moving, near, goal[:, None])
        # a foot at rest keeps its heading in the world
        heading = np.where(moves[:, None], poses[2] + ahead, state.heading[:, None] + np.zeros(count))
        left = np.maximum(
            0.0,
            np.abs(goal - steering)[:, None]
            - STEERING_SHARE * self._steering_rate * interval * np.arange(count),
        )
        speed = sign[:, None] * size * np.cos(np.minimum(left, 0.5 * np.pi)) * rolls
        steers = self._feet.steers[:, None]
        heading = np.where(steers, heading, poses[2] + self._offset[:, None])
        speed = np.where(steers, speed, self._feet.rolling(velocity) * rolls)
        rate = np.array([c * twists[0] - s * twists[1], s * twists[0] + c * twists[1], 0 * c, twists[2]])
        pose = np.array([poses[0], poses[1], np.full(count, self._height + self._height_change), poses[2]])
        return Reference(pose, rate, heading, speed, velocity)


def _approach(distance: float, largest: float, acceleration: float) -> float:
    """Speed at a distance from the goal: it can brake in time, and creeps up to the goal at last."""
    braking = math.sqrt(2.0 * BRAKING_SHARE * acceleration * distance)
    return min(largest, braking, distance / APPROACH_TIME)
