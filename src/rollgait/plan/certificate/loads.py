"""Does the plan carry what it was asked to carry? And what pulls at it, in the judge's own words.

The robot of a plan holds the sums, mass, CoM and inertia, that the planner made of its loads. Here they are
made anew from the robot that was asked for, by moments of mass, ∫ dm, ∫ x dm and ∫ x xᵀ dm, which simply add
up about any one point.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.certificate import tolerances as tol
from rollgait.plan.certificate.physics import Array, Pull
from rollgait.plan.certificate.rows import Row, measured
from rollgait.robot.library import find_robot
from rollgait.robot.loads import Load
from rollgait.robot.robot import Robot

if TYPE_CHECKING:
    from rollgait.plan.certificate.case import Case


def check_loads(case: Case) -> Iterator[Row]:
    """Mass, CoM and inertia of the plan's robot against those of the robot asked for and its loads.

    No row where there is no load and no posture of the arms, neither asked for nor in the plan's robot. What
    other arms change of CoM and inertia is pinocchio's word here, too.
    """
    asked = case.scenario
    extra, arms = asked.loads.payload, asked.loads.posture
    if not (extra or arms or case.robot.loads):
        return
    robot = find_robot(asked.robot) if isinstance(asked.robot, str) else asked.robot
    if arms:
        robot = robot.with_posture(arms)
    moments = _moments(robot) + sum((_moments_of(load, robot) for load in extra), start=np.zeros((4, 4)))
    mass, com = moments[3, 3], moments[:3, 3] / moments[3, 3]
    second = moments[:3, :3] - mass * np.outer(com, com)
    inertia = np.trace(second) * np.eye(3) - second
    own, time = case.robot, np.zeros(1)
    stance = robot.stance - com
    size = float(np.trace(inertia))
    figures = (
        ("load_mass", "mass against that of robot and loads", "kg", abs(own.mass - mass), tol.LOAD_MASS),
        (
            "load_place",
            "feet from the CoM against robot and loads",
            "m",
            np.abs(own.stance - stance).max(),
            tol.START_POSITION,
        ),
        (
            "load_inertia",
            "inertia against that of robot and loads, as a share",
            "",
            np.abs(own.inertia_matrix - inertia).max() / size,
            tol.LOAD_INERTIA,
        ),
    )
    for name, description, unit, value, limit in figures:
        yield from measured(name, description, unit, np.array([float(value)]), limit, time)


def pulls_of(case: Case) -> tuple[Pull, ...]:
    """What pulls at the base, with levers from the CoM of the loaded robot."""
    middles = case.schedule.mesh.middles
    offset = _com_from_bare(case.robot)
    return tuple(
        Pull(
            force=np.array(wrench.force),
            torque=np.array(wrench.torque),
            lever=np.array(wrench.at) - offset,
            in_base=wrench.frame == "base",
            acts=_acts(middles, wrench.start, wrench.end),
        )
        for wrench in case.scenario.wrenches
    )


def _acts(times: Array, start: float, end: float | None) -> NDArray[np.bool_]:
    return np.asarray((times > start) & (times < (np.inf if end is None else end)))


def _com_from_bare(robot: Robot) -> Array:
    """From the CoM without its loads to that with them, (3,), m."""
    loads = robot.loads or ()
    return np.asarray(sum((np.array(load.at) * load.mass for load in loads), start=np.zeros(3)) / robot.mass)


def _moments(robot: Robot) -> Array:
    """Moments of mass of a robot about its CoM, (4, 4): [∫ x xᵀ dm, ∫ x dm; …, ∫ dm]."""
    inertia = robot.inertia_matrix
    result = np.zeros((4, 4))
    result[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    result[3, 3] = robot.mass
    return result


def _moments_of(load: Load, robot: Robot) -> Array:
    """The same of a load, about the CoM of the robot that takes it up."""
    x = np.append(np.array(load.at) - _com_from_bare(robot), 1.0)
    result = load.mass * np.outer(x, x)
    if load.size is not None:
        result[:3, :3] += load.mass / 12.0 * np.diag(np.square(load.size))
    return np.asarray(result)
