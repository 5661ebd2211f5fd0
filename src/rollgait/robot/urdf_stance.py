"""The nominal stance: where the feet stand below the CoM, by inverse kinematics with the base held still."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES
from rollgait.robot.urdf_model import BASE_V, BodyState, WholeBodyModel

Array = NDArray[np.float64]

ITERATIONS: Final = 60
"""Newton steps after which a place counts as out of reach."""

STEP_MAX: Final = 0.3
"""Largest change of a joint in one of them, rad."""

TOLERANCE: Final = 1e-9
"""Error with which a place counts as reached, m or rad."""

DAMPING: Final = 1e-6
"""Of the least squares, (m or rad)²: where a leg is singular the step stays finite."""

LEFT: Final = np.array([1.0, -1.0, 1.0, -1.0])
"""Side of each leg."""

FRONT: Final = ((0, 1), (2, 3))
"""The legs of the front and of the hind axle."""

Places = Callable[[BodyState], Array]
"""Where the contact points shall be, (4, 3), m, as the CoM of the state may shift them."""


@dataclass(frozen=True)
class Stance:
    """The nominal stance; the base link at the origin of the world.

    Attributes:
        q: configuration.
        state: the whole body there.
        feet: contact points from the CoM, (4, 3), m.
    """

    q: Array
    state: BodyState
    feet: Array


def nominal_stance(model: WholeBodyModel) -> Stance:
    """The stance of the model's posture made regular.

    Feet of an axle stand at the mean of their x, at equal distances left and right of the CoM, all at one
    height, upright and with headings 0 as far as the legs control that: a toed-out posture becomes straight.

    Raises:
        InputError: a leg cannot stand so.
    """
    posture = model.state(model.posture)
    feet = posture.p_foot
    height = model.config.height or float(-feet[:, 2].mean())
    place = np.empty((len(LEG_NAMES), 3))
    for axle in FRONT:
        legs = list(axle)
        place[legs, 0] = feet[legs, 0].mean()
        place[legs, 1] = LEFT[legs] * np.ptp(feet[legs, 1]) / 2.0
    place[:, 2] = -height

    def places(state: BodyState) -> Array:
        return np.asarray(place + np.array([0.0, state.p_com[1], 0.0]))

    state, errors = reach(model, model.posture, places)
    for name, error in zip(LEG_NAMES, errors, strict=True):
        if not error <= TOLERANCE:
            rule = f"cannot stand: its foot stays {error:.2g} m or rad from the nominal stance"
            raise InputError(f"legs.{name}", model.config.name, rule)
    return Stance(state.q, state, state.p_foot - state.p_com)


def reach(model: WholeBodyModel, q: Array, places: Places) -> tuple[BodyState, Array]:
    """All feet at their places, upright and with headings 0, as far as the joints allow.

    Args:
        model: the whole body.
        q: where to begin; its base stays.
        places: where the contact points shall be.

    Returns:
        The whole body there, and what each leg lacks, (4,), m or rad.
    """
    state = model.state(q)
    errors = np.full(len(LEG_NAMES), np.inf)
    for _ in range(ITERATIONS):
        target = places(state)
        step = np.zeros(model.nv)
        for leg, chain in enumerate(model.legs):
            rows, missing = _rows(model, state, target, leg)
            errors[leg] = np.max(np.abs(missing))
            own = list(chain.joints)
            J = rows[:, own]
            free = _not_held(model, state.q, own, J.T @ missing)
            J = J * free
            step[own] = free * (J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(len(J)), missing))
        if np.max(errors) < TOLERANCE / 10.0:
            break
        largest = np.max(np.abs(step))
        q = model.integrate(state.q, step * min(1.0, STEP_MAX / max(largest, 1e-12)))
        q[BASE_V + 1 :] = np.clip(q[BASE_V + 1 :], model.position_lower, model.position_upper)
        state = model.state(q)
    return state, errors


def _rows(model: WholeBodyModel, state: BodyState, target: Array, leg: int) -> tuple[Array, Array]:
    """What a leg controls of its foot: Jacobian (rows, nv) and what is missing (rows,)."""
    angles = {
        "heading": (state.J_heading, state.heading),
        "tilt": (state.J_tilt, state.tilt),
        "camber": (state.J_camber, state.camber),
    }
    controlled = [angles[name] for name in model.orientation_rows[leg]]
    rows = np.vstack([state.J_foot[leg], *(jacobian[leg] for jacobian, _ in controlled)])
    return rows, np.concatenate([target[leg] - state.p_foot[leg], [-value[leg] for _, value in controlled]])


def _not_held(model: WholeBodyModel, q: Array, own: list[int], pull: Array) -> Array:
    """1 for each joint that may follow the pull, 0 for one that stands at the limit the pull leads to."""
    places = np.array(own) - BASE_V
    angles = q[np.array(own) + 1]
    at_upper = (angles >= model.position_upper[places] - 1e-12) & (pull > 0.0)
    at_lower = (angles <= model.position_lower[places] + 1e-12) & (pull < 0.0)
    return np.asarray(np.where(at_upper | at_lower, 0.0, 1.0))
