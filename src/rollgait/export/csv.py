"""A plan as comma-separated values: one row per sample, SI units, angles in rad, world frame.

Columns: `time`; the CoM `com_x … com_z`; `yaw, pitch, roll`; their rates `com_vx … com_vz` and `yaw_rate,
pitch_rate, roll_rate` (rates of the Euler angles); then for each leg of FL, FR, HL, HR the lowest point of
the wheel's rim `<leg>_x, _y, _z`, the heading, the contact force on the robot `_fx, _fy, _fz`, the speed
along the heading, `_heading_rate`, `_height_rate`, and `_contact` (1 in stance, 0 in swing). Heading and
speed of a point foot are 0; feet that may move across a heading (`point`, `fixed`) add `<leg>_vx, <leg>_vy`
behind them. At the end of the row stand for each leg where it touches the ground, `<leg>_cx, _cy, _cz`, and
the unit normal there, `_nx, _ny, _nz`: on level ground the lowest point of the rim, and 0, 0, 1, as in swing;
then the accelerations `com_ax … com_az` and `yaw_acceleration, pitch_acceleration, roll_acceleration`, which
are difference quotients of the rates before.
Numbers have all their digits: reading the file gives back the same doubles.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from rollgait.files import replacing
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array, Samples, rate_of
from rollgait.robot.robot import LEG_NAMES, Robot


def write_csv(plan: Plan, path: Path, rate: float) -> Path:
    """Writes the plan, sampled at `rate` (Hz, both ends included), as CSV with a header; returns the path."""
    table = columns(plan.sample_every(rate), plan.robot)
    rows = np.column_stack(list(table.values())).tolist()
    flags = [name.endswith("_contact") for name in table]
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="ascii") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(table)
        for row in rows:
            writer.writerow([int(x) if flag else repr(x) for flag, x in zip(flags, row, strict=True)])
    return path


def columns(samples: Samples, robot: Robot) -> dict[str, Array]:
    """Every column by its name, in the order of the file; shape (n,) each."""
    s = samples
    table = {"time": s.time}
    table |= _parts(s.com_position, "com_x", "com_y", "com_z")
    table |= _parts(s.euler, "yaw", "pitch", "roll")
    table |= _parts(s.com_velocity, "com_vx", "com_vy", "com_vz")
    table |= _parts(s.euler_rate, "yaw_rate", "pitch_rate", "roll_rate")
    for leg, name in enumerate(LEG_NAMES):
        table |= _parts(s.foot_position[:, leg], f"{name}_x", f"{name}_y", f"{name}_z")
        table[f"{name}_heading"] = s.heading[:, leg]
        table |= _parts(s.force[:, leg], f"{name}_fx", f"{name}_fy", f"{name}_fz")
        table[f"{name}_speed"] = s.speed[:, leg]
        table[f"{name}_heading_rate"] = s.heading_rate[:, leg]
        table[f"{name}_height_rate"] = s.foot_velocity[:, leg, 2]
        table[f"{name}_contact"] = s.contact[:, leg].astype(float)
    for leg, name in enumerate(LEG_NAMES):
        if robot.leg_list[leg].foot != "steerable":
            table |= _parts(s.foot_velocity[:, leg, :2], f"{name}_vx", f"{name}_vy")
    for leg, name in enumerate(LEG_NAMES):
        table |= _parts(s.contact_position[:, leg], f"{name}_cx", f"{name}_cy", f"{name}_cz")
        table |= _parts(s.contact_normal[:, leg], f"{name}_nx", f"{name}_ny", f"{name}_nz")
    table |= _parts(rate_of(s.com_velocity, s.time), "com_ax", "com_ay", "com_az")
    turns = ("yaw_acceleration", "pitch_acceleration", "roll_acceleration")
    table |= _parts(rate_of(s.euler_rate, s.time), *turns)
    return table


def _parts(values: Array, *names: str) -> dict[str, Array]:
    """The columns of an (n, k) array by their names."""
    return dict(zip(names, values.T, strict=True))
