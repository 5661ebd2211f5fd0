"""A motion built by hand: what figures, exports and files need of a plan, without a solver.

Its kinematics are consistent (the feet roll as their inputs say, the base moves as its rates say) and its
forces carry the weight; nothing else of a plan is promised.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.optimize import nnls

from rollgait.plan.plan import Plan, Statistics
from rollgait.plan.samples import Array
from rollgait.plan.trajectory import CollocationTrajectory
from rollgait.polynomials import HEIGHT_POINTS, STATE_POINTS, gauss_points
from rollgait.robot.robot import GRAVITY, LEG_NAMES, Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain import Ground, Terrain, WheelSurface
from rollgait.view.clip import Clip

FEET = len(LEG_NAMES)
SWAY = 0.06
"""How far the CoM moves away from a foot in the air, m."""

STATE_SUPPORT = np.concatenate([[0.0], gauss_points(STATE_POINTS)])
HEIGHT_SUPPORT = np.concatenate([[0.0], gauss_points(HEIGHT_POINTS)])


def motion_plan(
    scenario: Scenario,
    robot: Robot | None = None,
    *,
    schedule: ContactSchedule | None = None,
    solved: bool = True,
) -> Plan:
    """A plan that moves from start to goal and back if the goal switches.

    Args:
        scenario: what is asked.
        robot: with other feet than asked.
        schedule: on another mesh than asked.
        solved: what the plan says of itself.
    """
    body, schedule = robot or scenario.body, schedule or scenario.schedule
    times = schedule.node_times[:-1, None] + np.outer(schedule.lengths, STATE_SUPPORT)
    base, base_rate = _base(scenario, body, schedule, times)
    foot_xy, heading, motion = _feet(scenario, body, schedule)
    trajectory = CollocationTrajectory(
        contact=schedule.contact.T.copy(),
        lengths=schedule.lengths,
        base=base,
        base_rate=base_rate,
        foot_xy=foot_xy,
        heading=heading,
        foot_z=_heights(scenario, schedule),
        force=_forces(scenario, body, schedule, foot_xy),
        motion=motion,
    )
    statistics = Statistics(
        transcription="by hand",
        solver="none",
        solved=solved,
        status="built" if solved else "stopped",
        iterations=7,
        seconds={"build": 0.125, "solve": 0.5},
        cost=1.0 / 3.0,
        costs={"acc": 0.1, "goal": 1.0 / 3.0 - 0.1},
        worst="" if solved else "friction of FL at 1.2 s",
    )
    return Plan(body, scenario.resolved(), schedule, trajectory, statistics)


def _path(scenario: Scenario, times: Array) -> tuple[Array, Array]:
    """Pose and rate of the base at `times` (…), level: smooth from goal to goal."""
    pose, rate = np.zeros((*times.shape, 6)), np.zeros((*times.shape, 6))
    start = scenario.start
    stops = [(0.0, np.array([start.x, start.y, np.radians(start.yaw_deg)]))]
    stops += [
        (goal.at if hasattr(goal, "at") else 0.0, np.array([goal.x, goal.y, np.radians(goal.yaw_deg)]))
        for goal in (scenario.goal, *scenario.goal.then)
    ]
    ends = [begin for begin, _ in stops[2:]] + [scenario.schedule.horizon]
    pose[..., [0, 1, 3]] = stops[0][1]
    for (_, before), (begin, after), end in zip(stops[:-1], stops[1:], ends, strict=True):
        s = np.clip((times - begin) / (end - begin), 0.0, 1.0)[..., None]
        pose[..., [0, 1, 3]] += (after - before) * s**3 * (10 - 15 * s + 6 * s**2)
        rate[..., [0, 1, 3]] += (after - before) * 30 * s**2 * (1 - s) ** 2 / (end - begin)
    pose[..., 2] = scenario.height
    return pose, rate


def _base(scenario: Scenario, robot: Robot, schedule: ContactSchedule, times: Array) -> tuple[Array, Array]:
    """Pose and rate of the base at `times` (…): along the path, and away from the foot that is in the air."""
    pose, rate = _path(scenario, times)
    for swing in schedule.swings():
        begin, end = schedule.node_times[[swing.lift_off, swing.touch_down]]
        inside, length = (times >= begin) & (times <= end), end - begin
        phase = np.pi * (times - begin) / length
        away = -SWAY * robot.stance[swing.leg, :2] / np.linalg.norm(robot.stance[swing.leg, :2])
        tilt = np.array([0.015, 0.02]) * np.sign(away)
        for place, size in zip([0, 1, 4, 5], [*away, *tilt], strict=True):
            pose[..., place] += np.where(inside, size * np.sin(phase) ** 2, 0.0)
            rate[..., place] += np.where(inside, size * np.sin(2 * phase) * np.pi / length, 0.0)
    return pose, rate


def _feet(scenario: Scenario, robot: Robot, schedule: ContactSchedule) -> tuple[Array, Array, Array]:
    """Contact points (N, 4, 4, 2), headings (N, 4, 4) and inputs (N, 4, 2): the feet go with the base."""
    count, nodes = schedule.intervals, schedule.node_times
    pose, _ = _path(scenario, nodes)
    target = pose[:, None, :2] + _turned(robot.stance[:, :2], pose[:, None, 3])
    foot_xy, heading = np.zeros((count, 4, FEET, 2)), np.zeros((count, 4, FEET))
    motion = np.zeros((count, FEET, 2))
    for leg, data in enumerate(robot.leg_list):
        at = target[0, leg]
        sigma = pose[0, 3] + scenario.start_headings()[leg]
        for k, h in enumerate(schedule.lengths):
            ahead = _horizon_of_foot(schedule, leg, k)
            way = target[ahead, leg] - at
            wish = way / (nodes[ahead] - nodes[k])
            if data.foot == "point":
                motion[k, leg] = 0.0 if schedule.contact[leg, k] else wish
                foot_xy[k, :, leg] = at + np.outer(STATE_SUPPORT * h, motion[k, leg])
                at = at + h * motion[k, leg]
                continue
            pace = 0.5 if schedule.contact[leg, k] and scenario.gait.kind != "drive" else 1.0
            if data.foot == "fixed":
                sigma, rate = pose[k, 3] + data.heading, (pose[k + 1, 3] - pose[k, 3]) / h
            else:
                aim = np.arctan2(way[1], way[0]) if np.linalg.norm(wish) > 0.02 else sigma
                turn = np.mod(aim - sigma + np.pi / 2, np.pi) - np.pi / 2  # it may roll backward
                rate = np.clip(turn / h, -1.0, 1.0)
            axes = _turned(np.eye(2), -(sigma + 0.5 * h * rate))
            along, across = pace * axes.T @ wish
            across = 0.0 if schedule.contact[leg, k] or data.foot == "steerable" else across
            motion[k, leg] = [along, rate if data.foot == "steerable" else across]
            heading[k, :, leg] = sigma + STATE_SUPPORT * h * rate
            foot_xy[k, :, leg] = at + _rolled(along, across, sigma, rate, STATE_SUPPORT * h)
            at = at + _rolled(along, across, sigma, rate, np.array([h]))[0]
            sigma = sigma + h * rate
    return foot_xy, heading, motion


def _horizon_of_foot(schedule: ContactSchedule, leg: int, k: int) -> int:
    """The node for which the foot moves in interval k: the touch-down of its swing, or the next node."""
    landing = [s.touch_down for s in schedule.swings() if s.leg == leg and s.lift_off <= k < s.touch_down]
    return landing[0] if landing else k + 1


def _rolled(along: float, across: float, sigma: float, rate: float, times: Array) -> Array:
    """Way of a foot, (n, 2): the integral of its velocity along and across a heading that turns."""
    points, weights = np.polynomial.legendre.leggauss(6)
    inner = 0.5 * (points + 1.0) * times[:, None]
    s = sigma + rate * inner
    velocity = np.stack(
        [along * np.cos(s) - across * np.sin(s), along * np.sin(s) + across * np.cos(s)], axis=-1
    )
    return np.asarray(np.einsum("np,npi->ni", 0.5 * weights * times[:, None], velocity))


def _turned(vectors: Array, angle: Array | float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(
        [c * vectors[..., 0] - s * vectors[..., 1], s * vectors[..., 0] + c * vectors[..., 1]], -1
    )


def _heights(scenario: Scenario, schedule: ContactSchedule) -> Array:
    """(N, 3, 4): a smooth arc of the asked clearance in each swing."""
    z = np.full((schedule.intervals, 3, FEET), scenario.ground.height)
    times = schedule.node_times[:-1, None] + np.outer(schedule.lengths, HEIGHT_SUPPORT)
    for swing in schedule.swings():
        lift_off, touch_down = schedule.node_times[[swing.lift_off, swing.touch_down]]
        s = (times[swing.lift_off : swing.touch_down] - lift_off) / (touch_down - lift_off)
        z[swing.lift_off : swing.touch_down, :, swing.leg] += scenario.clearance * 16 * (s * (1 - s)) ** 2
    return z


def _forces(scenario: Scenario, robot: Robot, schedule: ContactSchedule, foot_xy: Array) -> Array:
    """(N, 4, 3): normal forces that carry the weight, and the share of the acceleration of the CoM."""
    pose, _ = _base(scenario, robot, schedule, schedule.mesh.middles)
    _, rate = _base(scenario, robot, schedule, schedule.node_times)
    acceleration = np.diff(rate[:, :2], axis=0) / schedule.lengths[:, None]
    force = np.zeros((schedule.intervals, FEET, 3))
    for k in range(schedule.intervals):
        stance = np.flatnonzero(schedule.contact[:, k])
        arm = foot_xy[k, 0, stance] - pose[k, :2]
        balance = np.vstack([np.ones(stance.size), arm.T, 0.05 * np.eye(stance.size)])  # spread them evenly
        share = nnls(balance, np.concatenate([[1.0, 0.0, 0.0], np.zeros(stance.size)]))[0]
        share /= share.sum()
        force[k, stance, 2] = robot.mass * GRAVITY * share
        force[k, stance, :2] = robot.mass * share[:, None] * acceleration[k]
    return force


def laid_on(terrain: Terrain, clip: Clip) -> Clip:
    """A clip of flat ground put on another one: the feet follow its surface, the base their mean."""
    s = clip.samples
    foot, com = s.foot_position.copy(), s.com_position.copy()
    for leg, data in enumerate(clip.robot.leg_list):
        surface = WheelSurface(terrain, data.wheel_radius or 0.02)
        foot[:, leg, 2] += surface.touch(foot[:, leg, :2]).height
    com[:, 2] += uniform_filter1d(foot[..., 2].mean(axis=1), max(3, len(com) // 8), mode="nearest")
    return replace(clip, terrain=terrain, samples=replace(s, foot_position=foot, com_position=com))


def plan_on(terrain: Terrain, plan: Plan) -> Plan:
    """The same motion, which says that it stands on another ground."""
    data = {**plan.scenario.to_dict(), "ground": Ground.of(terrain)}
    return replace(plan, scenario=Scenario.model_validate(data))
