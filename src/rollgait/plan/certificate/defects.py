"""Does the motion obey the physics? Every interval is integrated anew and compared with the plan."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.integration import TooWildError, integrate
from rollgait.plan.certificate.loads import pulls_of
from rollgait.plan.certificate.motion import SAMPLES, interpolation
from rollgait.plan.certificate.physics import (
    Array,
    BodyState,
    Inputs,
    angular_velocity_world,
    derivative,
    rotation_angle,
    rotation_world_base,
)
from rollgait.plan.certificate.rows import Row, measured


def check_defects(case: Case) -> Iterator[Row]:
    """Distance between plan and integrated motion: at dense times, and where the next interval begins."""
    planned = planned_states(case)
    integrated = integrated_states(case, planned)
    time = _comparison_times(case)

    def apart(a: Array, b: Array) -> Array:
        return np.asarray(np.linalg.norm(a - b, axis=-1))

    yield from measured(
        "position_defect",
        "CoM position against integrated dynamics, per interval",
        "m",
        apart(integrated.position, planned.position),
        tol.DEFECT_POSITION,
        time,
    )
    yield from measured(
        "angle_defect",
        "orientation against integrated dynamics, per interval",
        "rad",
        np.maximum(rotation_angle(integrated.rotation, planned.rotation), _euler_jumps(case)),
        tol.DEFECT_ANGLE,
        time,
    )
    yield from measured(
        "velocity_defect",
        "CoM velocity against integrated dynamics, per interval",
        "m/s",
        apart(integrated.velocity, planned.velocity),
        tol.DEFECT_VELOCITY,
        time,
    )
    yield from measured(
        "angular_velocity_defect",
        "angular velocity against integrated dynamics, per interval",
        "rad/s",
        apart(integrated.angular_velocity, planned.angular_velocity),
        tol.DEFECT_ANGULAR_VELOCITY,
        time,
    )
    yield from measured(
        "foot_defect",
        "feet against their integrated speeds, per interval",
        "m",
        _feet_apart(case, integrated.foot - planned.foot),
        tol.DEFECT_POSITION,
        time,
    )
    yield from measured(
        "heading_defect",
        "wheel headings against their integrated rates, per interval",
        "rad",
        np.abs(integrated.heading - planned.heading),
        tol.DEFECT_ANGLE,
        time,
        where=case.feet("steerable", "fixed"),
    )


def integrated_states(case: Case, planned: BodyState) -> BodyState:
    """All intervals at once, each from the plan's state at its beginning, under the plan's inputs.

    The integrator's time is the part of an interval that has passed: so all end together.

    Args:
        case: the plan.
        planned: the plan's states with leading axes (N, K + 1).

    Returns:
        states with leading axes (N, K + 1); infinite if the motion is too wild to be integrated.
    """
    motion, robot, pulls = case.motion, case.robot, pulls_of(case)
    h = motion.lengths[:, None]
    inputs = np.moveaxis(_planned_inputs(case).flat(), 1, 0)
    states = np.moveaxis(planned.flat(), 1, 0)

    def at_times(t: Array, sampled: Array) -> Array:
        to_times = np.stack([interpolation(tau) for tau in motion.tau[0] + t])
        return np.tensordot(to_times, sampled, axes=1)

    def slope(t: Array, y: Array) -> Array:
        now = Inputs.from_flat(at_times(t, inputs))
        return np.asarray(h * derivative(robot, BodyState.from_flat(y), now, pulls).flat())

    def guess(t: Array) -> Array:
        return at_times(t, states[:SAMPLES])

    # the last time is where the next interval's first sample lies, if that is as long; if not, nearly
    times = np.append(motion.tau - motion.tau[0], 1.0)
    try:
        found = integrate(slope, states[0], times, guess)
    except TooWildError:
        found = np.full(states.shape, np.inf)
    return BodyState.from_flat(np.moveaxis(found, 0, 1))


def planned_states(case: Case) -> BodyState:
    """The plan's states, (N, K + 1): at the samples, and at the first one of the next interval."""
    at = case.motion.at
    return BodyState(
        position=_with_next(at.com_position),
        velocity=_with_next(at.com_velocity),
        rotation=_with_next(rotation_world_base(at.euler)),
        angular_velocity=_with_next(angular_velocity_world(at.euler, at.euler_rate)),
        foot=_with_next(at.foot_position),
        heading=_with_next(at.heading),
    )


def _planned_inputs(case: Case) -> Inputs:
    """What drives the motion, (N, K)."""
    at = case.motion.at
    along, across = case.planar_speeds
    contacts = case.contacts
    contact = None if contacts is None else contacts.position - at.foot_position
    return Inputs(at.force, along, across, at.foot_velocity[..., 2], at.heading_rate, contact)


def _feet_apart(case: Case, difference: Array) -> Array:
    """(N, K + 1, 4), m. Of feet that stand on ground that is not flat in the plane: their height it gives.

    Where a foot leaves the ground its height counts: it rises from where it stood.
    """
    if case.terrain is not None:
        difference, stance = difference.copy(), case.motion.stance
        on_ground = np.repeat(stance[:, None], SAMPLES + 1, axis=1)
        on_ground[:-1, -1] &= stance[1:]
        difference[..., 2][on_ground] = 0.0
    return np.asarray(np.linalg.norm(difference, axis=-1))


def _with_next(values: Array) -> Array:
    """(N, K, …) → (N, K + 1, …): adds the first value of the next interval; to the last, its own last one."""
    behind = np.concatenate([values[1:, :1], values[-1:, -1:]], axis=0)
    return np.concatenate([values, behind], axis=1)


def _comparison_times(case: Case) -> Array:
    time = case.motion.time
    return np.concatenate([time, time[:, -1:]], axis=1)


def _euler_jumps(case: Case) -> Array:
    """Jumps of the Euler angles between intervals, (N, K + 1), rad: here a full turn is not nothing."""
    euler, rate = case.motion.at.euler, case.motion.at.euler_rate
    tau, h = case.motion.tau, case.motion.lengths
    gap = ((1.0 - tau[-1]) * h[:-1] + tau[0] * h[1:])[:, None]
    jumps = np.zeros((euler.shape[0], SAMPLES + 1))
    jumps[:-1, -1] = np.linalg.norm(euler[1:, 0] - euler[:-1, -1] - gap * rate[:-1, -1], axis=-1)
    return jumps
