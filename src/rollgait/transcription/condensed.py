"""A condensed transcription of the same problem: multiple shooting with one cheap step per interval.

State (r, θ, ṙ, L, feet) with the angular momentum L in place of θ̇, the height ζ of a foot above the ground
in place of its z, inputs constant in an interval, and x⁺ = F(x, u) by `dynamics.step`. Costs are integrated
by the midpoint rule (Simpson's where feet step freely). Constraints hold at nodes, tightened by what may
happen between them. The inputs of the interval before are part of the state, as the cost of force changes
and the bound of accelerations need them.

Variables of an interval: its node (state), then its inputs; at the end of the horizon a last node. That
order, and rows that define the next node before the others, is what a structure-exploiting solver wants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import (
    POINTS,
    FootInput,
    State,
    angular_momentum,
    step,
)
from rollgait.ocp.instant import Body, Inputs, Instant
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Place
from rollgait.plan.condensed import CondensedTrajectory
from rollgait.plan.samples import Samples
from rollgait.robot.robot import Robot
from rollgait.transcription.base import Structure
from rollgait.transcription.code import CodeStore, StageSymbols
from rollgait.transcription.easing import eased
from rollgait.transcription.guess import MotionGuess, motion_inputs
from rollgait.transcription.layout import Layout, StageLayout
from rollgait.transcription.nlp import Block, Nlp
from rollgait.transcription.stage import RowNumbers, make_stage
from rollgait.transcription.states import figures, instant_of, state_entries, state_of
from rollgait.transcription.tableau import gauss_legendre

Array = NDArray[np.float64]
FEET = 4
HEIGHT = gauss_legendre(len(POINTS))
CARRIED = "inputs carried on"
"""Name of the rows by which a node knows the inputs of the interval before it."""
SIMPSON = np.array([1.0, 4.0, 1.0]) / 6.0
"""Weights of Simpson's rule at the beginning, the middle and the end of an interval."""


@dataclass(frozen=True)
class Condensed:
    """The transcribed problem, and the way from a guess to its variables and from them to a motion."""

    problem: Problem
    nlp: Nlp

    name = "condensed"

    @property
    def layout(self) -> Layouts:
        """Order of the variables."""
        return make_layout(self.problem.robot)

    def encode(self, motion: MotionGuess) -> Array:
        """The free variables that come nearest to a motion."""
        rows, last = encoded(self.problem, motion)
        return np.concatenate([rows.ravel(), last])[self.nlp.free]

    def decode(self, w: Array) -> CondensedTrajectory:
        """The motion that free variables mean."""
        rows = self.layout.rows(self.nlp.all_variables(w), self.problem.schedule.intervals)
        return decoded(self.problem, self.layout, rows, self.problem.schedule.lengths)

    @property
    def structure(self) -> Structure:
        """Sizes of the stages as the solver sees them, fixed variables and empty rows left out."""
        layout, count, nlp = self.layout, self.problem.schedule.intervals, self.nlp
        is_free = np.zeros(nlp.total, dtype=int)
        is_free[nlp.free] = 1
        rows = is_free[: count * layout.stage].reshape(count, layout.stage)
        nx = [*rows[:, : layout.node.size].sum(axis=1), is_free[count * layout.stage :].sum()]
        interval, end = nlp.blocks
        path = nlp.kept(interval) & ~nlp.defines_next(interval)
        ng = [*path.sum(axis=0), nlp.kept(end).sum()]
        nu = [*rows[:, layout.node.size :].sum(axis=1), 0]
        return Structure(*(tuple(int(v) for v in sizes) for sizes in (nx, nu, ng)))


def transcribe(problem: Problem, store: CodeStore | None = None) -> Condensed:
    """The problem as an NLP by one step per interval; `store` keeps the code of its stages."""
    layout, count = make_layout(problem.robot), problem.schedule.intervals
    not_last = RowNumbers(
        holds=np.arange(count) < count - 1
    )  # nothing follows that would need the last inputs
    interval = make_stage(IntervalStage(layout), problem, store, {CARRIED: not_last})
    end = make_stage(EndStage(layout), problem, store)
    initial = start_values(problem, layout)
    if problem.scenario.start.motion is not None:
        interval = eased(interval, initial, problem)
    blocks = [
        Block(interval, layout.variables(count), next_state=layout.defined(interval.code.rows)),
        Block(end, layout.last_variables(count), first=count),
    ]
    return Condensed(problem, Nlp(blocks, layout.total(count), initial=initial))


# -- variables -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Layouts(StageLayout):
    """The layout of this transcription.

    Attributes:
        previous: which of the 8 planar inputs the next stage must know (σ̇ it need not).
    """

    previous: tuple[int, ...]


def make_layout(robot: Robot, clocks: int = 0, stretches: int = 0) -> Layouts:
    """The order of the variables; with states that tell the time, and inputs that make it, if there are."""
    steerable = tuple(i for i, leg in enumerate(robot.leg_list) if leg.foot == "steerable")
    previous = tuple(j for j in range(2 * FEET) if not (j % 2 == 1 and j // 2 in steerable))
    state = [
        ("theta", 3),
        ("L", 3),
        ("r", 3),
        ("dr", 3),
        ("xy", 2 * FEET),
        ("sigma", len(steerable)),
        ("z", FEET),
    ]
    state += [("clock", clocks)] if clocks else []
    node = Layout([*state, ("previous_force", 3 * FEET), ("previous_motion", len(previous))])
    stretch = [("stretch", stretches)] if stretches else []
    inputs = Layout([("force", 3 * FEET), ("motion", 2 * FEET), ("lift_rate", 2 * FEET), *stretch])
    return Layouts(node, inputs, steerable, sum(size for _, size in state), previous)


# -- stages ----------------------------------------------------------------------------------------------


class Scaled:
    """Units of the variables: forces in weights of the robot, L in its mean moment of inertia times rad/s."""

    def __init__(self, body: Body) -> None:
        self.force = body.weight
        self.momentum = (body.inertia[0, 0] + body.inertia[1, 1] + body.inertia[2, 2]) / 3.0


def state_in(layout: Layouts, node: ca.SX, scaled: Scaled, body: Body) -> State:
    return state_of(layout, node, scaled.momentum, node[layout.node["z"]], body)


def _node_of(
    layout: Layouts, x: State, heights: Sequence[ca.SX], clock: ca.SX, inputs: ca.SX, scaled: Scaled
) -> ca.SX:
    """The node vector of a state, heights of the feet and clocks, that follow an interval of these inputs."""
    motion = inputs[layout.inputs["motion"]]
    return ca.vertcat(
        *state_entries(layout, x, scaled.momentum),
        *heights,
        clock,
        inputs[layout.inputs["force"]],
        *(motion[j] for j in layout.previous),
    )


class Interval:
    """The symbols of one interval, its step, and instants at its begin, middle and end."""

    def __init__(self, symbols: StageSymbols, layout: Layouts) -> None:
        self.layout = layout
        self.node = ca.SX.sym("node", layout.node.size)
        self.u = ca.SX.sym("inputs", layout.inputs.size)
        self.next_node = ca.SX.sym("next_node", layout.node.size)
        body = self.body = self.body_of(symbols)
        self.scaled = Scaled(body)
        self.robot = figures(symbols)
        groups = {name: self.u[layout.inputs[name]] for name in ("force", "motion", "lift_rate")}
        self.inputs = Inputs(
            [body.weight * groups["force"][3 * i : 3 * i + 3] for i in range(FEET)],
            [groups["motion"][2 * i : 2 * i + 2] for i in range(FEET)],
            [groups["lift_rate"][2 * i : 2 * i + 2] for i in range(FEET)],
        )
        self.previous = self._previous_inputs()
        self.begin = state_in(layout, self.node, self.scaled, body)
        self.height = ca.vertsplit(self.node[layout.node["z"]])
        feet = [
            FootInput(ca.vertsplit(f), ca.vertsplit(m), ca.vertsplit(w))
            for f, m, w in zip(self.inputs.force, self.inputs.motion, self.inputs.lift_rate, strict=True)
        ]
        wrench = None if body.wrench is None else ca.vertsplit(body.wrench)
        self.end, self.middle = step(ca, self.begin, feet, body.interval, self.robot, body.terrain, wrench)
        self.next_height = self.heights_at(1.0)
        if symbols.leaves is not None:
            self.next_height = [
                z + leaves.height(foot.p)
                for z, leaves, foot in zip(self.next_height, symbols.leaves, self.end.feet, strict=True)
            ]

    def body_of(self, symbols: StageSymbols) -> Body:
        """The figures of the robot, and how long the interval lasts."""
        return symbols.body

    @property
    def next_clock(self) -> ca.SX:
        """What tells the time at the end of the interval, if anything does."""
        return ca.SX(0, 1)

    @property
    def y(self) -> ca.SX:
        """All local variables, in rising order of their numbers in the whole problem."""
        return ca.vertcat(self.node, self.u, self.next_node)

    def _previous_inputs(self) -> Inputs:
        force = self.node[self.layout.node["previous_force"]]
        motion = ca.SX.nan(2 * FEET)
        motion[list(self.layout.previous)] = self.node[self.layout.node["previous_motion"]]
        return Inputs(
            [self.body.weight * force[3 * i : 3 * i + 3] for i in range(FEET)],
            [motion[2 * i : 2 * i + 2] for i in range(FEET)],
            Inputs.none().lift_rate,
        )

    def instant(self, x: State, tau: float, height_point: int | None = None) -> Instant:
        """The instant of a state at the fraction τ of the interval."""
        height, rates = self.heights_at(tau), _rate_at(self.inputs.lift_rate, tau)
        inputs, previous = self.inputs, self.previous
        return instant_of(self.body, self.robot, x, height, rates, inputs, previous, height_point, tau)

    def heights_at(self, tau: float) -> list[ca.SX]:
        """Heights of the feet above the ground at the fraction τ of the interval."""
        h, weights = self.body.interval, ca.DM(_height_integrals(tau))
        lifts = self.inputs.lift_rate
        return [z + h * ca.dot(weights, lift) for z, lift in zip(self.height, lifts, strict=True)]

    def at_height_point(self, j: int) -> Instant:
        """The instant at a height point (only the height and its rate are those of the point)."""
        return self.instant(self.begin, float(HEIGHT.points[j]), j)


@dataclass(frozen=True)
class IntervalStage:
    """The stage of an interval: its step, costs and constraints."""

    layout: Layouts
    name: ClassVar[str] = "condensed interval"
    places: ClassVar[Mapping[Place, int]] = {
        Place.NODE: 1,
        Place.INTERVAL_END: 1,
        Place.HEIGHT_POINTS: len(POINTS),
    }
    terminal: ClassVar[bool] = False
    only_at_nodes: ClassVar[bool] = True
    worth_compiling: ClassVar[bool] = True

    def interval(self, symbols: StageSymbols) -> Interval:
        """The symbols of the interval."""
        return Interval(symbols, self.layout)

    def own_rows(self, symbols: StageSymbols, interval: Interval) -> None:
        """Rows and costs of the recipe's own, if it has any."""

    def write(self, symbols: StageSymbols) -> ca.SX:
        layout = self.layout
        interval = self.interval(symbols)
        node_end = _node_of(
            layout, interval.end, interval.next_height, interval.next_clock, interval.u, interval.scaled
        )
        gap, at_end = interval.next_node - node_end, Place.INTERVAL_END.name
        symbols.add_rows(gap[: layout.last], "dynamics", at_end)
        symbols.add_rows(gap[layout.last :], "dynamics", at_end, source=CARRIED)
        self.own_rows(symbols, interval)
        begin, middle, end = (
            interval.instant(x, tau)
            for x, tau in ((interval.begin, 0.0), (interval.middle, 0.5), (interval.end, 1.0))
        )
        if len(layout.steerable) == FEET:
            symbols.add_costs([middle], np.ones(1))
        else:  # a foot that steps freely may cross its whole step in one interval
            symbols.add_costs([begin, middle, end], SIMPSON)
        symbols.add_constraints(
            {
                Place.NODE: [begin],
                Place.INTERVAL_END: [end],
                Place.HEIGHT_POINTS: [interval.at_height_point(j) for j in range(len(POINTS))],
            }
        )
        return interval.y


@dataclass(frozen=True)
class EndStage:
    """The stage of the end of the horizon."""

    layout: Layouts
    name: ClassVar[str] = "condensed end"
    places: ClassVar[Mapping[Place, int]] = {Place.TERMINAL: 1}
    terminal: ClassVar[bool] = True
    only_at_nodes: ClassVar[bool] = False
    worth_compiling: ClassVar[bool] = False

    def write(self, symbols: StageSymbols) -> ca.SX:
        node = ca.SX.sym("node", self.layout.last)
        body, none = symbols.body, [ca.SX.nan(1)] * FEET
        x, height = (
            state_in(self.layout, node, Scaled(body), body),
            ca.vertsplit(node[self.layout.node["z"]]),
        )
        nothing = Inputs.none()
        instant = instant_of(body, figures(symbols), x, height, none, nothing, nothing, tau=1.0)
        symbols.add_costs([instant], np.ones(1), terminal=True)
        symbols.add_constraints({Place.TERMINAL: [instant]})
        return node


def _rate_at(lift_rate: Sequence[ca.SX], tau: float) -> list[ca.SX]:
    """ṗz at the fraction τ: linear through the two height points."""
    c1, c2 = POINTS
    return [((tau - c2) * w[0] - (tau - c1) * w[1]) / (c1 - c2) for w in lift_rate]


def _height_integrals(tau: float) -> Array:
    """∫₀^τ of the lines with value 1 at one height point and 0 at the other."""
    c1, c2 = POINTS
    return np.array([(0.5 * tau - c2) * tau / (c1 - c2), (0.5 * tau - c1) * tau / (c2 - c1)])


# -- to and from numbers ---------------------------------------------------------------------------------


def encoded(problem: Problem, motion: MotionGuess) -> tuple[Array, Array]:
    """The variables that come nearest to a motion: of each interval in a row, and of the last node."""
    layout, schedule, robot = make_layout(problem.robot), problem.schedule, problem.robot
    count, h, begins = schedule.intervals, schedule.lengths[:, None], schedule.node_times[:-1]
    nodes = _node_rows(layout, motion(schedule.node_times), problem)
    middle = motion(schedule.mesh.middles)
    at_height = motion((begins[:, None] + h * HEIGHT.points).ravel())
    interval = np.repeat(np.arange(count), len(POINTS))
    climb = problem.footing.climb(
        interval, at_height.foot_position[..., :2], at_height.foot_velocity[..., :2]
    )
    rates = (at_height.foot_velocity[:, :, 2] - climb).reshape(count, len(POINTS), FEET).swapaxes(1, 2)
    force = (middle.force / robot.weight).reshape(count, -1)
    motions = motion_inputs(robot, middle).reshape(count, -1)
    previous = np.hstack([force, motions[:, list(layout.previous)]])
    previous = np.vstack([np.zeros_like(previous[:1]), previous[:-1]])
    rows = np.hstack([nodes[:-1], previous, force, motions, rates.reshape(count, -1)])
    return rows, nodes[-1]


def _node_rows(layout: Layouts, s: Samples, problem: Problem) -> Array:
    """States at the nodes without the previous inputs, one row for each."""
    robot, nodes = problem.robot, np.arange(len(s.time))
    ground = problem.footing.height(np.minimum(nodes, nodes[-1] - 1), s.foot_position[..., :2])
    L = angular_momentum(np, list(s.euler.T), list(s.euler_rate.T), list(robot.inertia_matrix))
    return np.hstack(
        [
            s.euler,
            np.stack(L, axis=-1) / robot.mean_inertia,
            s.com_position,
            s.com_velocity,
            s.foot_position[:, :, :2].reshape(len(s.time), -1),
            s.heading[:, list(layout.steerable)],
            s.foot_position[:, :, 2] - ground,
        ]
    )


def start_values(problem: Problem, layout: Layouts, clock: Sequence[float] = ()) -> Array:
    """x0 in the order of the first node, with the inputs before it: none if the robot stands."""
    start, robot = problem.start, problem.robot
    L = angular_momentum(np, list(start.base[3:]), list(start.base_rate[3:]), list(robot.inertia_matrix))
    return np.concatenate(
        [
            start.base[3:],
            np.array(L) / robot.mean_inertia,
            start.base[:3],
            start.base_rate[:3],
            start.p_foot[:, :2].ravel(),
            start.heading[list(layout.steerable)],
            problem.start_height,  # of a foot on the ground it is zero, be it fitted or not
            clock,
            np.zeros(3 * FEET) if start.force is None else start.force.ravel() / robot.weight,
            start.motion.ravel()[list(layout.previous)],
        ]
    )


def decoded(problem: Problem, layout: Layouts, rows: Array, lengths: Array) -> CondensedTrajectory:
    """The motion that the variables of the intervals mean, one row each; they last `lengths` (s)."""
    count, robot = problem.schedule.intervals, problem.robot
    nodes, inputs = rows[:, : layout.node.size], rows[:, layout.node.size :]
    heading = np.zeros((count, FEET))
    heading[:, list(layout.steerable)] = nodes[:, layout.node["sigma"]]
    foot_xy = nodes[:, layout.node["xy"]].reshape(count, FEET, 2)
    ground = problem.footing.height(np.arange(count), foot_xy)
    values: dict[str, Any] = {
        "contact": problem.schedule.contact.T,
        "lengths": lengths,
        "r": nodes[:, layout.node["r"]],
        "theta": nodes[:, layout.node["theta"]],
        "dr": nodes[:, layout.node["dr"]],
        "L": nodes[:, layout.node["L"]] * robot.mean_inertia,
        "foot_xy": foot_xy,
        "foot_z": ground + nodes[:, layout.node["z"]],
        "ground": problem.footing.numbers(),
        "heading": heading,
        "force": inputs[:, layout.inputs["force"]].reshape(count, FEET, 3) * robot.weight,
        "motion": inputs[:, layout.inputs["motion"]].reshape(count, FEET, 2),
        "lift_rate": inputs[:, layout.inputs["lift_rate"]].reshape(count, FEET, 2),
    }
    wrench = None if problem.wrench is None else problem.wrench.T
    return CondensedTrajectory(**{name: value.copy() for name, value in values.items()}, wrench=wrench)
