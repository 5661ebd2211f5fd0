"""What drives the joints: PD about the planned joints plus feed-forward, within the effort limits.

    τ = kp (q_planned + Δq − q) + kd (q̇_planned + Δq̇ − q̇) + τ_feedforward

Δq is what a feedback of the base pose adds. kd q̇ is the drive's own and immediate; all else is as old as the
latency says.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import UnknownNameError
from rollgait.robot.robot import Robot
from rollgait.tracking.joints import JointTrajectory

Array = NDArray[np.float64]

WHEEL_MODES: Final = ("angle", "velocity")
"""Wheels follow the integrated planned angle, or only the planned speed."""

LEG_STIFFNESS: Final = 3.5
"""Stiffness of the legs over m g times the height of the CoM: 3000 N m/rad for CENTAURO. At a tenth of it the
stepping motions fall."""

DAMPING_TIME: Final = 0.02
"""Damping over stiffness, s."""

LIGHT_SHARE: Final = 1.0 / 3.0
"""Stiffness of wheels, steering joints and the upper body over that of the legs: they carry less. Wheels much
softer than that give way where they are locked: 33 mm instead of 25 mm at the end of the legged motion."""

SMOOTHING_MAX: Final = 0.1
"""Widest moving average that what is planned goes through, s. A wider one cuts curves, by the square of its
width: at intervals of 0.2 s `wheeled` ends 9.7 mm from its plan with 0.2 s, 5.3 mm with this."""


@dataclass(frozen=True)
class Gains:
    """Of the drives, one per joint.

    Attributes:
        stiffness: kp, (n_j,), N m/rad.
        damping: kd, (n_j,), N m s/rad.
    """

    stiffness: Array
    damping: Array


def gains_for(
    robot: Robot,
    count: int,
    legs: list[int],
    wheels: list[int],
    wheel_mode: str = "angle",
) -> Gains:
    """Gains that suit a robot's weight and size.

    Args:
        robot: the planner's robot.
        count: number of joints, n_j.
        legs: places of the joints that carry the robot.
        wheels: places of the wheels' joints.
        wheel_mode: one of `WHEEL_MODES`.

    Raises:
        UnknownNameError: there is no such wheel mode.
    """
    if wheel_mode not in WHEEL_MODES:
        raise UnknownNameError("wheels", wheel_mode, WHEEL_MODES)
    leg = LEG_STIFFNESS * robot.weight * robot.height
    stiffness = np.full(count, LIGHT_SHARE * leg)
    stiffness[legs] = leg
    damping = DAMPING_TIME * stiffness
    if wheel_mode == "velocity":
        stiffness[wheels] = 0.0
    return Gains(stiffness, damping)


@dataclass(frozen=True)
class JointReference:
    """What the joints shall do at the steps of the simulation: the joint trajectory, then rest at its end.

    Attributes:
        position, velocity, torque: (steps, n_j), rad, rad/s, N m.
    """

    position: Array
    velocity: Array
    torque: Array


def smoothing_of(joints: JointTrajectory) -> float:
    """Width of the moving average that a joint trajectory goes through, s: one interval of its plan.

    Speeds and forces are constant within an interval and jump at its ends. The average turns such a jump into
    the acceleration over an interval that the plan was bounded by; a shorter one asks more of the drives than
    that (`wheeled`: 72 % of a torque limit at 0.03 s, 60 % at 0.1 s).
    """
    return min(joints.interval, SMOOTHING_MAX)


def reference_at(joints: JointTrajectory, times: Array) -> JointReference:
    """The joint trajectory at `times`, (steps,), s, smoothed; the rest after its end."""
    position = interpolated(times, joints.time, joints.joint_position)
    torque = interpolated(times, joints.time, joints.joint_torque)
    step = float(times[1] - times[0])
    width = round(smoothing_of(joints) / step)
    position, torque = (_averaged(values, width) for values in (position, torque))
    return JointReference(position, np.gradient(position, step, axis=0), torque)


def _averaged(values: Array, width: int) -> Array:
    """Mean over `width` steps about each step, the ends held."""
    from scipy.ndimage import uniform_filter1d  # takes a tenth of a second to load

    if width < 2:
        return values
    return np.asarray(uniform_filter1d(values, width, axis=0, mode="nearest"))


def interpolated(times: Array, known: Array, values: Array) -> Array:
    """Linear between samples, constant outside: (len(times), …) from values (n, …)."""
    place = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 2)
    share = np.clip((times - known[place]) / (known[place + 1] - known[place]), 0.0, 1.0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(values[place] * (1.0 - share) + values[place + 1] * share)


class MovingAverage:
    """Mean over the last `width` rows of a stream.

    Args:
        width: number of rows.
        columns: numbers in a row.
    """

    def __init__(self, width: int, columns: int) -> None:
        self.width = width
        self._past: Array = np.zeros((width, columns))

    def fill(self, row: Array) -> None:
        """As if all rows until now had been this one, (columns,)."""
        self._past[:] = row

    def update(self, rows: Array) -> Array:
        """The means at each of the next rows, (n, columns)."""
        known = np.concatenate([self._past, rows])
        total = np.cumsum(known, axis=0)
        self._past = known[len(rows) :]
        return np.asarray((total[self.width :] - total[: -self.width]) / self.width)


class Controller:
    """Computes the controls step by step.

    Args:
        gains: of the drives.
        reference: at every step.
        delay: age of all it knows and sends, in steps.
    """

    def __init__(self, gains: Gains, reference: JointReference, delay: int = 0) -> None:
        self._gains, self._delay = gains, delay
        self.load(reference)
        self._waiting: list[Array] = []
        self.shift: Array = np.zeros_like(reference.position[0])
        """Δq, (n_j,), rad."""
        self.shift_rate: Array = np.zeros_like(reference.position[0])
        """Δq̇, (n_j,), rad/s."""

    def load(self, reference: JointReference) -> None:
        """Another reference; its steps count from 0. What waits for its time still comes."""
        self._reference = reference
        self._feedforward = reference.torque + self._gains.damping * reference.velocity

    def control(self, step: int, position: Array) -> Array:
        """The torque without the drives' own damping, (n_j,), N m.

        Args:
            step: number of the step.
            position: measured joint angles now, (n_j,), rad.
        """
        error = self._reference.position[step] + self.shift - position
        wanted = (
            self._gains.stiffness * error + self._feedforward[step] + self._gains.damping * self.shift_rate
        )
        self._waiting.append(wanted)
        return self._waiting.pop(0) if len(self._waiting) > self._delay else self._waiting[0]
