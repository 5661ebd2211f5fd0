"""Gains for the drives of a whole body: which of its joints carry it, and which are wheels."""

from __future__ import annotations

import numpy as np

from rollgait.robot.robot import Robot
from rollgait.robot.urdf_files import read_urdf
from rollgait.robot.whole_body import WholeBody
from rollgait.simulation.controller import Gains, gains_for
from rollgait.simulation.world import leg_joints


def gains_of(robot: Robot, body: WholeBody, joint_names: tuple[str, ...], wheels: str = "angle") -> Gains:
    """Gains of all joints.

    Args:
        robot: the planner's robot: its weight and height count.
        body: the whole body.
        joint_names: the joints, in this order.
        wheels: one of `controller.WHEEL_MODES`.

    Raises:
        UnknownNameError: there is no such mode.
    """
    light = {name for _, leg in body.leg_list() for name in (leg.wheel_joint, leg.steering_joint)}
    carrying = np.concatenate(leg_joints(body, read_urdf(body.urdf), joint_names))
    turning = {leg.wheel_joint for _, leg in body.leg_list()}
    return gains_for(
        robot,
        len(joint_names),
        [place for place in carrying if joint_names[place] not in light],
        [place for place, name in enumerate(joint_names) if name in turning],
        wheels,
    )
