"""Joints as keyframes of MuJoCo, with the ground: an XML file to be included in a model of the robot.

The robot has a free base and no ground of its own. One `key` per sample with `time`, `qpos` and `qvel`. The
order is that of MuJoCo's own reading of the URDF: the free joint, then the joints from the root outwards,
depth first.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from rollgait.errors import InputError, MissingExtraError
from rollgait.export.motion import Motion, Sampled, sampled
from rollgait.files import replacing
from rollgait.plan.samples import Array
from rollgait.robot.robot import Robot
from rollgait.robot.urdf_files import Urdf, read_urdf
from rollgait.robot.whole_body import find_whole_body


def write_mujoco(motion: Motion, path: Path, rate: float) -> Path:
    """Writes joints, sampled at `rate` (Hz), as keyframes; returns the path.

    Raises:
        InputError: the motion has no joints.
        MissingExtraError: the extra `whole-body` is not installed.
    """
    s = sampled(motion, rate)
    if not s.whole:
        raise InputError("format", "mujoco", "needs joints: track the plan first, then export its joints")
    order = [s.joint_names.index(name) for name in depth_first(_urdf(s.robot)) if name in s.joint_names]
    x, y, z, w = s.base_quaternion.T
    qpos = np.column_stack([s.base_position, w, x, y, z, s.joint_position[:, order]])
    turn = Rotation.from_quat(s.base_quaternion)  # linear velocity in world axes, angular in base axes
    base_velocity = np.column_stack([turn.apply(s.base_velocity[:, :3]), s.base_velocity[:, 3:]])
    qvel = np.column_stack([base_velocity, s.joint_velocity[:, order]])
    root = ET.Element("mujocoinclude")
    root.extend(_ground(s))
    frames = ET.SubElement(root, "keyframe")
    for k, time in enumerate(s.time):
        ET.SubElement(
            frames,
            "key",
            name=f"t{k:05d}",
            time=f"{time:.9g}",
            qpos=_numbers(qpos[k]),
            qvel=_numbers(qvel[k]),
        )
    ET.indent(root)
    with replacing(path) as temporary:
        ET.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)
    return path


def _ground(s: Sampled) -> list[ET.Element]:
    """The ground as MuJoCo has it in our own simulations: its assets and its geoms."""
    try:
        from rollgait.simulation.ground_xml import ground_xml
    except ImportError:
        raise MissingExtraError("an export to mujoco", "whole-body") from None
    return ground_xml(s.terrain, s.base_position[0, :2])


def depth_first(urdf: Urdf) -> list[str]:
    """Names of the moving joints of a URDF from its root outwards, each followed by what hangs on it."""
    names: list[str] = []
    waiting = [("", urdf.root_link)]
    while waiting:
        name, link = waiting.pop()
        if name and urdf.joints[name].kind != "fixed":
            names.append(name)
        waiting += [(joint.name, joint.child) for joint in reversed(urdf.children_of(link))]
    return names


def _urdf(robot: Robot) -> Urdf:
    return read_urdf(find_whole_body(robot).urdf)


def _numbers(values: Array) -> str:
    return " ".join(f"{value:.9g}" for value in values)
