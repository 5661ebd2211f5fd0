"""Times of a gait as variables: found on a coarse mesh, then given to the problem that is planned and judged.

At first each phase has few intervals, whatever its length by the gait, so that the same times come out
wherever the search began; then, warm, as many as the scenario's interval asks for. That motion is the start
of the same problem with given times.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.attempts import Attempts, Method, Ready
from rollgait.errors import NotSolvedError
from rollgait.ocp.problem import make_problem
from rollgait.ocp.term import Term
from rollgait.ocp.timed import TimedProblem
from rollgait.plan.plan import Plan, StartResult, Statistics
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Progress
from rollgait.solvers.solution import saying
from rollgait.starts import InitialGuess, from_plan, starts
from rollgait.stopwatch import Stopwatch
from rollgait.timing.phases import LONGEST, Phases
from rollgait.transcription.timed import Timed

Array = NDArray[np.float64]

TASK = "timing"
"""What iterations are for in which times are sought."""

FINEST: Final = 2.0
"""Scenario's intervals, how long one may get on the finer mesh."""


@dataclass(frozen=True)
class Found:
    """Times that were found.

    Attributes:
        scenario: what was asked, at these times.
        motion: the motion at these times on the coarse mesh, to start from.
        tried: what came of the starts.
    """

    scenario: Scenario
    motion: Plan
    tried: tuple[StartResult, ...]

    def told_by(self, plan: Plan) -> Plan:
        """The plan at these times, with a scenario that has its mesh, and with all iterations."""
        tried = tuple(replace(start, name=f"{TASK}: {start.name}") for start in self.tried)
        statistics = plan.statistics
        before = sum(start.iterations for start in tried)
        statistics = replace(
            statistics, iterations=statistics.iterations + before, starts=(*tried, *statistics.starts)
        )
        if plan.schedule.mesh != plan.scenario.schedule.mesh:  # mended
            nodes = plan.schedule.node_times.tolist()
            scenario = plan.scenario.with_values({"gait.nodes": nodes, "horizon": nodes[-1]})
            plan = replace(plan, scenario=scenario)
        return plan.with_statistics(statistics)


def find_timing(
    asked: Scenario,
    method: Method,
    terms: Sequence[Term],
    watch: Stopwatch,
    seed: int = 0,
    progress: Progress | None = None,
) -> Found:
    """The best times of a scenario whose gait lets them change.

    Args:
        asked: what is asked; its own times are where the search begins.
        method: of planning; times are always sought by the condensed transcription and fatrop.
        terms: further terms.
        watch: measures.
        seed: of random starts.
        progress: is called after each iteration.

    Raises:
        InputError: the scenario contradicts itself.
        NotSolvedError: no start converged.
    """
    timing = asked.gait.timing
    assert timing is not None, "asked only where times may change"
    method = replace(method, transcription="condensed", solver="fatrop")
    with watch("build"):
        if asked.value_of("weights", "effort") is None and timing.effort:
            asked = asked.with_values({"weights.effort": timing.effort})
        phases = Phases.of(asked, asked.schedule)
        counts = phases.coarse(timing)
        ready = Ready(method, _problem(asked, terms, phases, counts, LONGEST))
        ready.refuse_contradictions()
    attempts = Attempts(ready, saying(TASK, progress), watch)
    attempts.run(starts(ready.problem, method.solve, None, seed), 1)
    if not attempts.solved:
        best = attempts.best
        rule = (
            f"{best.solver} stopped with {best.solution.status} after {best.solution.iterations} iterations"
        )
        raise NotSolvedError(f"no timing found from {len(attempts.done)} initial guesses: {rule}")
    with watch("build"):
        settled, motion = _result(asked, phases, ready, attempts)
        counts = settled.fine(asked.interval)
        if settled.is_fine(timing, asked.interval):
            scenario = _at_times(asked, settled, settled.on_mesh(counts).node_times)
            return Found(scenario, motion, tuple(_results(attempts)))
        again = Ready(method, _problem(motion.scenario, terms, settled, counts, FINEST * asked.interval))
    finer = Attempts(again, saying(TASK, progress), watch)
    near = InitialGuess("finer mesh", lambda: from_plan(again.problem, motion), warm=True)
    finer.run(iter([near]), 1)
    tried = [*_results(attempts), *_results(finer)]
    with watch("build"):
        if finer.solved:
            settled, motion = _result(asked, settled, again, finer)
        nodes = settled.on_mesh(counts).node_times
        return Found(_at_times(asked, settled, nodes), motion, tuple(tried))


def _problem(
    asked: Scenario, terms: Sequence[Term], phases: Phases, counts: NDArray[np.intp], longest: float
) -> TimedProblem:
    """The problem with so many intervals in each phase, none longer than `longest` (s)."""
    timing = asked.gait.timing
    assert timing is not None
    schedule = phases.on_mesh(counts)
    now = _at_times(asked, phases, schedule.node_times)
    problem = make_problem(now, terms, schedule)
    durations = phases.durations(timing, counts, asked.interval, longest, asked.horizon)
    return TimedProblem.of(problem, durations)


def _at_times(asked: Scenario, phases: Phases, nodes: Array) -> Scenario:
    """What is asked at the times of phases, on a mesh of these nodes (s)."""
    gait = phases.gait(asked, nodes).model_dump(mode="json")
    return asked.with_values({"gait": gait, "horizon": float(nodes[-1])})


def _result(asked: Scenario, phases: Phases, ready: Ready, attempts: Attempts) -> tuple[Phases, Plan]:
    """The phases as they have come out, and their motion."""
    transcribed, best = ready.transcribed, attempts.best
    assert isinstance(transcribed, Timed)
    w = best.solution.w
    schedule = transcribed.schedule(w)
    first = np.flatnonzero(transcribed.problem.durations.first)
    statistics = Statistics(
        transcription="condensed",
        solver=best.solver,
        solved=True,
        status=best.solution.status,
        iterations=best.solution.iterations,
        cost=best.solution.cost / transcribed.problem.cost_scale,
    )
    motion = Plan(asked.body, asked, schedule, transcribed.decode(w), statistics)
    return phases.lasting(np.add.reduceat(schedule.lengths, first)), motion


def _results(attempts: Attempts) -> list[StartResult]:
    """What came of the starts, in costs that are not scaled."""
    problem = attempts.ready.problem
    assert isinstance(problem, TimedProblem)
    results = (attempt.result() for attempt in attempts.done)
    return [replace(result, cost=result.cost / problem.cost_scale) for result in results]
