"""A small scenario with a step, for tests that plan it, and a way to plan it on any mesh."""

from __future__ import annotations

from typing import Any

import rollgait as rg
from rollgait.ocp.problem import make_problem
from rollgait.plan.plan import Statistics
from rollgait.scenario import ContactSchedule
from rollgait.solvers import make_solver
from rollgait.starts import from_plan
from rollgait.transcription import transcribe
from rollgait.transcription.guess import kinematic_guess

METHODS = {"condensed": "fatrop", "collocation": "ipopt"}
"""Transcriptions and the solver that suits each."""


def stepping(**values: Any) -> rg.Scenario:
    """A step of the hind left foot while driving a little, in 2 s; `values` are set instead."""
    data: dict[str, Any] = {
        "robot": "centauro-2020",
        "goal": {"x": 0.15, "y": 0.03, "yaw_deg": 5},
        "horizon": 2.0,
        "gait": {"kind": "schedule", "HL": [[0.5, 1.2]]},
    }
    return rg.Scenario.from_dict(data | values)


def solved(
    scenario: rg.Scenario,
    schedule: ContactSchedule,
    transcription: str = "condensed",
    warm_start: rg.Plan | None = None,
) -> rg.Plan:
    """The scenario planned on the mesh of this schedule."""
    problem = make_problem(scenario, schedule=schedule)
    transcribed = transcribe(transcription, problem)
    solver = make_solver(METHODS[transcription], transcribed)
    start = kinematic_guess(problem) if warm_start is None else from_plan(problem, warm_start)
    solution = solver.solve(transcribed.encode(start), None, warm_start is not None)
    statistics = Statistics(
        transcription,
        solver.name,
        solution.solved,
        solution.status,
        solution.iterations,
        cost=solution.cost,
    )
    trajectory = transcribed.decode(solution.w)
    return rg.Plan(problem.robot, scenario.self_contained(), schedule, trajectory, statistics)
