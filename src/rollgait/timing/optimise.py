"""Times of a gait as variables: found on a coarse mesh, then given to the problem that is planned and judged.

Each phase has a few intervals while its length is sought, whatever it is at first, so that the same times come
out wherever the search began. The motion found so is a start of the same problem with given times, on a mesh
of about the scenario's interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from rollgait.starts import starts
from rollgait.stopwatch import Stopwatch
from rollgait.timing.phases import Phases
from rollgait.transcription.timed import Timed

Array = NDArray[np.float64]

TASK = "timing"
"""What iterations are for in which times are sought."""


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


def is_asked(scenario: Scenario) -> bool:
    """Whether the times of a scenario's gait may change."""
    timing = scenario.gait.timing
    return timing is not None and timing.optimize


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
    with watch("build"):
        if asked.value_of("weights", "effort") is None and timing.effort:
            asked = asked.with_values({"weights.effort": timing.effort})
        phases = Phases.of(asked, asked.schedule)
        counts = phases.coarse()
        durations = phases.durations(timing, counts, asked.interval, asked.horizon)
        problem = TimedProblem.of(make_problem(asked, terms, phases.on_mesh(counts)), durations)
        method = replace(method, transcription="condensed", solver="fatrop")
        ready = Ready(method, problem)
        ready.refuse_contradictions()
    attempts = Attempts(ready, saying(TASK, progress), watch)
    attempts.run(starts(problem, method.solve, None, seed), 1)
    best = attempts.best
    if not attempts.solved:
        rule = f"{best.solver} stopped with {best.solution.status} after {best.solution.iterations} iterations"
        raise NotSolvedError(f"no timing found from {len(attempts.done)} initial guesses: {rule}")
    with watch("build"):
        return _found(asked, phases, ready, attempts)


def _found(asked: Scenario, phases: Phases, ready: Ready, attempts: Attempts) -> Found:
    transcribed, best = ready.transcribed, attempts.best
    assert isinstance(transcribed, Timed)
    w = best.solution.w
    first = np.flatnonzero(transcribed.problem.durations.first)
    settled = phases.lasting(np.add.reduceat(transcribed.lengths(w), first))
    nodes = settled.on_mesh(settled.fine(asked.interval)).node_times
    gait = settled.gait(asked, nodes)
    scenario = asked.with_values({"gait": gait.model_dump(mode="json"), "horizon": float(nodes[-1])})
    statistics = Statistics(
        transcription="condensed",
        solver=best.solver,
        solved=True,
        status=best.solution.status,
        iterations=best.solution.iterations,
        cost=best.solution.cost,
    )
    motion = Plan(
        robot=asked.body,
        scenario=scenario,
        schedule=transcribed.schedule(w),
        trajectory=transcribed.decode(w),
        statistics=statistics,
    )
    return Found(scenario, motion, tuple(attempt.result() for attempt in attempts.done))
