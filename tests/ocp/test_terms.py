"""What holds for every term of the problem."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from rollgait.errors import InputError, UnknownNameError
from rollgait.ocp.instant import Instant
from rollgait.ocp.lift import lift
from rollgait.ocp.problem import ALL_COSTS, Problem, make_problem
from rollgait.ocp.term import INPUT, Constraint, Cost, Data, FootConstraint, Phase, Place, Term
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.mesh import Mesh
from rollgait.scenario.profile import PROFILES
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.transcription import transcribe
from tests.expressions import value
from tests.instants import as_instant, data_of, random_numbers
from tests.plan.builders import robot as simple_robot

KINDS = ("steerable", "fixed", "point")
STEPPING = {"kind": "schedule", "HL": [[0.4, 1.0]], "FR": [[1.2, 1.8]]}


def scenario(foot: str = "steerable", **values: Any) -> Scenario:
    robot = simple_robot(foot)
    data = {"robot": robot, "goal": {"x": 0.1}, "horizon": 2.0, "interval": 0.2, "gait": STEPPING}
    return Scenario.from_dict(data | values)


def names(problem: Problem) -> set[str]:
    return {term.name for term in problem.terms}


def feet_of(term: Term, problem: Problem) -> list[int | None]:
    """The legs that a term is about, None for one that is about the whole robot."""
    if isinstance(term, FootConstraint):
        return [leg for leg in range(4) if term.applies(problem, leg)]
    return [None]


CASES = [
    pytest.param(problem, term, id=f"{problem.scenario.profile}-{kind}-{term.name}")
    for kind in KINDS
    for profile in ("paper", "executable")
    for problem in [make_problem(scenario(kind, profile=profile))]
    for term in problem.terms
]


def evaluated(term: Term, problem: Problem, leg: int | None, interval: int, seed: int = 0) -> np.ndarray:
    robot: Robot = problem.robot
    height_point = 0 if not isinstance(term, Cost) and Place.HEIGHT_POINTS in term.places else None
    x = as_instant(robot, random_numbers(seed, robot), height_point)
    d = data_of(term, problem, interval, leg or 0)
    if isinstance(term, FootConstraint):
        assert leg is not None
        return value(term.expression(x, x.feet[leg], d))
    return value(term.expression(x, d))


@pytest.mark.parametrize(("problem", "term"), CASES)
def test_expression_is_finite_at_random_instants(problem: Problem, term: Term) -> None:
    for leg in feet_of(term, problem):
        for interval in (0, problem.schedule.intervals - 1):
            assert np.isfinite(evaluated(term, problem, leg, interval)).all()


@pytest.mark.parametrize(("problem", "term"), [c for c in CASES if isinstance(c.values[1], Cost)])
def test_cost_is_one_number_and_never_negative(problem: Problem, term: Cost) -> None:
    for seed in range(3):
        for interval in (0, 4):
            result = evaluated(term, problem, None, interval, seed)
            assert result.shape == (1,)
            assert result[0] >= 0.0


@pytest.mark.parametrize(("problem", "term"), [c for c in CASES if not isinstance(c.values[1], Cost)])
def test_limits_and_masks_fit_the_expression_and_the_horizon(
    problem: Problem, term: Constraint | FootConstraint
) -> None:
    count = problem.schedule.intervals
    for leg in feet_of(term, problem):
        rows = evaluated(term, problem, leg, 0).size
        if isinstance(term, FootConstraint):
            assert leg is not None
            low, high = term.limits(problem, leg)
            masks = [term.holds(problem, place, leg) for place in term.places]
        else:
            low, high = term.limits(problem)
            masks = [term.holds(problem, place) for place in term.places]
        low, high = (np.broadcast_to(np.atleast_2d(limit), (rows, count)) for limit in (low, high))
        assert np.all(low <= high)
        assert np.isfinite(low).any() or np.isfinite(high).any()
        assert [mask.shape for mask in masks] == [(count,)] * len(masks)


@pytest.mark.parametrize("kind", KINDS)
def test_names_are_unique(kind: str) -> None:
    problem = make_problem(scenario(kind))
    assert len(names(problem)) == len(problem.terms)


@pytest.mark.parametrize("cost", ALL_COSTS, ids=lambda cost: cost.name)
def test_a_weight_switches_a_cost_on_and_off(cost: type[Cost]) -> None:
    on = make_problem(scenario(profile="paper", weights={cost.name: 2.5}))
    off = make_problem(scenario(weights={cost.name: 0.0}))
    assert next(term.weight for term in on.costs if term.name == cost.name) == 2.5
    assert cost.name not in names(off)


def test_the_paper_has_its_terms_and_no_others() -> None:
    assert {cost.name for cost in make_problem(scenario(profile="paper")).costs} == set(
        PROFILES["paper"]["weights"]
    )
    paper, executable = (names(make_problem(scenario(profile=p))) for p in ("paper", "executable"))
    assert executable - paper == {
        *(set(PROFILES["executable"]["weights"]) - set(PROFILES["paper"]["weights"])),
        *("joint_steering", "reach", "acceleration", "touchdown_speed", "level_at_end"),
        *("com_margin", "capture_margin"),
    }
    assert paper - executable == {"steering"}, "a range of σ − θz, in place of the joints behind it"


@pytest.mark.parametrize(
    ("bounds", "gone"),
    [
        ({"joint_steering": False}, "joint_steering"),
        ({"reach": False}, "reach"),
        ({"level_at_end": False}, "level_at_end"),
    ],
)
def test_a_bound_switches_a_constraint_off(bounds: dict[str, Any], gone: str) -> None:
    assert gone in names(make_problem(scenario()))
    assert gone not in names(make_problem(scenario(bounds=bounds)))


@pytest.mark.parametrize(
    ("bounds", "new"),
    [
        ({"touchdown_speed": 0.1}, "touchdown_speed"),
        ({"acceleration_max": 2.0}, "acceleration"),
        ({"level_at_end": True}, "level_at_end"),
        ({"joint_steering": True}, "joint_steering"),
        ({"reach": True}, "reach"),
        ({"com_margin": 0.0}, "com_margin"),
        ({"capture_margin": -0.02}, "capture_margin"),
    ],
)
def test_a_bound_switches_a_constraint_on(bounds: dict[str, Any], new: str) -> None:
    assert new in names(make_problem(scenario(profile="paper", bounds=bounds)))


@pytest.mark.parametrize("name", sorted(names(make_problem(scenario()))))
def test_any_term_can_be_left_out_by_its_name(name: str) -> None:
    assert names(make_problem(scenario())) - names(make_problem(scenario(bounds={"without": [name]}))) == {
        name
    }


def test_a_term_that_is_not_there_cannot_be_left_out() -> None:
    with pytest.raises(UnknownNameError, match="goal, ") as error:
        make_problem(scenario(bounds={"without": ["goals"]}))
    assert error.value.choices[0] == "goal"


class _Mine(Cost):
    name = "mine"

    def expression(self, x: Instant, d: Data) -> ca.SX:
        return ca.sumsqr(x.r)


def test_terms_of_the_user_join_and_can_be_left_out() -> None:
    assert names(make_problem(scenario(), [_Mine()])) - names(make_problem(scenario())) == {"mine"}
    left_out = scenario(bounds={"without": ["mine"]})
    assert "mine" not in names(make_problem(left_out, [_Mine()]))


def test_two_terms_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="'mine' is the name of two terms"):
        make_problem(scenario(), [_Mine(), _Mine()])


@pytest.mark.parametrize("kind", KINDS)
def test_phases_divide_the_horizon(kind: str) -> None:
    problem = make_problem(scenario(kind))
    for leg in range(len(LEG_NAMES)):
        for term in problem.constraints:
            if isinstance(term, FootConstraint) and term.phase is not Phase.ALWAYS and term.places == INPUT:
                in_stance = problem.schedule.contact[leg]
                wanted = in_stance if term.phase is Phase.STANCE else ~in_stance
                np.testing.assert_array_equal(term.holds(problem, Place.NODE, leg), wanted)


# -- on a mesh of unequal intervals --------------------------------------------------------------------------

LENGTHS = 0.2 * np.array([0.5, 1.5, 0.8, 1.2, 1.0, 1.7, 0.3, 1.0, 1.0, 1.0])


def uneven(kind: str = "steerable", **values: Any) -> Problem:
    asked = scenario(kind, **values)
    schedule = ContactSchedule(asked.schedule.contact, Mesh(LENGTHS))
    return make_problem(asked, schedule=schedule)


def term_of(problem: Problem, name: str) -> FootConstraint:
    (term,) = [term for term in problem.constraints if term.name == name]
    assert isinstance(term, FootConstraint)
    return term


def test_an_acceleration_is_over_the_time_between_the_middles_of_two_intervals() -> None:
    problem = uneven(bounds={"acceleration_max": 2.0, "swing_acceleration_max": 5.0})
    mesh = problem.schedule.mesh
    for leg in range(4):
        low, high = np.asarray(term_of(problem, "acceleration").limits(problem, leg))
        contact = problem.schedule.contact[leg]
        stays = contact & np.append(True, contact[:-1])
        between = np.append(LENGTHS[0], np.diff(mesh.times[:-1] + 0.5 * LENGTHS))
        np.testing.assert_allclose(high[0], np.where(stays, 2.0, 5.0) * between)
        np.testing.assert_array_equal(low, -high)


@pytest.mark.parametrize("kind", ["fixed", "point"])
def test_a_landing_is_a_lift_off_reversed(kind: str) -> None:
    """What moves freely in swing starts and stops within the same acceleration."""
    problem = uneven(kind)
    acceleration = term_of(problem, "acceleration")
    for leg in range(4):
        contact = problem.schedule.contact[leg]
        changes = contact[1:] != contact[:-1]
        counted = np.asarray(acceleration.data(problem, leg)["sideways"])[0].astype(bool)
        counted &= acceleration.holds(problem, Place.NODE, leg)
        np.testing.assert_array_equal(counted[1:], ~contact[1:] | changes)
        assert contact[0]
        assert not counted[0]


def test_friction_is_narrowed_by_the_turn_in_each_interval() -> None:
    problem = uneven(bounds={"steering_rate_max": 2.0}, ground={"friction": 0.6})
    mu = np.asarray(term_of(problem, "friction").data(problem, 0)["mu"])
    np.testing.assert_allclose(
        mu, 0.6 * np.cos(LENGTHS)[None, :] / (2**0.5 if problem.scenario.bounds.inscribed else 1.0)
    )


def test_between_two_nodes_a_box_is_tightened_for_the_longer_interval_beside_each() -> None:
    problem = uneven()
    stage = transcribe("condensed", problem).nlp.blocks[0].stage
    row = next(i for i, label in enumerate(stage.labels) if label.term == "box")
    box, curvature = problem.robot.box[0], term_of(problem, "box").curvature
    longest = np.maximum(LENGTHS, np.append(0.0, LENGTHS[:-1]))
    np.testing.assert_allclose(stage.upper[row], box - curvature * longest**2 / 8.0)


def test_goals_and_lifts_are_those_of_their_intervals() -> None:
    problem = uneven(goal={"x": 0.1, "then": [{"at": 1.2, "x": 0.2}]})
    middles = problem.schedule.node_times[:-1] + 0.5 * LENGTHS
    np.testing.assert_array_equal(problem.goals[0], np.where(middles < 1.2, 0.1, 0.2))
    rate = problem.lift_rate
    np.testing.assert_array_equal((rate != 0.0).any(axis=0), ~problem.schedule.contact)
    for j, point in enumerate(0.5 + 0.5 * np.array([-1.0, 1.0]) / np.sqrt(3.0)):
        times = problem.schedule.node_times[:-1] + point * LENGTHS
        wanted = lift(problem.schedule, problem.scenario.clearance, times)[1]
        np.testing.assert_allclose(rate[j], wanted.T, atol=1e-12)


def test_a_schedule_of_another_horizon_is_refused() -> None:
    asked = scenario()
    schedule = ContactSchedule(asked.schedule.contact, Mesh.equal(2.1, 10))
    with pytest.raises(InputError, match=r"schedule\.horizon: 2\.1 must have the scenario's horizon of 2 s"):
        make_problem(asked, schedule=schedule)


def test_start_is_standing_at_the_nominal_place() -> None:
    start = make_problem(
        scenario(
            start={"x": 1.0, "y": -2.0, "yaw_deg": 90.0}, ground={"height": 0.3}, goal={"x": 1.0, "y": -2.0}
        )
    ).start
    np.testing.assert_allclose(start.base, [1.0, -2.0, 1.0, np.pi / 2, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(start.p_foot[0], [1.0 - 0.35, -2.0 + 0.3, 0.3], atol=1e-12)
    np.testing.assert_array_equal(start.base_rate, 0.0)
    np.testing.assert_allclose(start.heading, np.pi / 2)


def test_goal_of_an_interval_is_that_of_its_middle() -> None:
    goal = {"x": 0.1, "then": [{"at": 1.0, "x": 0.2, "yaw_deg": 90}]}
    goals = make_problem(scenario(goal=goal)).goals
    np.testing.assert_array_equal(goals[0], [0.1] * 5 + [0.2] * 5)
    np.testing.assert_allclose(goals[3, 5:], np.pi / 2)
