"""Plans that are right by construction on a slope: a robot that stands there, and steps on the spot."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import tests.plan.builders as b
from rollgait.plan import Plan, Statistics
from rollgait.plan.condensed import CondensedTrajectory
from rollgait.robot import Robot
from rollgait.scenario import Scenario
from rollgait.terrain import Terrain

Array = NDArray[np.float64]

SLOPE = np.array([-0.15, 0.05])
"""Downhill ahead: there the CoM stays inside the support when a hind foot is in the air."""
SHARE = 0.6
"""Of the slope that the base takes."""
GAUSS = b.HEIGHT_SUPPORT[1:]


def plane(slope: Array, yaw: float = 0.0, **values: Any) -> Terrain:
    """A wide ramp through the origin with a gradient, in a world that is turned by a yaw."""
    steepness, half = float(np.linalg.norm(slope)), 20.0
    uphill = slope / steepness
    ramp = {
        "kind": "ramp",
        "x": float(-half * uphill[0]),
        "y": float(-half * uphill[1]),
        "z": -half * steepness,
        "yaw_deg": float(np.degrees(np.arctan2(uphill[1], uphill[0]))),
        "length": 2.0 * half,
        "rise": 2.0 * half * steepness,
    }
    return Terrain.from_parts([ramp], **values).turned(yaw)


def pose_on(robot: Robot, slope: Array, yaw: float) -> tuple[Array, Array, Array]:
    """r, θ and the lowest points of the wheels of a robot that stands on a plane through the origin."""
    theta = np.array([yaw, 0.0, 0.0])
    columns = np.column_stack([np.ones(4), robot.stance[:, :2]])
    lift = np.array([leg.foot_radius for leg in robot.leg_list]) * (np.sqrt(1.0 + slope @ slope) - 1.0)
    r, in_base = np.array([0.0, 0.0, robot.height]), robot.stance.copy()
    for _ in range(100):  # how far the ground is below the base, and how tilted, follows from where it is
        R = Rotation.from_euler("ZYX", theta).as_matrix()
        feet = r + in_base @ R.T
        feet[:, 2] = feet[:, :2] @ slope + lift
        r[2] = feet[:, 2].mean() + robot.height
        in_base[:, 2] = ((feet - r) @ R)[:, 2]
        ahead, left = np.linalg.lstsq(columns, feet[:, 2], rcond=None)[0][1:]
        theta[1:] = -SHARE * np.arctan(ahead), SHARE * np.arctan(left)
    return r, theta, feet


def standing_on_slope(yaw: float = 0.0, body: Robot | None = None, **values: Any) -> Plan:
    """Steps with the hind feet on the spot, on a plane; turned with its world by a yaw (rad)."""
    body = body or b.robot()
    c, s = np.cos(yaw), np.sin(yaw)
    slope = np.array([[c, -s], [s, c]]) @ SLOPE
    data = b.STEPPING | {"ground": plane(SLOPE, yaw), "start": {"yaw_deg": float(np.degrees(yaw))}}
    data["goal"] = {"x": 0.0, "yaw_deg": float(np.degrees(yaw))}
    asked = b.scenario(body, **(data | values))
    body, schedule = asked.body, asked.schedule
    count, h, nodes = schedule.intervals, schedule.lengths, schedule.node_times
    r, theta, feet = pose_on(body, slope, yaw)
    n = np.array([-slope[0], -slope[1], 1.0]) / np.sqrt(1.0 + slope @ slope)
    radius = np.array([leg.foot_radius for leg in body.leg_list])
    contact = feet + radius[:, None] * (np.array([0.0, 0.0, 1.0]) - n)
    force, foot_z, rates = np.zeros((count, 4, 3)), np.tile(feet[:, 2], (count, 1)), np.zeros((count, 4, 2))
    for k in range(count):
        down = schedule.contact[:, k]
        balance = np.vstack([np.ones(down.sum()), (contact[down, :2] - r[:2]).T])
        wanted = np.array([body.mass * b.GRAVITY, 0.0, 0.0])
        force[k, down, 2] = np.linalg.lstsq(balance, wanted, rcond=None)[0]
    for swing in schedule.swings():
        first, last = nodes[[swing.lift_off, swing.touch_down]]
        for k in range(swing.lift_off, swing.touch_down):
            at = (nodes[k] + h[k] * np.array([0.0, 0.5, 1.0]) - first) / (last - first)
            begin, middle, end = asked.clearance * np.sin(np.pi * at) ** 2
            bulge = 4.0 * middle - 2.0 * (begin + end)
            foot_z[k, swing.leg] += begin
            rates[k, swing.leg] = (end - begin + bulge * (1.0 - 2.0 * GAUSS)) / h[k]
    ground = np.zeros((count, 4, 10))
    ground[..., 2] = radius * (np.sqrt(1.0 + slope @ slope) - 1.0)
    ground[..., 3:5] = slope
    ground[..., 8:] = np.where(schedule.contact.T[..., None], slope, 0.0)
    trajectory = CondensedTrajectory(
        contact=schedule.contact.T,
        lengths=h,
        r=np.tile(r, (count, 1)),
        theta=np.tile(theta, (count, 1)),
        dr=np.zeros((count, 3)),
        L=np.zeros((count, 3)),
        foot_xy=np.tile(feet[:, :2], (count, 1, 1)),
        foot_z=foot_z,
        heading=np.tile(yaw + asked.start_headings(), (count, 1)),
        force=force,
        motion=np.zeros((count, 4, 2)),
        lift_rate=rates,
        ground=ground,
    )
    statistics = Statistics("condensed", "none", True, "by construction", 0, 0.0)
    return Plan(asked.body, asked, schedule, trajectory, statistics)


def on(plan: Plan, terrain: Terrain) -> Plan:
    """The plan, unchanged, judged on other ground, even if nobody could stand there."""
    data = plan.scenario.to_dict() | {"ground": terrain}
    scenario = Scenario.model_validate(data)
    return replace(plan, scenario=scenario)
