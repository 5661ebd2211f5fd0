"""The problem: a scenario, and the list of its terms. Immutable; knows no transcription and no solver."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import turned
from rollgait.dynamics.foot import planar_inputs
from rollgait.dynamics.wrench import wrench_numbers
from rollgait.errors import InputError, UnknownNameError
from rollgait.footing.beneath import Beneath, BodyPath, Underside, beneath
from rollgait.footing.footing import Footing
from rollgait.footing.skidding import skid_route, turns_by_skidding
from rollgait.ocp import body, boundary, contact, costs, friction, limb, limits, skid, support
from rollgait.ocp.lift import InAir, lift
from rollgait.ocp.term import Constraint, Cost, FootConstraint, Term
from rollgait.polynomials import HEIGHT_POINTS, gauss_points
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.scenario.start import Motion

if TYPE_CHECKING:
    from rollgait.footing.on_terrain import OnTerrain
    from rollgait.plan.samples import Samples

Array = NDArray[np.float64]

HORIZON_TOLERANCE = 1e-9
"""Relative; the lengths of the intervals add up to the horizon but for round-off."""


@dataclass(frozen=True)
class StartState:
    """x0: (r, θ) and its rate (6 each), contact points (4, 3) and headings (4,), world, SI units.

    Attributes:
        motion: planar inputs of the feet in the interval before, as `dynamics.foot` has them, (4, 2).
        force: contact forces in it, (4, 3), N; None if nothing is known of them.
        lift_rate: vertical velocity of the feet, (4,), m/s.
    """

    base: Array
    base_rate: Array
    p_foot: Array
    heading: Array
    motion: Array = field(default_factory=lambda: np.zeros((4, 2)))
    force: Array | None = None
    lift_rate: Array = field(default_factory=lambda: np.zeros(4))


@dataclass(frozen=True)
class Problem:
    """An optimal control problem.

    Attributes:
        scenario: what is asked.
        terms: costs and constraints; the dynamics and the start are the transcription's.
        start: the state at t = 0.
        schedule: which foot is on the ground when, on the mesh on which the problem is solved.
        footing: the ground under each foot in each interval.
        terrain: the ways of the feet over ground that is not flat; None where it is.
        expected: where the robot is about, for what its body comes near; None where nobody asks.
    """

    scenario: Scenario
    terms: tuple[Term, ...]
    start: StartState
    schedule: ContactSchedule
    footing: Footing
    terrain: OnTerrain | None = None
    expected: BodyPath | None = None

    @property
    def robot(self) -> Robot:
        """The robot, with the feet that the gait gives it."""
        return self.scenario.body

    def friction_at(self, leg: int) -> Array:
        """μ under a foot in each interval, as much of it as forces may use, (N,)."""
        return np.asarray(self.bound("friction_share") * self.footing.friction[leg])

    def bound(self, name: str) -> Any:
        """A bound of the scenario or its profile, by its key; None if there is none."""
        return self.scenario.value_of("bounds", name)

    def speed_max(self, leg: int) -> float:
        """Limit of |v| of a foot in stance, m/s."""
        return self.scenario.speed_max(leg)

    def steering_rate_max(self, leg: int) -> float:
        """Limit of |σ̇| of a foot, rad/s."""
        return self.scenario.steering_rate_max(leg)

    def steering_range(self, leg: int) -> tuple[float, float]:
        """Range of σ − θz of a foot, rad."""
        return self.scenario.steering_range(leg)

    @property
    def start_eased(self) -> tuple[str, ...]:
        """In words, which feet the start has nearer to edges than they may be."""
        if self.terrain is None:
            return ()
        return tuple(
            f"{name} stands {distance:.3g} m nearer to an edge than it may, until it leaves"
            for name, distance in zip(LEG_NAMES, self.terrain.ways.nearer, strict=True)
            if distance > 0.0
        )

    @property
    def costs(self) -> tuple[Cost, ...]:
        """The costs among the terms."""
        return tuple(term for term in self.terms if isinstance(term, Cost))

    @property
    def constraints(self) -> tuple[Constraint | FootConstraint, ...]:
        """The constraints among the terms."""
        return tuple(term for term in self.terms if not isinstance(term, Cost))

    @property
    def beside_nodes(self) -> Array:
        """The longer interval beside the beginning of each, (N,), s: margins cover what happens in it."""
        mesh = self.schedule.mesh
        return np.asarray(np.maximum(mesh.lengths_before, mesh.lengths))

    @property
    def skids(self) -> bool:
        """Whether the robot turns by wheels that slip sideways, and by no step."""
        return turns_by_skidding(self.scenario, self.schedule)

    @cached_property
    def goals(self) -> Array:
        """Goal pose (x, y, z, yaw, pitch, roll) of each interval, shape (6, N): that of its middle.

        Height and tilt are those that the ground asks for there and then. Of a robot that skids it is the
        pose on its way: the straight way to its goal it cannot go.
        """
        goals = self.scenario.goal_at(self.schedule.mesh.middles).T
        if self.skids:
            goals[[0, 1, 3]] = skid_route(self.scenario, self.schedule.mesh.middles).T
        if not self.footing.is_flat:
            middle = 0.5 * (self.footing.base[:-1] + self.footing.base[1:])
            goals[2] = middle[:, 0] + self.robot.height
            goals[4:] = middle[:, 1:].T
        return goals

    @cached_property
    def beneath(self) -> Beneath:
        """Where body and legs come near the ground."""
        clearance = self.bound("body_clearance")
        if self.expected is None or clearance is None:
            return Beneath.nothing(self.schedule.intervals)
        return beneath(Underside.of(self.robot), self.scenario.terrain, self.expected, clearance)

    @cached_property
    def lift_rate(self) -> Array:
        """Vertical speed of the smooth lift at the height points, shape (points, 4, N), m/s."""
        h = self.schedule.lengths[:, None]
        times = self.schedule.node_times[:-1, None] + h * gauss_points(HEIGHT_POINTS)
        rate = self.lift_at(times.ravel())[1]
        return np.moveaxis(rate.reshape(*times.shape, 4), 0, -1)

    @property
    def start_height(self) -> Array:
        """How high feet are at t = 0 above the ground of their first interval, (4,), m; 0 if they stand."""
        first = np.zeros(1, dtype=np.intp)
        height = self.start.p_foot[:, 2] - self.footing.height(first, self.start.p_foot[None, :, :2])[0]
        return np.where(self._in_air, height, 0.0)

    @cached_property
    def in_air(self) -> InAir:
        """How high feet are at t = 0 above the ground that their swings come from, and how fast they rise."""
        height = self.start_height
        for swing in self.footing.swings:
            if swing.lift_off == 0 and swing.over and self._in_air[swing.leg]:
                height[swing.leg] = self.start.p_foot[swing.leg, 2] - swing.before
        return InAir(height, np.where(self._in_air, self.start.lift_rate, 0.0))

    @property
    def _in_air(self) -> NDArray[np.bool_]:
        return np.array(self.schedule.begun) > 0.0

    def lift_at(self, times: Array) -> tuple[Array, Array]:
        """Height of the smooth lift above the ground and its rate at times (n,), both (n, 4)."""
        return lift(self.schedule, self.scenario.clearance, times, self.footing.swings, self.in_air)

    @cached_property
    def wrench(self) -> Array | None:
        """What pulls at the base in each interval, as `dynamics.wrench` has it, (21, N); None if nothing."""
        acting, nodes = self.scenario.wrenches, self.schedule.node_times
        return wrench_numbers(acting, self.robot.com_offset, nodes[:-1], nodes[1:]) if acting else None

    def remeshed(self, schedule: ContactSchedule, motion: Callable[[Array], Samples]) -> Problem:
        """The same problem on another mesh of the same contacts, with the ground about a motion."""
        if self.terrain is None:
            footing = Footing.flat(self.footing.level, self.scenario.ground.friction, schedule.intervals)
            return replace(self, schedule=schedule, footing=footing)
        terrain, at = self.terrain.on(schedule), motion(schedule.node_times)
        expected = BodyPath(at.com_position, at.euler, at.foot_position)
        return replace(
            self, schedule=schedule, terrain=terrain, footing=terrain.around(at), expected=expected
        )

    def cut_at_bends(self, motion: Callable[[Array], Samples]) -> Problem:
        """The same problem with the ground about a motion, and nodes where its feet meet bends of it."""
        schedule = self.schedule if self.terrain is None else self.terrain.cut(self.schedule, motion)
        return self.remeshed(schedule, motion)


def make_problem(
    scenario: Scenario,
    extra: Sequence[Term] = (),
    schedule: ContactSchedule | None = None,
    motion: Callable[[Array], Samples] | None = None,
) -> Problem:
    """The problem of a scenario.

    Args:
        scenario: what is asked.
        extra: further terms, the user's.
        schedule: the contacts, on another mesh than the scenario's own.
        motion: the ways of the feet over ground that is not flat are about those of this motion.

    Raises:
        InputError: the scenario contradicts itself, its gait is yet to be found, a name is there twice,
            `bounds.without` names no term, or the schedule has another horizon.
        NotSolvedError: on the ground a foot has no place to stand.
    """
    if scenario.gait.kind == "discover":
        raise InputError("gait", "discover", "must be found first: rollgait.plan, or rollgait plan, finds it")
    scenario.check()
    schedule = scenario.schedule if schedule is None else schedule
    if not np.isclose(schedule.horizon, scenario.horizon, rtol=HORIZON_TOLERANCE):
        rule = f"must have the scenario's horizon of {scenario.horizon:g} s"
        raise InputError("schedule.horizon", schedule.horizon, rule)
    terms = [*standard_terms(scenario), *extra]
    names = [term.name for term in terms]
    for name in names:
        if names.count(name) > 1:
            raise InputError("terms", name, "is the name of two terms; names must differ")
    for name in scenario.bounds.without:
        if name not in names:
            raise UnknownNameError("bounds.without", name, names, "is no term of this problem")
    kept = tuple(term for term in terms if term.name not in scenario.bounds.without)
    ground = scenario.ground
    if ground.kind == "flat":
        footing = Footing.flat(ground.height, ground.friction, schedule.intervals)
        return Problem(scenario, kept, start_state(scenario), schedule, footing)
    from rollgait.footing.on_terrain import find_ways, standing_start  # here: it needs SciPy

    terrain = find_ways(scenario, schedule, motion)
    base, p_foot = standing_start(scenario)
    start = StartState(base, np.zeros(6), p_foot, base[3] + scenario.start_headings())
    if scenario.start.motion is not None:
        start = start_state(scenario)
    expected = terrain.expected(scenario.body)
    return Problem(scenario, kept, start, schedule, terrain.footing, terrain, expected)


def standard_terms(scenario: Scenario) -> list[Term]:
    """The terms that the scenario asks for, by its profile, weights and bounds."""
    terms: list[Term] = [cost(w) for cost in ALL_COSTS if (w := scenario.value_of("weights", cost.name))]
    return terms + [term for kind in ALL_CONSTRAINTS for term in kind.asked_for(scenario)]


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
    costs.Effort,
)
ALL_CONSTRAINTS: tuple[type[Constraint] | type[FootConstraint], ...] = (
    boundary.RestAtEnd,
    boundary.WheelsRestAtEnd,
    boundary.StanceAtEnd,
    boundary.HeightAtEnd,
    contact.StanceHeight,
    contact.StanceMotion,
    contact.SwingForce,
    contact.Clearance,
    contact.AboveGround,
    contact.Foothold,
    friction.Friction,
    skid.Skid,
    friction.ForceLimits,
    limits.Box,
    limits.SteeringRate,
    limits.StanceSpeed,
    limits.SwingSpeed,
    limb.JointSteering,
    limits.Steering,
    limb.PlannedReach,
    limits.Acceleration,
    contact.TouchdownSpeed,
    contact.TouchdownDrift,
    boundary.LevelAtEnd,
    support.ComMargin,
    support.CaptureMargin,
    body.BodyClearance,
)


def start_state(scenario: Scenario) -> StartState:
    """Standing at rest, level, the feet at their nominal places; or in motion, if the scenario says how."""
    if scenario.start.motion is not None:
        return _moving_start(scenario.start.motion, scenario.body)
    yaw = np.radians(scenario.start.yaw_deg)
    r = np.array([scenario.start.x, scenario.start.y, scenario.height])
    return StartState(
        base=np.concatenate([r, [yaw, 0.0, 0.0]]),
        base_rate=np.zeros(6),
        p_foot=r + turned(scenario.body.stance, yaw),
        heading=yaw + scenario.start_headings(),
    )


def _moving_start(motion: Motion, robot: Robot) -> StartState:
    """The state of a robot that moves."""
    heading, velocity = np.array(motion.heading), np.array(motion.foot_velocity)
    inputs = np.zeros((4, 2))
    for i, leg in enumerate(robot.leg_list):
        # how fast a wheel steered nobody asks
        inputs[i] = planar_inputs(np, leg.foot, velocity[i, :2], heading[i], 0.0, motion.speed[i])
    return StartState(
        base=np.array([*motion.com_position, *motion.euler]),
        base_rate=np.array([*motion.com_velocity, *motion.euler_rate]),
        p_foot=motion.feet,
        heading=heading,
        motion=inputs,
        force=None if motion.force is None else np.array(motion.force),
        lift_rate=velocity[:, 2],
    )
