"""The controller: built once, then a step for each state, without building anything again."""

from __future__ import annotations

import logging
import math
import time as wall
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rollgait.dynamics.step import rotation
from rollgait.dynamics.wrench import external, mean_wrench
from rollgait.errors import InputError, NotSolvedError
from rollgait.mpc.clock import GaitClock
from rollgait.mpc.command import PoseCommand, VelocityCommand, check_command
from rollgait.mpc.context import LiveContext
from rollgait.mpc.filling import Filling
from rollgait.mpc.first_inputs import first_inputs
from rollgait.mpc.footwork import Footwork
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.ground.level import LevelGround
from rollgait.mpc.incoming import Incoming
from rollgait.mpc.iterate import Iterate
from rollgait.mpc.model import RobotModel
from rollgait.mpc.outlook import expected_at, outlook
from rollgait.mpc.prediction import STANDING_STATUS, Event, Mode, Prediction, Status
from rollgait.mpc.reference import Reference, ReferenceMaker
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.standing import Standing
from rollgait.mpc.support import StepHold
from rollgait.ocp.live import as_costs, standard_costs
from rollgait.ocp.term import Term
from rollgait.plant.control import Control
from rollgait.plant.state import RobotState, largest_gap
from rollgait.robot.library import find_robot
from rollgait.robot.loads import Wrench
from rollgait.robot.robot import Robot
from rollgait.solvers import Repair, Solution, make_solver, quickest_solver
from rollgait.solvers.code_store import store_for
from rollgait.solvers.stage_evaluation import StageEvaluation
from rollgait.terrain.terrain import Terrain
from rollgait.transcription.live import transcribe
from rollgait.transcription.nlp import Nlp

if TYPE_CHECKING:
    from rollgait.mpc.ground.terrain import TerrainGround
    from rollgait.mpc.plans.follower import PlanFollower, Progress
    from rollgait.mpc.plans.wanted import Wanted
    from rollgait.plan.plan import Plan
    from rollgait.plant.moving import MotionState

log = logging.getLogger("rollgait")
Array = NDArray[np.float64]

FEASIBLE: Final = 1e-3
"""Largest violation (scaled as the solver sees it) of a converged iterate."""
USABLE: Final = 0.2
"""Violation from which on an iterate is not used: its motion is not one that the robot could make."""

FOLLOWING: Final = {"goal": 5000.0, "feet": 4000.0, "velocity": 50.0, "heading": 20.0, "support": 0.0}
"""Weights of the costs while a plan is followed: it knows where all shall be, a command does not."""
ROOMY: Final = ("speed_max", "acceleration_max", "swing_speed_max", "swing_acceleration_max")
FOLLOWING_ROOM: Final = 1.5
"""Factor on these bounds while a plan is followed: it may use all of its own, and who is late catches up."""
REPAIR: Final = Repair(above=0.02, iterations=4)
"""Violation from which on a step iterates on, if there is time (after a push, or a change of gait), and how
often altogether."""
PATIENT_ITERATIONS: Final = 30
"""Fewest that a solver may make which keeps no deadline anyway."""
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
        terms: further costs and constraints of your own; constraints become costs beyond their limits, with
            the weight `workspace`.
        follows: whether the states are those of a robot that does what it is told, so that one whose feet
            move otherwise is old; those of a recording are not.
        solver: one of `SOLVER_NAMES`; the quickest that is installed if not given. Only fatrop as CasADi 3.8
            ships it keeps deadlines; others find the same motion, late.
        wrenches: what pulls at the base, in the time of the states; what the robot carries it says itself.

    Raises:
        UnknownNameError: there is no such robot, gait or solver.
        InputError: a cost is no sum of squares, a constraint is of the end of the horizon, or the solver that
            was asked for is not installed.

    Attributes:
        events: what went wrong, newest last.
        clock: which foot is where when.
        stretch: seconds of wall time in a second of the robot's: more than 1 where its time is simulated and
            goes slowly. Deadlines grow with it.
    """

    def __init__(
        self,
        robot: Robot | str,
        settings: MpcSettings | None = None,
        *,
        gait: str = "drive",
        kernels: bool = True,
        terms: Sequence[Term] = (),
        follows: bool = True,
        solver: str | None = None,
        wrenches: Sequence[Wrench] = (),
    ) -> None:
        self._wrenches = tuple(wrenches)
        self.robot = find_robot(robot) if isinstance(robot, str) else robot
        self.settings = settings or MpcSettings()
        self._own = as_costs(terms, self.settings.weights.workspace)
        self._kernels, self._solver_name = kernels, solver
        self._level = LevelGround()
        self._build(self._level)
        self._take_robot(self.robot)
        self._iterate = Iterate(self._problem)
        self._draft: Iterate | None = None
        rates = [leg.steering_rate_max for leg in self.robot.leg_list]
        steering_rate = min(self.settings.bounds.steering_rate_max, *rates)
        self._reference = ReferenceMaker(self.robot, self.settings.limits, steering_rate, self.robot.height)
        self.stretch = 1.0
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self._gait = gait
        self._now = 0.0
        self.clock = GaitClock(gait)
        self._last: Control | None = None
        self._failures = 0
        self._incoming = Incoming(self.settings.period, self._note, self.stop, follows)
        self._stands = False
        self._hold = StepHold(self.settings.period)
        self._weights, self._bounds = self.settings.weights, self.settings.bounds
        self._checked: VelocityCommand | PoseCommand | None = None
        self._cut = ""
        self._unfit: set[str] = set()
        self._plans: PlanFollower | None = None
        self._follows_from_next = False
        self._wanted: Wanted | None = None

    def _build(self, ground: LevelGround | TerrainGround) -> None:
        """The problem on some kind of ground, its solver, and who fills its numbers in."""
        on_terrain = not isinstance(ground, LevelGround)
        context = LiveContext(self.robot, self.settings)
        costs = [*standard_costs(self.settings.bounds.workspace, on_terrain), *self._own]
        pulled = bool(self._wrenches)
        self._problem = transcribe(costs, context, store_for(self._kernels), on_terrain, pulled)
        if self._solver_name is None:
            self._solver = quickest_solver(self._problem, self._kernels)
        else:
            self._solver = make_solver(self._solver_name, self._problem, self._kernels)
        self._stages = StageEvaluation(self._problem.nlp, self._problem.nlp.blocks[0])
        self._fill = Filling(self._problem, self.settings, context, ground, self._own)

    def _rebuild(self, ground: LevelGround | TerrainGround) -> None:
        """Goes on with another kind of ground: same robot, weights and bounds, same plan."""
        before, self._draft = self._fill, None
        self._build(ground)
        self._put_settings()
        self._take_robot(before.robot)
        self._fill.take_stance(before)

    # -- what may be changed at any time -----------------------------------------------------------------

    @property
    def wanted(self) -> tuple[float, float, float]:
        """Forward and lateral velocity (m/s) and yaw rate (rad/s) that the reference has now."""
        if self._plans is not None and not self._follows_from_next and not self._plans.clock.held:
            return self._plans.twist(self._now)
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
        self._put_settings()

    def set_bounds(self, **bounds: float) -> None:
        """Bounds by name, as in `MpcBounds`; the workspace itself stays as it was built."""
        for name in FROM_THE_START.intersection(bounds):
            raise InputError(f"bounds.{name}", bounds[name], "must be given when the controller is built")
        before, self._bounds = self._bounds, type(self._bounds)(**(self._bounds.model_dump() | bounds))
        try:
            self._put_settings()
        except InputError:
            self._bounds = before
            raise

    def _put_settings(self) -> None:
        """Weights and bounds as they are to be now."""
        weights, bounds = self._weights, self._bounds
        if self._plans is not None:
            weights = weights.model_copy(update=FOLLOWING)
            bounds = bounds.model_copy(
                update={name: FOLLOWING_ROOM * getattr(bounds, name) for name in ROOMY}
            )
        self._fill.set_weights(weights)
        self._fill.set_bounds(bounds)

    def set_ground(self, ground: Terrain | ArrayLike) -> None:
        """The ground: a terrain, or a height in m, one or one for each foot (4,).

        The first terrain makes the controller build its problem anew, in a second or so, as slopes cost time
        that level ground does not need; before a run is the moment for it. The swings and footholds of a
        terrain before are forgotten.

        Raises:
            InputError: it is neither.
        """
        if isinstance(ground, Terrain):
            from rollgait.mpc.ground.terrain import TerrainGround  # loads SciPy, which level ground needs not

            seen = TerrainGround(ground, self.robot)
            if self._last is not None:
                seen.begin(self._last.end.foot_position[:, :2])
            if self._fill.ground is self._level:
                self._rebuild(seen)
            else:
                self._fill.ground = seen
            return
        rule = "must be a Terrain, a finite height in m, or one for each of the 4 feet"
        try:
            given = np.broadcast_to(np.asarray(ground, dtype=float), (4,)).copy()
        except (TypeError, ValueError):
            raise InputError("ground", ground, rule) from None
        if not np.isfinite(given).all():
            raise InputError("ground", ground, rule)
        self._level.height = given
        if self._fill.ground is not self._level:
            self._rebuild(self._level)

    def reset(self, gait: str | None = None) -> None:
        """Forgets the past and all faults: the next state is taken as that of a standing robot.

        It begins with a gait: this one, or else the one of the last beginning. Raises `UnknownNameError`.
        """
        self._gait = self._gait if gait is None else find_gait(gait).name
        self._last, self._failures, self._stands = None, 0, False
        self._hold.reset()
        self._cut = ""
        self._unfit.clear()
        self._forget_plans()
        self._fill.reset_stance()
        self._incoming.reset()
        self.events.clear()

    # -- plans -------------------------------------------------------------------------------------------

    def follow(self, *plans: Plan) -> None:
        """From the next step on follows plans, one after the other, in place of commands; see `leave`.

        Contacts, footholds, base, headings and forces are those of the plan. It waits, all feet on the
        ground, while the robot is pushed off, and stands at the end. The ground is that of `set_ground`.

        Raises:
            InputError: a plan is of another robot, or begins neither where the robot is (said at the first
                step, if there was none yet) nor where the plan before it ends; nothing has changed then.
        """
        from rollgait.mpc.plans.follower import PlanFollower
        from rollgait.mpc.plans.joining import check_joins, check_robot
        from rollgait.mpc.plans.path import PlanPath

        if not plans:
            raise InputError("plans", [], "must be at least one plan")
        paths = [PlanPath(plan) for plan in plans]
        for path in paths:
            check_robot(path, self.robot)
        for before, path in pairwise(paths):
            check_joins(path, before, "where the plan before it ends")
        if self._last is not None:
            check_joins(paths[0], self._last.end, "where the robot is")
        self._forget_plans()
        self._plans = PlanFollower(paths, self._reference, self.settings.period, self.note)
        self._put_settings()
        self._follows_from_next = True

    def expected(self, ahead: float) -> MotionState:
        """The robot as it is expected after a time, with what its feet do then: a plan can begin there.

        Args:
            ahead: s, of the horizon; the nearest node counts, which the state's time says.

        Raises:
            InputError: there was no step yet, or the time is beyond the horizon.
        """
        if self._last is None:
            raise InputError("ahead", ahead, "needs a step of the controller before")
        count, interval = self._fill.count, self._fill.interval
        node = round(ahead / interval)
        if not 1 <= node < count:
            rule = f"must lie in [{interval:g}, {(count - 1) * interval:g}] s, the horizon"
            raise InputError("ahead", ahead, rule)
        return expected_at(self._problem, self._iterate, self._fill, self.clock, self._model, self._now, node)

    def replace(self, plan: Plan, time: float) -> None:
        """In place of the plan that is followed another one, which begins in motion at a time.

        Args:
            plan: made for `expected`, or with `plan.rest`.
            time: at which it begins, s; that of the next step or so.

        Raises:
            InputError: no plan is followed, it is of another robot, or does not begin as the robot moves.
        """
        from rollgait.mpc.plans.joining import check_robot
        from rollgait.mpc.plans.path import PlanPath

        if self._plans is None or self._last is None or self._follows_from_next:
            raise InputError("plan", plan.robot.name, "needs a plan that is followed, which it replaces")
        path = PlanPath(plan)
        check_robot(path, self.robot)
        self.clock = self._plans.replace(path, self._last.end, time)

    def halt(self) -> None:
        """Ends the following of plans where all feet stand next and the robot can come to rest.

        The progress says `stopped` then, and `rests` when it does; `leave` lets commands count again.
        """
        if self._plans is not None:
            self._plans.halt()

    @property
    def is_following(self) -> bool:
        """Whether plans are followed, or will be from the next step on."""
        return self._plans is not None

    @property
    def rests(self) -> bool:
        """Whether what was followed has ended, and the robot stands where it has."""
        return self._plans is not None and not self._follows_from_next and self._plans.rests

    def leave(self) -> None:
        """Follows plans no longer: commands count again, in the gait of the last beginning."""
        if self._plans is not None and self._last is not None and not self._follows_from_next:
            end = self._last.end
            x, y, yaw = float(end.com_position[0]), float(end.com_position[1]), float(end.euler[0])
            self._reference.begin_at((x, y, yaw), self.wanted)
            self.clock.request(self._fitting(self._gait), self._now)
        self._forget_plans()

    @property
    def progress(self) -> Progress | None:
        """How far the following of plans is; None if no plan is followed."""
        if self._plans is None or self._follows_from_next:
            return None
        return self._plans.progress(self._now)

    @property
    def planned(self) -> RobotState | None:
        """The robot as the plan that is followed has it now, feet as they are led; None if there is none."""
        if self._plans is None or self._follows_from_next:
            return None
        return self._plans.path.state(self._plans.progress(self._now).plan_time)

    def _forget_plans(self) -> None:
        if self._plans is not None:
            self._plans = None
            self._put_settings()
            self._fill.restore_stance()

    def _advance_plans(self, state: RobotState, touching: NDArray[np.bool_] | None) -> None:
        """The clock of the plan that is followed, brought up to now."""
        if self._plans is None:
            return
        if self._follows_from_next:
            self._follows_from_next = False
            try:
                self.clock = self._plans.begin(state)
            except InputError:
                self._forget_plans()
                raise
        self.clock = self._plans.update(state, touching)

    # -- a step ------------------------------------------------------------------------------------------

    def step(
        self,
        state: RobotState | None,
        command: VelocityCommand | PoseCommand,
        touching: NDArray[np.bool_] | None = None,
    ) -> tuple[Control, Prediction]:
        """What to do for the next period, and what is expected of the horizon.

        Args:
            state: of the robot now; None if there is none. One that cannot be, or that does not go with what
                the robot was told to do, counts as none, and an event says why.
            command: what is asked for; beyond the limits it is cut. None counts while a plan is followed.
            touching: which feet press on the ground, (4,), where that is measured: feet of a plan land then.

        Raises:
            InputError: the command is none, or there is no usable state to begin with.
        """
        begin = wall.perf_counter()
        if command is not self._checked:  # what has been looked at cannot have changed
            check_command(command)
            self._checked = command
        state, elapsed = self._incoming.take(state, self._last)
        self._now = state.time
        deadline = begin + self.stretch * (self.settings.deadline or self.settings.period)
        if self._last is None and (unfit := self._feet.unfit()):
            self._note(state.time, unfit)
        if command.gait is not None and (fitting := self._fitting(command.gait)) != command.gait:
            command = command.model_copy(update={"gait": fitting})
        command = self._within_limits(command, state.time)
        if self._stands:
            command = VelocityCommand()
        elif self._plans is None and command.gait not in (None, self.clock.gait.name):
            self.clock.request(str(command.gait), state.time)
            self._hold.reset()
        self.clock.advance(state.time)
        previous = self._last
        if previous is None:
            self._begin(state)
        else:
            for iterate in self._iterates:
                iterate.shift(elapsed / self._fill.interval)
        self._advance_plans(state, touching)
        self._hold.apply(self.clock, state)
        reference = self._fill_in(state, command, elapsed)
        status = self._solve(deadline - AFTERWARDS) if not self._stands else STANDING_STATUS
        in_doubt = self._stands or self._failures > 0
        if previous is not None and in_doubt and largest_gap(state, previous.end) > BELIEVED:
            state = previous.end.at(state.time)  # what is measured may be the very reason
        control = self._control(state, previous)
        self._last = control
        seconds = wall.perf_counter() - begin
        status = replace(status, seconds=seconds, late=begin + seconds > deadline, mode=self._mode)
        return control, outlook(
            self._problem, self._iterate, self._fill, self.clock, state.time, reference, status
        )

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
            self._forget_plans()
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
        height = self._feet.within_height(cut.height_change)
        if height != cut.height_change:
            legs = f"height change {cut.height_change:.3g} m is cut to {height:.3g} m: legs reach no farther"
            cut, note = (
                cut.model_copy(update={"height_change": height}),
                "; ".join(filter(None, (note, legs))),
            )
        if isinstance(cut, VelocityCommand) and self._plans is None and not self._stands:
            gait = self.clock.gait if cut.gait is None else find_gait(cut.gait)
            feet = self._feet.note(gait, (cut.forward, cut.lateral, cut.turn_rate))
            note = "; ".join(part for part in (note, feet) if part)
        if note and note != self._cut:
            self._note(time, f"command beyond the limits: {note}")
        self._cut = note
        return cut

    def _fitting(self, name: str) -> str:
        """A gait, or in its place one in which the robot does not fall; an event says so once."""
        gait = find_gait(name)
        fitting = self._feet.carried(gait).name
        if fitting != name and name not in self._unfit:
            self._unfit.add(name)
            self._note(
                self._now,
                f"the gait {name!r} is {fitting!r} here: legs that reach so little aside cannot "
                "bring the CoM over the feet that stand",
            )
        return fitting

    def _begin(self, state: RobotState) -> None:
        """Standing: the weight on all feet, all else at rest."""
        self.clock = GaitClock("stand" if self._stands else self._fitting(self._gait), state.time)
        self._draft = None
        self._reference.reset(state)
        self._fill.ground.begin(state.foot_position[:, :2])
        self._iterate.stand(self._model.node(state), self.robot.static_forces() / self.robot.weight)

    def _fill_in(
        self, state: RobotState, command: VelocityCommand | PoseCommand, elapsed: float
    ) -> Reference:
        it, fill = self._iterate, self._fill
        limit = fill.speed_limit
        it.previous[12:] = np.minimum(np.maximum(it.previous[12:], -limit), limit)
        for iterate in self._iterates:
            iterate.begin(self._model.node(state), it.previous)
        fill.put_state(it.first_node)
        if self._plans is None:
            fill.put_stance(self.clock.gait.centred, elapsed)
        fill.put_contact(self.clock, state.time)
        if self._wrenches:
            fill.put_wrenches(self._wrenches, state.time)
        for iterate in self._iterates:
            iterate.adapt_forces(fill.share, fill.force_low, fill.force_high, fill.usual_force)
        wanted = None
        if self._plans is None:
            reference = self._reference.look_ahead(
                state, command, self.clock, elapsed, fill.count, fill.interval
            )
        else:
            wanted = self._plans.wanted(state, elapsed, fill.count, fill.interval)
            reference = wanted.reference
        self._wanted = wanted
        fill.put_reference(reference)
        layout = self._problem.layout.node
        xy = it.states[:, layout["xy"]].reshape(-1, 4, 2)
        if wanted is None:
            fill.put_strides(self.clock, state.time, reference.foot_velocity)
        fill.put_ground(self.clock, state.time, xy, reference, keeps_off=wanted is None)
        if wanted is not None:
            times = state.time + fill.interval * np.arange(fill.count + 1, dtype=float)
            feet = np.dstack([xy, fill.ground.foot_heights(self.clock, times, xy)[0]])
            nodes = np.concatenate([it.states[:, None, layout["r"]], feet], axis=1)
            fill.put_plan(wanted, nodes, it.states[:, layout["theta"]][:, 0])
        return reference

    # -- solving -----------------------------------------------------------------------------------------

    @property
    def _iterates(self) -> tuple[Iterate, ...]:
        """The motion that is carried out and, after a failed solve, the one that the next goes on with."""
        return (self._iterate,) if self._draft is None else (self._iterate, self._draft)

    def _solve(self, deadline: float) -> Status:
        nlp, solver, guess = self._problem.nlp, self._solver, self._iterates[-1].variables()
        begin = wall.perf_counter()
        if not (before := solver.violation(guess)) < HOPELESS:
            self._draft = None
            return self._failed("the guess is far from any motion", math.inf)
        wanted = self.settings.iterations
        if not solver.real_time:  # late, whatever it does: it shall at least find the motion
            deadline, wanted = math.inf, max(wanted, PATIENT_ITERATIONS)
        try:
            repair = REPAIR if wanted < REPAIR.iterations else None
            solution = solver.solve(guess, warm=True, until=deadline, iterations=wanted, repair=repair)
            iterations, violation = solution.iterations, _violation(nlp, solution)
        except NotSolvedError as error:
            self._draft = None
            return self._failed(str(error), math.inf, seconds=wall.perf_counter() - begin)
        seconds = wall.perf_counter() - begin
        if violation > USABLE:
            # not to be carried out, yet nearer: time was up, and the next solve shall not begin anew
            self._draft = self._iterate.with_variables(solution.w) if violation < before else None
            return self._failed(f"violation {violation:.2g}", violation, iterations, seconds)
        if not solution.solved and np.array_equal(solution.w, guess):
            # a draft that it cannot leave is none
            self._draft = None
            return self._failed("it found no step", violation, iterations, seconds)
        self._iterate.take(solution.w)
        self._draft, self._failures = None, 0
        return Status(
            mode="tracking",
            iterations=iterations,
            converged=solution.solved and violation < FEASIBLE,
            violation=violation,
            cost=solution.cost,
            cost_rate=self._stages.first_cost(solution.w) / self._fill.interval,
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
        period, it, fill = self.settings.period, self._iterate, self._fill
        contact = self.clock.contact(state.time)
        xy = state.foot_position[:, :2]
        normals, touch = fill.ground.normals(contact, xy), fill.ground.touch(contact, xy, state.heading)
        tilt = fill.ground.tilt(xy, float(state.euler[0])) if self._stands else (0.0, 0.0)
        wrench = mean_wrench(self._wrenches, self._fill.robot.com_offset, state.time, state.time + period)
        if self._stands:
            offset = 0.0 if touch is None else touch[0]
            pull: Array | None = None
            if wrench is not None:
                pull = np.concatenate(external(wrench, rotation(np, state.euler.tolist())))
            force, motion = self._standing.inputs(state, contact, previous, tilt, normals, offset, pull)
        else:
            force, motion = first_inputs(
                it,
                self._problem.layout,
                fill,
                self.clock,
                contact,
                state.time,
                period,
                previous,
                normals,
                self._wanted,
            )
        it.previous[:12] = force.ravel() / fill.robot.weight
        it.previous[12:] = motion[:, 0]
        if self._wanted is not None:
            # a wheel that waits has no speed to change: on the ground it rolls at once, as the robot does
            it.previous[12:] = np.where(self._wanted.waits, self._wanted.landed, motion[:, 0])
        end = self._model.after(state, force, motion, period, self.clock, fill.ground, wrench)
        if self._stands:
            end = self._standing.settle(end, period, tilt)
            it.rest(self._model.node(end))
        return Control(state, end, force, motion, contact, *(touch or ()))

    def _take_robot(self, robot: Robot) -> None:
        on_slopes = self._fill.ground is not self._level
        self._model = RobotModel(robot, self._problem.layout, on_slopes, bool(self._wrenches))
        self._standing = Standing(robot, self.settings)
        self._feet = Footwork(robot)
        self._fill.set_robot(robot)
