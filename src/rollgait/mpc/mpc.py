"""The controller: built once, then a step for each state, without building anything again."""

from __future__ import annotations

import logging
import math
import time as wall
from collections import deque
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.step import (
    POINTS,
    Figures,
    FootInput,
    FootState,
    State,
    angular_momentum,
    euler_rate,
    step,
)
from rollgait.errors import InputError, RollgaitError
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.command import PoseCommand, VelocityCommand, check_command
from rollgait.mpc.filling import Filling
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.incoming import Incoming
from rollgait.mpc.iterate import Iterate
from rollgait.mpc.model import build
from rollgait.mpc.prediction import STANDING_STATUS, Event, Mode, Prediction, Status
from rollgait.mpc.reference import Reference, ReferenceMaker
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.standing import Standing, within_cone
from rollgait.mpc.state import Control, RobotState
from rollgait.mpc.support import HOLD_MAX, READY_MARGIN, support_margin
from rollgait.robot.robot import Robot
from rollgait.solvers.fatrop import OPTIONS
from rollgait.solvers.fatrop_direct import DirectFatrop
from rollgait.solvers.fatrop_library import InterfaceError
from rollgait.solvers.kernels import compiled
from rollgait.solvers.linear_algebra import use_fast_products
from rollgait.solvers.solution import Solution
from rollgait.transcription.nlp import Nlp

log = logging.getLogger("rollgait")
Array = NDArray[np.float64]

BARRIER: Final = 1e-2
"""Barrier parameter with which a step begins: a warm start is near the solution."""
FEASIBLE: Final = 1e-3
"""Largest violation (scaled as the solver sees it) of a converged iterate."""
USABLE: Final = 0.2
"""Violation from which on an iterate is not used: its motion is not one that the robot could make."""
REPAIRED: Final = 0.02
"""Violation from which on a step iterates again, if there is time: after a push, or a change of gait."""
REPAIR_ITERATIONS: Final = 4
"""How many then."""
BELIEVED: Final = 0.1
"""After a failed solve a state is believed if it is no farther than this from the expected one, m."""
FROM_THE_START: Final = frozenset({"workspace", "joint_margin_deg"})
"""Bounds that are built in."""
HOPELESS: Final = 1e2
"""Violation of a guess from which on the solver is not asked: it may not come back from there."""
AFTERWARDS: Final = 1e-3
"""What is left to do when the solver has come back takes less than this, s."""
FAILURES_MAX: Final = 10
"""So many failed solves in a row bring the robot to a stand for good."""
EVENTS_KEPT: Final = 1000


def _far(state: RobotState, expected: RobotState) -> bool:
    """Whether a state is too far from what was expected to be believed when something is wrong."""
    gap = (state.com_position - expected.com_position, state.foot_position - expected.foot_position)
    return max(float(np.abs(part).max()) for part in gap) > BELIEVED


def _violation(nlp: Nlp, solution: Solution) -> float:
    """Largest violation of a constraint, scaled as the solver sees it; infinite where it is no number."""
    if not np.isfinite(solution.w).all() or not np.isfinite(solution.g).all():
        return math.inf
    return float(nlp.violations(solution.g, solution.w).max(initial=0.0))


class Mpc:
    """Receding-horizon control of stepping, rolling and steering.

    >>> mpc = Mpc("centauro")                                        # doctest: +SKIP
    >>> control, prediction = mpc.step(state, VelocityCommand(forward=0.3))  # doctest: +SKIP

    Args:
        robot: of the library by name, or its data.
        settings: horizon, weights, bounds.
        gait: with which it begins.
        kernels: compile the stage functions, where there is a compiler.

    Raises:
        UnknownNameError: there is no such robot or gait.
        RollgaitError: the solver's library is not the expected one.

    Attributes:
        events: what went wrong, newest last.
        clock: which foot is where when.
    """

    def __init__(
        self,
        robot: Robot | str,
        settings: MpcSettings | None = None,
        *,
        gait: str = "drive",
        kernels: bool = True,
    ) -> None:
        from rollgait.robot.library import find_robot

        self.robot = find_robot(robot) if isinstance(robot, str) else robot
        self.settings = settings or MpcSettings()
        self._problem = build(self.robot, self.settings, compiled if kernels else None)
        if kernels:
            use_fast_products()
        options = OPTIONS | {"mu_init": BARRIER}
        try:
            self._solver = DirectFatrop(self._problem.nlp, self._problem.structure, options, {})
        except InterfaceError as error:
            raise RollgaitError(f"the controller needs fatrop as CasADi 3.8 ships it: {error}") from None
        self._fill = Filling(self._problem, self.settings)
        self._take_robot(self.robot)
        self._iterate = Iterate(self._problem)
        rates = [leg.steering_rate_max for leg in self.robot.leg_list]
        steering_rate = min(self.settings.bounds.steering_rate_max, *rates)
        self._reference = ReferenceMaker(self.robot, self.settings.limits, steering_rate, self.robot.height)
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self._gait = gait
        self._now = 0.0
        self.clock = GaitClock(gait)
        self._last: Control | None = None
        self._failures = 0
        self._incoming = Incoming(self.settings.period, self._note, self.stop)
        self._stands = False
        self._held = 0.0
        self._weights = self.settings.weights
        self._cut = ""

    # -- what may be changed at any time -----------------------------------------------------------------

    @property
    def wanted(self) -> tuple[float, float, float]:
        """Forward and lateral velocity (m/s) and yaw rate (rad/s) that the reference has now."""
        return self._reference.twist

    def set_mass(self, mass: float) -> None:
        """The robot's mass, kg; its inertia grows with it."""
        inertia = {
            name: value * mass / self.robot.mass for name, value in self.robot.inertia.model_dump().items()
        }
        data = self.robot.model_dump(mode="json") | {"mass": mass, "inertia": inertia}
        self._take_robot(type(self.robot).model_validate(data))

    def set_weights(self, **weights: float) -> None:
        """Weights of costs by name, as in `MpcWeights`."""
        self._weights = type(self._weights)(**(self._weights.model_dump() | weights))
        self._fill.set_weights(self._weights)

    def set_bounds(self, **bounds: float) -> None:
        """Bounds by name, as in `MpcBounds`; the workspace itself stays as it was built."""
        for name in FROM_THE_START.intersection(bounds):
            raise InputError(f"bounds.{name}", bounds[name], "must be given when the controller is built")
        self._fill.set_bounds(type(self.settings.bounds)(**(self._fill.bounds.model_dump() | bounds)))

    def set_ground(self, height: Array | float) -> None:
        """Height of the ground, m: one, or one for each foot (4,). Raises `InputError`."""
        rule = "must be a finite height in m, or one for each of the 4 feet"
        try:
            given = np.broadcast_to(np.asarray(height, dtype=float), (4,)).copy()
        except (TypeError, ValueError):
            raise InputError("ground", height, rule) from None
        if not np.isfinite(given).all():
            raise InputError("ground", height, rule)
        self._fill.ground = given

    def reset(self, gait: str | None = None) -> None:
        """Forgets the past and all faults: the next state is taken as that of a standing robot.

        It begins with a gait: this one, or else the one of the last beginning. Raises `UnknownNameError`.
        """
        self._gait = self._gait if gait is None else find_gait(gait).name
        self._last, self._failures, self._stands = None, 0, False
        self._held, self._cut = 0.0, ""
        self._fill.reset_stance()
        self._incoming.reset()
        self.events.clear()

    # -- a step ------------------------------------------------------------------------------------------

    def step(
        self, state: RobotState | None, command: VelocityCommand | PoseCommand
    ) -> tuple[Control, Prediction]:
        """What to do for the next period, and what is expected of the horizon.

        Args:
            state: of the robot now; None if there is none.
            command: what is asked for; beyond the limits it is cut.

        Raises:
            InputError: the command is none, or there is no state to begin with.
        """
        begin = wall.perf_counter()
        check_command(command)
        state, elapsed = self._incoming.take(state, self._last)
        self._now = state.time
        deadline = begin + (self.settings.deadline or self.settings.period)
        command = self._within_limits(command, state.time)
        if self._stands:
            command = VelocityCommand()
        elif command.gait is not None and command.gait != self.clock.gait.name:
            self.clock.request(command.gait, state.time)
            self._held = 0.0
        self.clock.advance(state.time)
        self._put_off_steps(state)
        previous = self._last
        if previous is None:
            self._begin(state)
        else:
            self._iterate.shift(elapsed / self._fill.interval)
        reference = self._fill_in(state, command, elapsed)
        status = self._solve(deadline - AFTERWARDS) if not self._stands else STANDING_STATUS
        if previous is not None and (self._stands or self._failures) and _far(state, previous.end):
            state = previous.end.at(state.time)  # what is measured may be the very reason
        control = self._control(state, previous)
        self._last = control
        seconds = wall.perf_counter() - begin
        status = replace(status, seconds=seconds, late=begin + seconds > deadline, mode=self._mode)
        return control, self._prediction(state.time, reference, status)

    @property
    def _mode(self) -> Mode:
        if self._stands:
            return "standing"
        coasts = self._failures > 0 or self._incoming.missing
        return "coasting" if coasts else "tracking"

    def stop(self, reason: str) -> None:
        """Brings the robot to a stand, for good until `reset`; the reason is logged."""
        if not self._stands:
            self._stands = True
            time = self._last.end.time if self._last is not None else 0.0
            self.clock.request("stand", time)
            self._note(time, f"stands: {reason}")

    def note(self, text: str) -> None:
        """Adds an event of now: something that was not as it should be."""
        self._note(self._now, text)

    def _note(self, time: float, text: str) -> None:
        self.events.append(Event(time, text))
        log.warning("t = %.2f s: %s", time, text)

    # -- what is known -----------------------------------------------------------------------------------

    def _within_limits(
        self, command: VelocityCommand | PoseCommand, time: float
    ) -> VelocityCommand | PoseCommand:
        cut, note = command.within(self.settings.limits)
        if note and note != self._cut:
            self._note(time, f"command beyond the limits: {note}")
        self._cut = note
        return cut

    def _begin(self, state: RobotState) -> None:
        """Standing: the weight on all feet, all else at rest."""
        self.clock = GaitClock("stand" if self._stands else self._gait, state.time)
        self._reference.reset(state)
        it, layout = self._iterate, self._problem.layout
        it.states[:] = self._node(state)
        it.inputs[:] = 0.0
        it.forget_contacts()
        p = self.robot.stance[:, :2]
        A = np.vstack([np.ones(4), p.T])
        forces = np.linalg.pinv(A) @ np.array([1.0, 0.0, 0.0])
        it.inputs[:, layout.inputs["force"]][:, 2::3] = forces
        it.previous[:] = 0.0
        it.previous[2:12:3] = forces

    def _put_off_steps(self, state: RobotState) -> None:
        """Lets a foot stay on the ground while the others could not carry the robot yet."""
        period = self.settings.period
        pending = self.clock.pending(state.time, period)
        if not pending:
            return
        standing = self.clock.contact(state.time)
        standing[pending] = False
        if support_margin(state, standing) < READY_MARGIN and self._held < HOLD_MAX:
            self._held += period
            self.clock.hold(period)
        else:
            self._held = 0.0

    def _node(self, state: RobotState) -> Array:
        """The state as a node vector."""
        L = angular_momentum(np, state.euler.tolist(), state.euler_rate.tolist(), self._inertia)
        steerable = list(self._problem.layout.steerable)
        return np.concatenate(
            [
                state.euler,
                np.array(L) / self._momentum,
                state.com_position,
                state.com_velocity,
                state.foot_position[:, :2].ravel(),
                state.heading[steerable],
            ]
        )

    def _fill_in(
        self, state: RobotState, command: VelocityCommand | PoseCommand, elapsed: float
    ) -> Reference:
        it, fill = self._iterate, self._fill
        it.states[0] = self._node(state)
        limit = fill.speed_limit
        it.previous[12:] = np.clip(it.previous[12:], -limit, limit)
        fill.put_state(it.first_node)
        fill.put_stance(self.clock.gait.centred, elapsed)
        fill.put_contact(self.clock, state.time)
        it.adapt_forces(fill.share, fill.force_low, fill.force_high, fill.usual_force)
        reference = self._reference.look_ahead(state, command, self.clock, elapsed, fill.count, fill.interval)
        fill.put_reference(reference)
        fill.put_strides(self.clock, state.time, reference.foot_velocity)
        return reference

    # -- solving -----------------------------------------------------------------------------------------

    def _solve(self, deadline: float) -> Status:
        nlp, solver = self._problem.nlp, self._solver
        if not solver.violation(self._iterate.variables()) < HOPELESS:
            return self._failed("the guess is far from any motion", math.inf)
        begin = wall.perf_counter()
        wanted = self.settings.iterations
        solution = solver.solve(self._iterate.variables(), until=deadline, iterations=wanted)
        iterations = solution.iterations
        again = wanted < REPAIR_ITERATIONS and _violation(nlp, solution) > REPAIRED
        if again and wall.perf_counter() < deadline:
            # from the same guess: a second start from a first iterate would lose its barrier
            other = solver.solve(self._iterate.variables(), until=deadline, iterations=REPAIR_ITERATIONS)
            iterations += other.iterations
            if _violation(nlp, other) <= _violation(nlp, solution):
                solution = other
        seconds = wall.perf_counter() - begin
        violation = _violation(nlp, solution)
        if violation > USABLE:
            return self._failed(f"violation {violation:.2g}", violation, iterations, seconds)
        if not solution.solved and np.array_equal(solution.w, self._iterate.variables()):
            return self._failed("it found no step", violation, iterations, seconds)
        self._iterate.take(solution.w)
        self._failures = 0
        return Status(
            mode="tracking",
            iterations=iterations,
            converged=solution.solved and violation < FEASIBLE,
            violation=violation,
            cost=solution.cost,
            cost_rate=solver.first_cost(solution.w) / self._fill.interval,
            solver_seconds=seconds,
        )

    def _failed(self, why: str, violation: float, iterations: int = 0, seconds: float = 0.0) -> Status:
        self._failures += 1
        if self._failures == 1:
            self._note(self._now, f"a solve failed ({why}): the last plan goes on")
        if self._failures >= FAILURES_MAX:
            self.stop(f"{FAILURES_MAX} solves in a row have failed")
        return Status("coasting", iterations, violation=violation, solver_seconds=seconds)

    # -- what to do --------------------------------------------------------------------------------------

    def _control(self, state: RobotState, previous: Control | None) -> Control:
        """The first bit of the plan, carried out by the model for one period."""
        period, robot = self.settings.period, self._fill.robot
        contact = self.clock.contact(state.time)
        if self._stands:
            force, motion = self._standing.inputs(state, contact, previous)
        else:
            force, motion = self._inputs(state.time, contact, previous)
        it = self._iterate
        it.previous[:12] = force.ravel() / robot.weight
        it.previous[12:] = motion[:, 0]
        end = self._end_of_period(state, force, motion, period)
        if self._stands:
            end = self._standing.settle(end, period)
            it.rest(self._node(end))
        return Control(state, end, force, motion, contact)

    def _inputs(
        self, now: float, contact: NDArray[np.bool_], previous: Control | None
    ) -> tuple[Array, Array]:
        """Forces and motions of the plan now. Speeds change no faster than the bounds allow."""
        layout, it, bounds = self._problem.layout, self._iterate, self._fill.bounds
        u = it.inputs[0]
        force = contact[:, None] * u[layout.inputs["force"]].reshape(4, 3) * self._fill.robot.weight
        motion = u[layout.inputs["motion"]].reshape(4, 2).copy()
        locked = contact & self.clock.locked(now)
        motion[locked] = 0.0
        before = np.zeros(4) if previous is None else previous.motion[:, 0]
        limit = self.settings.period * np.where(
            contact, bounds.acceleration_max, bounds.swing_acceleration_max
        )
        change = np.clip(motion[:, 0] - before, -limit, limit)
        speed, rate = self._fill.speed_limit, self._fill.steering_rate
        motion[:, 0] = np.where(locked, 0.0, np.clip(before + change, -speed, speed))
        motion[:, 1] = np.clip(motion[:, 1], -rate, rate)
        # an iterate may violate what no robot shall be asked for; the pyramid reaches √2 beyond the cone
        return within_cone(force, np.sqrt(2.0) * bounds.friction), motion

    def _end_of_period(self, state: RobotState, force: Array, motion: Array, period: float) -> RobotState:
        """The model one period later: the planner's step with Python's numbers, which are the quickest."""
        ground, t = self._fill.ground, state.time
        points = [t, t + period, *(t + period * point for point in POINTS)]
        height, rate = self.clock.lift(np.array(points))
        theta, p = state.euler.tolist(), state.foot_position.tolist()
        z, heading = (ground + height[0]).tolist(), state.heading.tolist()
        L = angular_momentum(math, theta, state.euler_rate.tolist(), self._inertia)
        feet = tuple(FootState([p[i][0], p[i][1], z[i]], heading[i]) for i in range(4))
        x = State(state.com_position.tolist(), theta, state.com_velocity.tolist(), L, feet)
        rates = rate[2:].T.tolist()
        given = zip(force.tolist(), motion.tolist(), rates, strict=True)
        end, _ = step(math, x, [FootInput(*values) for values in given], period, self._figures)
        foot_position = np.array([foot.p for foot in end.feet])
        foot_position[:, 2] = ground + height[1]
        return RobotState(
            time=t + period,
            com_position=np.array(end.r),
            euler=np.array(end.theta),
            com_velocity=np.array(end.dr),
            euler_rate=np.array(euler_rate(math, end.theta, end.L, self._figures)),
            foot_position=foot_position,
            heading=np.array([foot.sigma for foot in end.feet]),
            speed=motion[:, 0].copy(),
        )

    def _take_robot(self, robot: Robot) -> None:
        self._inertia = robot.inertia_matrix.tolist()
        inverse = np.linalg.inv(robot.inertia_matrix).tolist()
        self._momentum = robot.mean_inertia
        self._standing = Standing(robot, self.settings)
        legs = robot.leg_list
        self._figures = Figures(
            robot.mass, inverse, [leg.foot for leg in legs], [leg.heading for leg in legs]
        )
        self._fill.set_robot(robot)

    def _prediction(self, time: float, reference: Reference, status: Status) -> Prediction:
        layout, it, fill = self._problem.layout, self._iterate, self._fill
        count = fill.count
        stage = self._problem.interval
        stands = stage.numbers("stands").T > 0.0
        position = np.empty((count + 1, 4, 3))
        position[:, :, :2] = it.states[:, layout.node["xy"]].reshape(count + 1, 4, 2)
        position[:-1, :, 2] = stage.numbers("foot_z").T
        position[-1, :, 2] = self._problem.end.numbers("foot_z")[:, 0]
        force = it.inputs[:, layout.inputs["force"]].reshape(count, 4, 3) * fill.robot.weight
        return Prediction(
            time=time + fill.interval * np.arange(count + 1, dtype=float),
            com_position=it.states[:, layout.node["r"]].copy(),
            euler=it.states[:, layout.node["theta"]].copy(),
            foot_position=position,
            force=force * stands[:, :, None],
            contact=stands,
            reference=reference.pose.T,
            status=status,
        )
