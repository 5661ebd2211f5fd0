"""What the whole body shall do in the next step: one small class per task, with its error and its Jacobian.

Steps, not velocities: a task asks for the displacement Δq (shape (nv,), rad and m) with J Δq = e, where e is
what is missing at the end of the step. With the error taken against the reference one step ahead, the step
carries its own feed-forward, and what a linearisation leaves is corrected by the next.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Target:
    """Where everything shall be at the end of a step; world frame, SI units, legs FL, FR, HL, HR.

    Attributes:
        p_com: (3,), m.
        R_world_base: (3, 3).
        p_foot: lowest points of the rims, on level ground the contact points, (4, 3), m.
        heading: of the wheels, (4,), rad.
        roll_step: by how much each wheel turns about its axle in this step, (4,), rad: ∫ v/R dt, v along the
            ground.
    """

    p_com: Array
    R_world_base: Array
    p_foot: Array
    heading: Array
    roll_step: Array


class Task(ABC):
    """A group of rows J Δq = e.

    Attributes:
        name: for reports.
    """

    name: ClassVar[str]

    @abstractmethod
    def error(self, state: BodyState, target: Target) -> Array:
        """e, shape (rows,): what is missing, in the task's own unit."""

    @abstractmethod
    def jacobian(self, state: BodyState) -> Array:
        """J, shape (rows, nv): how much of it a displacement brings, to first order."""


class FootPosition(Task):
    """Lowest points of the rims at their planned places: 3 rows per leg, m."""

    name = "foot position"

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray((target.p_foot - state.p_foot).ravel())

    def jacobian(self, state: BodyState) -> Array:
        return state.J_foot.reshape(-1, state.J_foot.shape[-1])


class WheelRolling(Task):
    """Wheels turn as they roll, γ̇ = v / R about their axle in the world, v along the ground: 1 row each, rad.

    Together with `FootPosition` the material point at the contact stands still along the heading.
    """

    name = "wheel rolling"

    def __init__(self, model: WholeBodyModel) -> None:
        self._legs = np.array([i for i, leg in enumerate(model.legs) if leg.wheel is not None], dtype=int)

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray(target.roll_step[self._legs])

    def jacobian(self, state: BodyState) -> Array:
        return np.asarray(state.J_roll[self._legs])


class FootAngle(Task):
    """An angle of every foot that its leg controls: 1 row per such leg, rad."""

    row: ClassVar[str]

    def __init__(self, model: WholeBodyModel) -> None:
        self._legs = np.array(
            [i for i, rows in enumerate(model.orientation_rows) if self.row in rows], dtype=int
        )


class WheelHeading(FootAngle):
    """Wheels at their planned headings σ."""

    name = "wheel heading"
    row = "heading"

    def error(self, state: BodyState, target: Target) -> Array:
        missing = target.heading[self._legs] - state.heading[self._legs]
        return np.asarray((missing + np.pi) % (2.0 * np.pi) - np.pi)

    def jacobian(self, state: BodyState) -> Array:
        return np.asarray(state.J_heading[self._legs])


class FootTilt(FootAngle):
    """Feet upright in the plane in which the leg can tilt them.

    In a leg of five joints that is the leg's own plane: a camber of the wheel it cannot control, and asking
    for none would cost the base its place.
    """

    name = "foot tilt"
    row = "tilt"

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray(-state.tilt[self._legs])

    def jacobian(self, state: BodyState) -> Array:
        return np.asarray(state.J_tilt[self._legs])


class WheelCamber(FootAngle):
    """Axles level, where a leg has the sixth joint for it."""

    name = "wheel camber"
    row = "camber"

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray(-state.camber[self._legs])

    def jacobian(self, state: BodyState) -> Array:
        return np.asarray(state.J_camber[self._legs])


class CentreOfMass(Task):
    """CoM at its planned place r: 3 rows, m."""

    name = "centre of mass"

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray(target.p_com - state.p_com)

    def jacobian(self, state: BodyState) -> Array:
        return state.J_com


class WaistPosition(Task):
    """Origin of the base link at r plus a constant offset: 3 rows, m. Blind to the moving legs."""

    name = "waist position"

    def __init__(self, p_base_from_com: Array) -> None:
        self._offset = p_base_from_com

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray(target.p_com + target.R_world_base @ self._offset - state.p_base)

    def jacobian(self, state: BodyState) -> Array:
        return state.J_base


class WaistOrientation(Task):
    """Base at its planned orientation: 3 rows, the rotation vector of R_target Rᵀ in world axes, rad."""

    name = "waist orientation"

    def error(self, state: BodyState, target: Target) -> Array:
        return rotation_vector(target.R_world_base @ state.R_world_base.T)

    def jacobian(self, state: BodyState) -> Array:
        return state.J_base_angular


class Posture(Task):
    """Given joints at a given posture: 1 row per joint, rad. Takes what the tasks above leave."""

    name = "posture"

    def __init__(self, model: WholeBodyModel, q: Array, places: Sequence[int]) -> None:
        self._places = np.array(places, dtype=int)
        self._angles = q[self._places + 1]
        self._jacobian: Array = np.eye(model.nv)[self._places]

    def error(self, state: BodyState, target: Target) -> Array:
        return np.asarray(self._angles - state.q[self._places + 1])

    def jacobian(self, state: BodyState) -> Array:
        return self._jacobian


def upper_body(model: WholeBodyModel) -> list[int]:
    """Places in v of the joints that belong to no leg."""
    legs = {v for leg in model.legs for v in (*leg.joints, leg.wheel)}
    return [v for v in range(BASE_V, model.nv) if v not in legs]


def leg_joints(model: WholeBodyModel) -> list[int]:
    """Places in v of the legs' joints, without the wheels."""
    return sorted(v for leg in model.legs for v in leg.joints)


def rotation_vector(R: Array) -> Array:
    """Rotation vector of a rotation matrix by less than a half turn, shape (3,), rad."""
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.sqrt(axis @ axis))
    if sine < 1e-9:
        return np.asarray(axis)
    return np.asarray(axis * (np.arctan2(sine, 0.5 * (np.trace(R) - 1.0)) / sine))
