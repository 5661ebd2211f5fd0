"""A run of the controller as a clip: what the robot did, and the moments at which something was wrong."""

from __future__ import annotations

import math

import numpy as np

from rollgait.mpc.log import MpcLog
from rollgait.mpc.log_samples import ground_height, samples_of_mpc
from rollgait.terrain import Terrain
from rollgait.view.clip import FRICTION, Clip, Joints, frame_times
from rollgait.view.marks import MOST, Mark


def clip_of_mpc(log: MpcLog, name: str) -> Clip:
    """A run of the controller, with its events as marks. Forces are those that the controller asked for."""
    elapsed = log.time - log.time[0]
    times = frame_times(max(float(elapsed[-1]), log.period))
    row = np.rint(np.interp(times, elapsed, np.arange(elapsed.size))).astype(np.intp)
    joints = None
    if log.joint_names:
        joints = Joints(
            log.joint_names, log.base_position[row], log.base_quaternion[row], log.joint_position[row]
        )
    report = log.report()
    return Clip(
        name=name,
        kind="mpc",
        robot=log.robot,
        samples=samples_of_mpc(log, row, times),
        terrain=Terrain(ground_height(log), FRICTION),
        goals=(),
        marks=_marks(log),
        verdict=report.verdict,
        passed=report.passed,
        joints=joints,
    )


def _marks(log: MpcLog) -> tuple[Mark, ...]:
    """The fall, and the first events."""
    begin = float(log.time[0])
    marks = [Mark(event.time - begin, "event", "", event.text, False, 1.0) for event in log.events]
    if log.fallen_at is not None:
        marks.insert(0, Mark(log.fallen_at - begin, "fall", "", "the robot fell", True, math.inf))
    return tuple(marks[:MOST])
