"""Does the motion begin where the robot stands, and end at rest at the goal?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.physics import Array, in_base_frame, in_yaw_frame
from rollgait.plan.certificate.rows import Row, measured
from rollgait.plan.samples import Samples
from rollgait.scenario.start import Motion


def check_start(case: Case) -> Iterator[Row]:
    """At t = 0 the robot stands where the scenario says, at rest, its feet at their nominal places.

    It is level, or tilted as the ground asks for.
    """
    begin, scenario = case.plan.sample([0.0]), case.scenario
    if scenario.start.motion is not None:
        yield from _check_moving_start(case, begin, scenario.start.motion)
        return
    yaw = np.radians(scenario.start.yaw_deg)
    height, wanted = case.standing_pose(begin, np.array([yaw]))
    com = np.array([scenario.start.x, scenario.start.y, height[0]])
    feet = _norm(begin.foot_position - com - in_yaw_frame(case.robot.stance, np.asarray(-yaw)))
    if case.terrain is not None:  # how far below the base they are the ground says
        place = in_base_frame(begin.foot_position - com, wanted)
        feet = _norm((place - case.robot.stance)[..., :2])
    time = begin.time
    yield from measured(
        "start_position",
        "CoM at the start",
        "m",
        _norm(begin.com_position - com),
        tol.START_POSITION,
        time,
        promised=case.has("start"),
    )
    yield from measured(
        "start_angle",
        "orientation at the start",
        "rad",
        _norm(begin.euler - wanted),
        tol.END_ANGLE,
        time,
        promised=case.has("start"),
    )
    yield from measured(
        "start_velocity",
        "CoM velocity at the start",
        "m/s",
        _norm(begin.com_velocity),
        tol.END_SPEED,
        time,
        promised=case.has("start"),
    )
    yield from measured(
        "start_rate",
        "angular rates at the start",
        "rad/s",
        _norm(begin.euler_rate),
        tol.END_RATE,
        time,
        promised=case.has("start"),
    )
    yield from measured(
        "start_feet",
        "feet at the start against the nominal stance",
        "m",
        feet,
        tol.START_POSITION,
        time,
        promised=case.has("foot_start"),
    )
    yield from measured(
        "start_heading",
        "wheel headings at the start",
        "rad",
        np.abs(begin.heading - yaw - scenario.start_headings()),
        tol.END_ANGLE,
        time,
        where=case.feet("steerable", "fixed"),
        promised=case.has("foot_start"),
    )


def _check_moving_start(case: Case, begin: Samples, motion: Motion) -> Iterator[Row]:
    """At t = 0 the robot is and moves as the scenario says."""
    where, feet = case.has("start"), case.has("foot_start")
    apart = begin.foot_position - motion.feet
    if case.terrain is not None:  # the height of feet that stand the ground says
        apart[..., 2] = np.where(begin.contact, 0.0, apart[..., 2])
    stated = (
        (
            "start_position",
            "CoM at the start",
            "m",
            begin.com_position,
            motion.com_position,
            tol.START_POSITION,
        ),
        ("start_angle", "orientation at the start", "rad", begin.euler, motion.euler, tol.END_ANGLE),
        (
            "start_velocity",
            "CoM velocity at the start",
            "m/s",
            begin.com_velocity,
            motion.com_velocity,
            tol.END_SPEED,
        ),
        (
            "start_rate",
            "angular rates at the start",
            "rad/s",
            begin.euler_rate,
            motion.euler_rate,
            tol.END_RATE,
        ),
    )
    for name, description, unit, is_so, said, limit in stated:
        away = _norm(is_so - np.array(said))
        yield from measured(
            name, f"{description}, from what is said", unit, away, limit, begin.time, promised=where
        )
    yield from measured(
        "start_feet",
        "feet at the start, from what is said",
        "m",
        _norm(apart),
        tol.START_POSITION,
        begin.time,
        promised=feet,
    )
    yield from measured(
        "start_heading",
        "wheel headings at the start, from what is said",
        "rad",
        np.abs(begin.heading - np.array(motion.heading)),
        tol.END_ANGLE,
        begin.time,
        where=case.feet("steerable", "fixed"),
        promised=feet,
    )


def check_goal(case: Case) -> Iterator[Row]:
    """The goal is a cost; only the terminal one promises to get there."""
    end = case.plan.sample([case.plan.horizon])
    goal = case.scenario.goal_at(end.time)
    promised = bool(case.scenario.value_of("weights", "terminal_goal")) and case.has("terminal_goal")
    legged = bool(case.feet("point").any())
    yield from measured(
        "goal_distance",
        "CoM from the goal at the end, horizontally",
        "m",
        _norm(end.com_position[:, :2] - goal[:, :2]),
        tol.GOAL_DISTANCE_LEGGED if legged else tol.GOAL_DISTANCE,
        end.time,
        promised=promised,
    )
    yield from measured(
        "goal_yaw",
        "yaw from the goal at the end",
        "deg",
        np.degrees(np.abs(end.euler[:, 0] - goal[:, 3])),
        tol.GOAL_YAW,
        end.time,
        promised=promised,
    )


def check_rest(case: Case) -> Iterator[Row]:
    """At the end nothing moves and the base is level."""
    end = case.plan.sample([case.plan.horizon])
    level = bool(case.bound("level_at_end")) and case.has("level_at_end")
    rest = case.has("rest_at_end")
    yield from measured(
        "end_velocity",
        "CoM velocity at the end",
        "m/s",
        _norm(end.com_velocity),
        tol.END_SPEED,
        end.time,
        promised=rest,
    )
    yield from measured(
        "end_wheel_speed",
        "rolling speed at the end",
        "m/s",
        np.abs(end.speed),
        tol.END_SPEED,
        end.time,
        where=case.feet("steerable", "fixed"),
        promised=case.has("wheels_rest_at_end"),
    )
    yield from measured(
        "end_rate",
        "angular rates at the end",
        "rad/s",
        _norm(end.euler_rate),
        tol.END_RATE,
        end.time,
        promised=level,
    )
    _, wanted = case.standing_pose(end, end.euler[:, 0])
    yield from measured(
        "end_level",
        "larger of pitch and roll at the end, against those that the ground asks for",
        "rad",
        np.abs(end.euler - wanted).max(axis=-1),
        tol.END_ANGLE,
        end.time,
        promised=level,
    )


def check_final_stance(case: Case) -> Iterator[Row]:
    """The robot ends in its nominal stance."""
    end = case.plan.sample([case.plan.horizon])
    height, wanted = case.standing_pose(end, end.euler[:, 0])
    offset = end.foot_position - end.com_position[:, None, :]
    place = in_yaw_frame(offset, end.euler[:, :1]) if case.terrain is None else in_base_frame(offset, wanted)
    # a foot that never swings cannot choose its place: a point foot stays, a fixed wheel only rolls along,
    # unless it may slip
    swings = ~case.schedule.contact.all(axis=1)
    rolls_along = case.feet("fixed") & ~swings & (case.slip_max == 0.0)
    offset = (place - case.robot.stance)[..., :2]
    along, across = np.cos(case.fixed_headings), np.sin(case.fixed_headings)
    lengthwise = along * offset[..., 0] + across * offset[..., 1]
    yield from measured(
        "end_feet",
        "feet at the end against the nominal stance, horizontally; wheels that cannot go sideways: along",
        "m",
        np.where(rolls_along, np.abs(lengthwise), _norm(offset)),
        tol.END_POSITION,
        end.time,
        where=~case.feet("point") | swings,
        promised=case.has("stance_at_end"),
    )
    yield from measured(
        "end_height",
        "height of the CoM at the end against the nominal stance",
        "m",
        np.abs(end.com_position[:, 2] - height),
        tol.END_POSITION,
        end.time,
        promised=case.has("height_at_end"),
    )


def _norm(vector: Array) -> Array:
    return np.asarray(np.linalg.norm(vector, axis=-1))
