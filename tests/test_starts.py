"""Initial guesses: which, in which order, always the same ones, and what becomes of them."""

from __future__ import annotations

from functools import partial
from itertools import islice

import numpy as np
import pytest

import rollgait as rg
from rollgait.ocp.problem import Problem, make_problem
from rollgait.scenario import Mesh
from rollgait.starts import InitialGuess, starts
from rollgait.transcription.guess import MotionGuess
from tests.stepping import stepping

SOME = 7


asked = partial(stepping, robot="centauro")


def never(problem: Problem, motion: MotionGuess) -> MotionGuess | None:
    """Solves nothing."""
    return None


def first(problem: Problem, seed: int = 0) -> list[InitialGuess]:
    return list(islice(starts(problem, never, None, seed), SOME))


def places(start: InitialGuess) -> np.ndarray:
    motion = start.motion()
    assert motion is not None
    return motion(np.linspace(0.0, 2.0, 21)).com_position


def test_the_first_start_is_the_kinematic_one_and_no_two_have_one_name() -> None:
    names = [start.name for start in first(make_problem(asked()))]
    assert names[0] == "kinematic"
    assert len(set(names)) == SOME
    assert not any(start.warm for start in first(make_problem(asked())))


def test_the_same_seed_gives_the_same_starts_and_another_gives_others() -> None:
    problem = make_problem(asked())
    drawn = [start for start in first(problem) if start.name.startswith("detour")]
    same = [start for start in first(problem) if start.name.startswith("detour")]
    other = [start for start in first(problem, seed=1) if start.name.startswith("detour")]
    assert len(drawn) >= 2
    for a, b, c in zip(drawn, same, other, strict=True):
        np.testing.assert_array_equal(places(a), places(b))
        assert np.abs(places(a) - places(c)).max() > 1e-3
    assert np.abs(places(drawn[0]) - places(drawn[1])).max() > 1e-3


def test_every_start_begins_where_the_robot_stands() -> None:
    problem = make_problem(asked(start={"x": 0.4, "y": -0.2, "yaw_deg": 30}, goal={"x": 0.5, "y": -0.2}))
    for start in first(problem):
        if start.name != "homotopy":  # which needs a solver
            np.testing.assert_allclose(places(start)[0], problem.start.base[:3], atol=1e-9)


def test_homotopy_solves_the_problem_without_what_makes_it_hard() -> None:
    solved: list[Problem] = []

    def solve(problem: Problem, motion: MotionGuess) -> MotionGuess | None:
        solved.append(problem)
        return motion

    problem = make_problem(asked())
    homotopy = next(start for start in starts(problem, solve, None, 0) if start.name == "homotopy")
    assert homotopy.motion() is not None
    (easier,) = solved
    names, all_names = ({term.name for term in p.terms} for p in (easier, problem))
    hardest = {"joint_steering", "reach", "acceleration", "touchdown_speed", "com_margin", "capture_margin"}
    assert all_names - names == hardest & all_names
    assert all_names - names


def test_homotopy_solves_on_the_mesh_of_the_problem() -> None:
    meshes: list[Mesh] = []

    def solve(problem: Problem, motion: MotionGuess) -> MotionGuess | None:
        meshes.append(problem.schedule.mesh)
        return motion

    problem = make_problem(asked(), schedule=asked().schedule.refined([0, 7]))
    next(start for start in starts(problem, solve, None, 0) if start.name == "homotopy").motion()
    assert meshes == [problem.schedule.mesh]


def test_what_the_paper_asks_has_nothing_to_leave_out() -> None:
    problem = make_problem(asked(profile="paper"))
    homotopy = next(start for start in starts(problem, never, None, 0) if start.name == "homotopy")
    assert homotopy.motion() is None


# -- planning ------------------------------------------------------------------------------------------------


def test_the_cheapest_of_several_starts_is_taken_and_all_are_told() -> None:
    plan = rg.plan(asked(), multistart=4, seed=3)
    results = plan.statistics.starts
    assert len(results) == 4
    solved = [result for result in results if result.solved]
    assert plan.statistics.cost == min(result.cost for result in solved)
    assert plan.statistics.start == min(solved, key=lambda result: result.cost).name
    assert 0.0 < plan.statistics.solve_time <= sum(result.solve_time for result in results) * 1.05
    again = rg.plan(asked(), multistart=4, seed=3)
    assert [(r.name, r.cost, r.iterations) for r in again.statistics.starts] == [
        (r.name, r.cost, r.iterations) for r in results
    ]


def test_one_start_is_enough_where_it_is_solved() -> None:
    plan = rg.plan(asked())
    assert [result.name for result in plan.statistics.starts] == ["kinematic"]
    assert plan.statistics.starts[0].cost == plan.statistics.cost


@pytest.mark.parametrize("wrong", [{"multistart": 0}, {"seed": -1}])
def test_numbers_that_make_no_sense_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(rg.InputError, match=f"{next(iter(wrong))}: .* must be at least"):
        rg.plan(asked(), **wrong)  # type: ignore[arg-type]
