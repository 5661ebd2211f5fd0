"""A posture for a robot that names none: knees bent, feet level, under the hips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

Array = NDArray[np.float64]

STRETCHED: Final = 0.8
"""Distance from the hip to the foot, as a share of the largest."""

GRID: Final = 61
"""Angles of a hip and of a knee that are tried; every pair of them."""

ALONG: Final = 0.9
"""Cosine above which an axis counts as along an axis of the base."""

BACKWARD: Final = 0.05
"""What a knee ahead of its foot costs, as a share of the leg's length: all legs bend the same way."""

SPREAD: Final = 0.4
"""Distance of a foot from a hip that yaws, away from the base, as a share of the leg's length."""

SPREAD_ANGLE: Final = np.pi / 4.0
"""Angle by which such a leg points to the side, rad."""

LIMIT: Final = 0.05
"""Kept free at both ends of a joint's range, as a share of it."""


@dataclass(frozen=True)
class LegEnd:
    """A leg, by pinocchio's joints.

    Attributes:
        joints: ids of its joints from the base down, without the wheel's.
        frame: id of its frame.
        centre: of the wheel or ball in that frame, (3,), m.
        radius: m.
    """

    joints: tuple[int, ...]
    frame: int
    centre: Array
    radius: float


def find_posture(model: Any, legs: list[LegEnd]) -> Array | None:
    """Configuration, (nq,), in which the legs stand bent; None if a leg has not two pitch joints in a row.

    Args:
        model: pinocchio's, with a free base.
        legs: the four legs.
    """
    data = model.createData()
    q = _within_limits(model, np.array(pin.neutral(model), dtype=float))
    axes, origins = _axes(model, data, q)
    pitches = [[j for j in leg.joints if abs(axes[j][1]) > ALONG] for leg in legs]
    if any(len(pitch) < 2 for pitch in pitches):
        return None
    hips = np.array([origins[pitch[0]] for pitch in pitches])
    tried = [(_angles(model, pitch[0]), _angles(model, pitch[1])) for pitch in pitches]
    feet = np.empty((GRID, GRID, len(legs), 3))
    knees = np.empty((GRID, GRID, len(legs)))
    for a in range(GRID):
        for b in range(GRID):
            for (hip, knee), (hip_angles, knee_angles) in zip(
                ((p[0], p[1]) for p in pitches), tried, strict=True
            ):
                q[model.joints[hip].idx_q] = hip_angles[a]
                q[model.joints[knee].idx_q] = knee_angles[b]
            pin.forwardKinematics(model, data, q)
            for i, leg in enumerate(legs):
                frame = model.frames[leg.frame]
                pose = data.oMi[frame.parentJoint].act(frame.placement)
                feet[a, b, i] = pose.act(leg.centre)
                knees[a, b, i] = data.oMi[pitches[i][1]].translation[0]
    below = feet - hips
    longest = np.hypot(below[..., 0], below[..., 2]).max(axis=(0, 1))
    radii = np.array([leg.radius for leg in legs])
    ground = float((hips[:, 2] - STRETCHED * longest - radii).max())
    ahead = np.array([_ahead(axes[leg.joints[0]], hip, hips) for leg, hip in zip(legs, hips, strict=True)])
    missed = np.hypot(below[..., 0] - ahead * longest, feet[..., 2] - radii - ground)
    missed += BACKWARD * longest * (knees > feet[..., 0])
    for i, (pitch, (hip_angles, knee_angles)) in enumerate(zip(pitches, tried, strict=True)):
        a, b = divmod(int(np.argmin(missed[..., i])), GRID)
        q[model.joints[pitch[0]].idx_q] = hip_angles[a]
        q[model.joints[pitch[1]].idx_q] = knee_angles[b]
        _level_the_rest(model, q, axes, pitch)
        if ahead[i] != 0.0:
            yaw = legs[i].joints[0]
            outward = np.sign(ahead[i] * hips[i, 1] * axes[yaw][2])
            q[model.joints[yaw].idx_q] = outward * SPREAD_ANGLE
    return _within_limits(model, q)


def _ahead(first_axis: Array, hip: Array, hips: Array) -> float:
    """How far ahead of its hip a foot stands, as a share of the leg's length: 0 but for a hip that yaws."""
    return float(SPREAD * np.sign(hip[0] - hips[:, 0].mean())) if abs(first_axis[2]) > ALONG else 0.0


def _level_the_rest(model: Any, q: Array, axes: dict[int, Array], pitch: list[int]) -> None:
    """The third pitch joint undoes what the first two have turned, so that the end stands upright."""
    if len(pitch) < 3:
        return
    turned = sum(float(np.sign(axes[j][1])) * q[model.joints[j].idx_q] for j in pitch[:2])
    q[model.joints[pitch[2]].idx_q] = -float(np.sign(axes[pitch[2]][1])) * turned


def _axes(model: Any, data: Any, q: Array) -> tuple[dict[int, Array], dict[int, Array]]:
    """Axes and origins of all joints with one degree of freedom, world frame."""
    pin.computeJointJacobians(model, data, q)
    joints = [j for j in range(2, model.njoints) if model.joints[j].nv == 1]
    axes = {j: np.array(data.J[3:, model.joints[j].idx_v]) for j in joints}
    return axes, {j: np.array(data.oMi[j].translation) for j in joints}


def _angles(model: Any, joint: int) -> Array:
    """Angles to be tried; a joint without limits is tried all around."""
    low, high = _range(model, model.joints[joint].idx_q)
    low, high = max(low, -np.pi), min(high, np.pi)
    spare = LIMIT * (high - low)
    return np.linspace(low + spare, high - spare, GRID)


def _range(model: Any, place: int) -> tuple[float, float]:
    low, high = float(model.lowerPositionLimit[place]), float(model.upperPositionLimit[place])
    return (low, high) if low < high else (-np.pi, np.pi)


def _within_limits(model: Any, q: Array) -> Array:
    """The configuration with each joint pulled into its range."""
    for joint in range(2, model.njoints):
        if model.joints[joint].nq == 1:
            place = model.joints[joint].idx_q
            low, high = _range(model, place)
            q[place] = min(max(q[place], low), high)
    return q
