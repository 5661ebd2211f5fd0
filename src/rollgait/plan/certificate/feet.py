"""Do the feet stand, swing, and carry as feet can? Ground, slip, swing and contact forces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.contacts import in_contact_frame
from rollgait.plan.certificate.physics import in_yaw_frame
from rollgait.plan.certificate.rows import Row, measured
from rollgait.plan.certificate.skid import slip_along
from rollgait.plan.certificate.wheels import STEEP, STEP_MAX
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.schedule import SwingPhase


def check_stance(case: Case) -> Iterator[Row]:
    """Feet in stance stay on the ground and do not slip."""
    motion = case.motion
    if case.terrain is None:  # else it is for `check_ground` to say
        yield from measured(
            "stance_height",
            "height of feet in stance off the ground",
            "m",
            np.abs(motion.at.foot_position[..., 2] - case.scenario.ground.height),
            tol.HEIGHT,
            motion.time,
            where=motion.in_stance,
            promised=case.has("stance_height"),
        )
    speed = np.where(case.feet("point"), 0.0, motion.at.speed)
    rolling = np.stack([speed * np.cos(motion.at.heading), speed * np.sin(motion.at.heading)], axis=-1)
    unexplained = motion.path_velocity[..., :2] - rolling
    # what a wheel may slip sideways is for `check_skid` to say
    along = slip_along(case, unexplained)
    yield from measured(
        "stance_slip",
        "velocity of feet in stance that rolling does not explain, from the path",
        "m/s",
        np.where(case.slip_max > 0.0, np.abs(along), np.linalg.norm(unexplained, axis=-1)),
        tol.SLIP,
        motion.time,
        where=motion.in_stance,
        promised=case.has("stance_motion"),
    )


def check_swing(case: Case) -> Iterator[Row]:
    """Feet in swing clear the ground and are set down gently."""
    motion, ground = case.motion, case.scenario.ground.height
    swings = list(case.schedule.swings())
    if not swings:
        return
    clearance, touch_down = np.full((2, case.schedule.intervals + 1, len(LEG_NAMES)), np.nan)
    foot_z = motion.at.foot_position[..., 2]
    for swing in swings:
        middle = swing.middle
        if middle is not None:  # else the foot was past it when the motion began
            lowest, highest = _asked_at_the_middle(case, swing, middle)
            both_sides = np.array([foot_z[middle - 1, -1, swing.leg], foot_z[middle, 0, swing.leg]])
            missed = np.maximum(lowest - both_sides, both_sides - highest)
            clearance[middle, swing.leg] = np.maximum(missed, 0.0).max()
        touch_down[swing.touch_down, swing.leg] = abs(_sinking(case, swing))
    nodes = case.schedule.node_times
    yield from measured(
        "swing_clearance",
        "height of the foot in mid-swing against the asked clearance",
        "m",
        clearance,
        tol.CLEARANCE,
        nodes,
        where=~np.isnan(clearance),
        promised=case.has("clearance"),
    )
    if case.terrain is None:
        yield from measured(
            "swing_ground",
            "depth of feet in swing below the ground",
            "m",
            np.maximum(ground - foot_z, 0.0),
            tol.HEIGHT,
            motion.time,
            where=~motion.in_stance,
            promised=case.has("ground"),
        )
    limit = case.bound("touchdown_speed")
    yield from measured(
        "touchdown_speed",
        "vertical speed at touch-down",
        "m/s",
        touch_down,
        None if limit is None else limit + tol.SPEED_MARGIN,
        nodes,
        where=~np.isnan(touch_down),
        promised=case.has("touchdown_speed"),
    )
    yield from _check_drift(case, swings)


def _check_drift(case: Case, swings: list[SwingPhase]) -> Iterator[Row]:
    """Point feet are not set down while they fly: the larger component in the last interval of a swing."""
    limit, motion = case.bound("touchdown_drift"), case.motion
    lands = np.zeros(motion.stance.shape, dtype=bool)
    for swing in swings:
        lands[swing.touch_down - 1, swing.leg] = True
    yield from measured(
        "touchdown_drift",
        "horizontal speed of point feet in the last interval of a swing, from the path",
        "m/s",
        np.abs(motion.path_velocity[..., :2]).max(axis=-1),
        None if limit is None else limit + tol.SPEED_MARGIN,
        motion.time,
        where=(lands & case.feet("point"))[:, None],
        promised=case.has("touchdown_drift"),
    )


def _asked_at_the_middle(case: Case, swing: SwingPhase, middle: int) -> tuple[float, float]:
    """Lowest and highest z that are asked of a foot in mid-swing, m.

    On flat ground it is the clearance. Else it is that at least, over the ground right below, or over the
    highest on the way if that jumps or stands out.
    """
    terrain, z_fly = case.terrain, case.scenario.clearance
    if terrain is None:
        height = case.scenario.ground.height + z_fly
        return height, height
    path = case.motion.at.foot_position[swing.lift_off : swing.touch_down, :, swing.leg, :2].reshape(-1, 2)
    heights = terrain.height(path[:, 0], path[:, 1])
    way = np.linalg.norm(np.diff(path, axis=0), axis=-1)
    rises = np.abs(np.diff(heights))
    steepest = STEEP * terrain.friction_at(path[1:, 0], path[1:, 1])
    top = float(np.nanmax(heights))
    level = float(terrain.height(*case.motion.at.foot_position[middle, 0, swing.leg, :2]))
    jumps = bool((rises > STEP_MAX + steepest * way).any())
    if jumps or np.isnan(level) or top > max(heights[0], heights[-1]) + tol.STANDS_OUT:
        return top + case.scenario.clearance_over, np.inf
    if swing.begun > 0.0:  # what it has gone over already nobody sees here
        z_fly = min(z_fly, case.scenario.clearance_over)
    return level + z_fly, np.inf


def _sinking(case: Case, swing: SwingPhase) -> float:
    """Vertical speed at touch-down, relative to the ground below the foot as it moves, m/s."""
    motion, before = case.motion, swing.touch_down - 1
    velocity = motion.path_velocity[before, -1, swing.leg]
    if case.contacts is None:
        return float(velocity[2])
    n = case.contacts.normal[min(swing.touch_down, len(motion.stance) - 1), 0, swing.leg]
    return float(velocity @ n / n[2])


def check_forces(case: Case) -> Iterator[Row]:
    """Contact forces in the contact frame: along the heading, across it, normal (point feet: world axes)."""
    motion, contacts = case.motion, case.contacts
    heading = np.where(case.feet("point"), 0.0, motion.at.heading)
    if contacts is None:
        force, friction = in_yaw_frame(motion.at.force, heading), np.asarray(case.scenario.ground.friction)
    else:
        force = in_contact_frame(motion.at.force, contacts.normal, heading)
        friction = contacts.friction
    along, across, normal = np.moveaxis(force, -1, 0)
    cone, inscribed = case.bound("friction_share") * friction, bool(case.scenario.bounds.inscribed)
    mu = cone / np.sqrt(2.0) if inscribed else cone
    yield from measured(
        "friction_margin",
        "friction that is left: μ fz − max(|fx|, |fy|)",
        "N",
        mu * normal - np.maximum(np.abs(along), np.abs(across)),
        -tol.FORCE,
        motion.time,
        where=motion.in_stance,
        at_least=True,
        promised=case.has("friction"),
    )
    # the paper's pyramid is around the cone: at its corners are forces that no ground gives
    yield from measured(
        "friction_cone",
        "friction that is left in Coulomb's cone: μ fz − √(fx² + fy²)",
        "N",
        cone * normal - np.hypot(along, across),
        -np.sqrt(2.0) * tol.FORCE,
        motion.time,
        where=motion.in_stance,
        at_least=True,
        promised=case.has("friction") and inscribed,
    )
    limited = case.has("force_limits")
    yield from measured(
        "force_min_margin",
        "normal force above the smallest allowed",
        "N",
        normal - (case.bound("force_min") or 0.0),
        -tol.FORCE,
        motion.time,
        where=motion.in_stance,
        at_least=True,
        promised=limited,
    )
    own = case.bound("force_max")
    largest = np.array([min(leg.force_max, own or np.inf) for leg in case.legs])
    yield from measured(
        "force_max_margin",
        "normal force below the largest allowed",
        "N",
        largest - normal,
        -tol.FORCE,
        motion.time,
        where=motion.in_stance,
        at_least=True,
        promised=limited,
    )
    yield from measured(
        "swing_force",
        "contact force on feet in swing",
        "N",
        np.linalg.norm(motion.at.force, axis=-1),
        tol.FORCE,
        motion.time,
        where=~motion.in_stance,
        promised=case.has("swing_force"),
    )
