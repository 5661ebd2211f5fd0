"""The paper's transcription: orthogonal collocation, lifted.

The horizon is cut into N intervals. In each, the states other than the foot heights are 3rd-order
polynomials with 3 Gauss-Legendre points and constant inputs u1; the foot heights are parabolas with 2
points and u2 = ṗz free at each of them. Intervals are independent; continuity is a constraint. At a
collocation point the dynamics is written as a residual, in the polynomial's own derivatives, which is the
same as θ̈ = f(x, u) and cheaper to differentiate.

All values at supports are columns: support 0 is the node, the others are the collocation points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.rigid_body import momentum_rate, torque_about_com
from rollgait.errors import InputError
from rollgait.ocp.instant import Inputs, Instant, make_instant
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import Place
from rollgait.plan.samples import Samples
from rollgait.plan.trajectory import CollocationTrajectory
from rollgait.polynomials import HEIGHT_POINTS, STATE_POINTS
from rollgait.robot.robot import Robot
from rollgait.transcription.code import CodeStore, StageSymbols
from rollgait.transcription.guess import MotionGuess, motion_inputs
from rollgait.transcription.layout import Layout
from rollgait.transcription.nlp import Block, Nlp
from rollgait.transcription.stage import make_stage
from rollgait.transcription.tableau import gauss_legendre

Array = NDArray[np.float64]

STATE = gauss_legendre(STATE_POINTS)
HEIGHT = gauss_legendre(HEIGHT_POINTS)
FEET = 4


@dataclass(frozen=True)
class Collocation:
    """The transcribed problem, and the way from a guess to its variables and from them to a motion."""

    problem: Problem
    nlp: Nlp

    name = "collocation"
    structure = None

    def encode(self, motion: MotionGuess) -> Array:
        """The free variables that come nearest to a motion."""
        return _encode(self.problem, motion)[self.nlp.free]

    def decode(self, w: Array) -> CollocationTrajectory:
        """The motion that free variables mean."""
        return _decode(self.problem, self.nlp.all_variables(w))


def transcribe(problem: Problem, store: CodeStore | None = None) -> Collocation:
    """The problem as an NLP by collocation; `store` keeps the code of its stages.

    Raises:
        InputError: the ground is not flat, which only the condensed transcription knows.
    """
    if not problem.footing.is_flat:
        rule = "plans on flat ground only; on other ground: condensed"
        raise InputError("transcription", "collocation", rule)
    layout = _layout(problem.robot)
    count = problem.schedule.intervals
    node, interval = layout.node.size, layout.node.size + layout.inner.size
    total = count * interval + node
    begins = np.arange(count) * interval
    inside = begins + np.arange(interval + node)[:, None]  # the interval's own variables and the next node
    inputs = node + np.concatenate([layout.inner.index("force"), layout.inner.index("motion")])
    before = begins - interval + inputs[:, None]
    before[:, 0] = -1  # there is no interval before the first
    blocks = [
        Block(make_stage(_IntervalStage(layout), problem, store), np.vstack([before, inside])),
        Block(
            make_stage(_EndStage(layout), problem, store),
            (total - node + np.arange(node))[:, None],
            first=count,
        ),
    ]
    return Collocation(problem, Nlp(blocks, total, initial=_start_values(problem, layout)))


# -- variables -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Layouts:
    """Order of the variables: `state` at one support; `node` = state + heights; `inner` = the others."""

    state: Layout
    node: Layout
    inner: Layout
    steerable: tuple[int, ...]


def _layout(robot: Robot) -> _Layouts:
    steerable = tuple(i for i, leg in enumerate(robot.leg_list) if leg.foot == "steerable")
    state = Layout([("base", 6), ("base_rate", 6), ("xy", 2 * FEET), ("sigma", len(steerable))])
    node = Layout([("state", state.size), ("z", FEET)])
    inner = Layout(
        [
            ("states", STATE_POINTS * state.size),
            ("heights", HEIGHT_POINTS * FEET),
            ("force", 3 * FEET),
            ("motion", 2 * FEET),
            ("height_rate", HEIGHT_POINTS * FEET),
        ]
    )
    return _Layouts(state, node, inner, steerable)


# -- stages ----------------------------------------------------------------------------------------------


class _Interval:
    """The symbols of one interval, its polynomials, and instants anywhere in it."""

    def __init__(self, symbols: StageSymbols, layout: _Layouts) -> None:
        self.body, self.layout = symbols.body, layout
        self.kinds = symbols.outline.kinds
        inner = layout.inner
        self.previous = ca.SX.sym("previous", 5 * FEET)
        self.node = ca.SX.sym("node", layout.node.size)
        self.inner = ca.SX.sym("inner", inner.size)
        self.next_node = ca.SX.sym("next_node", layout.node.size)
        state_size = layout.state.size
        node_state, node_z = self.node[layout.node["state"]], self.node[layout.node["z"]]
        self.states = ca.horzcat(
            node_state, ca.reshape(self.inner[inner["states"]], state_size, STATE_POINTS)
        )
        self.heights = ca.horzcat(node_z, ca.reshape(self.inner[inner["heights"]], FEET, HEIGHT_POINTS))
        self.height_rates = ca.reshape(self.inner[inner["height_rate"]], FEET, HEIGHT_POINTS)
        weight = symbols.body.weight
        rates = [self.height_rates[i, :].T for i in range(FEET)]
        self.inputs = _inputs(weight, self.inner[inner["force"]], self.inner[inner["motion"]], rates)
        self.previous_inputs = _inputs(
            weight, self.previous[: 3 * FEET], self.previous[3 * FEET :], Inputs.none().lift_rate
        )

    @property
    def y(self) -> ca.SX:
        """All local variables, in rising order of their numbers in the whole problem."""
        return ca.vertcat(self.previous, self.node, self.inner, self.next_node)

    def instant(self, state: ca.SX, z: ca.SX, z_rate: ca.SX, height_point: int | None = None) -> Instant:
        """An instant with this interval's inputs."""
        base, rate, xy, sigma = _unpack(self.layout, state)
        return make_instant(
            self.body,
            self.kinds,
            base,
            rate,
            xy,
            [z[i] for i in range(FEET)],
            sigma,
            [z_rate[i] for i in range(FEET)],
            self.inputs,
            self.previous_inputs,
            height_point,
        )

    def at_point(self, j: int) -> Instant:
        """The instant at a collocation point; heights and their rates come from their own polynomial."""
        tau = STATE.points[j : j + 1]
        z = ca.mtimes(self.heights, HEIGHT.values_at(tau).T)
        # ṗz is linear in the interval and known at the two height points
        weights = (tau - HEIGHT.points[::-1]) / (HEIGHT.points - HEIGHT.points[::-1])
        return self.instant(self.states[:, 1 + j], z, ca.mtimes(self.height_rates, weights))

    def at_node(self) -> Instant:
        """The instant at the beginning."""
        return self.instant(self.states[:, 0], self.heights[:, 0], self._height_slope(HEIGHT.slope_begin))

    def at_end(self) -> Instant:
        """The instant at the end: the next node, still with this interval's inputs and parabolas."""
        state, z = self.next_node[self.layout.node["state"]], self.next_node[self.layout.node["z"]]
        return self.instant(state, z, self._height_slope(HEIGHT.slope_end))

    def at_height_point(self, j: int) -> Instant:
        """The instant at a height point (only the height and its rate are those of the point)."""
        return self.instant(self.states[:, 0], self.heights[:, 1 + j], self.height_rates[:, j], j)

    def _height_slope(self, weights: Array) -> ca.SX:
        return ca.mtimes(self.heights, weights) / self.body.interval


@dataclass(frozen=True)
class _IntervalStage:
    """The stage of an interval: its polynomials, costs and constraints."""

    layout: _Layouts
    name: ClassVar[str] = "collocation interval"
    places: ClassVar[Mapping[Place, int]] = {
        Place.NODE: 1,
        Place.POINTS: STATE_POINTS,
        Place.INTERVAL_END: 1,
        Place.HEIGHT_POINTS: HEIGHT_POINTS,
    }
    terminal: ClassVar[bool] = False
    only_at_nodes: ClassVar[bool] = False
    worth_compiling: ClassVar[bool] = True

    def write(self, symbols: StageSymbols) -> ca.SX:
        interval = _Interval(symbols, self.layout)
        points = [interval.at_point(j) for j in range(STATE_POINTS)]
        _add_defects(symbols, interval, points)
        _add_continuity(symbols, interval)
        symbols.add_costs(points, STATE.weights)
        symbols.add_constraints(
            {
                Place.NODE: [interval.at_node()],
                Place.POINTS: points,
                Place.INTERVAL_END: [interval.at_end()],
                Place.HEIGHT_POINTS: [interval.at_height_point(j) for j in range(HEIGHT_POINTS)],
            }
        )
        return interval.y


@dataclass(frozen=True)
class _EndStage:
    """The stage of the end of the horizon."""

    layout: _Layouts
    name: ClassVar[str] = "collocation end"
    places: ClassVar[Mapping[Place, int]] = {Place.TERMINAL: 1}
    terminal: ClassVar[bool] = True
    only_at_nodes: ClassVar[bool] = False
    worth_compiling: ClassVar[bool] = False

    def write(self, symbols: StageSymbols) -> ca.SX:
        node = ca.SX.sym("node", self.layout.node.size)
        base, rate, xy, sigma = _unpack(self.layout, node[self.layout.node["state"]])
        z = node[self.layout.node["z"]]
        x = make_instant(
            symbols.body,
            symbols.outline.kinds,
            base,
            rate,
            xy,
            [z[i] for i in range(FEET)],
            sigma,
            [ca.SX.nan(1)] * FEET,
            Inputs.none(),
            Inputs.none(),
        )
        symbols.add_costs([x], np.ones(1), terminal=True)
        symbols.add_constraints({Place.TERMINAL: [x]})
        return node


def _add_defects(symbols: StageSymbols, interval: _Interval, points: Sequence[Instant]) -> None:
    """The polynomials obey the dynamics at the collocation points: equations 1, 2 and 4."""
    h, body = symbols.body.interval, symbols.body
    inertia_scale = (body.inertia[0, 0] + body.inertia[1, 1] + body.inertia[2, 2]) / 3.0
    for j, x in enumerate(points):
        slope = ca.mtimes(interval.states, STATE.slope[j]) / h
        d_base, dd_base, d_xy, d_sigma = _unpack(interval.layout, slope)
        forces = [foot.force for foot in x.feet]
        torque = torque_about_com(x.r, [foot.p for foot in x.feet], forces)
        if body.wrench is not None:
            torque += x.external[1]
        momentum = momentum_rate(body.inertia, x.theta, x.dtheta, dd_base[3:])
        at = Place.POINTS.name
        symbols.add_rows(h * (d_base - ca.vertcat(x.dr, x.dtheta)), "dynamics", at)
        symbols.add_rows(h * (dd_base[:3] - x.ddr), "dynamics", at)
        symbols.add_rows(h * (momentum - torque) / inertia_scale, "dynamics", at)
        for foot in x.feet:
            rolling = [d_xy[foot.index] - foot.velocity[:2]]
            if foot.kind == "steerable":
                rolling.append(d_sigma[foot.index] - foot.heading_rate)
            symbols.add_rows(h * ca.vertcat(*rolling), "rolling", at, leg=foot.index, unit="m")
    for j in range(HEIGHT_POINTS):
        slope = ca.mtimes(interval.heights, HEIGHT.slope[j]) / h
        symbols.add_rows(h * (slope - interval.height_rates[:, j]), "height", Place.HEIGHT_POINTS.name)


def _add_continuity(symbols: StageSymbols, interval: _Interval) -> None:
    """The polynomials end where the next interval begins."""
    end = ca.vertcat(ca.mtimes(interval.states, STATE.end), ca.mtimes(interval.heights, HEIGHT.end))
    symbols.add_rows(interval.next_node - end, "continuity", Place.INTERVAL_END.name)


def _unpack(layout: _Layouts, state: ca.SX) -> tuple[ca.SX, ca.SX, list[ca.SX], list[ca.SX]]:
    """(base, base rate, contact points, headings) of a state; only feet that steer have a heading here."""
    xy, sigma = state[layout.state["xy"]], state[layout.state["sigma"]]
    headings = [ca.SX(0)] * FEET
    for number, leg in enumerate(layout.steerable):
        headings[leg] = sigma[number]
    feet = [xy[2 * i : 2 * i + 2] for i in range(FEET)]
    return state[layout.state["base"]], state[layout.state["base_rate"]], feet, headings


def _inputs(weight: ca.SX, force: ca.SX, motion: ca.SX, lift_rate: Sequence[ca.SX]) -> Inputs:
    """Inputs from their variables; forces are in units of the robot's weight, which halves iterations."""
    return Inputs(
        [weight * force[3 * i : 3 * i + 3] for i in range(FEET)],
        [motion[2 * i : 2 * i + 2] for i in range(FEET)],
        lift_rate,
    )


# -- to and from numbers ---------------------------------------------------------------------------------


def _encode(problem: Problem, motion: MotionGuess) -> Array:
    layout, schedule = _layout(problem.robot), problem.schedule
    count, h, begins = schedule.intervals, schedule.lengths[:, None], schedule.node_times[:-1, None]
    at_support = motion((begins + h * STATE.support).ravel())
    at_height = motion((begins + h * HEIGHT.points).ravel())
    middle = motion(schedule.mesh.middles)
    end = motion(np.array([schedule.horizon]))
    states = _state_rows(layout, at_support).reshape(count, STATE_POINTS + 1, -1)
    ground = problem.footing.level
    heights = at_support.foot_position[:, :, 2].reshape(count, STATE_POINTS + 1, FEET)[:, 0] - ground
    inner_heights = at_height.foot_position[:, :, 2].reshape(count, -1) - ground
    rates = at_height.foot_velocity[:, :, 2].reshape(count, -1)
    rows = np.hstack(
        [
            states[:, 0],
            heights,
            states[:, 1:].reshape(count, -1),
            inner_heights,
            (middle.force / problem.robot.weight).reshape(count, -1),
            motion_inputs(problem.robot, middle).reshape(count, -1),
            rates,
        ]
    )
    last = np.concatenate([_state_rows(layout, end)[0], end.foot_position[0, :, 2] - ground])
    return np.concatenate([rows.ravel(), last])


def _start_values(problem: Problem, layout: _Layouts) -> Array:
    """x0 in the order of the first node, which comes first among all variables."""
    start = problem.start
    sigma = start.heading[list(layout.steerable)]
    return np.concatenate(
        [
            start.base,
            start.base_rate,
            start.p_foot[:, :2].ravel(),
            sigma,
            start.p_foot[:, 2] - problem.footing.level,
        ]
    )


def _state_rows(layout: _Layouts, s: Samples) -> Array:
    xy = s.foot_position[:, :, :2].reshape(len(s.time), -1)
    sigma = s.heading[:, list(layout.steerable)]
    return np.hstack([s.com_position, s.euler, s.com_velocity, s.euler_rate, xy, sigma])


def _decode(problem: Problem, variables: Array) -> CollocationTrajectory:
    layout, count = _layout(problem.robot), problem.schedule.intervals
    node, inner = layout.node, layout.inner
    rows = variables[: count * (node.size + inner.size)].reshape(count, -1)
    nodes, rest = rows[:, : node.size], rows[:, node.size :]
    states = np.concatenate(
        [nodes[:, None, node["state"]], rest[:, inner["states"]].reshape(count, STATE_POINTS, -1)], axis=1
    )
    heading = np.zeros((count, STATE_POINTS + 1, FEET))
    heading[:, :, list(layout.steerable)] = states[:, :, layout.state["sigma"]]
    return CollocationTrajectory(
        contact=problem.schedule.contact.T.copy(),
        lengths=problem.schedule.lengths.copy(),
        base=states[:, :, layout.state["base"]].copy(),
        base_rate=states[:, :, layout.state["base_rate"]].copy(),
        foot_xy=states[:, :, layout.state["xy"]].reshape(count, STATE_POINTS + 1, FEET, 2).copy(),
        heading=heading,
        foot_z=problem.footing.level
        + np.concatenate(
            [nodes[:, None, node["z"]], rest[:, inner["heights"]].reshape(count, HEIGHT_POINTS, FEET)], axis=1
        ),
        force=rest[:, inner["force"]].reshape(count, FEET, 3) * problem.robot.weight,
        motion=rest[:, inner["motion"]].reshape(count, FEET, 2).copy(),
    )
