"""Scenarios that cannot be: the right constraint is named, and what is suggested helps."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.diagnosis.budget import ITERATIONS, Budget
from rollgait.diagnosis.entry import MAX_SUGGESTIONS, Investigation
from rollgait.diagnosis.report import Diagnosis, Reason, Suggestion
from rollgait.ocp.problem import make_problem
from rollgait.scenario.scenario import Scenario
from rollgait.solvers import Iteration
from rollgait.transcription import transcribe

ROLLING = {"robot": "centauro", "goal": {"x": 0.5}, "horizon": 3.0}
PATIENT = 600.0
"""s: how busy the machine is shall not decide about a test."""
LOCKED = {"wheels": "locked", "kind": "schedule"}


def scenario(**changes: Any) -> Scenario:
    return Scenario.from_dict(ROLLING | changes)


def terms(diagnosis: Diagnosis) -> set[str]:
    return {reason.term for reason in diagnosis.reasons}


def keys(diagnosis: Diagnosis) -> set[str]:
    return {key for suggestion in diagnosis.suggestions for key in suggestion.change}


def assert_helps(asked: Scenario, suggestion: Suggestion) -> None:
    assert suggestion.verified
    plan = rg.plan(asked.with_values(suggestion.change), diagnose=False)
    rows = {row.name: row for row in plan.certificate().rows}
    assert rows["goal_distance"].verdict != "fail"
    assert rows["goal_yaw"].verdict != "fail"


# -- what is in the way ------------------------------------------------------------------------------------


def test_nothing_is_in_the_way_of_what_can_be_solved() -> None:
    diagnosis = rg.diagnose(scenario(), seconds=PATIENT)
    assert diagnosis == Diagnosis()
    assert "no constraint" in str(diagnosis)


def test_the_elastic_motion_keeps_the_constraints() -> None:
    asked = scenario(goal={"x": 2.9})
    motion = Investigation(asked, (), True, None, Budget(PATIENT)).motion
    assert motion is not None  # it only misses the goal
    transcribed = transcribe("condensed", make_problem(asked))
    w = transcribed.encode(motion)
    g = np.asarray(transcribed.nlp.functions["nlp_g"](w, transcribed.nlp.parameters)).ravel()
    assert transcribed.nlp.violations(g, w).max() < 1e-3


def test_goal_too_far_for_the_horizon() -> None:
    asked = scenario(goal={"x": 2.9})
    diagnosis = rg.diagnose(asked, seconds=PATIENT)
    assert terms(diagnosis) <= {"acceleration", "stance_speed"}
    assert {reason.leg for reason in diagnosis.reasons} == {"FL", "FR", "HL", "HR"}
    assert {"goal.x", "horizon"} <= keys(diagnosis)
    nearer = next(s for s in diagnosis.suggestions if "goal.x" in s.change)
    assert 1.5 < nearer.change["goal.x"] < 2.9
    for suggestion in diagnosis.suggestions:
        assert_helps(asked, suggestion)


def test_friction_too_low_to_get_there() -> None:
    asked = scenario(goal={"x": 1.0}, ground={"friction": 0.01})
    diagnosis = rg.diagnose(asked, seconds=PATIENT)
    assert terms(diagnosis) == {"friction"}
    assert all(reason.unit == "N" and 0.0 < reason.excess < 500.0 for reason in diagnosis.reasons)
    more = next(s for s in diagnosis.suggestions if "ground.friction" in s.change)
    assert_helps(asked, more)


@pytest.mark.slow
def test_box_too_small_for_the_stride() -> None:
    asked = scenario(
        goal={"x": 0.3},
        horizon=6.0,
        gait={"kind": "crawl", "steps": 4, "wheels": "locked"},
        # so small a box leaves the CoM no room to shift either, and that would be reason enough
        bounds={"box": [0.03, 0.03, 0.1], "without": ["com_margin", "capture_margin"]},
    )
    diagnosis = rg.diagnose(asked, seconds=PATIENT)
    assert terms(diagnosis) == {"box"}
    assert all(1.0 <= reason.begin < reason.end <= 6.0 for reason in diagnosis.reasons)
    larger = next(s for s in diagnosis.suggestions if "bounds.box" in s.change)
    assert larger.change["bounds.box"][0] > 0.03
    assert_helps(asked, larger)


@pytest.mark.slow
def test_diagonal_and_lateral_pairs_in_the_air() -> None:
    swings = {"FL": [[0.5, 1.5], [3.0, 5.5]], "HR": [[0.5, 1.5]], "HL": [[3.0, 5.5]]}
    asked = scenario(goal={"x": 0.1}, horizon=7.0, gait=LOCKED | swings)
    diagnosis = rg.diagnose(asked, seconds=PATIENT)
    assert diagnosis.reasons
    lateral = [reason for reason in diagnosis.reasons if reason.begin < 5.5 and reason.end > 3.0]
    assert lateral
    single = next(s for s in diagnosis.suggestions if "gait.FL" in s.change)
    assert "one foot" in single.text
    assert_helps(asked, single)


def test_steering_too_slow_for_the_turn() -> None:
    asked = scenario(goal={"x": 0.3, "y": 0.4, "yaw_deg": 30}, bounds={"steering_rate_max": 0.05})
    diagnosis = rg.diagnose(asked, seconds=PATIENT)
    assert terms(diagnosis) == {"steering_rate"}
    faster = next(s for s in diagnosis.suggestions if "bounds.steering_rate_max" in s.change)
    assert 0.05 < faster.change["bounds.steering_rate_max"] <= 2.0
    assert_helps(asked, faster)


# -- with the error ------------------------------------------------------------------------------------------


def test_forces_too_small_to_stand() -> None:
    asked = scenario(bounds={"force_max": 100.0})
    with pytest.raises(rg.NotSolvedError) as caught:
        rg.plan(asked, diagnose_seconds=PATIENT)
    diagnosis = caught.value.diagnosis
    assert terms(diagnosis) == {"force_limits"}
    # the four feet carry 1149 N, so that each must carry some 187 N more on average
    assert sum(reason.excess for reason in diagnosis.reasons) > 4 * 180.0
    (larger,) = [s for s in diagnosis.suggestions if "bounds.force_max" in s.change]
    assert_helps(asked, larger)
    assert pickle.loads(pickle.dumps(caught.value)).diagnosis == diagnosis


def test_numbers_that_contradict_each_other() -> None:
    asked = scenario(bounds={"force_min": 200.0, "force_max": 150.0})
    with pytest.raises(rg.NotSolvedError, match="no solution exists") as caught:
        rg.plan(asked, diagnose_seconds=PATIENT)
    diagnosis = caught.value.diagnosis
    assert terms(diagnosis) == {"force_limits"}
    assert diagnosis.reasons[0].excess == pytest.approx(50.0, rel=0.01)


def test_without_a_diagnosis() -> None:
    with pytest.raises(rg.NotSolvedError) as caught:
        rg.plan(scenario(bounds={"force_max": 100.0}), diagnose=False)
    assert caught.value.diagnosis is None


# -- within a budget ----------------------------------------------------------------------------------------

TOO_FAR = {"goal": {"x": 2.9}}


@pytest.mark.parametrize("iterations", [1, 5, 40])
def test_it_ends_when_its_iterations_are_spent(iterations: int) -> None:
    heard: list[str] = []
    diagnosis = rg.diagnose(
        scenario(**TOO_FAR),
        seconds=PATIENT,
        iterations=iterations,
        progress=lambda iteration: heard.append(iteration.task),
    )
    assert len(heard) <= iterations + 1  # IPOPT tells of its start, too
    assert not diagnosis.complete
    assert "before all was tried" in str(diagnosis)
    assert diagnosis.suggestions  # the best answer so far
    assert not any(suggestion.verified for suggestion in diagnosis.suggestions)
    assert "worth a try:" in str(diagnosis)


def test_it_ends_when_its_time_is_up() -> None:
    heard: list[str] = []
    diagnosis = rg.diagnose(
        scenario(**TOO_FAR, horizon=3.0),
        seconds=1e-3,
        progress=lambda iteration: heard.append(iteration.task),
    )
    assert len(heard) <= 2  # building takes longer than that: no solver gets beyond its first iteration
    assert not diagnosis.complete


def test_a_plan_that_fails_comes_back_within_the_time_for_its_diagnosis() -> None:
    heard: list[str] = []
    with pytest.raises(rg.NotSolvedError) as caught:
        rg.plan(
            scenario(bounds={"force_max": 100.0}),
            diagnose_seconds=1e-3,
            progress=lambda iteration: heard.append(iteration.task),
        )
    assert not caught.value.diagnosis.complete
    assert sum(task != "solving" and not task.startswith("solving, start") for task in heard) <= 4


def test_progress_says_what_is_tried() -> None:
    heard: dict[str, None] = {}
    rg.diagnose(
        scenario(**TOO_FAR), seconds=PATIENT, progress=lambda iteration: heard.setdefault(iteration.task)
    )
    tasks = list(heard)
    assert tasks[:2] == [
        "looking for the reason with the goal almost free",
        "looking for the reason with the goal demanded",
    ]
    assert any(task.startswith("trying a goal nearer: ") for task in tasks)
    assert any(task.startswith("trying a longer horizon: ") for task in tasks)


@pytest.mark.parametrize("seconds", [0.0, -1.0, np.nan])
def test_a_budget_that_is_none_is_refused(seconds: float) -> None:
    with pytest.raises(rg.InputError, match=r"seconds: .* must be a positive number of seconds"):
        rg.diagnose(scenario(), seconds=seconds)
    with pytest.raises(rg.InputError, match=r"diagnose_seconds: .* must be a positive number of seconds"):
        rg.plan(scenario(), diagnose_seconds=seconds)
    with pytest.raises(rg.InputError, match="iterations: 0 must be at least 1"):
        rg.diagnose(scenario(), iterations=0)


# -- with nothing in the way --------------------------------------------------------------------------------


def test_where_nothing_is_in_the_way_the_next_step_is_tried() -> None:
    asked = scenario()
    diagnosis = Investigation(asked, (), True, None, Budget(PATIENT), has_failed=True).diagnosis()
    assert not diagnosis.reasons
    (step,) = diagnosis.suggestions
    assert step.change == {"interval": 0.05}
    assert_helps(asked, step)


def test_next_steps_for_which_there_is_no_time_are_named() -> None:
    budget = Budget(PATIENT)
    why = Investigation(scenario(), (), True, None, budget, has_failed=True)
    spend = budget.counting("a test", None)
    for number in range(ITERATIONS):
        spend(Iteration(number, 0.0, 0.0))
    diagnosis = why.diagnosis()
    assert {"interval", "horizon"} <= keys(diagnosis)
    assert "--starts 8" in str(diagnosis)
    assert "worth a try:" in str(diagnosis)


# -- as text and data ------------------------------------------------------------------------------------


def test_text_is_aligned_and_data_is_plain() -> None:
    diagnosis = Diagnosis(
        (
            Reason("box", "the foot would have to leave its box", "FL", 1.0, 2.0, 0.0123, "m"),
            Reason("level_at_end", "the base would not end level", None, 3.0, 3.0, 0.5, "rad"),
        ),
        (Suggestion({"goal.x": 0.5, "bounds.box": [0.1, 0.2, 0.3]}, "a goal nearer", True),),
    )
    lines = str(diagnosis).splitlines()
    assert lines[1].index("by 0.0123 m") == lines[2].index("by 0.5 rad")
    assert "--set goal.x=0.5" in lines[4]
    assert "--set bounds.box=[0.1,0.2,0.3]" in lines[4]
    data = diagnosis.to_dict()
    assert data["reasons"][0]["leg"] == "FL"
    assert data["suggestions"][0]["verified"]
    assert len(diagnosis.suggestions) <= MAX_SUGGESTIONS


def test_what_was_tried_in_vain_is_named() -> None:
    text = str(Diagnosis(failed=("a finer mesh", "more initial guesses: 5")))
    assert text.splitlines()[1:] == [
        "tried, and does not help:",
        "  a finer mesh",
        "  more initial guesses: 5",
    ]


def test_a_margin_of_the_com_that_cannot_be_kept_is_named_and_made_smaller() -> None:
    """A triangle of feet is not wide enough for it."""
    crawl = {"kind": "schedule", "FL": [[1.0, 2.0]]}
    asked = scenario(gait=crawl, bounds={"com_margin": 0.4})
    diagnosis = rg.diagnose(asked, seconds=PATIENT)
    assert terms(diagnosis) == {"com_margin"}
    (reason,) = diagnosis.reasons
    assert (reason.leg, reason.unit) == (None, "m")
    assert reason.begin >= 0.9
    assert reason.end <= 2.1
    assert "feet that stand" in reason.description
    assert "bounds.com_margin" in keys(diagnosis)
    assert_helps(asked, next(s for s in diagnosis.suggestions if "bounds.com_margin" in s.change))
