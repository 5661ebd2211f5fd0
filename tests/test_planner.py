"""Laws of plans: what must hold whatever the solver does. Short horizons, on the symmetric robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray

import rollgait as rg
from rollgait.attempts import FALLBACKS
from rollgait.errors import UnknownNameError
from rollgait.ocp.term import END, Data
from rollgait.plan.samples import Samples
from rollgait.robot.robot import GRAVITY
from rollgait.solvers import Iteration

Array = NDArray[np.float64]

ROBOT = rg.find_robot("centauro-2020")
SWAPPED = [1, 0, 3, 2]
"""The legs of the other side."""


def asked(**values: Any) -> rg.Scenario:
    """A step of the hind left foot while driving a little, in 1.6 s."""
    data: dict[str, Any] = {
        "robot": "centauro-2020",
        "goal": {"x": 0.1, "y": 0.04, "yaw_deg": 5},
        "horizon": 1.6,
        "interval": 0.1,
        "gait": {"kind": "schedule", "HL": [[0.4, 0.9]]},
    }
    return rg.Scenario.from_dict(data | values)


Planned = Callable[..., rg.Plan]


@pytest.fixture(scope="module", params=[("collocation", "ipopt"), ("condensed", "fatrop")], ids="-".join)
def planned(request: pytest.FixtureRequest) -> Planned:
    """Plans in one of the ways that there are."""
    transcription, solver = request.param
    return partial(rg.plan, transcription=transcription, solver=solver)


@pytest.fixture(scope="module")
def plan(planned: Planned) -> rg.Plan:
    return planned(asked())


def dense(plan: rg.Plan) -> Samples:
    return plan.sample(np.linspace(0.0, plan.horizon, 161)[:-1] + 1e-4)


def turned(a: float, vectors: Array) -> Array:
    c, s = np.cos(a), np.sin(a)
    return np.asarray(vectors @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))


def assert_same_motion(found: Samples, wanted: Samples) -> None:
    np.testing.assert_allclose(found.com_position, wanted.com_position, atol=1e-5)
    np.testing.assert_allclose(found.euler, wanted.euler, atol=1e-5)
    np.testing.assert_allclose(found.foot_position, wanted.foot_position, atol=1e-5)
    np.testing.assert_allclose(found.heading, wanted.heading, atol=1e-4)
    np.testing.assert_allclose(found.speed, wanted.speed, atol=1e-4)
    np.testing.assert_allclose(found.force, wanted.force, atol=0.5)


# -- standing ------------------------------------------------------------------------------------------------


def test_standing_needs_the_weight_and_nothing_else(planned: Planned) -> None:
    s = dense(planned(asked(goal={"x": 0.0}, gait={"kind": "drive"}, horizon=1.0)))
    np.testing.assert_allclose(
        s.force.sum(axis=1), np.tile([0, 0, ROBOT.mass * GRAVITY], (160, 1)), atol=1e-2
    )
    torque = np.cross(s.foot_position - s.com_position[:, None], s.force).sum(axis=1)
    np.testing.assert_allclose(torque, 0.0, atol=0.05)
    np.testing.assert_allclose(s.com_position, s.com_position[:1].repeat(160, axis=0), atol=1e-5)
    for still in (s.euler, s.com_velocity, s.euler_rate, s.speed, s.heading_rate, s.foot_velocity):
        np.testing.assert_allclose(still, 0.0, atol=1e-3)


# -- symmetries ----------------------------------------------------------------------------------------------


def test_a_mirrored_scenario_mirrors_the_plan(planned: Planned, plan: rg.Plan) -> None:
    other = planned(
        asked(goal={"x": 0.1, "y": -0.04, "yaw_deg": -5}, gait={"kind": "schedule", "HR": [[0.4, 0.9]]})
    )
    assert other.statistics.cost == pytest.approx(plan.statistics.cost, rel=1e-5)
    s, flip = dense(other), np.array([1.0, -1.0, 1.0])
    mirrored = replace(
        s,
        com_position=s.com_position * flip,
        euler=s.euler * [-1.0, 1.0, -1.0],
        foot_position=s.foot_position[:, SWAPPED] * flip,
        heading=-s.heading[:, SWAPPED],
        speed=s.speed[:, SWAPPED],
        force=s.force[:, SWAPPED] * flip,
    )
    assert_same_motion(mirrored, dense(plan))


@pytest.mark.parametrize("turn_deg", [90, -37, 200])
def test_a_turned_and_moved_scenario_turns_and_moves_the_plan(
    planned: Planned, plan: rg.Plan, turn_deg: float
) -> None:
    a, shift = np.radians(turn_deg), np.array([2.0, -1.0, 0.3])
    goal = turned(a, np.array([0.1, 0.04, 0.0])) + shift
    other = planned(
        asked(
            start={"x": shift[0], "y": shift[1], "yaw_deg": turn_deg},
            goal={"x": goal[0], "y": goal[1], "yaw_deg": turn_deg + 5},
            ground={"height": shift[2]},
        )
    )
    assert other.statistics.cost == pytest.approx(plan.statistics.cost, rel=1e-5)
    s = dense(other)
    back = replace(
        s,
        com_position=turned(-a, s.com_position - shift),
        euler=s.euler - [a, 0.0, 0.0],
        foot_position=turned(-a, s.foot_position - shift),
        heading=s.heading - a,
        force=turned(-a, s.force),
    )
    assert_same_motion(back, dense(plan))


def test_forces_scale_with_the_mass(planned: Planned, plan: rg.Plan) -> None:
    factor = 0.25
    limits = {leg: ROBOT.leg_list[i].force_max * factor for i, leg in enumerate(("FL", "FR", "HL", "HR"))}
    lighter = {f"robot.legs.{leg}.force_max": limit for leg, limit in limits.items()}
    lighter |= {f"robot.inertia.{name}": v * factor for name, v in ROBOT.inertia.model_dump().items()}
    given = asked().with_values(
        lighter
        | {
            "robot.mass": ROBOT.mass * factor,
            "weights.force": 5e-4 / factor**2,
            "bounds.force_min": 40.0 * factor,
        }
    )
    s = dense(planned(given))
    assert_same_motion(replace(s, force=s.force / factor), dense(plan))


def test_the_same_question_has_the_same_answer(planned: Planned, plan: rg.Plan) -> None:
    again = planned(asked())
    for name, array in plan.trajectory.arrays().items():
        np.testing.assert_array_equal(again.trajectory.arrays()[name], array)


# -- wheels --------------------------------------------------------------------------------------------------


def test_wheels_do_not_slip_between_nodes(plan: rg.Plan) -> None:
    """Lateral velocity of the contact points, found from their places alone."""
    step = 1e-5
    times = np.linspace(0.0, plan.horizon, 321)[:-1] + 0.0021
    before, s, after = (plan.sample(times + shift) for shift in (-step, 0.0, step))
    velocity = (after.foot_position - before.foot_position) / (2 * step)
    lateral = np.cos(s.heading) * velocity[..., 1] - np.sin(s.heading) * velocity[..., 0]
    along = np.cos(s.heading) * velocity[..., 0] + np.sin(s.heading) * velocity[..., 1]
    assert np.abs(lateral).max() < 1e-4
    np.testing.assert_allclose(along, s.speed, atol=1e-4)


@pytest.mark.parametrize("kind", ["steerable", "fixed", "point"])
def test_every_kind_of_foot_is_planned_and_certified(planned: Planned, kind: Any) -> None:
    gait = {"kind": "crawl", "steps": 4, "pause_start": 0.4, "pause_end": 0.4}
    plan = planned(
        asked(
            robot=ROBOT.with_feet(kind),
            goal={"x": 0.1},
            horizon=4.0,
            gait=gait,
            bounds={"acceleration_max": 1.0},
        )
    )
    assert plan.certificate().passed, plan.certificate().failures
    s = dense(plan)
    if kind == "point":
        np.testing.assert_allclose(s.foot_velocity[s.contact], 0.0, atol=1e-9)
    if kind == "fixed":
        np.testing.assert_allclose(s.heading, s.euler[:, :1].repeat(4, axis=1), atol=1e-9)


# -- terms of the user ---------------------------------------------------------------------------------------


class _Crouch(rg.Constraint):
    """The CoM stays below 0.67 m at the end, so that the height at the end must be given up."""

    name = "crouch"
    places = END
    upper = 0.67
    unit = "m"

    def expression(self, x: rg.Instant, d: Data) -> ca.SX:
        return x.r[2]


class _ToTheLeft(rg.Cost):
    name = "to_the_left"

    def expression(self, x: rg.Instant, d: Data) -> ca.SX:
        return (x.r[1] - 0.05) ** 2


def test_costs_of_the_user_pull_and_are_accounted_for(planned: Planned, plan: rg.Plan) -> None:
    pulled = planned(asked(weights={"goal": 0.0, "terminal_goal": 0.0}), terms=[_ToTheLeft(weight=1e4)])
    assert pulled.statistics.costs["to_the_left"] > 0.0
    assert sum(pulled.statistics.costs.values()) == pytest.approx(pulled.statistics.cost)
    assert pulled.sample(pulled.horizon).com_position[1] == pytest.approx(0.05, abs=5e-3)


def test_constraints_of_the_user_hold(planned: Planned) -> None:
    plan = planned(asked(bounds={"without": ["height_at_end"]}), terms=[_Crouch()])
    assert plan.sample(plan.horizon).com_position[2] <= 0.67 + 1e-6


# -- ways in and out -----------------------------------------------------------------------------------------


def test_a_scenario_may_be_a_file_or_a_name(planned: Planned, plan: rg.Plan, tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(asked().to_yaml(), encoding="utf-8")
    for name in (file, str(file)):
        assert planned(name).statistics.cost == pytest.approx(plan.statistics.cost, rel=1e-6)
    with pytest.raises(UnknownNameError, match="wheeled"):
        planned("wheels")


def test_profile_replaces_that_of_the_scenario(planned: Planned) -> None:
    plan = planned(asked(), profile="paper")
    assert plan.scenario.profile == "paper"
    assert "tilt" not in plan.statistics.costs


@pytest.mark.parametrize("what", ["transcription", "solver", "profile"])
def test_unknown_names_are_refused_with_the_valid_ones(what: str) -> None:
    with pytest.raises(rg.InputError, match=f"{what}.*valid|{what}.*paper"):
        rg.plan(asked(), **{what: "nonsense"})


def test_statistics_account_for_the_solution(plan: rg.Plan) -> None:
    statistics = plan.statistics
    assert plan.solved
    assert statistics.violation < 1e-6
    assert statistics.worst == ""
    assert sum(statistics.costs.values()) == pytest.approx(statistics.cost)
    assert min(statistics.costs.values()) >= 0.0
    assert statistics.variables > 0 < statistics.constraints


def test_progress_is_told_of_every_iteration() -> None:
    seen: list[Iteration] = []
    plan = rg.plan(asked(), solver="ipopt", progress=seen.append)
    assert [i.number for i in seen] == list(range(plan.statistics.iterations + 1))
    assert seen[-1].cost == pytest.approx(plan.statistics.cost)
    assert seen[-1].violation < 1e-6 < seen[0].violation


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_what_progress_raises_comes_through(error: type[BaseException]) -> None:
    def stop(iteration: Iteration) -> None:
        if iteration.number == 2:
            raise error

    with pytest.raises(error):
        rg.plan(asked(), solver="ipopt", progress=stop)


def test_no_solution_is_an_error_that_carries_the_iterate(planned: Planned, tmp_path: Path) -> None:
    tasks: list[str] = []
    with pytest.raises(rg.NotSolvedError, match=r"worst: .* at t = ") as caught:
        planned(asked(bounds={"force_max": 100.0}), progress=lambda each: tasks.append(each.task))
    assert tasks[0] == "solving"
    said = [task for task in dict.fromkeys(tasks) if task.startswith("solving, start")]
    assert said == [f"solving, start {number} of {FALLBACKS}" for number in range(2, 2 + len(said))]
    iterate = caught.value.plan
    assert isinstance(iterate, rg.Plan)
    assert not iterate.solved
    assert iterate.statistics.violation > 1e-3
    assert not iterate.certificate().passed
    assert not rg.Plan.load(iterate.save(tmp_path / "iterate")).solved


def test_what_cannot_be_is_said_without_trying(planned: Planned) -> None:
    class _Float(_Crouch):
        name = "float"
        lower, upper = 5.0, 6.0

    with pytest.raises(
        rg.NotSolvedError, match=r"no solution exists: height_at_end contradicts .* by 4\.31 m"
    ):
        planned(asked(), terms=[_Float()])


def test_fixed_wheels_drive_straight_ahead() -> None:
    """Their sideways places at the end are not theirs to choose: rows for them would be redundant."""
    robot = rg.find_robot("centauro-2020").with_feet("fixed")
    plan = rg.plan(rg.Scenario(robot=robot, goal={"x": 0.3}, horizon=2.0, gait="drive"))
    assert plan.certificate().passed


WRONG_ARGUMENTS: dict[str, tuple[Callable[[rg.Plan], object], str]] = {
    "a word as time": (lambda plan: plan.sample("a"), "time: 'a' must be a number"),  # type: ignore[arg-type]
    "a word as rate": (lambda plan: plan.sample_every("fast"), "rate: 'fast' must be"),  # type: ignore[arg-type]
    "a plan as scenario": (lambda plan: rg.plan(plan), "plan.scenario"),  # type: ignore[arg-type]
    "a number as scenario": (lambda _: rg.plan(7), "<class 'int'> must be"),  # type: ignore[arg-type]
    "a class as term": (lambda _: rg.plan("wheeled", terms=[rg.Cost]), "terms.0: 'Cost' is a class"),  # type: ignore[list-item]
    "a word as term": (lambda _: rg.plan("wheeled", terms=["acc"]), "terms.0: 'acc' must be"),  # type: ignore[list-item]
    "a term as terms": (lambda _: rg.plan("wheeled", terms=7), "terms: 7 must be a list"),  # type: ignore[arg-type]
    "another ending": (lambda plan: plan.save("x.txt"), "'x.txt' must end in .npz"),
}


@pytest.mark.parametrize("wrong", WRONG_ARGUMENTS)
def test_a_wrong_argument_is_one_sentence(wrong: str, plan: rg.Plan) -> None:
    call, said = WRONG_ARGUMENTS[wrong]
    with pytest.raises(rg.InputError) as raised:
        call(plan)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)
