"""The judge on ground that is not flat: on planes it knows what is right, and each row finds what is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import tests.plan.builders as b
from rollgait.plan import Plan
from rollgait.plan.certificate import certify
from rollgait.terrain import Terrain
from tests.plan.slopes import SLOPE, on, plane, standing_on_slope

FL, FR, HL, HR = range(4)
LEVEL = {"kind": "ramp", "x": -10.0, "length": 20.0, "rise": 1e-12}
FLAT = {
    "a ramp of 0°": Terrain.from_parts([LEVEL]),
    "a map of equal heights": Terrain.from_map(np.zeros((61, 61)), 0.1, (-3.0, -3.0)),
    "a part far away": Terrain.from_parts([{"kind": "step", "x": 30.0, "height": 0.2}]),
}
PLANS: dict[str, Callable[[], Plan]] = {
    "driving": b.driving,
    "turning": b.turning,
    "stepping": b.stepping,
    "stepping on point feet": lambda: b.stepping(b.robot("point")),
    "stepping on fixed wheels": lambda: b.stepping(b.robot("fixed")),
}
RADIUS = 0.1
FRONT = 0.3
"""x of the front wheels of the builders' robot, m."""


@pytest.mark.parametrize("ground", FLAT)
@pytest.mark.parametrize("name", PLANS)
def test_ground_that_happens_to_be_flat_is_judged_as_flat(name: str, ground: str) -> None:
    plan = PLANS[name]()
    flat, other = plan.certificate(), certify(on(plan, FLAT[ground]))
    assert other.passed, "\n".join(map(str, other.failures))
    for row in flat.rows:
        if row.name != "stance_height":  # there it is depth and gap
            found = other.row(row.name)
            assert found.verdict == row.verdict
            if row.name == "box_margin":  # there reach and hip say how high and low a foot may be
                assert found.worst >= row.worst - 1e-4
                continue
            # feet are looked at from a base that pitches by 1e-5 rad as it drives
            assert found.worst == pytest.approx(row.worst, abs=1e-4), row.name


@pytest.mark.parametrize("foot", ["steerable", "fixed", "point"])
def test_standing_and_stepping_on_a_slope_passes(foot: str) -> None:
    certificate = standing_on_slope(body=b.robot(foot)).certificate()
    assert certificate.passed, "\n".join(map(str, certificate.failures))


@pytest.mark.parametrize("yaw", [0.7, -2.0])
def test_a_turned_world_gives_the_same_rows(yaw: float) -> None:
    straight, turned = standing_on_slope().certificate(), standing_on_slope(yaw).certificate()
    assert [row.name for row in turned.rows] == [row.name for row in straight.rows]
    for one, other in zip(straight.rows, turned.rows, strict=True):
        assert other.worst == pytest.approx(one.worst, abs=1e-7), one.name
        assert other.verdict == one.verdict


def _level(foot: str = "steerable") -> Plan:
    return b.standing(b.scenario(b.robot(foot)))


def _moved(plan: Plan, name: str, place: Any, by: Any) -> Plan:
    return b.spoilt(plan, name, place, by)


def _gap(distance: float) -> Terrain:
    """A ditch that begins so far ahead of the front wheels."""
    return Terrain.from_parts([{"kind": "gap", "x": FRONT + distance, "length": 0.5}])


def _riser(distance: float, height: float) -> Terrain:
    """A step so far ahead of where the rims of the front wheels would touch it."""
    under = max(RADIUS - height, 0.0)
    touch = np.sqrt(RADIUS**2 - under**2)
    return Terrain.from_parts([{"kind": "step", "x": FRONT + touch + distance, "height": height}])


def _with_hole(at: float) -> Terrain:
    heights = np.zeros((301, 301))
    x = -1.5 + 0.01 * np.arange(301)
    heights[np.abs(x - FRONT - at) < 0.011, :] = np.nan
    return Terrain.from_map(heights, 0.01, (-1.5, -1.5))


def _elsewhere(plan: Plan) -> Plan:
    """The same with another start: under that, holes are filled from what is around them."""
    start = plan.scenario.start.model_copy(update={"x": 1.2})
    return replace(plan, scenario=plan.scenario.model_copy(update={"start": start}))


def _block(height: float) -> Terrain:
    """Something under the hind left foot, narrower than its wheel."""
    return Terrain.from_parts(
        [{"kind": "block", "x": -0.4, "y": 0.35, "length": 0.02, "width": 0.1, "height": height}]
    )


def _jumping() -> Plan:
    """A foot is 5 cm above the ground as soon as it leaves it, and comes down evenly from there."""
    plan, height, swing = standing_on_slope(), 0.05, slice(5, 15)
    falls = height * (1.0 - np.arange(10) / 10)
    plan = b.spoilt(plan, "foot_z", (swing, HL), falls)
    return b.spoilt(plan, "lift_rate", (swing, HL), -height / float(plan.schedule.lengths[swing].sum()))


slope = standing_on_slope

SPOILT: dict[str, list[Callable[[], Plan]]] = {
    "stance_depth": [
        lambda: _moved(slope(), "foot_z", np.s_[7:9, FR], -1e-3),
        lambda: on(slope(), plane(SLOPE, height=1e-3)),
        lambda: on(_level(), _riser(-0.02, 0.05)),
        lambda: on(_level(), _block(0.01)),
    ],
    "stance_gap": [
        lambda: _moved(slope(), "foot_z", np.s_[7:9, FR], 1e-3),
        lambda: on(slope(), plane(SLOPE, height=-1e-3)),
        lambda: _elsewhere(on(_level(), _with_hole(0.0))),
    ],
    "swing_ground": [
        lambda: _moved(slope(), "foot_z", np.s_[5:8, HL], -0.1),
        lambda: on(b.stepping(), _block(0.3)),
    ],
    "swing_clearance": [
        lambda: _moved(slope(), "foot_z", np.s_[5:15, HL], -0.004),
        lambda: on(b.stepping(), _block(0.03)),
    ],
    "touchdown_speed": [lambda: _moved(slope(), "lift_rate", (14, HL), -0.1)],
    "foot_defect": [_jumping],
    "contact_place": [
        lambda: _moved(slope(), "ground", (5, FL, 8), 0.3),
        lambda: on(slope(), plane(-SLOPE)),
    ],
    "edge_distance": [
        lambda: on(_level(), _gap(0.02)),
        lambda: on(_level("point"), _gap(0.02)),
        lambda: on(_level(), _riser(0.02, 0.05)),
        lambda: on(_level(), _riser(0.02, 0.5)),
    ],
    "unknown_ground": [lambda: _elsewhere(on(_level(), _with_hole(0.01)))],
    "friction_margin": [
        lambda: on(slope(), plane(SLOPE, friction=0.12)),
        lambda: _moved(slope(), "force", (5, FR, 1), 100.0),
    ],
    "force_max_margin": [lambda: b.asked(slope(), bounds__force_max=200.0)],
    "angular_velocity_defect": [lambda: _moved(slope(), "force", np.s_[5, [FL, FR], 2], [20.0, -20.0])],
    "stance_speed_margin": [
        lambda: b.asked(_moved(slope(), "motion", (5, FL, 0), 1.0), bounds__speed_max=1.005),
    ],
    "box_margin": [
        lambda: _moved(slope(), "r", np.s_[:, 0], 0.2),
        lambda: b.asked(_moved(slope(), "theta", np.s_[:, 1], 0.4), bounds__full_rotation=True),
    ],
    "reach_margin": [lambda: _moved(slope(), "r", np.s_[:, 2], 0.15)],
    "start_position": [lambda: _moved(slope(), "r", np.s_[:, 2], 1e-3)],
    "start_angle": [lambda: _moved(slope(), "theta", np.s_[:, 1], 2e-3)],
    "start_feet": [lambda: _moved(slope(), "foot_xy", np.s_[:, FL, 0], 1e-3)],
    "end_level": [lambda: _moved(slope(), "theta", np.s_[-1, 2], 2e-3)],
    "end_height": [lambda: _moved(slope(), "r", np.s_[-1, 2], -2e-3)],
    "end_feet": [lambda: _moved(slope(), "foot_xy", np.s_[-1, FL, 1], 2e-3)],
}


@pytest.mark.parametrize(
    ("row", "number"), [(row, i) for row, all_ in SPOILT.items() for i in range(len(all_))]
)
def test_what_is_spoilt_fails_in_its_row(row: str, number: int) -> None:
    certificate = certify(SPOILT[row][number]())
    assert certificate.row(row).verdict == "fail", f"\n{certificate}"


def test_every_row_of_the_ground_alone_has_a_test_that_spoils_it() -> None:
    flat = {row.name for row in b.stepping().certificate().rows}
    rows = {row.name for row in standing_on_slope().certificate().rows}
    assert rows - flat <= set(SPOILT)
    assert flat - rows == {"stance_height"}


@pytest.mark.parametrize(
    ("terrain", "distance"),
    [
        (_gap(0.035), 0.035),
        (_riser(0.035, 0.05), 0.035),
        (_riser(0.035, 0.5), 0.035),
        (_riser(-0.01, 0.004), None),  # rolled over, so no edge
        (Terrain.from_parts([{"kind": "ramp", "x": FRONT + 0.02, "length": 2.0, "slope_deg": 20.0}]), None),
    ],
)
def test_how_far_edges_are(terrain: Terrain, distance: float | None) -> None:
    row = certify(on(_level(), terrain)).row("edge_distance")
    assert row.verdict == "pass"
    assert row.worst == pytest.approx(0.05 if distance is None else distance, abs=5e-4)


def test_the_force_acts_where_the_wheel_touches_the_ground() -> None:
    """Forces in balance about the lowest points of the rims, 1.5 cm beside the contacts, are in none."""
    plan = standing_on_slope()
    right = plan.certificate().row("angular_velocity_defect").worst
    as_points = standing_on_slope(body=b.robot().model_copy(update={"legs": _without_radius()}))
    force = as_points.trajectory.arrays()["force"]
    wrong = certify(b.changed(plan, force=force)).row("angular_velocity_defect")
    assert right < 1e-9
    assert wrong.verdict == "fail"


def _without_radius() -> Any:
    legs = b.robot("point").legs
    bare = {name: leg.model_copy(update={"wheel_radius": None}) for name, leg in legs}
    return legs.model_copy(update=bare)


def test_an_upright_disc_may_stand_lower_than_a_ball_across_a_slope() -> None:
    """Plans reckon with a ball; the disc that a wheel is has room below, which is no depth."""
    plan = standing_on_slope(np.pi / 2.0)
    assert plan.certificate().row("stance_depth").worst == 0.0
    assert plan.certificate().row("stance_gap").worst < 1e-9


def test_samples_say_where_the_ground_is_touched() -> None:
    plan = standing_on_slope()
    s = plan.sample([0.0, 1.0])
    n = np.array([-SLOPE[0], -SLOPE[1], 1.0]) / np.sqrt(1.0 + SLOPE @ SLOPE)
    np.testing.assert_allclose(s.contact_normal[0], np.tile(n, (4, 1)), atol=1e-12)
    c = s.contact_position[0]
    np.testing.assert_allclose(c[:, 2], c[:, :2] @ SLOPE, atol=1e-12)
    centre = s.foot_position[0] + [0.0, 0.0, RADIUS]
    np.testing.assert_allclose(c + RADIUS * n, centre, atol=1e-12)
    np.testing.assert_array_equal(s.contact_position[1, HL], s.foot_position[1, HL])  # in the air
    np.testing.assert_array_equal(s.contact_normal[1, HL], [0.0, 0.0, 1.0])
    level = b.stepping().sample([0.0, 1.0])
    np.testing.assert_array_equal(level.contact_position, level.foot_position)
