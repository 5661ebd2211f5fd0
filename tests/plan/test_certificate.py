"""The certificate passes what is right by construction, and fails in the row in which a plan is spoilt."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import tests.plan.builders as b
from rollgait.errors import UnknownNameError
from rollgait.plan import Plan
from rollgait.plan.certificate import Certificate, certify
from rollgait.plan.certificate.rows import nearness

LOADS = {"payload": {"mass": 20.0, "at": [0.1, 0.15, 0.3], "size": [0.3, 0.2, 0.1]}}

RIGHT: dict[str, Callable[[], Plan]] = {
    "standing": lambda: b.standing(b.scenario()),
    "driving": b.driving,
    "driving on fixed wheels": lambda: b.driving(b.robot("fixed")),
    "turning": b.turning,
    "stepping": b.stepping,
    "stepping on fixed wheels": lambda: b.stepping(b.robot("fixed")),
    "stepping on point feet": lambda: b.stepping(b.robot("point")),
    "stepping, wheels locked": lambda: b.stepping(gait=b.STEPPING["gait"] | {"wheels": "locked"}),
    "without limbs": lambda: b.driving(b.robot(limbs=False)),
    "on an unequal mesh": b.stepping_on_an_unequal_mesh,
    "on another mesh than asked": lambda: b.asked(b.stepping(), interval=0.05),
    "carrying a load": lambda: carrying(),
    "paper": lambda: b.stepping(profile="paper"),
    "one interval": lambda: b.standing(b.scenario(horizon=0.1)),
    "many intervals": lambda: b.standing(b.scenario(horizon=10.0, interval=0.01)),
}


@pytest.mark.parametrize("name", RIGHT)
def test_what_is_right_passes(name: str) -> None:
    certificate = RIGHT[name]().certificate()
    assert certificate.passed, "\n".join(map(str, certificate.failures))


FL, FR, HL, HR = range(4)
END = -1
"""Last interval."""


def _turned(plan: Plan, interval: int, angle: float) -> Plan:
    """Shifts the yaw of everything from an interval on."""
    return b.spoilt(plan, "base", np.s_[interval:, :, 3], angle)


def _launched(plan: Plan, component: int, speed: float) -> Plan:
    """Changes a velocity from the start on."""
    return b.spoilt(plan, "base_rate", np.s_[:, :, component], speed)


def _lifted(plan: Plan, leg: int, place: Any, by: float) -> Plan:
    return b.spoilt(plan, "foot_z", (*place, leg), by)


def carrying() -> Plan:
    """Standing under a load."""
    return b.standing(b.scenario(loads=LOADS))


def another(figure: str, value: Any) -> Plan:
    """Driving with a robot of which a figure is another than asked."""
    plan = b.driving()
    return replace(plan, robot=plan.robot.with_values({figure: value}))


def between_samples() -> Plan:
    """Stands in one long interval where a short step was asked for, which no sample meets."""
    standing = b.standing(b.scenario(horizon=4.0, interval=4.0))
    return b.asked(standing, interval=0.05, gait={"kind": "schedule", "FL": [[1.75, 1.85]]})


drive, turn, step, uneven = b.driving, b.turning, b.stepping, b.stepping_on_an_unequal_mesh

SPOILT: dict[str, list[Callable[[], Plan]]] = {
    "mesh": [
        lambda: b.spoilt(uneven(), "lengths", 5, 1e-3),
        lambda: b.spoilt(uneven(), "lengths", 5, -0.2),
        lambda: replace(uneven(), schedule=uneven().scenario.schedule),
        lambda: b.asked(step(), horizon=4.1),
    ],
    **{
        row: [lambda: b.asked(drive(), loads=LOADS), lambda: b.asked(carrying(), loads={})]
        for row in ("load_mass", "load_place", "load_inertia")
    },
    "robot": [
        lambda: another("mass", 100.001),
        lambda: another("legs.HR.limb.extension", [0.2, 0.8]),
        lambda: another("legs.FL.force_max", 3000.0),
        lambda: another("legs.FL.wheel_radius", 0.11),
    ],
    "finite": [lambda: b.spoilt(drive(), "force", (3, FL, 0), np.nan)],
    "schedule": [
        lambda: b.changed(step(), contact=np.roll(step().schedule.contact.T, 1, axis=0)),
        lambda: b.asked(step(), gait__HL=[[0.5, 1.6]]),
        lambda: b.asked(step(), interval=0.15),
        between_samples,
    ],
    "position_defect": [
        lambda: b.spoilt(drive(), "base", (5, 1, 1), 1e-3),
        lambda: b.spoilt(drive(), "base", np.s_[5:, :, 1], 2e-4),
    ],
    "angle_defect": [
        lambda: b.spoilt(drive(), "base", (5, 2, 5), 5e-3),
        lambda: _turned(drive(), 5, 2e-3),
        lambda: _turned(drive(), 5, 2.0 * np.pi),
    ],
    "velocity_defect": [
        lambda: b.spoilt(drive(), "base_rate", (5, 3, 0), 5e-3),
        lambda: b.spoilt(drive(), "force", (5, slice(None), 1), 5.0),
    ],
    "angular_velocity_defect": [
        lambda: b.spoilt(drive(), "base_rate", (5, 3, 3), 0.05),
        lambda: b.spoilt(drive(), "force", (5, [FL, FR], 0), [20.0, -20.0]),
    ],
    "foot_defect": [
        lambda: b.spoilt(drive(), "motion", (5, HL, 0), 0.01),
        lambda: b.spoilt(drive(), "foot_xy", np.s_[5:, :, HL, 0], 2e-4),
        lambda: b.spoilt(drive(b.robot("fixed")), "foot_xy", np.s_[5:, :, HL, 1], 2e-4),
    ],
    "heading_defect": [
        lambda: b.spoilt(turn(), "motion", (5, HL, 1), 0.05),
        lambda: b.spoilt(turn(), "heading", np.s_[5:, :, HL], 2e-3),
    ],
    "stance_height": [lambda: _lifted(drive(), FR, np.s_[7:9, :], 1e-3)],
    "stance_slip": [
        lambda: b.spoilt(drive(), "foot_xy", (5, 2, FL, 1), 2e-3),
        lambda: b.spoilt(turn(), "heading", np.s_[:, :, FL], 0.05),
        lambda: b.spoilt(step(b.robot("point")), "foot_xy", (5, 2, FL, 0), 2e-3),
    ],
    "swing_clearance": [
        lambda: b.asked(step(), gait__clearance=0.09),
        lambda: _lifted(step(), HL, np.s_[10, 0], -0.002),
    ],
    "swing_ground": [lambda: _lifted(step(), HL, np.s_[5, 1], -0.02)],
    "touchdown_speed": [lambda: _lifted(step(), HL, np.s_[14, 2], 0.01)],
    "touchdown_drift": [
        lambda: b.asked(
            b.spoilt(step(b.robot("point")), "foot_xy", (14, 2, HL, 1), 0.01), bounds__touchdown_drift=0.05
        )
    ],
    "friction_margin": [
        lambda: b.asked(drive(), ground__friction=0.01),
        lambda: b.spoilt(drive(), "force", (5, HR, 1), -200.0),
        lambda: b.spoilt(step(b.robot("point")), "force", (5, HR, 0), 300.0),
    ],
    "friction_cone": [
        lambda: b.asked(drive(), ground__friction=0.01, bounds__inscribed=True),
        lambda: b.spoilt(b.asked(drive(), bounds__inscribed=True), "force", (5, HR, [0, 1]), 100.0),
    ],
    "force_min_margin": [
        lambda: b.asked(drive(), bounds__force_min=400.0),
        lambda: b.asked(drive(), profile="paper", bounds__force_min=400.0),
        lambda: b.spoilt(drive(), "force", (5, HR, 2), -1000.0),
    ],
    "force_max_margin": [
        lambda: b.asked(drive(), bounds__force_max=200.0),
        lambda: b.spoilt(drive(), "force", (5, HR, 2), 1500.0),
    ],
    "com_margin": [
        lambda: b.asked(step(), bounds__com_margin=0.04),
        lambda: b.spoilt(step(), "base", np.s_[5:15, :, 0], -0.04),
        lambda: b.spoilt(step(), "base", np.s_[7, 3, 0], -0.04),
    ],
    "capture_margin": [
        lambda: b.asked(step(), bounds__capture_margin=0.04),
        lambda: b.spoilt(step(), "base_rate", np.s_[5:15, :, 0], -0.4),
        lambda: b.spoilt(step(), "foot_xy", np.s_[7, 1:, [FL, FR, HR], 0], 0.02),
    ],
    "swing_force": [lambda: b.spoilt(step(), "force", (7, HL, 1), 1.0)],
    "box_margin": [
        lambda: b.asked(step(), bounds__box=[0.2, 0.2, 0.07]),
        lambda: b.spoilt(drive(), "foot_xy", np.s_[:, :, FL, 0], 0.21),
        lambda: b.spoilt(b.asked(drive(), bounds__full_rotation=True), "base", np.s_[:, :, 4], 0.4),
    ],
    "steering_margin": [
        lambda: b.spoilt(b.driving(b.robot(limbs=False)), "heading", np.s_[5:, :, HL], 1.6),
        lambda: b.spoilt(b.driving(profile="paper"), "heading", np.s_[5:, :, HL], 2.0 * np.pi),
        lambda: b.asked(b.spoilt(drive(), "heading", np.s_[:], 0.1), bounds__steering_deg=[-1.0, 1.0]),
    ],
    "steering_rate_margin": [
        lambda: b.asked(turn(), bounds__steering_rate_max=0.1),
        lambda: b.spoilt(turn(), "motion", (5, HL, 1), -2.5),
    ],
    "stance_speed_margin": [
        lambda: b.asked(drive(), bounds__speed_max=0.4),
        lambda: b.spoilt(drive(), "motion", (5, HL, 0), -1.3),
    ],
    "swing_speed_margin": [
        lambda: b.spoilt(step(), "motion", (7, HL, 0), 2.0),
        lambda: b.spoilt(step(b.robot("point")), "foot_xy", (7, 2, HL, 1), 0.2),
        lambda: b.spoilt(step(b.robot("fixed")), "foot_xy", (7, 2, HL, 1), 0.2),
    ],
    "acceleration": [
        lambda: b.asked(drive(), bounds__acceleration_max=0.4),
        lambda: b.spoilt(drive(), "motion", (0, FL, 0), 0.3),
        lambda: b.spoilt(drive(b.robot("fixed")), "motion", (5, FL, 0), 0.3),
    ],
    "swing_acceleration": [
        lambda: b.spoilt(step(), "motion", (7, HL, 0), 1.4),
        lambda: b.spoilt(step(), "motion", (14, HL, 0), 1.4),
        lambda: b.spoilt(step(b.robot("point")), "motion", (7, HL, 1), 1.4),
        lambda: b.spoilt(step(b.robot("fixed")), "motion", (7, HL, 1), 1.4),
    ],
    "hip_yaw_margin": [lambda: b.spoilt(drive(), "foot_xy", np.s_[5:8, :, FL], [-0.6, -0.2])],
    "steering_joint_margin": [lambda: b.spoilt(drive(), "heading", np.s_[5:, :, FL], -2.0)],
    "reach_margin": [
        lambda: b.spoilt(drive(), "base", np.s_[:, :, 2], 0.15),
        lambda: b.asked(drive(), bounds__reach_margin=0.2),
    ],
    "radius_margin": [lambda: b.spoilt(drive(), "foot_xy", np.s_[:, :, FL], [-0.2, -0.15])],
    "start_position": [
        lambda: b.asked(drive(), start__x=0.01),
        lambda: b.spoilt(drive(), "base", np.s_[:, :, 2], 1e-3),
    ],
    "start_angle": [
        lambda: b.asked(drive(), start__yaw_deg=1.0),
        lambda: b.spoilt(drive(), "base", np.s_[:, :, 5], 0.01),
    ],
    "start_velocity": [lambda: _launched(drive(), 1, 0.01)],
    "start_rate": [lambda: _launched(drive(), 3, 0.01)],
    "start_feet": [lambda: b.spoilt(drive(), "foot_xy", np.s_[:, :, FL, 0], 1e-3)],
    "start_heading": [lambda: b.spoilt(turn(), "heading", np.s_[:, :, FL], 0.01)],
    "goal_distance": [
        lambda: b.asked(drive(), goal__x=0.52),
        lambda: b.asked(step(b.robot("point")), goal__x=0.025),
        lambda: b.asked(drive(), **{"goal__then": [{"at": 1.0, "x": 0.0}]}),
    ],
    "goal_yaw": [
        lambda: b.asked(drive(), goal__yaw_deg=1.1),
        lambda: b.asked(drive(), goal__yaw_deg=360.0),
    ],
    "end_velocity": [lambda: b.spoilt(drive(), "base_rate", np.s_[END, :, 1], 0.01)],
    "end_wheel_speed": [lambda: b.spoilt(drive(), "motion", (END, FL, 0), 0.01)],
    "end_rate": [lambda: b.spoilt(drive(), "base_rate", np.s_[END, :, 3], 0.01)],
    "end_level": [
        lambda: b.spoilt(drive(), "base", np.s_[END, :, 4], 0.01),
        lambda: b.spoilt(drive(), "base", np.s_[END, :, 5], -0.01),
    ],
    "end_feet": [lambda: b.spoilt(drive(), "foot_xy", np.s_[END, :, FL, 1], 2e-3)],
    "end_height": [lambda: b.spoilt(drive(), "base", np.s_[END, :, 2], -2e-3)],
}


@pytest.mark.parametrize(
    ("row", "number"), [(row, i) for row, all_ in SPOILT.items() for i in range(len(all_))]
)
def test_a_spoilt_number_fails_in_its_row(row: str, number: int) -> None:
    certificate = certify(SPOILT[row][number]())
    assert certificate.row(row).verdict == "fail", f"\n{certificate}"
    assert not certificate.passed
    assert certificate.row(row) in certificate.failures


def test_every_row_has_a_test_that_spoils_it() -> None:
    plans = [make() for make in RIGHT.values()]
    assert {row.name for plan in plans for row in plan.certificate().rows} == set(SPOILT)


@pytest.mark.parametrize(
    "name", ["base", "base_rate", "foot_xy", "heading", "foot_z", "force", "motion", "lengths"]
)
@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_a_number_that_is_none_fails_and_does_not_crash(name: str, value: float) -> None:
    plan = b.driving()
    place = (0,) * np.ndim(getattr(plan.trajectory, name))
    certificate = certify(b.spoilt(plan, name, place, value))
    assert not certificate.passed
    assert [row.name for row in certificate.failures] == ["mesh" if name == "lengths" else "finite"]
    json.dumps(certificate.to_dict(), allow_nan=False)


def test_a_wild_motion_fails_and_ends() -> None:
    """Of a motion that spins faster than the integrator is willing to follow, the defects are infinite."""
    certificate = certify(b.spoilt(b.driving(), "base_rate", np.s_[:, :, 4], 1e7))
    assert certificate.row("angle_defect").verdict == "fail"
    for name in ("position_defect", "velocity_defect", "angular_velocity_defect", "foot_defect"):
        assert certificate.row(name).verdict == "fail"
        assert certificate.row(name).worst == np.inf
    json.dumps(certificate.to_dict(), allow_nan=False)


def test_upside_down_and_at_90_degrees_of_pitch_is_judged() -> None:
    """The judge has no singular orientation."""
    for pitch in (np.pi / 2, np.pi):
        certificate = certify(b.spoilt(b.standing(b.scenario()), "base", np.s_[:, :, 4], pitch))
        assert certificate.row("angle_defect").verdict == "pass"
        assert certificate.row("angular_velocity_defect").verdict == "pass"


PAPER_LEAVES_OUT = {
    "friction_cone",
    "touchdown_speed",
    "com_margin",
    "capture_margin",
    "acceleration",
    "swing_acceleration",
    "hip_yaw_margin",
    "steering_joint_margin",
    "reach_margin",
    "radius_margin",
    "goal_distance",
    "goal_yaw",
    "end_rate",
    "end_level",
}


def test_profile_paper_does_not_promise_what_the_paper_leaves_open() -> None:
    certificate = b.stepping(profile="paper").certificate()
    assert {row.name for row in certificate.rows if row.verdict == "not promised"} == PAPER_LEAVES_OUT


def test_what_is_not_promised_does_not_count() -> None:
    plan = b.asked(b.stepping(profile="paper"), goal__x=0.3)
    row = plan.certificate().row("goal_distance")
    assert (row.verdict, row.worst) == ("not promised", pytest.approx(0.3))
    assert plan.certificate().passed


@pytest.mark.parametrize(
    ("term", "rows"),
    [
        ("friction", {"friction_margin"}),
        ("force_limits", {"force_min_margin", "force_max_margin"}),
        ("box", {"box_margin"}),
        ("reach", {"reach_margin", "radius_margin"}),
        ("clearance", {"swing_clearance"}),
        ("acceleration", {"acceleration", "swing_acceleration"}),
        ("level_at_end", {"end_rate", "end_level"}),
        ("terminal_goal", {"goal_distance", "goal_yaw"}),
        ("stance_height", {"stance_height"}),
        ("swing_speed", {"swing_speed_margin"}),
        ("com_margin", {"com_margin"}),
        ("capture_margin", {"capture_margin"}),
    ],
)
def test_a_term_that_is_left_out_promises_nothing(term: str, rows: set[str]) -> None:
    certificate = b.stepping(bounds={"without": [term]}).certificate()
    never = {"friction_cone"}  # but with `inscribed`
    assert {row.name for row in certificate.rows if row.verdict == "not promised"} == rows | never


@pytest.mark.parametrize("inscribed", [False, True])
def test_a_force_at_a_corner_of_the_pyramid_is_told_and_fails_where_the_cone_is_promised(
    inscribed: bool,
) -> None:
    """The paper's pyramid is around Coulomb's cone: at its corners it asks for √2 of what there is."""
    plan = b.driving(bounds={"inscribed": inscribed})
    force = plan.trajectory.force
    corner = np.abs(force[5, HR, 2]) * plan.scenario.ground.friction * 0.9 - force[5, HR, :2]
    rows = certify(b.spoilt(plan, "force", (5, HR, [0, 1]), corner))
    cone, pyramid = rows.row("friction_cone"), rows.row("friction_margin")
    assert cone.worst < 0.0
    assert (cone.verdict, pyramid.verdict) == (("fail",) * 2 if inscribed else ("not promised", "pass"))


def test_the_physics_is_always_promised() -> None:
    """No scenario can talk the judge out of the equations of motion."""
    plan = b.spoilt(b.driving(bounds={"without": ["dynamics"]}), "base", np.s_[5:, :, 1], 1e-3)
    assert certify(plan).row("position_defect").verdict == "fail"


def test_a_row_says_where_and_when() -> None:
    plan = b.spoilt(b.stepping(), "force", (7, HL, 1), 3.0)
    row = certify(plan).row("swing_force")
    assert (row.leg, row.unit, row.sense, row.limit) == ("HL", "N", "at most", 0.1)
    assert row.worst == pytest.approx(3.0)
    assert row.time == pytest.approx(0.7, abs=1e-3)
    assert str(row).split()[:2] == ["fail", "swing_force"]


def test_the_defect_is_found_in_the_interval_that_has_it() -> None:
    row = certify(b.spoilt(b.driving(), "base", (5, 2, 1), 1e-3)).row("position_defect")
    assert row.time is not None
    assert 0.5 <= row.time <= 0.6


def test_json_round_trip() -> None:
    certificate = b.turning().certificate()
    data = json.loads(json.dumps(certificate.to_dict(), allow_nan=False))
    assert data["passed"] is True
    assert [row["name"] for row in data["rows"]] == [row.name for row in certificate.rows]
    assert set(data["rows"][0]) >= {"name", "description", "worst", "limit", "unit", "leg", "time", "verdict"}


def test_an_unknown_row_names_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="friction_margin"):
        b.standing(b.scenario()).certificate().row("friction")


def test_a_certificate_without_failures_passes() -> None:
    assert Certificate(()).passed


def test_it_survives_saving(tmp_path: Any) -> None:
    plan = b.turning()
    assert Plan.load(plan.save(tmp_path / "plan")).certificate() == plan.certificate()


def test_it_believes_the_path_and_not_the_solver() -> None:
    """Whatever the statistics say, a plan is judged by its motion alone."""
    plan = b.driving()
    unsolved = replace(plan, statistics=replace(plan.statistics, solved=False, violation=1.0))
    assert unsolved.certificate() == plan.certificate()


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.booleans())
def test_what_is_nearer_than_its_limit_passes_and_nothing_else(
    worst: float, limit: float, at_least: bool
) -> None:
    assume(abs(worst - limit) > 1e-9 * max(abs(worst), abs(limit), 1e-300))  # not by rounding
    passes = worst >= limit if at_least else worst <= limit
    assert (nearness(worst, limit, at_least) <= 1.0) == passes
