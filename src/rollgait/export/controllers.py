"""Which controller of ros2_control gets which joints."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Final

from rollgait.errors import InputError
from rollgait.export.description import Description

LEGS_CONTROLLER: Final = "joint_trajectory_controller"
"""Of joints that are held at an angle: the name that ros2_control's own examples have for it."""
WHEELS_CONTROLLER: Final = "wheel_trajectory_controller"
"""Of joints that roll, which have a velocity interface."""

Controllers = Mapping[str, Sequence[str]]
"""Names of controllers, and of their joints, or patterns of these (`*_wheel`)."""

_NAME: Final = re.compile(r"[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)


def joints_of_controllers(robot: Description, asked: Controllers | None = None) -> dict[str, tuple[str, ...]]:
    """The joints of each controller, in the order of the robot; no controller without joints.

    Args:
        robot: the robot.
        asked: controllers; if none, one for the joints that roll and one for all others. Joints of none of
            them are in no trajectory.

    Raises:
        InputError: a name is none for ROS, a pattern finds no joint, or two controllers have the same joint.
    """
    if asked is None:
        wheels = tuple(name for name in robot.controlled if name in robot.wheels)
        others = tuple(name for name in robot.controlled if name not in robot.wheels)
        return {
            name: joints
            for name, joints in ((LEGS_CONTROLLER, others), (WHEELS_CONTROLLER, wheels))
            if joints
        }
    owner: dict[str, str] = {}
    for controller, patterns in asked.items():
        if not _NAME.fullmatch(controller):
            raise InputError("controllers", controller, "must be a name for ROS: letters, digits and _")
        for pattern in patterns:
            found = [name for name in robot.controlled if fnmatchcase(name, pattern)]
            if not found:
                known = ", ".join(robot.controlled) or "it has none that a plan knows"
                raise InputError(
                    f"controllers.{controller}", pattern, f"must be a joint of the robot: {known}"
                )
            for name in found:
                if owner.setdefault(name, controller) != controller:
                    rule = f"must not have the joint {name}, which {owner[name]} has"
                    raise InputError(f"controllers.{controller}", pattern, rule)
    found_of = {c: tuple(n for n in robot.controlled if owner.get(n) == c) for c in asked}
    return {controller: joints for controller, joints in found_of.items() if joints}
