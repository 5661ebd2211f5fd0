"""Whatever comes from above, what goes to the drives keeps the bounds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rollgait.errors import InputError
from rollgait.hardware.last_stage import PERIODS_MAX, Bounds, LastStage, StageLimits, bounds_of
from rollgait.robot.urdf_model import load_model
from rollgait.robot.whole_body import library_whole_body
from rollgait.tracking.follower import JointTarget

PERIOD = 0.01
COUNT = 3
BOUNDS = Bounds(
    position_low=np.array([-1.0, -np.inf, -2.0]),
    position_high=np.array([1.0, np.inf, 2.0]),
    speed=np.array([2.0, 20.0, 5.0]),
    torque=np.array([100.0, 30.0, 50.0]),
    lead=np.array([0.3, np.inf, 0.3]),
)
ANY = st.floats(width=64, allow_nan=True, allow_infinity=True)
ROW = st.lists(ANY, min_size=COUNT, max_size=COUNT).map(np.array)
TARGET = st.builds(JointTarget, ROW, ROW, ROW)
PLACE = st.lists(st.floats(-1.0, 1.0), min_size=COUNT, max_size=COUNT).map(np.array)


def begun(at: np.ndarray) -> LastStage:
    stage = LastStage(("hip", "wheel", "knee"), BOUNDS, PERIOD)
    stage.begin(at, 0.0)
    return stage


@given(PLACE, st.lists(st.tuples(TARGET, st.none() | PLACE, st.floats(0.0, 1.0)), max_size=6))
def test_no_target_passes_a_bound(
    at: np.ndarray, told: list[tuple[JointTarget, np.ndarray | None, float]]
) -> None:
    stage, time, before = begun(at), 0.0, at
    for target, measured, pause in told:
        time += pause
        got = stage.let_through(target, measured, time)
        for part in (got.position, got.velocity, got.torque):
            assert np.isfinite(part).all()
        assert np.all(np.abs(got.position - before) <= BOUNDS.speed * PERIODS_MAX * PERIOD + 1e-12)
        assert np.all(np.abs(got.velocity) <= BOUNDS.speed)
        assert np.all(np.abs(got.torque) <= BOUNDS.torque)
        before = got.position


@given(PLACE)
def test_what_keeps_the_bounds_goes_through_unchanged(at: np.ndarray) -> None:
    stage = begun(at)
    step = 0.5 * BOUNDS.speed * PERIOD
    target = JointTarget(np.clip(at + step, -1.0, 1.0), 0.5 * BOUNDS.speed, -0.5 * BOUNDS.torque)
    got = stage.let_through(target, at, PERIOD)
    for part in ("position", "velocity", "torque"):
        np.testing.assert_array_equal(getattr(got, part), getattr(target, part))
    assert stage.cut == ""
    assert stage.cuts == 0


def test_a_joint_that_is_stuck_is_pulled_no_further() -> None:
    stage, still = begun(np.zeros(COUNT)), np.zeros(COUNT)
    for k in range(1, 200):
        got = stage.let_through(JointTarget(np.full(COUNT, 0.9), still, still), still, k * PERIOD)
    assert got.position[0] == pytest.approx(0.3)
    assert got.position[1] == pytest.approx(0.9)  # a wheel has no lead
    assert "lead" in stage.cut
    assert "hip" in stage.cut or "knee" in stage.cut


def test_what_is_no_number_becomes_a_hold() -> None:
    stage = begun(np.full(COUNT, 0.2))
    bad = JointTarget(np.full(COUNT, np.nan), np.ones(COUNT), np.zeros(COUNT))
    got = stage.let_through(bad, None, PERIOD)
    np.testing.assert_array_equal(got.position, np.full(COUNT, 0.2))
    np.testing.assert_array_equal(got.velocity, np.zeros(COUNT))
    assert stage.cuts == 1


def test_nothing_goes_through_before_somebody_says_where_the_joints_are() -> None:
    stage = LastStage(("a",), BOUNDS, PERIOD)
    with pytest.raises(RuntimeError, match="where the joints are"):
        stage.hold(0.0)


@pytest.mark.parametrize("name", ["centauro", "rover", "strider"])
def test_bounds_of_robots_are_those_of_their_urdf_times_the_share(name: str) -> None:
    model = load_model(library_whole_body(name))
    half = bounds_of(model, StageLimits(speed_share=0.5, torque_share=0.25))
    np.testing.assert_allclose(half.speed, 0.5 * model.velocity_max)
    np.testing.assert_allclose(half.torque, 0.25 * model.effort_max)
    wheels = [leg.wheel - 6 for leg in model.legs if leg.wheel is not None]
    assert np.isinf(half.lead[wheels]).all()


def test_a_share_is_positive() -> None:
    with pytest.raises(InputError, match="speed_share"):
        StageLimits(speed_share=0.0)
