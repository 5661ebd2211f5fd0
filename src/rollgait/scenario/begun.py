"""Whether a start in motion, and swings that have begun before it, go together."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.errors import InputError
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.gait import BaseGait
from rollgait.scenario.schedule import ContactSchedule
from rollgait.scenario.start import Motion

ON_GROUND: Final = 1e-4
"""m; what the certificate allows a start to be away from its place."""
TILT_MAX: Final = 0.5
"""Pitch or roll from which on a robot falls rather than moves, rad."""
COM_SPEED_MAX: Final = 3.0
"""Of the CoM, m/s; no robot here goes on from that."""


def check_moving_start(
    motion: Motion | None, gait: BaseGait, kind: str, schedule: ContactSchedule, level: float | None
) -> None:
    """Raises `InputError` where swings that have begun and the motion at the start do not go together.

    Args:
        motion: at the start; None if the robot stands.
        gait: the gait.
        kind: of the gait.
        schedule: its contacts.
        level: z of the ground where it is flat, m; else None.
    """
    begun = schedule.begun
    if motion is None:
        for name, time in zip(LEG_NAMES, begun, strict=True):
            if time > 0.0:
                rule = "lifts off before t = 0, which needs a start in motion (start.motion)"
                raise InputError(f"gait.{name}", f"t = {-time:.4g} s", rule)
        return
    timing = gait.timing
    if kind == "discover" or (timing is not None and timing.optimize):
        raise InputError("start.motion", kind, "needs a gait whose times are given")
    _check_rates(motion)
    if level is None:
        return  # on slopes a plan's own ground is near the true one, which the certificate compares
    for leg, name in enumerate(LEG_NAMES):
        z = motion.foot_position[leg][2]
        if begun[leg] == 0.0 and abs(z - level) > ON_GROUND:
            rule = f"must be {level:g} m, as the gait has the foot on the ground at t = 0"
            raise InputError(f"start.motion.foot_position.{name}.z", z, rule)
        if z < level - ON_GROUND:
            raise InputError(f"start.motion.foot_position.{name}.z", z, "is below the ground")


def _check_rates(motion: Motion) -> None:
    tilt = max(abs(motion.euler[1]), abs(motion.euler[2]))
    if tilt > TILT_MAX:
        rule = f"must be at most {TILT_MAX:g} rad of pitch or roll: such a robot falls"
        raise InputError("start.motion.euler", tilt, rule)
    speed = float(np.linalg.norm(motion.com_velocity))
    if speed > COM_SPEED_MAX:
        raise InputError("start.motion.com_velocity", speed, f"must be at most {COM_SPEED_MAX:g} m/s")
