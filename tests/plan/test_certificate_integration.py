"""The judge's integration against SciPy's DOP853 and motions that are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import tests.plan.builders as b
from rollgait.plan import Plan
from rollgait.plan.certificate.case import Case
from rollgait.plan.certificate.defects import integrated_states, planned_states
from rollgait.plan.certificate.integration import PANELS, TooWildError, integrate
from rollgait.plan.certificate.motion import SAMPLES, DenseMotion, interpolation
from rollgait.plan.certificate.physics import BodyState, Inputs, derivative

TIMES = np.array([0.0, 0.1, 0.4, 0.7, 1.0])


def turning(rate: float, guess: float = 0.0) -> np.ndarray:
    """A point on a circle at `TIMES`, (5, 1, 2), integrated."""
    turn = rate * np.array([[0.0, 1.0], [-1.0, 0.0]])
    return integrate(
        lambda t, y: y @ turn,
        np.array([[1.0, 0.0]]),
        TIMES,
        lambda t: np.full((t.size, 1, 2), guess),
    )


@given(st.floats(-20.0, 20.0), st.floats(-1e3, 1e3))
def test_a_circle_is_found_from_any_guess(rate: float, guess: float) -> None:
    """Slow or fast: also where one panel is not enough."""
    angle = rate * TIMES
    expected = np.stack([np.cos(angle), np.sin(angle)], axis=-1)[:, None]
    np.testing.assert_allclose(turning(rate, guess), expected, atol=1e-7)


@pytest.mark.parametrize("rate", [1e3, 1e6, np.inf, np.nan])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_what_is_too_wild_ends(rate: float) -> None:
    with pytest.raises(TooWildError):
        turning(rate)


def test_a_motion_without_end_is_too_wild() -> None:
    """y' = y² from 1 is infinite at t = 1."""
    with pytest.raises(TooWildError), np.errstate(all="ignore"):
        integrate(lambda t, y: y * y, np.ones((1, 1)), 1.1 * TIMES, lambda t: np.ones((t.size, 1, 1)))


def test_what_one_panel_cannot_show_is_cut() -> None:
    """A pulse of 0.2 s: twelve points in a second would smear it."""
    asked: set[int] = set()

    def slope(t: np.ndarray, y: np.ndarray) -> np.ndarray:
        asked.add(round(1.0 / (t[-1] - t[0])))
        return np.broadcast_to(10.0 * np.exp(-(((t - 0.45) / 0.2) ** 2))[:, None, None], y.shape)

    found = integrate(slope, np.zeros((1, 1)), TIMES, lambda t: np.zeros((t.size, 1, 1)))
    exact = solve_ivp(
        lambda t, y: 10.0 * np.exp(-(((t - 0.45) / 0.2) ** 2)) + 0.0 * y,
        (0.0, 1.0),
        [0.0],
        "DOP853",
        TIMES,
        rtol=1e-12,
        atol=1e-13,
    )
    assert asked == set(PANELS)
    np.testing.assert_allclose(found[:, 0, 0], exact.y[0], atol=1e-7)


def by_scipy(case: Case, planned: BodyState) -> np.ndarray:
    """The same intervals by SciPy, (N, K + 1, 34)."""
    motion = case.motion
    h, count = motion.lengths[:, None], motion.stance.shape[0]
    along, across = case.planar_speeds
    at = motion.at
    inputs = Inputs(at.force, along, across, at.foot_velocity[..., 2], at.heading_rate).flat()

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        now = Inputs.from_flat(np.einsum("k,nku->nu", interpolation(motion.tau[0] + t), inputs))
        return (h * derivative(case.robot, BodyState.from_flat(y.reshape(count, -1)), now).flat()).ravel()

    times = np.append(motion.tau - motion.tau[0], 1.0)
    begin = planned.flat()[:, 0].ravel()
    found = solve_ivp(slope, (0.0, 1.0), begin, "DOP853", times, rtol=1e-11, atol=1e-12)
    return np.moveaxis(found.y.reshape(count, -1, SAMPLES + 1), 2, 1)


def agree(plan: Plan) -> None:
    case = Case(plan, DenseMotion.of(plan))
    planned = planned_states(case)
    ours, theirs = integrated_states(case, planned).flat(), by_scipy(case, planned)
    np.testing.assert_allclose(ours, theirs, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("build", [b.driving, b.stepping, lambda: b.standing(b.scenario())])
def test_right_plans_are_integrated_as_by_scipy(build: Callable[[], Plan]) -> None:
    agree(build())


@given(st.sampled_from(["base", "base_rate", "foot_xy", "heading", "force", "motion"]), st.integers(0, 99))
@settings(max_examples=25, deadline=None)
def test_spoilt_plans_are_integrated_as_by_scipy(name: str, seed: int) -> None:
    """Where the states of the plan are far from the truth, they are no more than another guess."""
    plan = b.driving()
    array = getattr(plan.trajectory, name)
    noise = np.random.default_rng(seed).normal(size=array.shape) * (500.0 if name == "force" else 0.5)
    agree(replace(plan, trajectory=replace(plan.trajectory, **{name: array + noise})))
