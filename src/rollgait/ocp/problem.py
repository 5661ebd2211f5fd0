"""The problem: a scenario, and the list of its terms. Immutable; knows no transcription and no solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError, UnknownNameError
from rollgait.ocp import boundary, contact, costs, friction, limb, limits
from rollgait.ocp.lift import lift
from rollgait.ocp.term import Constraint, Cost, FootConstraint, Term
from rollgait.polynomials import HEIGHT_POINTS, gauss_points
from rollgait.robot.robot import Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StartState:
    """x0: (r, θ) and its rate (6 each), contact points (4, 3) and headings (4,), world, SI units."""

    base: Array
    base_rate: Array
    p_foot: Array
    heading: Array


@dataclass(frozen=True)
class Problem:
    """An optimal control problem.

    Attributes:
        scenario: what is asked.
        terms: costs and constraints; the dynamics and the start are the transcription's.
        start: the state at t = 0.
    """

    scenario: Scenario
    terms: tuple[Term, ...]
    start: StartState

    @property
    def robot(self) -> Robot:
        """The robot, with the feet that the gait gives it."""
        return self.scenario.body

    @property
    def schedule(self) -> ContactSchedule:
        """Which foot is on the ground when."""
        return self.scenario.schedule

    @property
    def costs(self) -> tuple[Cost, ...]:
        """The costs among the terms."""
        return tuple(term for term in self.terms if isinstance(term, Cost))

    @property
    def constraints(self) -> tuple[Constraint | FootConstraint, ...]:
        """The constraints among the terms."""
        return tuple(term for term in self.terms if not isinstance(term, Cost))

    @cached_property
    def goals(self) -> Array:
        """Goal pose (x, y, z, yaw, pitch, roll) of each interval, shape (6, N): that of its middle."""
        middles = self.schedule.node_times[:-1] + 0.5 * self.schedule.interval
        return self.scenario.goal_at(middles).T

    @cached_property
    def lift_rate(self) -> Array:
        """Vertical speed of the smooth lift at the height points, shape (points, 4, N), m/s."""
        h = self.schedule.interval
        times = self.schedule.node_times[:-1, None] + h * gauss_points(HEIGHT_POINTS)
        rate = lift(self.schedule, self.scenario.gait.clearance, times.ravel())[1]
        return np.moveaxis(rate.reshape(*times.shape, 4), 0, -1)


def make_problem(scenario: Scenario, extra: Sequence[Term] = ()) -> Problem:
    """The problem of a scenario, with further terms of the user's.

    Raises:
        InputError: the scenario contradicts itself, a name is there twice, or `bounds.without` names no term.
    """
    scenario.check()
    terms = [*standard_terms(scenario), *extra]
    names = [term.name for term in terms]
    for name in names:
        if names.count(name) > 1:
            raise InputError("terms", name, "is the name of two terms; names must differ")
    for name in scenario.bounds.without:
        if name not in names:
            raise UnknownNameError("bounds.without", name, names, "is no term of this problem")
    kept = tuple(term for term in terms if term.name not in scenario.bounds.without)
    return Problem(scenario, kept, start_state(scenario))


def standard_terms(scenario: Scenario) -> list[Term]:
    """The terms that the scenario asks for, by its profile, weights and bounds."""
    terms: list[Term] = [cost(w) for cost in ALL_COSTS if (w := scenario.value_of("weights", cost.name))]
    terms += [
        boundary.RestAtEnd(),
        boundary.WheelsRestAtEnd(),
        boundary.StanceAtEnd(),
        boundary.HeightAtEnd(),
        contact.StanceHeight(),
        contact.StanceMotion(),
        contact.SwingForce(),
        contact.Clearance(),
        contact.AboveGround(),
        friction.Friction(),
        friction.ForceLimits(),
        limits.Box(scenario.bounds.full_rotation),
        limits.SteeringRate(),
        limits.StanceSpeed(),
        limits.SwingSpeed(),
    ]

    def asked(name: str) -> bool:
        return bool(scenario.value_of("bounds", name))

    knows_joints = all(leg.limb is not None for leg in scenario.body.leg_list if leg.foot == "steerable")
    joint_steering = asked("joint_steering") and knows_joints
    terms.append(limb.JointSteering() if joint_steering else limits.Steering())
    if joint_steering and scenario.bounds.steering_deg is not None:
        terms.append(limits.Steering())
    if asked("reach") and knows_joints:
        terms.append(limb.Reach())
    if asked("acceleration_max") or asked("swing_acceleration_max"):
        terms.append(limits.Acceleration())
    if asked("touchdown_speed"):
        terms.append(contact.TouchdownSpeed())
    if asked("level_at_end"):
        terms.append(boundary.LevelAtEnd())
    return terms


ALL_COSTS: tuple[type[Cost], ...] = (
    costs.Acceleration,
    costs.Goal,
    costs.ForceChange,
    costs.Feet,
    costs.Speed,
    costs.HeadingRate,
    costs.Tilt,
    costs.TerminalGoal,
    costs.Lift,
    costs.SwingMotion,
)


def start_state(scenario: Scenario) -> StartState:
    """Standing at rest, level, the feet at their nominal places."""
    yaw = np.radians(scenario.start.yaw_deg)
    r = np.array([scenario.start.x, scenario.start.y, scenario.height])
    c, s = np.cos(yaw), np.sin(yaw)
    R_yaw = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return StartState(
        base=np.concatenate([r, [yaw, 0.0, 0.0]]),
        base_rate=np.zeros(6),
        p_foot=r + scenario.body.stance @ R_yaw.T,
        heading=yaw + scenario.start_headings(),
    )
