"""From a scenario to a plan."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.attempts import OF_REST, USUAL, Attempt, Attempts, Effort, Method, Ready
from rollgait.diagnosis.budget import SECONDS, Budget, Limits
from rollgait.diagnosis.entry import Investigation
from rollgait.errors import InputError, NotSolvedError
from rollgait.mending import finer
from rollgait.ocp.problem import Problem, make_problem
from rollgait.ocp.term import Constraint, Cost, FootConstraint, Term
from rollgait.plan.plan import Plan, Statistics
from rollgait.plan.rest import Rest
from rollgait.plant.state import RobotState
from rollgait.scenario.library import find_scenario
from rollgait.scenario.moving import begun_at
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.solvers import Progress, Solution
from rollgait.solvers.solution import saying
from rollgait.starts import InitialGuess, from_plan, starts
from rollgait.stopwatch import Stopwatch
from rollgait.transcription.guess import MotionGuess
from rollgait.transcription.nlp import Nlp

GROUND_ROUNDS = 4
"""How often the ground is looked up around a motion at most: each round, what is left is a tenth or less."""
GROUND_TOLERANCE = 3e-4
"""By how much feet in stance may be beside the ground, m, before it is looked up again: three tenths of what
the certificate allows."""
TILT_TOLERANCE = 1e-3
"""By how much the tilt that the ground asks of the base may differ, rad: half a millimetre at a foot."""
VIOLATION_TOLERANCE = 1e-6
"""Scaled violation of a constraint above which it is named in the statistics."""


class Planner:
    """Plans motions by one method: built once, used as often as needed.

    What depends on kinds of feet, terms and transcription alone is made with the first plan (or read from the
    cache on disk) and serves all later ones of this process; the rest are numbers put in place.

    >>> planner = Planner()
    >>> plans = [planner.plan("wheeled"), planner.plan("hybrid-forward")]  # doctest: +SKIP

    Args:
        transcription: how the problem becomes a nonlinear program, one of `TRANSCRIPTION_NAMES`. Default:
            `condensed`.
        solver: what solves that, one of `SOLVER_NAMES`. Default: what suits the transcription, `fatrop` for
            condensed, `ipopt` for collocation.
        terms: further costs and constraints of your own.
        kernels: whether to use compiled stage functions where there is a compiler.

    Raises:
        UnknownNameError: there is no such transcription or solver.
    """

    clock = staticmethod(time.perf_counter)
    """By which the statistics say where time went, s."""

    def __init__(
        self,
        *,
        transcription: str | None = None,
        solver: str | None = None,
        terms: Sequence[Term] = (),
        kernels: bool = True,
    ) -> None:
        self._method = Method.of(transcription, solver, kernels)
        self._terms = _instances(terms)

    def plan(
        self,
        scenario: str | Path | Scenario | Rest,
        *,
        start: RobotState | None = None,
        profile: str | None = None,
        warm_start: Plan | str | Path | None = None,
        multistart: int = 1,
        seed: int = 0,
        diagnose: bool = True,
        diagnose_seconds: float = SECONDS,
        progress: Progress | None = None,
    ) -> Plan:
        """Plans a motion.

        Args:
            scenario: a scenario, the name of one in the library, the path of a YAML file, or what is left of
                a plan (`plan.rest(time)`), which is then solved from that plan.
            start: where the robot is at t = 0, in any motion (`plan.state_at(time)`, `MotionState.of(…)`), in
                place of the scenario's own start. What of it cannot be is changed a little, and
                `statistics.start_changes` says so.
            profile: `paper` or `executable`, in place of the scenario's own.
            warm_start: a plan to start from (or its file), also for another goal or horizon.
            multistart: how many initial guesses are solved to take the cheapest result. With 1, further ones
                are tried only where the first fails.
            seed: of the random ones among the initial guesses.
            diagnose: whether to look for the reason if no start converges.
            diagnose_seconds: of wall time that this may take.
            progress: is called after each iteration of the solver.

        Returns:
            The plan. The solver converged, and where a finer mesh or another start could make its certificate
            pass, it does; whether the plan is good its `certificate()` says.

        Raises:
            InputError: something in the input is wrong.
            NotSolvedError: there is no way over the ground; or no start converged, then the last iterate is
                the error's `plan`, marked as not solved, and the reason its `diagnosis`.
        """
        watch = Stopwatch(self.clock)
        if multistart < 1:
            raise InputError("multistart", multistart, "must be at least 1")
        if seed < 0:
            raise InputError("seed", seed, "must be at least 0")
        budget = Budget(diagnose_seconds, field="diagnose_seconds")
        with watch("load"):
            earlier: Plan | Rest | None
            earlier = Plan.load(warm_start) if isinstance(warm_start, str | Path) else warm_start
            changes: tuple[str, ...] = ()
            if isinstance(scenario, Rest):
                rest = scenario if start is None else scenario.started(start)
                asked, changes, earlier = rest.scenario, rest.changes, earlier or rest
            else:
                asked = _asked(scenario)
                if start is not None:
                    asked, changes = begun_at(asked, start)
            if profile is not None:
                asked = asked.with_values({"profile": profile})
            if asked.start.motion is not None and self._method.transcription != "condensed":
                rule = "cannot begin in motion; condensed can"
                raise InputError("transcription", self._method.transcription, rule)
        timing, found = asked.gait.timing, None
        is_timed = timing is not None and timing.optimize
        planned = partial(self._planned, multistart=multistart, seed=seed, watch=watch)
        if asked.gait.kind == "discover":
            discovered = self._discovered(asked, partial(planned, earlier=earlier), watch, progress)
            if timing is None or not is_timed:
                return discovered
            asked = discovered.scenario.with_values({"gait.timing": timing.model_dump(mode="json")})
        if is_timed:
            from rollgait.timing.optimise import find_timing  # here: most plans do without

            found = find_timing(asked, self._method, self._terms, watch, seed, progress)
            asked, earlier = found.scenario, found.motion
        plan = planned(
            asked,
            earlier=earlier,
            progress=progress,
            effort=OF_REST if isinstance(scenario, Rest) else USUAL,
            budget=budget if diagnose else None,
        )
        if changes:
            every = (*changes, *plan.statistics.start_changes)
            plan = plan.with_statistics(replace(plan.statistics, start_changes=every))
        return plan if found is None else found.told_by(plan)

    def plan_within(self, scenario: Scenario, effort: Effort, earlier: Plan | None = None) -> Plan:
        """Plans a scenario whose gait is given with no more than some effort; nobody looks for a reason.

        Args:
            scenario: what is asked; its timing stays as it is.
            effort: what may be spent.
            earlier: a plan to start from.

        Raises:
            InputError: something in the input is wrong.
            NotSolvedError: there is no way over the ground, or this effort does not find it.
        """
        watch = Stopwatch(self.clock)
        return self._planned(
            scenario,
            earlier=earlier,
            multistart=1,
            seed=0,
            watch=watch,
            progress=None,
            effort=effort,
            budget=None,
        )

    def _discovered(
        self,
        asked: Scenario,
        planned: Callable[..., Plan],
        watch: Stopwatch,
        progress: Progress | None,
    ) -> Plan:
        """The plan of a scenario whose gait is to be found; `planned` is `_planned` with its starts."""
        from rollgait.discover.search import (  # here: it needs SciPy
            MENDINGS,
            discover,
            iterations,
        )

        def plan_one(scenario: Scenario, task: str, until: float, start: Plan | None = None) -> Plan:
            limits = Limits(until=until, iterations=iterations(scenario, start is not None))
            effort = Effort(1, MENDINGS, math.inf, limits)
            told = saying(task, progress)
            begun = planned if start is None else partial(planned, earlier=start)
            return begun(scenario, progress=told, effort=effort, budget=None)

        with watch("discover"):
            return discover(asked, plan_one)

    def _planned(
        self,
        asked: Scenario,
        *,
        earlier: Plan | Rest | None,
        multistart: int,
        seed: int,
        watch: Stopwatch,
        progress: Progress | None,
        effort: Effort,
        budget: Budget | None,
    ) -> Plan:
        """The plan of a scenario whose gait is given; with a budget the reason is sought if it has none."""
        method = self._method
        with watch("build"):
            motion = earlier.motion if isinstance(earlier, Rest) else None
            problem = make_problem(
                asked, self._terms, motion=motion
            )  # where it knows of no way, it says why itself
        try:
            with watch("build"):
                ready = Ready(method, problem)
                ready.refuse_contradictions()
        except NotSolvedError as error:
            if budget is not None:
                error.diagnosis = self._investigate(asked, progress, budget).diagnosis()
            raise
        attempts = Attempts(ready, progress, watch, effort)
        guesses = starts(problem, method.solve, earlier, seed)
        attempts.run(guesses, multistart)
        why = None
        if budget is not None and not attempts.solved:
            why = self._investigate(asked, progress, budget)
            attempts.run_elastic(why.motion, budget)
        if not attempts.solved:
            result = _as_plan(Settled(ready, attempts.best), attempts, method)
            result = result.with_statistics(replace(result.statistics, seconds=watch.parts()))
            diagnosis = None if why is None else why.diagnosis()
            raise NotSolvedError(_failure(result, len(attempts.done)), result, diagnosis)
        settled = self._settled(ready, attempts.best, watch, progress, effort)
        return self._certified(settled, attempts, guesses, watch, progress, effort)

    def _investigate(self, asked: Scenario, progress: Progress | None, budget: Budget) -> Investigation:
        return Investigation(asked, self._terms, self._method.kernels, progress, budget, has_failed=True)

    def _settled(
        self, ready: Ready, best: Attempt, watch: Stopwatch, progress: Progress | None, effort: Effort
    ) -> Settled:
        """A solution on the ground that is where its feet are: curved ground is looked up again around it."""
        result, first = Settled(ready, best), ready.problem
        while result.ready.problem.footing.may_differ and result.rounds < GROUND_ROUNDS:
            with watch("build"):
                motion = result.motion
                around = first.cut_at_bends(motion)
                if not _differ(result.ready.problem, around, motion):
                    break
                again = Ready(self._method, around)
            if again.transcribed.nlp.contradictions:
                break
            attempts = Attempts(again, saying("fitting to the ground", progress), watch, effort.again)
            attempts.run(_again(best.start.name, partial(_the, motion)), 1)
            if not attempts.solved:
                break
            result = Settled(again, attempts.best, result.rounds + 1, result.iterations)
        return result

    def _certified(
        self,
        settled: Settled,
        attempts: Attempts,
        guesses: Iterator[InitialGuess],
        watch: Stopwatch,
        progress: Progress | None,
        effort: Effort,
    ) -> Plan:
        """The plan of a solution: mended, then from other starts, while its certificate does not pass."""
        begin, tried = self.clock(), list[Plan]()
        ready = settled.ready
        plan: Plan | None = _as_plan(settled, attempts, self._method)
        while plan is not None:
            for look in range(1, effort.rounds + 1):
                tried.append(plan)
                with watch("certify"):
                    passed = plan.certificate().passed
                    # what is mended after the last look, nobody would judge
                    schedule = None if passed or look == effort.rounds else finer(plan)
                if passed or schedule is None or self.clock() - begin > effort.patience:
                    break
                mended = self._mended(
                    ready.problem, plan, schedule, watch, saying("mending", progress), effort
                )
                if mended is None:
                    break
                plan = mended
            if passed or self.clock() - begin > effort.patience:
                break
            another = attempts.run_another(guesses)
            if another is not None:
                settled = self._settled(attempts.ready, another, watch, progress, effort)
                ready, plan = settled.ready, _as_plan(settled, attempts, self._method)
            else:
                plan = None
        best = min(tried, key=lambda plan: (not plan.certificate().passed, len(plan.certificate().failures)))
        starts = tuple(attempt.result() for attempt in attempts.done)
        return best.with_statistics(replace(best.statistics, starts=starts, seconds=watch.parts()))

    def _mended(
        self,
        problem: Problem,
        plan: Plan,
        schedule: ContactSchedule,
        watch: Stopwatch,
        progress: Progress | None,
        effort: Effort,
    ) -> Plan | None:
        """The same problem solved on another mesh, from the motion that is known; None if it is not."""
        with watch("build"):
            finer_problem = problem.remeshed(schedule, plan.sample)
            ready = Ready(self._method, finer_problem)
        if ready.transcribed.nlp.contradictions:
            return None
        attempts = Attempts(ready, progress, watch, effort.again)
        name = f"{plan.statistics.start}, finer mesh".replace(", finer mesh, finer mesh", ", finer mesh")
        attempts.run(_again(name, lambda: from_plan(finer_problem, plan)), 1)
        if not attempts.solved:
            return None
        settled = self._settled(ready, attempts.best, watch, progress, effort)
        if finer_problem.footing.may_differ:  # the ground was looked up before as well
            settled = replace(settled, rounds=plan.statistics.ground_rounds + settled.rounds)
        return _as_plan(settled, attempts, self._method)


def _differ(problem: Problem, around: Problem, motion: MotionGuess) -> bool:
    """Whether the ground about a motion is another than that on which it was solved, by more than counts."""
    old, new = problem.schedule, around.schedule
    xy = motion(new.node_times).foot_position[..., :2]
    origin = old.mesh.interval_at(new.mesh.middles)
    apart = problem.footing.deviation(origin, around.footing, new.contact, xy)
    tilted = problem.footing.tilt_deviation(old.node_times, around.footing, new.node_times)
    return apart > GROUND_TOLERANCE or tilted > TILT_TOLERANCE


def plan(
    scenario: str | Path | Scenario | Rest,
    *,
    start: RobotState | None = None,
    profile: str | None = None,
    transcription: str | None = None,
    solver: str | None = None,
    terms: Sequence[Term] = (),
    warm_start: Plan | str | Path | None = None,
    multistart: int = 1,
    seed: int = 0,
    kernels: bool = True,
    diagnose: bool = True,
    diagnose_seconds: float = SECONDS,
    progress: Progress | None = None,
) -> Plan:
    """Plans a motion: `Planner(…).plan(…)` in one call. The arguments are those of both."""
    planner = Planner(transcription=transcription, solver=solver, terms=terms, kernels=kernels)
    return planner.plan(
        scenario,
        start=start,
        profile=profile,
        warm_start=warm_start,
        multistart=multistart,
        seed=seed,
        diagnose=diagnose,
        diagnose_seconds=diagnose_seconds,
        progress=progress,
    )


def _asked(scenario: Any) -> Scenario:
    """The scenario that is meant. Raises `InputError`."""
    if isinstance(scenario, Scenario):
        return scenario
    if not isinstance(scenario, str | Path):
        rule = "must be a scenario, the name of one in the library, or the path of a YAML file"
        of_a_plan = "; a plan knows its own: plan.scenario" if isinstance(scenario, Plan) else ""
        raise InputError("scenario", type(scenario), rule + of_a_plan)
    return find_scenario(str(scenario))


def _instances(terms: Any) -> tuple[Term, ...]:
    """The terms. Raises `InputError` for what is none."""
    kinds = (Cost, Constraint, FootConstraint)
    if not isinstance(terms, Iterable):
        raise InputError("terms", terms, "must be a list of costs and constraints")
    made: tuple[Any, ...] = tuple(terms)
    for number, term in enumerate(made):
        if isinstance(term, type):
            rule = f"is a class; a term is made of it: {term.__name__}(…)"
            raise InputError(f"terms.{number}", term.__name__, rule)
        if not isinstance(term, kinds):
            raise InputError(f"terms.{number}", term, "must be a Cost, a Constraint or a FootConstraint")
    return made


@dataclass(frozen=True)
class Settled:
    """A solution of a problem, after how many rounds of looking at the ground, with how many iterations."""

    ready: Ready
    best: Attempt
    rounds: int = 1
    iterations_before: int = 0

    @property
    def iterations(self) -> int:
        """Those of all rounds."""
        return self.iterations_before + self.best.solution.iterations

    @property
    def motion(self) -> MotionGuess:
        """The motion that it means."""
        trajectory, robot = self.ready.transcribed.decode(self.best.solution.w), self.ready.problem.robot
        return lambda times: trajectory.sample(times, robot)  # it keeps no solver alive: that is large


def _again(name: str, motion: Callable[[], MotionGuess]) -> Iterator[InitialGuess]:
    """Starts from the motion of nearly the same problem: warm; where that stalls, as from any guess."""
    yield InitialGuess(name, motion, warm=True)
    yield InitialGuess(name, motion)


def _the(motion: MotionGuess) -> MotionGuess:
    return motion


def _as_plan(settled: Settled, attempts: Attempts, method: Method) -> Plan:
    ready, best = settled.ready, settled.best
    problem, nlp, solution = ready.problem, ready.transcribed.nlp, best.solution
    statistics = Statistics(
        transcription=method.transcription,
        solver=best.solver,
        linear_algebra=best.linear_algebra,
        solved=solution.solved,
        status=solution.status,
        iterations=settled.iterations,
        ground_rounds=settled.rounds,
        cost=solution.cost,
        costs=nlp.costs(solution.w),
        variables=nlp.size,
        constraints=nlp.rows,
        violation=best.violation,
        worst=_describe_worst(nlp, problem, solution),
        start=best.start.name,
        starts=tuple(attempt.result() for attempt in attempts.done),
        start_changes=problem.start_eased,
    )
    return Plan(
        robot=problem.robot,
        scenario=problem.scenario.self_contained(),
        schedule=problem.schedule,
        trajectory=ready.transcribed.decode(solution.w),
        statistics=statistics,
    )


def _failure(iterate: Plan, attempts: int) -> str:
    """Why there is no plan, as far as the solver knows."""
    statistics = iterate.statistics
    text = (
        f"no solution found from {attempts} initial guesses: {statistics.solver} stopped with "
        f"{statistics.status} after {statistics.iterations} iterations"
    )
    return text + (f"; worst: {statistics.worst}" if statistics.worst else "")


def _describe_worst(nlp: Nlp, problem: Problem, solution: Solution) -> str:
    """The most violated constraint in words: what, where, when, by how much; "" if none is violated."""
    violations = nlp.violations(solution.g, solution.w)[: nlp.rows]
    if violations.max(initial=0.0) <= VIOLATION_TOLERANCE:
        return ""
    number = int(np.argmax(violations))
    origin = nlp.origin(number)
    label = origin.label
    at = problem.schedule.node_times[origin.interval]
    amount = f"{violations[number] * label.scale:.3g} {label.unit}".rstrip()
    return f"{label.describe()} at t = {at:.2f} s by {amount}"
