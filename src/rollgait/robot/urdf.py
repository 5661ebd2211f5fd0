"""From a URDF to a `Robot`: what it says, what inverse kinematics finds, and what neither can know."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES, FootKind, Robot
from rollgait.robot.urdf_model import BASE_V, LegChain, WholeBodyModel, load_model
from rollgait.robot.urdf_reach import LimbFound, find_limb, reachable_box, steering_ranges
from rollgait.robot.urdf_stance import Stance, nominal_stance
from rollgait.robot.whole_body import WholeBody

SPEED_UNKNOWN = 1.0
"""m/s: rolling speed where the URDF gives the wheel joint no limit."""

STEERING_RATE_UNKNOWN = 2.0
"""rad/s: likewise for the steering joint."""


@dataclass(frozen=True)
class Finding:
    """One figure of the robot and where it is from.

    Attributes:
        name: what it is.
        value: with its unit, as text.
        source: where it is from.
        known: whether the URDF or inverse kinematics gave it; else it is a choice or a default.
    """

    name: str
    value: str
    source: str
    known: bool = True


@dataclass(frozen=True)
class ImportedRobot:
    """What an import found.

    Attributes:
        robot: the robot for the planner.
        findings: what it is made of, in the order of the robot's fields.
    """

    robot: Robot
    findings: tuple[Finding, ...]


def import_robot(body: WholeBody, whole_body_file: str | None = None) -> ImportedRobot:
    """The planner's robot of a whole body.

    Args:
        body: the whole body.
        whole_body_file: where it is described, for tracking; the library knows its own.

    Raises:
        InputError: the URDF or a name in it is wrong, a mesh is missing, or the robot cannot stand.
    """
    model = load_model(body)
    model.urdf.meshes()
    stance = nominal_stance(model)
    inertia = model.inertia(stance.q)
    box = reachable_box(model, stance)
    if box is None and body.planner.box is None:
        rule = "cannot be found: the feet do not reach 1 cm about the nominal stance; give planner.box"
        raise InputError("box", body.name, rule)
    steering_box = np.array(body.planner.steering_box or (box if box is not None else body.planner.box))
    ranges = steering_ranges(model, stance, steering_box)
    limbs = [find_limb(model, stance, i, body.planner) for i in range(len(LEG_NAMES))]
    legs = {name: _leg(model, stance, i, ranges[i], limbs[i].limb, body) for i, name in enumerate(LEG_NAMES)}
    data = {
        "name": body.name,
        "description": body.planner.description,
        "mass": round(model.mass, 4),
        "inertia": {
            f"{a}{b}": round(float(inertia[i, k]), 4)
            for i, a in enumerate("xyz")
            for k, b in enumerate("xyz")
            if k >= i
        },
        "box": body.planner.box or [float(v) for v in (box if box is not None else ())],
        "legs": legs,
        "whole_body": whole_body_file,
    }
    robot = Robot.model_validate(data)
    return ImportedRobot(robot, tuple(_findings(model, robot, box, steering_box, limbs)))


def foot_kind(chain: LegChain) -> FootKind:
    """What the planner takes the foot of a leg for."""
    if chain.wheel is None:
        return "point"
    return "fixed" if chain.steering is None else "steerable"


def _leg(
    model: WholeBodyModel,
    stance: Stance,
    leg: int,
    steering: tuple[float, float] | None,
    limb: Any,
    body: WholeBody,
) -> dict[str, Any]:
    chain, choices = model.legs[leg], body.planner
    height = round(float(stance.feet[:, 2].mean()), 5)
    data: dict[str, Any] = {
        "foot": foot_kind(chain),
        "stance": [round(float(stance.feet[leg, 0]), 5), round(float(stance.feet[leg, 1]), 5), height],
        "force_max": choices.force_max or round(model.mass * 9.81, 0),
    }
    if chain.wheel is not None:
        limit = model.velocity_max[chain.wheel - BASE_V] * chain.radius
        data["wheel_radius"] = chain.radius
        data["speed_max"] = choices.speed_max or (
            round(float(limit), 4) if np.isfinite(limit) else SPEED_UNKNOWN
        )
    if data["foot"] == "fixed":
        data["heading"] = round(float(stance.state.heading[leg]), 6)
    if chain.steering is not None and steering is not None:
        rate = float(model.velocity_max[chain.steering - BASE_V])
        data["steering"] = [round(steering[0], 4), round(steering[1], 4)]
        data["steering_rate_max"] = choices.steering_rate_max or (
            rate if np.isfinite(rate) else STEERING_RATE_UNKNOWN
        )
        data["limb"] = limb
    return data


def _findings(
    model: WholeBodyModel, robot: Robot, box: Any, steering_box: Any, limbs: list[LimbFound]
) -> list[Finding]:
    body, choices = model.config, model.config.planner
    share = float(robot.static_forces()[:2].sum() / robot.weight)
    posture = f"posture {body.posture}" if body.posture else "posture with all joints at 0"
    wheel, ik = "wheel joint's speed limit × radius", "inverse kinematics"
    first = robot.legs.FL
    found = [
        Finding("joints", str(len(model.joint_names)), "URDF"),
        Finding("mass", f"{robot.mass:.3f} kg", "URDF, all links"),
        Finding("inertia", _list([robot.inertia.xx, robot.inertia.yy, robot.inertia.zz], "kg m²"), posture),
        Finding(
            "feet",
            ", ".join(f"{n} {leg.foot}" for n, leg in zip(LEG_NAMES, robot.leg_list, strict=True)),
            "legs",
        ),
        Finding("height of the CoM", f"{robot.height:.4f} m", f"{ik} from the {posture}"),
        Finding("weight on the front", f"{100.0 * share:.0f} %", "stance"),
    ]
    for name, leg in zip(LEG_NAMES, robot.leg_list, strict=True):
        found.append(
            Finding(f"stance {name}", _list(leg.stance, "m"), f"{ik}, upright, left/right symmetric")
        )
    if box is None:
        found.append(Finding("reachable box", "none", "less than 1 cm", known=False))
    else:
        found.append(Finding("reachable box", _list(box, "m", "±"), f"{ik} at its corners, edges and faces"))
    asked = choices.box is not None
    found.append(
        Finding("box", _list(robot.box, "m", "±"), "chosen" if asked else "the reachable one", not asked)
    )
    if first.wheel_radius is not None:
        given = next(body.leg_list())[1].radius is not None
        found.append(
            Finding("wheel radius", f"{first.wheel_radius:g} m", "given" if given else "URDF's geometry")
        )
        limited = all(
            np.isfinite(model.velocity_max[c.wheel - BASE_V]) for c in model.legs if c.wheel is not None
        )
        source = "chosen" if choices.speed_max else wheel if limited else "default: the URDF gives no limit"
        found.append(Finding("speed", f"{first.speed_max:g} m/s", source, source == wheel))
    for name, leg, limb in zip(LEG_NAMES, robot.leg_list, limbs, strict=True):
        if leg.foot == "steerable":
            where = f"steering joint over the box {_list(steering_box, 'm', '±')}"
            found.append(Finding(f"steering {name}", _list(leg.steering, "rad"), where))
            known = limb.limb is not None
            text = "found" if known else "not found"
            found.append(Finding(f"limb {name}", text, "axes of its joints" if known else limb.reason, known))
    if first.foot == "steerable":
        chosen = choices.steering_rate_max is not None
        source = "chosen" if chosen else "steering joint's speed limit"
        found.append(Finding("steering rate", f"{first.steering_rate_max:g} rad/s", source, not chosen))
    source = "chosen" if choices.force_max else "default: the robot's weight"
    found.append(Finding("contact force", f"{first.force_max:g} N", source, known=False))
    return found


def _list(values: Any, unit: str, sign: str = "") -> str:
    return f"{sign}({', '.join(f'{float(v):.4g}' for v in values)}) {unit}"
