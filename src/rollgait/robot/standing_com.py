"""Where the CoM is in the base link, and what other angles of the arms change about it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError, MissingExtraError, UnknownNameError
from rollgait.robot.robot import Robot
from rollgait.robot.whole_body import EXTRA, EquippedBody, WholeBody, find_whole_body

Array = NDArray[np.float64]


class LinkLoad(NamedTuple):
    """A load as the base link has it.

    Attributes:
        mass: kg.
        place: of its centre in the frame of the base link, (3,), m.
        inertia: about its centre, (3, 3), kg m².
    """

    mass: float
    place: Array
    inertia: Array


def link_loads(body: WholeBody) -> list[LinkLoad]:
    """What a whole body carries; nothing unless `equipped` has said so."""
    if not isinstance(body, EquippedBody) or not body.loads:
        return []
    com = com_in_base(body)
    return [LinkLoad(load.mass, com + np.array(load.at), load.inertia()) for load in body.loads]


def com_in_base(body: WholeBody) -> Array:
    """The CoM without loads, in the nominal stance, in the frame of the base link, (3,), m."""
    arms = body.arms if isinstance(body, EquippedBody) else {}
    unladen = body.unladen if isinstance(body, EquippedBody) else body
    return np.array(_com(unladen.model_dump_json(), tuple(sorted(arms.items()))))


@lru_cache(maxsize=16)
def _com(body: str, arms: tuple[tuple[str, float], ...]) -> tuple[float, ...]:
    model, q = _standing(body)
    return tuple(model.state(with_angles(model, q, dict(arms))).p_com.tolist())


@lru_cache(maxsize=4)
def _standing(body: str) -> tuple[Any, Array]:
    """A model without loads and its configuration in the nominal stance; the base link at the origin.

    By name, as that model asks here for its loads.
    """
    try:
        model = import_module("rollgait.robot.urdf_model").load_model(WholeBody.model_validate_json(body))
        stance = import_module("rollgait.robot.urdf_stance").nominal_stance(model)
    except ImportError:
        raise MissingExtraError("the whole body under loads", EXTRA) from None
    return model, np.asarray(stance.q)


def with_angles(model: Any, q: Array, joints: Mapping[str, float]) -> Array:
    """The configuration of a `WholeBodyModel` with other angles of some joints.

    Raises:
        InputError: as `Robot.with_posture`.
    """
    result = q.copy()
    legs = {place for leg in model.legs for place in (*leg.joints, leg.wheel)}
    for name, angle in joints.items():
        if name not in model.joint_names:
            free = [known for known in model.joint_names if model.place("posture", known) not in legs]
            raise UnknownNameError("posture", name, free, "is not a joint of the robot")
        place = model.place("posture", name)
        if place in legs:
            raise InputError("posture", name, "must be a joint of no leg: legs stand as the plan has them")
        index = model.joint_names.index(name)
        low, high = float(model.position_lower[index]), float(model.position_upper[index])
        if not low <= angle <= high:
            rule = f"must lie in the joint's range [{low:.4g}, {high:.4g}] rad"
            raise InputError(f"posture.{name}", angle, rule)
        result[place + 1] = angle
    return result


def change_of_posture(robot: Robot, joints: Mapping[str, float]) -> tuple[Array, Array]:
    """What other angles of the arms change about the robot without its loads.

    Returns:
        By how much the CoM moves in the base link, (3,), m, and by how much the inertia about it is larger,
        (3, 3), kg m².
    """
    body = find_whole_body(robot)
    arms = body.arms if isinstance(body, EquippedBody) else {}
    unladen = body.unladen if isinstance(body, EquippedBody) else body
    model, q = _standing(unladen.model_dump_json())
    before, after = with_angles(model, q, arms), with_angles(model, q, {**arms, **joints})
    shift = model.state(after).p_com - model.state(before).p_com
    return np.asarray(shift), np.asarray(model.inertia(after) - model.inertia(before))
