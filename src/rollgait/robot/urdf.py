"""From a URDF to a `Robot`: what it says, what inverse kinematics finds, and what neither can know."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.config import dump_yaml, validate
from rollgait.errors import InputError, shown
from rollgait.files import replacing
from rollgait.robot.first_scenario import first_scenario
from rollgait.robot.robot import LEG_NAMES, FootKind, Robot
from rollgait.robot.robot_files import RobotFiles, robot_files
from rollgait.robot.urdf_discovery import described
from rollgait.robot.urdf_feet import measure_foot
from rollgait.robot.urdf_model import BASE_V, LegChain, WholeBodyModel, load_model
from rollgait.robot.urdf_reach import (
    PLANAR,
    LimbFound,
    find_limb,
    foot_boxes,
    reachable_box,
    steering_ranges,
)
from rollgait.robot.urdf_skid import slip_to_turn
from rollgait.robot.urdf_stance import Stance, nominal_stance
from rollgait.robot.urdf_underside import find_underside
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
        body: the whole body it was derived from.
        legs_found: whether the import has found the legs, as no file describes them.
    """

    robot: Robot
    findings: tuple[Finding, ...]
    body: WholeBody
    legs_found: bool = False

    def save(self, file: str | Path) -> RobotFiles:
        """Writes the robot, beside it a first scenario and, if the legs were found, their description.

        Raises:
            FileError: a file cannot be written.
        """
        files, robot = robot_files(file), self.robot
        if self.legs_found:
            robot = robot.model_copy(update={"whole_body": str(files.legs.absolute())})
            _write(files.legs, described(self.body))
        _write(files.robot, dump_yaml(robot.model_dump(mode="json", exclude_none=True)))
        _write(files.first, dump_yaml(first_scenario(robot, str(files.robot.absolute()))))
        return files


def import_robot(
    body: WholeBody, whole_body_file: str | None = None, *, found: bool = False
) -> ImportedRobot:
    """The planner's robot of a whole body.

    Args:
        body: the whole body.
        whole_body_file: where it is described, for tracking; the library knows its own.
        found: whether the whole body was found in a bare URDF.

    Raises:
        InputError: the URDF or a name in it is wrong, or the robot cannot stand.
    """
    model = load_model(body)
    stance = nominal_stance(model)
    inertia = model.inertia(stance.q)
    box = reachable_box(model, stance)
    if box is None and body.planner.box is None:
        rule = "cannot be found: the feet do not reach 2 mm about the nominal stance; give planner.box"
        raise InputError("box", body.name, rule)
    if body.planner.slip_max is not None and all(foot_kind(chain) != "fixed" for chain in model.legs):
        rule = "must not be given, as no foot is a fixed wheel"
        raise InputError("planner.slip_max", body.planner.slip_max, rule)
    slip = slip_to_turn(model, stance, PLANAR if box is None else float(box[1]))
    if found and slip is not None:
        planner = body.planner.model_copy(update={"slip_max": slip})
        body = body.model_copy(update={"planner": planner})
    steering_box = np.array(body.planner.steering_box or (box if box is not None else body.planner.box))
    ranges = steering_ranges(model, stance, steering_box)
    limbs = [find_limb(model, stance, i, body.planner) for i in range(len(LEG_NAMES))]
    legs = {name: _leg(model, stance, i, ranges[i], limbs[i].limb, body) for i, name in enumerate(LEG_NAMES)}
    if box is not None and body.planner.box is None:
        boxes = foot_boxes(model, stance)
        for i, leg in enumerate(legs.values()):
            if leg["foot"] != "steerable":  # its steering range must hold all over its box
                leg["box"] = [[float(low), float(high)] for low, high in boxes[i].T]
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
        "underside": find_underside(model, stance).model_dump(mode="json"),
        "whole_body": whole_body_file,
    }
    robot = validate(Robot, data, "robot")
    findings = [*_legs(body)] if found else []
    findings += _findings(model, robot, box, steering_box, limbs, found)
    findings += _turning(body.planner.slip_max, slip, found)
    return ImportedRobot(robot, tuple(findings), body, found)


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
    if chain.radius > 0.0:
        data["wheel_radius"] = chain.radius
    if chain.wheel is not None:
        limit = model.velocity_max[chain.wheel - BASE_V] * chain.radius
        data["speed_max"] = choices.speed_max or (
            round(float(limit), 4) if np.isfinite(limit) else SPEED_UNKNOWN
        )
    if data["foot"] == "fixed":
        data["heading"] = round(float(stance.state.heading[leg]), 6) + 0.0  # not −0.0
        data["slip_max"] = choices.slip_max
    if chain.steering is not None and steering is not None:
        rate = float(model.velocity_max[chain.steering - BASE_V])
        data["steering"] = [round(steering[0], 4), round(steering[1], 4)]
        data["steering_rate_max"] = choices.steering_rate_max or (
            rate if np.isfinite(rate) else STEERING_RATE_UNKNOWN
        )
        data["limb"] = limb
    return data


def _findings(
    model: WholeBodyModel,
    robot: Robot,
    box: Any,
    steering_box: Any,
    limbs: list[LimbFound],
    legs_found: bool,
) -> list[Finding]:
    body, choices = model.config, model.config.planner
    share = float(robot.static_forces()[:2].sum() / robot.weight)
    posture = _posture(model, legs_found)
    shapes = {chain.name: chain.shape for chain in model.legs}
    if legs_found:  # what was measured has become part of the description
        bare = {"radius": None, "centre": None}
        shapes = {
            name: measure_foot(model.urdf, f"legs.{name}", leg.model_copy(update=bare))
            for name, leg in body.leg_list()
        }
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
    missing = model.urdf.missing_meshes()
    if missing:
        text = f"{len(missing)} without file, {shown(missing[0])} first"
        found.append(Finding("meshes", text, "pictures go without them", known=False))
    for name, leg in zip(LEG_NAMES, robot.leg_list, strict=True):
        found.append(
            Finding(f"stance {name}", _list(leg.stance, "m"), f"{ik}, upright, left/right symmetric")
        )
    if box is None:
        found.append(Finding("reachable box", "none", "less than 1 cm", known=False))
    else:
        found.append(Finding("reachable box", _list(box, "m", "±"), f"{ik} at its corners, edges and faces"))
        if box[1] <= PLANAR:
            found.append(Finding("sideways", "not at all", "no leg has a joint for it", known=False))
    asked = choices.box is not None
    found.append(
        Finding("box", _list(robot.box, "m", "±"), "chosen" if asked else "the reachable one", not asked)
    )
    for name, leg in zip(LEG_NAMES, robot.leg_list, strict=True):
        if leg.box is not None:
            room = ", ".join(f"{low:g} to {high:g}" for low, high in leg.box)
            found.append(Finding(f"box {name}", f"{room} m", f"{ik}: as far as this leg reaches"))
    for chain in model.legs:
        shape, what = shapes[chain.name], "foot" if chain.wheel is None else "wheel"
        found.append(Finding(f"{what} radius {chain.name}", f"{shape.radius:g} m", shape.source, shape.known))
        if shape.centre.any():
            where = f"in the frame {getattr(body.legs, chain.name).frame}"
            found.append(Finding(f"{what} centre {chain.name}", _list(shape.centre, "m"), where))
    if first.foot != "point":
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
    under = robot.underside
    text = f"{len(under.belly)} boxes, {len(under.limbs)} spheres"
    text = text if under.known else "none: nobody looks after body and legs on rough ground"
    found.append(Finding("underside", text, "collision shapes", known=under.known))
    source = "chosen" if choices.force_max else "default: the robot's weight"
    found.append(Finding("contact force", f"{first.force_max:g} N", source, known=False))
    return found


def _turning(slip_max: float | None, slip: float | None, found: bool) -> Iterator[Finding]:
    """How a robot on fixed wheels turns whose legs give no way sideways, or whose wheels may slip."""
    if slip_max is not None:
        source = "chosen, as it turns in no other way" if found else "chosen"
        yield Finding("lateral slip", f"{slip_max:g} m/s at most", source, known=False)
        promise = (
            "slip and friction of plans at the ground's friction, with feedback; other ground is not known"
        )
        yield Finding("turns", "by wheels that skid, on flat ground", promise, known=False)
    elif slip is not None:
        yield Finding("turns", "not at all", f"unless planner.slip_max: {slip:g} is given", known=False)


def _legs(body: WholeBody) -> Iterator[Finding]:
    """What was taken for what."""
    for name, leg in body.leg_list():
        parts = [f"wheel {leg.wheel} on {leg.wheel_joint}" if leg.wheel else f"foot {leg.foot}"]
        if leg.steering_joint is not None:
            parts.append(f"steered by {leg.steering_joint}")
        yield Finding(f"leg {name}", ", ".join(parts), "chains, symmetry, axes")


def _write(file: Path, text: str) -> None:
    with replacing(file) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _posture(model: WholeBodyModel, found: bool) -> str:
    """Where the angles of the stance's posture are from, as text."""
    body = model.config
    if model.posture_is_found or (found and body.joints and body.posture is None):
        return "posture found: knees bent, feet under the hips"
    if body.posture is not None:
        return f"posture {body.posture}" + (" and given joints" if body.joints else "")
    return "posture of the given joints" if body.joints else "posture with all joints at 0"


def _list(values: Any, unit: str, sign: str = "") -> str:
    return f"{sign}({', '.join(f'{float(v):.4g}' for v in values)}) {unit}"
