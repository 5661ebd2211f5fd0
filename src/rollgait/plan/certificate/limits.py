"""Does the motion stay within what the robot can do? Workspace, steering, speeds, joints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.contacts import slope_along
from rollgait.plan.certificate.physics import Array, in_base_frame
from rollgait.plan.certificate.rows import Row, measured
from rollgait.robot.robot import Limb

UP: Final = np.array([0.0, 0.0, 1.0])


def check_box(case: Case) -> Iterator[Row]:
    """Every foot stays in its box, stance and swing."""
    at = case.motion.at
    place = case.foot_base
    if case.scenario.bounds.full_rotation:
        place = in_base_frame(at.foot_position - at.com_position[..., None, :], at.euler)
    boxes = case.robot.foot_boxes(case.bound("box"))
    low, high = -boxes[:, 0], boxes[:, 1]
    if case.terrain is not None and case.bound("reach"):  # how low a foot is says its reach, how high its hip
        known = [leg.limb is not None for leg in case.legs]
        low[known, 2] = np.inf
        high[known, 2] = np.maximum(high[known, 2], tol.LIFT_OF_HEIGHT * case.robot.height)
    offset = place - case.robot.stance
    yield from measured(
        "box_margin",
        "distance of feet from the sides of their boxes",
        "m",
        case.eased(np.min(np.minimum(high - offset, low + offset), axis=-1), 0.0, tol.BEYOND),
        -tol.LENGTH_MARGIN,
        case.motion.time,
        at_least=True,
        promised=case.has("box"),
    )


def check_steering(case: Case) -> Iterator[Row]:
    """Headings against a fixed range, and their rates. A fixed wheel's range is its one heading."""
    time = case.motion.time
    low, high = np.array(
        [
            (leg.heading, leg.heading) if leg.foot == "fixed" else case.scenario.steering_range(i)
            for i, leg in enumerate(case.legs)
        ]
    ).T
    # a range that the scenario sets itself holds beside the joints
    by_joints = case.steers_by_joints and case.scenario.bounds.steering_deg is None
    yield from measured(
        "steering_margin",
        "heading relative to the base, from the ends of its range",
        "rad",
        case.eased(np.minimum(case.steering - low, high - case.steering), 0.0, tol.BEYOND_ANGLE),
        -tol.ANGLE_MARGIN,
        time,
        where=case.feet("fixed") if by_joints else case.feet("steerable", "fixed"),
        at_least=True,
        promised=case.has("steering"),
    )
    own = case.bound("steering_rate_max")
    largest = np.array([min(leg.steering_rate_max, own or np.inf) for leg in case.legs])
    yield from measured(
        "steering_rate_margin",
        "steering rate below its limit",
        "rad/s",
        largest - np.abs(case.motion.at.heading_rate),
        -tol.RATE_MARGIN,
        time,
        where=case.feet("steerable"),
        at_least=True,
        promised=case.has("steering_rate"),
    )


def check_speeds(case: Case) -> Iterator[Row]:
    """Speeds in stance and in swing; of feet that do not roll in swing the larger of the two components."""
    motion = case.motion
    speed = np.abs(motion.at.speed)
    along_ground = speed
    if case.contacts is not None:
        along_ground = speed * np.hypot(1.0, slope_along(case.contacts.normal, motion.at.heading))
    yield from measured(
        "stance_speed_margin",
        "rolling speed in stance below its limit",
        "m/s",
        np.array([case.scenario.speed_max(i) for i in range(len(case.legs))]) - along_ground,
        -tol.SPEED_MARGIN,
        motion.time,
        where=motion.in_stance & case.feet("steerable", "fixed"),
        at_least=True,
        promised=case.has("stance_speed"),
    )
    c, s = np.cos(motion.at.heading), np.sin(motion.at.heading)
    vx, vy = motion.path_velocity[..., 0], motion.path_velocity[..., 1]
    free = np.maximum(np.abs(c * vx + s * vy), np.abs(c * vy - s * vx))
    limit = case.bound("swing_speed_max")
    yield from measured(
        "swing_speed_margin",
        "horizontal speed in swing below its limit",
        "m/s",
        limit - np.where(case.feet("steerable"), speed, free),
        -tol.SPEED_MARGIN,
        motion.time,
        where=~motion.in_stance,
        at_least=True,
        promised=case.has("swing_speed"),
    )


def check_accelerations(case: Case) -> Iterator[Row]:
    """Jumps of the feet's speeds between intervals, over the mean of their lengths; at first from the start.

    Of feet that move freely in swing the larger component counts, and their stop when they land.
    """
    along, across = (speed[:, case.motion.tau.size // 2] for speed in case.planar_speeds)
    before_along, before_across = case.start_speeds
    jump_along = np.abs(np.diff(along, axis=0, prepend=before_along[None]))
    jump_across = np.abs(np.diff(across, axis=0, prepend=before_across[None]))
    before = np.concatenate([case.motion.stance[:1], case.motion.stance[:-1]])
    in_stance = case.motion.stance & before
    jump_across = np.where(in_stance & ~(case.slip_max > 0.0), 0.0, jump_across)
    h = case.motion.lengths
    mean_length = np.append(h[:1], 0.5 * (h[1:] + h[:-1]))
    change = np.maximum(jump_along, jump_across) / mean_length[:, None]
    time = case.schedule.node_times[:-1]
    moves = case.feet("steerable", "fixed") | ~in_stance
    for name, description, bound, where in (
        ("acceleration", "change of speed, in stance", "acceleration_max", in_stance),
        (
            "swing_acceleration",
            "change of speed, in swing or just landed",
            "swing_acceleration_max",
            ~in_stance,
        ),
    ):
        limit = case.bound(bound)
        yield from measured(
            name,
            description,
            "m/s²",
            change,
            None if limit is None else limit + tol.ACCELERATION_MARGIN,
            time,
            where=where & moves,
            promised=case.has("acceleration"),
        )


def check_joints(case: Case) -> Iterator[Row]:
    """Joints behind the feet of whose limbs the robot has figures; promised of steerable feet only."""
    time = case.motion.time
    known = np.array([leg.limb is not None for leg in case.legs])
    steered = known & case.feet("steerable")
    if not known.any():
        return
    known = steered if steered.any() else known
    shape = (*time.shape, len(case.legs))
    hip_margin, ankle_margin, extension_margin, radius_margin = np.full((4, *shape), np.nan)
    guard, reserve = np.radians(case.bound("joint_margin_deg") or 0.0), case.bound("reach_margin") or 0.0
    for i, leg in enumerate(case.legs):
        if leg.limb is None:
            continue
        hip_yaw, ankle_yaw = joint_angles(leg.limb, case.foot_base[..., i, :], case.steering[..., i])
        hip_margin[..., i] = _inside(hip_yaw, leg.limb.hip_yaw) - guard
        ankle_margin[..., i] = _inside(ankle_yaw, leg.limb.steering_joint) - guard
        extension, radius = reach(leg.limb, case.foot_base[..., i, :], case.up_base)
        extension_margin[..., i] = _inside(extension, leg.limb.extension) - reserve
        radius_margin[..., i] = radius - leg.limb.radius_min
    steering = case.steers_by_joints
    reaching = bool(case.bound("reach")) and case.has("reach") and bool(known.any())
    angle, length = -tol.ANGLE_MARGIN, -tol.LENGTH_MARGIN
    for name, description, unit, margin, limit, where, promised in (
        ("hip_yaw_margin", "hip_yaw from its guarded limits", "rad", hip_margin, angle, steered, steering),
        (
            "steering_joint_margin",
            "steering joint from its guarded limits",
            "rad",
            ankle_margin,
            angle,
            steered,
            steering,
        ),
        (
            "reach_margin",
            "leg extension from its guarded limits",
            "m",
            extension_margin,
            length,
            known,
            reaching,
        ),
        (
            "radius_margin",
            "distance of feet from the hip axis, above its limit",
            "m",
            radius_margin,
            length,
            known,
            reaching,
        ),
    ):
        most = tol.BEYOND if unit == "m" else tol.BEYOND_ANGLE
        yield from measured(
            name,
            description,
            unit,
            case.eased(margin, 0.0, most),
            limit,
            time,
            where=where,
            at_least=True,
            promised=promised,
        )


def joint_angles(limb: Limb, foot: Array, steering: Array) -> tuple[Array, Array]:
    """Angles of hip_yaw and of the steering joint that put the wheel there, two arrays (…), rad.

    The leg's plane is turned by α with Rz(α) (direction √(X² + Y² − d²), d) = (X, Y); hip_yaw = −α, and the
    headings add up: σ − θz = −(hip_yaw + steering joint).

    Args:
        limb: figures of the leg.
        foot: contact point from the CoM, frame of the base, (…, 3), m.
        steering: σ − θz, (…), rad.
    """
    x, y = foot[..., 0] - limb.hip[0], foot[..., 1] - limb.hip[1]
    forward = limb.direction * np.sqrt(np.maximum(x**2 + y**2 - limb.plane_offset**2, 0.0))
    alpha = np.arctan2(y, x) - np.arctan2(limb.plane_offset, forward)
    hip_yaw = -np.arctan2(np.sin(alpha), np.cos(alpha))
    return hip_yaw, -steering - hip_yaw


def reach(limb: Limb, foot: Array, up: Array = UP) -> tuple[Array, Array]:
    """Extension e and radius ρ of a leg, two arrays (…), m.

    e is the distance of the ankle pitch axis from the hip pitch axis in the leg's plane. In that plane the
    wheel is upright.

    Args:
        limb: figures of the leg.
        foot: lowest point of the rim from the CoM, frame of the base, (…, 3), m.
        up: unit vector upwards in that frame, (…, 3).
    """
    offset = foot - np.asarray(limb.hip)
    radius = np.hypot(offset[..., 0], offset[..., 1])
    alpha = -joint_angles(limb, foot, np.zeros(()))[0]
    c, s = np.cos(alpha), np.sin(alpha)
    ankle = offset + limb.ankle_height * up
    forward = np.sqrt(np.maximum(radius**2 - limb.plane_offset**2, 0.0)) * limb.direction
    forward = forward + limb.ankle_height * (c * up[..., 0] + s * up[..., 1])
    return np.hypot(forward, ankle[..., 2]), radius


def _inside(values: Array, limits: tuple[float, float]) -> Array:
    return np.minimum(values - limits[0], limits[1] - values)
