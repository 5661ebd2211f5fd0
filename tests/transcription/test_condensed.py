"""The condensed transcription: from motions to variables and back, and the stages that a solver sees.

(Its derivatives are held against finite differences in `test_nlp`, its step in `tests/dynamics/test_step`.)
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from rollgait.plan.condensed import CondensedTrajectory
from rollgait.transcription.condensed import Condensed, transcribe
from rollgait.transcription.guess import kinematic_guess
from tests.transcription.problems import CASES, about_the_guess, problem_of, small_problem

Array = NDArray[np.float64]


@pytest.fixture(scope="module", params=CASES)
def transcribed(request: pytest.FixtureRequest) -> Condensed:
    return transcribe(problem_of(request.param))


def value(transcribed: Condensed, name: str, w: Array) -> Array:
    function = transcribed.nlp.functions[name]
    return np.asarray(function.call([w, transcribed.nlp.parameters])[-1])


# -- motions -------------------------------------------------------------------------------------------------


def test_decoding_is_the_inverse_of_encoding(transcribed: Condensed) -> None:
    robot = transcribed.problem.robot
    trajectory = transcribed.decode(about_the_guess(transcribed))
    w = transcribed.encode(lambda times: trajectory.sample(times, robot))
    again = transcribed.decode(w)
    for name, array in trajectory.arrays().items():
        np.testing.assert_allclose(again.arrays()[name], array, atol=1e-9, err_msg=name)


def test_a_motion_keeps_its_values_at_the_nodes(transcribed: Condensed) -> None:
    problem = transcribed.problem
    guess = kinematic_guess(problem)
    trajectory = transcribed.decode(transcribed.encode(guess))
    nodes = problem.schedule.node_times[:-1]
    planned, wanted = trajectory.sample(nodes, problem.robot), guess(nodes)
    np.testing.assert_allclose(planned.com_position, wanted.com_position, atol=1e-12)
    np.testing.assert_allclose(planned.com_velocity, wanted.com_velocity, atol=1e-12)
    np.testing.assert_allclose(planned.euler, wanted.euler, atol=1e-12)
    np.testing.assert_allclose(planned.euler_rate, wanted.euler_rate, atol=1e-10)
    np.testing.assert_allclose(planned.foot_position, wanted.foot_position, atol=1e-6)  # who stands stands
    middles = problem.schedule.mesh.middles
    np.testing.assert_allclose(
        trajectory.sample(middles, problem.robot).force, guess(middles).force, atol=1e-9
    )


# -- rows ----------------------------------------------------------------------------------------------------


def test_dynamics_rows_are_the_gap_to_the_next_node(transcribed: Condensed) -> None:
    """They are next node − end of the step, and a sample just before a node is that end."""
    w, problem = about_the_guess(transcribed), transcribed.problem
    interval = transcribed.nlp.blocks[0]
    rows = transcribed.nlp.row_numbers(interval)
    labels = interval.stage.labels
    r = next(i for i, label in enumerate(labels) if label.term == "dynamics") + 6  # after θ and L
    g, trajectory = value(transcribed, "nlp_g", w).ravel(), transcribed.decode(w)
    just_before = problem.schedule.node_times[1:-1] - 1e-9
    ends = trajectory.sample(just_before, problem.robot).com_position
    for axis in range(3):
        np.testing.assert_allclose(g[rows[r + axis, :-1]], trajectory.r[1:, axis] - ends[:, axis], atol=1e-6)


def test_rows_that_define_the_next_state_have_a_one_there_and_none_else(transcribed: Condensed) -> None:
    """Explicit dynamics x⁺ − F(x, u), each x⁺ defined once, and by no other row of that stage."""
    nlp, structure = transcribed.nlp, transcribed.structure
    jacobian = value(transcribed, "nlp_jac_g", about_the_guess(transcribed))
    row, column = 0, 0
    for k, (nx, nu, ng) in enumerate(zip(structure.nx, structure.nu, structure.ng, strict=True)):
        here = column + nx + nu
        following = structure.nx[k + 1] if k + 1 < len(structure.nx) else 0
        defining = jacobian[row : row + following]
        np.testing.assert_array_equal(defining[:, here : here + following], np.eye(following))
        rows = jacobian[row : row + following + ng]
        assert not rows[:, :column].any()
        assert not rows[:, here + following :].any()
        assert not rows[following:, here:].any()
        limits = slice(row, row + following)
        np.testing.assert_array_equal(nlp.g_lower[limits], 0.0)
        np.testing.assert_array_equal(nlp.g_upper[limits], 0.0)
        row, column = row + following + ng, here
    assert (row, column) == (nlp.rows, nlp.size)


def test_the_stages_make_up_the_whole_problem(transcribed: Condensed) -> None:
    structure, nlp = transcribed.structure, transcribed.nlp
    count = transcribed.problem.schedule.intervals
    assert len(structure.nx) == len(structure.nu) == len(structure.ng) == count + 1
    assert structure.nx[0] == 0  # the motion starts from a given state
    assert structure.nu[-1] == 0
    assert sum(structure.nx) + sum(structure.nu) == nlp.size
    assert sum(structure.nx[1:]) + sum(structure.ng) == nlp.rows


def test_everything_grows_as_the_horizon_does() -> None:
    sizes = []
    for intervals in (6, 9, 12):
        nlp = transcribe(small_problem(gait={"kind": "drive"}, horizon=0.15 * intervals)).nlp
        sizes.append([nlp.size, nlp.rows, nlp.jacobian_sparsity.nnz(), nlp.hessian_sparsity.nnz()])
    np.testing.assert_array_equal(np.diff(sizes, axis=0)[0], np.diff(sizes, axis=0)[1])


def test_the_trajectory_is_of_the_condensed_kind(transcribed: Condensed) -> None:
    trajectory = transcribed.decode(about_the_guess(transcribed))
    assert isinstance(trajectory, CondensedTrajectory)
    schedule = transcribed.problem.schedule
    np.testing.assert_array_equal(trajectory.contact, schedule.contact.T)
    assert trajectory.mesh == schedule.mesh
