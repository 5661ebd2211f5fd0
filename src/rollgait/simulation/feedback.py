"""Feedback of the base pose: a correction twist of the base, carried out by those who can.

The twist takes the base to its planned pose in the ground plane. Wheels that steer carry it out themselves:
a wheel i at p_i shall move by δ_i = v + ω × (p_i − p_base) on top of its planned velocity: along its heading
it rolls faster, across it steers, by δ⊥ v / (v² + ε²), as it must roll to get aside. After the last step, as
far as the wheels stand still, the legs shift the base over the feet sideways.

Of wheels that do not steer the twist asks only for what is along the heading that all of them share, and for
turns where they may slip sideways; point feet roll nowhere. The rest is for the legs: those that stand shift
and turn the base over their feet, those in the air go to where their feet were planned in the world, so that
steps take back what the base is off. Standing legs also take out the speed with which the base sways, and
level it where it tilts beside its plan.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import turned
from rollgait.simulation.leg_shift import LegShift
from rollgait.simulation.report import rotation_matrices
from rollgait.simulation.skid_feedback import leading, turning_rims, unwinding
from rollgait.simulation.world import World
from rollgait.tracking.joints import JointTrajectory
from rollgait.tracking.tasks import rotation_vector

Array = NDArray[np.float64]

PERIOD: Final = 0.005
"""Time between two corrections, s."""

GAIN: Final = 1.0
"""Share of the error that wheels take back per second, 1/s."""

SPEED_MAX: Final = 0.2
"""Largest linear part of the twist, m/s."""

TURN_MAX: Final = 0.4
"""Largest angular part of the twist, rad/s."""

STEERING_MAX: Final = 0.25
"""Largest correction of a heading, rad."""

STEERING_TIME: Final = 0.1
"""Time constant with which a heading is corrected, s."""

STEERING_RATE: Final = 1.5
"""Largest rate of that correction, rad/s."""

SLOW: Final = 0.1
"""ε: a wheel that rolls more slowly steers less, m/s."""

SHIFT_MAX: Final = 0.04
"""Farthest that legs shift a foot from where it is planned from the base, m."""

SHIFT_SPEED: Final = 0.05
"""Largest speed with which legs shift the base over the feet, m/s."""

SHIFT_TURN: Final = 0.1
"""Largest rate with which legs turn the base over the feet, rad/s."""

SHIFT_GAIN: Final = 4.0
"""Share of the error that the legs take back per second while all feet stand, 1/s."""

STEPPING_GAIN: Final = 1.0
"""The same from the first step to the last, 1/s: on three legs the base sways, and more would add to it."""

SWING_TIME: Final = 0.1
"""Time constant with which a foot in the air goes to where it was planned in the world, s."""

SWING_SPEED: Final = 0.2
"""Largest speed of that, m/s."""

FREE_SHARE: Final = 0.5
"""Share of a swing, about its middle, in which a foot is high enough to be led elsewhere without dragging."""

AFTER_STEP: Final = 0.1
"""From how long after the last step on all feet count as standing, s."""

SWAY_TIME: Final = 0.06
"""Shift of the feet per speed with which the base sways beside its plan, s. Legs between base and ground are
springs with hardly any damping (ζ about 0.08); taking the error of the place back at a gain of more than
2 ζ ω shakes them up until the robot falls. This adds `SWAY_TIME` ω² to 2 ζ ω; ω is 6 to 10 rad/s."""

SWAY_MAX: Final = 0.02
"""Largest such shift, m."""

TILT_SHARE: Final = 0.5
"""Share of a tilt beside its plan by which the legs level the base at once. Legs are springs: on a narrow
triangle of feet the base tips over, from a height h over legs of stiffness k at a distance l from its edge if
m g h > k l². This makes k half as large again."""

TILT_TIME: Final = 0.02
"""The same of the rate of the tilt, s, which damps it. Twice that shakes up robots of 2.5 kg."""

TILT_MAX: Final = 0.03
"""Farthest that it lengthens or shortens a leg, m."""

PARALLEL: Final = np.radians(1.0)
"""Up to this angle between their headings wheels roll into one direction, rad."""


class BaseFeedback:
    """Turns errors of the base pose into shifts of the joints.

    Args:
        world: where the wheels are.
        joints: what is planned.
    """

    def __init__(self, world: World, joints: JointTrajectory) -> None:
        self._world, self._joints = world, joints
        self._rolled = np.zeros(4)
        self._steered = np.zeros(4)
        self._shift = np.zeros((4, 2))
        self._has_wheel = np.array([wheel is not None for wheel in world.wheels])
        self._skids = all(leg.slip_max is not None for leg in joints.robot.leg_list)
        self._steers = self._has_wheel & [joint is not None for joint in world.steering]
        steps = joints.time[~joints.reference.contact.all(axis=1)]
        self._stands_from = float(steps[-1]) + AFTER_STEP if len(steps) else 0.0
        self._legs = LegShift(world)
        begin = (joints.base_position[0], joints.base_quaternion[0], joints.joint_position[0])
        self._legs_move_all_ways = self._legs.moves_all_ways(*begin)
        self._free = _middle_of_swings(joints.reference.contact)

    def update(self, time: float, data: Any) -> tuple[Array, Array]:
        """Δq (n_j,), rad, and Δq̇ (n_j,), rad/s, to hold for the next period.

        Args:
            time: s.
            data: MuJoCo's data: the base pose is taken from it as it is, without noise.
        """
        plan = self._joints
        k = min(int(np.searchsorted(plan.time, time)), len(plan.time) - 1)
        samples = plan.reference
        yaw = yaw_of(np.roll(data.qpos[3:7], -1))
        away = plan.base_position[k, :2] - data.qpos[:2]
        turned_by = wrapped(yaw_of(plan.base_quaternion[k]) - yaw)
        heading, speed = samples.heading[k], samples.speed[k] * (time <= plan.time[-1])
        stance, sway, height = samples.contact[k], np.zeros((4, 2)), np.zeros((4, 1))
        if self._steers.all():
            rolling = self._roll(self._along(k, self._wanted(k, away, turned_by)), stance)
            steering_rate = self._steer(k, away, turned_by, speed)
            if time >= self._stands_from:
                left = np.array([-np.sin(yaw), np.cos(yaw)])
                standing = SLOW**2 / (float(np.max(speed**2)) + SLOW**2)
                self._shift_base(k, standing * (away @ left) * left, 0.0, stance)
        else:
            along = self._shared_heading(heading, stance)
            rims = self._along(k, self._wanted(k, (away @ along) * along, 0.0))
            if self._skids:
                to_the_left = np.array([-along[1], along[0]])
                lever = self._lever(k) @ np.stack([along, to_the_left], axis=1)
                aside = float(away @ to_the_left)
                rims += turning_rims(lever, turned_by + leading(aside, float(np.mean(speed))), aside)
            rolling = self._roll(rims, stance & self._has_wheel)
            steering_rate = self._steer(k, np.zeros(2), turned_by, speed)
            across = away - (away @ along) * along
            gain = SHIFT_GAIN if time >= self._stands_from else STEPPING_GAIN
            if self._legs_move_all_ways:
                self._shift_base(k, across, turned_by, ~self._free[k], gain)
                self._place_swinging(k, across, turned_by, self._free[k])
                sway = self._against_sway(k, time, data)
                height = self._against_tilt(k, time, data)
            elif self._has_wheel.all():  # legs of a plane give way along the heading only
                sway = self._against_sway(k, time, data)
                ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
                sway = np.sum(sway * ahead, axis=1, keepdims=True) * ahead
                height = self._against_tilt(k, time, data)
        if self._skids and time > plan.time[-1]:
            rolling = rolling + self._unwind(k, heading, data)
        self._legs.update(
            plan.base_position[k],
            plan.base_quaternion[k],
            plan.joint_position[k],
            np.hstack([self._shift_in_world(k) + sway, height]),
        )
        return self._as_joints(data.xaxis[self._world.joints], heading, rolling, steering_rate)

    # -- wheels --------------------------------------------------------------------------------------------

    def _wanted(self, k: int, away: Array, turned_by: float) -> Array:
        """δ of the feet in the ground plane, (4, 2), m/s."""
        velocity = bounded(GAIN * away, SPEED_MAX)
        rate = float(np.clip(GAIN * turned_by, -TURN_MAX, TURN_MAX))
        return velocity + rate * _left_of(self._lever(k))

    def _along(self, k: int, wanted: Array) -> Array:
        """Of a δ of the feet, (4, 2), what is along their headings, (4,), m/s."""
        heading = self._joints.reference.heading[k]
        return np.asarray(wanted[:, 0] * np.cos(heading) + wanted[:, 1] * np.sin(heading))

    def _roll(self, rims: Array, stance: NDArray[np.bool_]) -> Array:
        """By which rate each wheel turns in addition, (4,), rad/s, for speeds of the rims, (4,), m/s."""
        rolling = np.where(stance, rims, 0.0) / np.where(self._world.radius > 0.0, self._world.radius, 1.0)
        self._rolled += rolling * PERIOD
        return rolling

    def _unwind(self, k: int, heading: Array, data: Any) -> Array:
        """Rates that let wheels at rest go to where they are, (4,), rad/s."""
        world, planned = self._world, self._joints.joint_position[k] + self._legs.joints
        axes, wound = data.xaxis[world.joints], np.zeros(4)
        for leg, wheel in enumerate(world.wheels):
            if wheel is not None:
                turned_on = data.qpos[world.position[wheel]] - planned[wheel]
                wound[leg] = self._rolled[leg] - _sense(axes[wheel], heading[leg]) * turned_on
        rates = unwinding(wound)
        self._rolled += rates * PERIOD
        return rates

    def _steer(self, k: int, away: Array, turned_by: float, speed: Array) -> Array:
        """With which rate each heading changes in addition, (4,), rad/s."""
        wanted, heading = self._wanted(k, away, turned_by), self._joints.reference.heading[k]
        across = wanted[:, 1] * np.cos(heading) - wanted[:, 0] * np.sin(heading)
        steering = turned_by + across * speed / (speed**2 + SLOW**2)
        steering = np.clip(steering, -STEERING_MAX, STEERING_MAX)
        change = (steering - self._steered) * PERIOD / STEERING_TIME
        change = np.clip(change, -STEERING_RATE * PERIOD, STEERING_RATE * PERIOD)
        self._steered += change
        return np.asarray(change / PERIOD)

    def _shared_heading(self, heading: Array, stance: NDArray[np.bool_]) -> Array:
        """The direction into which all feet on the ground roll, (2,); zero where they share none."""
        along = heading[stance]
        if not stance.any() or not self._has_wheel[stance].all():
            return np.zeros(2)
        if np.max(np.abs(np.sin(along - along[0]))) > np.sin(PARALLEL):
            return np.zeros(2)
        return np.array([np.cos(along[0]), np.sin(along[0])])

    # -- legs ----------------------------------------------------------------------------------------------

    def _lever(self, k: int) -> Array:
        """From the planned base to the planned feet in the ground plane, (4, 2), m."""
        plan = self._joints
        return np.asarray(plan.reference.foot_position[k, :, :2] - plan.base_position[k, :2])

    def _shift_in_world(self, k: int) -> Array:
        """The feet's shifts in axes of the world, (4, 2), m; they are kept in those of the base's yaw."""
        return turned(self._shift, yaw_of(self._joints.base_quaternion[k]))

    def _shift_base(
        self, k: int, away: Array, turned_by: float, stance: NDArray[np.bool_], gain: float = SHIFT_GAIN
    ) -> None:
        """Moves the base over the feet that stand by a share of what it is off, as far as all of them can."""
        velocity = bounded(gain * away, SHIFT_SPEED)
        rate = float(np.clip(gain * turned_by, -SHIFT_TURN, SHIFT_TURN))
        step = -PERIOD * (velocity + rate * _left_of(self._lever(k)))
        step = turned(step, -yaw_of(self._joints.base_quaternion[k]))
        before, after = (np.linalg.norm(shift[stance], axis=1) for shift in (self._shift, self._shift + step))
        if not np.any((after > SHIFT_MAX) & (after > before)):  # all feet, or they would be pulled apart
            self._shift[stance] += step[stance]

    def _against_sway(self, k: int, time: float, data: Any) -> Array:
        """Shifts of standing feet that take speed out of a swaying base, (4, 2), axes of the world, m."""
        plan = self._joints
        R_planned = rotation_matrices(plan.base_quaternion[k : k + 1])[0]
        R_world_base = rotation_matrices(np.roll(data.qpos[3:7], -1)[None])[0]
        moving = float(time <= plan.time[-1])
        linear = moving * R_planned @ plan.base_velocity[k, :3] - data.qvel[:3]
        angular = moving * R_planned @ plan.base_velocity[k, 3:] - R_world_base @ data.qvel[3:6]
        step = -SWAY_TIME * (linear[:2] + angular[2] * _left_of(self._lever(k)))
        stands = plan.reference.contact[k] & ~self._free[k]
        return np.array([bounded(each, SWAY_MAX) * here for each, here in zip(step, stands, strict=True)])

    def _against_tilt(self, k: int, time: float, data: Any) -> Array:
        """Heights of standing feet that level a base which tilts beside its plan, (4, 1), m."""
        plan = self._joints
        R_planned = rotation_matrices(plan.base_quaternion[k : k + 1])[0]
        R_world_base = rotation_matrices(np.roll(data.qpos[3:7], -1)[None])[0]
        tilt = rotation_vector(R_world_base @ R_planned.T)
        moving = float(time <= plan.time[-1])
        rate = R_world_base @ data.qvel[3:6] - moving * R_planned @ plan.base_velocity[k, 3:]
        asked = TILT_SHARE * tilt + TILT_TIME * rate
        lever = self._lever(k)
        rises = asked[0] * lever[:, 1] - asked[1] * lever[:, 0]
        stands = plan.reference.contact[k] & ~self._free[k]
        return np.asarray(np.clip(rises, -TILT_MAX, TILT_MAX) * stands)[:, None]

    def _place_swinging(self, k: int, away: Array, turned_by: float, swings: NDArray[np.bool_]) -> None:
        """Leads feet in the air to where they were planned in the world, seen from where the base is."""
        yaw = yaw_of(self._joints.base_quaternion[k])
        lever = self._lever(k)
        wanted = turned(lever + away, turned_by - yaw) - turned(lever, -yaw)
        for leg in np.flatnonzero(swings):
            step = bounded((bounded(wanted[leg], SHIFT_MAX) - self._shift[leg]) / SWING_TIME, SWING_SPEED)
            self._shift[leg] += PERIOD * step

    def _as_joints(
        self, axes: Array, heading: Array, rolling: Array, steering_rate: Array
    ) -> tuple[Array, Array]:
        shift, rate = self._legs.joints.copy(), np.zeros(len(axes))
        for leg in range(4):
            wheel, steering = self._world.wheels[leg], self._world.steering[leg]
            if wheel is not None:
                sign = _sense(axes[wheel], heading[leg])
                shift[wheel] += sign * self._rolled[leg]
                rate[wheel] = sign * rolling[leg]
            if steering is not None:
                sign = np.sign(axes[steering, 2])
                shift[steering] += sign * self._steered[leg]
                rate[steering] = sign * steering_rate[leg]
        return shift, rate


def _middle_of_swings(contact: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """When each foot is in the middle of a swing, (n, 4), from when it stands, (n, 4)."""
    free = np.zeros_like(contact)
    for leg in range(contact.shape[1]):
        edges = np.flatnonzero(np.diff(np.concatenate([[True], contact[:, leg], [True]]).astype(int)))
        for begin, end in edges.reshape(-1, 2):
            kept = round(0.5 * (1.0 - FREE_SHARE) * (end - begin))
            free[begin + kept : end - kept, leg] = True
    return free


def _sense(axle: Array, heading: float) -> float:
    """+1 where a wheel rolls ahead by turning about its joint's axis, (3,) in the world; −1 where back."""
    return float(np.sign(axle @ [-np.sin(heading), np.cos(heading), 0.0]))


def _left_of(vectors: Array) -> Array:
    """Vectors in the plane, (n, 2), turned by 90°."""
    return np.stack([-vectors[:, 1], vectors[:, 0]], axis=1)


def yaw_of(quaternion: Array) -> float:
    """Yaw of a quaternion (x, y, z, w), rad."""
    x, y, z, w = quaternion
    return float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def wrapped(angle: float) -> float:
    """The same angle in [−π, π), rad."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def bounded(vector: Array, largest: float) -> Array:
    """The vector, shortened to a length of at most `largest`."""
    length = float(np.linalg.norm(vector))
    return np.asarray(vector * (largest / length if length > largest else 1.0))
