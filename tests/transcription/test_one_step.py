"""The step of the controller as one function: the planner's step on Python's numbers, whichever."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rollgait.dynamics.ground import FootGround
from rollgait.dynamics.step import Figures, FootInput, FootState, State, angular_momentum, euler_rate, step
from rollgait.robot.robot import FootKind
from rollgait.transcription.one_step import OneStep

MASS, PERIOD = 83.0, 0.01
ROOT = np.random.default_rng(1).normal(size=(3, 3))
INERTIA = ROOT @ ROOT.T + 5.0 * np.eye(3)
OFFSET = [0.0, 0.2, -0.1, 3.0]
KINDS: tuple[tuple[FootKind, ...], ...] = (("steerable",) * 4, ("fixed",) * 4, ("point",) * 4)


@pytest.mark.parametrize("kinds", KINDS, ids=lambda kinds: kinds[0])
@pytest.mark.parametrize("on_slopes", [False, True], ids=["level", "slopes"])
@pytest.mark.parametrize("pulled", [False, True], ids=["alone", "pulled"])
@given(seed=st.integers(0, 10**6))
@settings(max_examples=5, deadline=None)
def test_it_is_the_planners_step(
    kinds: tuple[FootKind, ...], on_slopes: bool, pulled: bool, seed: int
) -> None:
    random = np.random.default_rng(seed)
    own = OneStep(kinds, MASS, INERTIA, OFFSET, on_slopes, pulled)
    values = {
        name: random.normal(scale=scale, size=own.given[name].size)
        for name, scale in (
            *(("r", 1.0), ("theta", 0.5), ("dr", 1.0), ("dtheta", 1.0), ("p", 1.0), ("sigma", 1.0)),
            *(("force", 200.0), ("motion", 1.0), ("lift_rate", 0.3), ("wrench", 50.0), ("ground", 0.1)),
        )
    }
    for name, numbers in values.items():
        own.given[name][:] = numbers
    own.given["period"][0] = PERIOD
    found = own()

    def feet(name: str) -> list[list[float]]:
        return [part.tolist() for part in values[name].reshape(4, -1)]

    robot = Figures(MASS, np.linalg.inv(INERTIA).tolist(), kinds, OFFSET)
    theta = values["theta"].tolist()
    L = angular_momentum(math, theta, values["dtheta"].tolist(), INERTIA.tolist())
    begin = State(
        values["r"].tolist(),
        theta,
        values["dr"].tolist(),
        L,
        tuple(FootState(p, s) for p, s in zip(feet("p"), values["sigma"].tolist(), strict=True)),
    )
    inputs = [FootInput(*u) for u in zip(feet("force"), feet("motion"), feet("lift_rate"), strict=True)]
    under = [FootGround(g[:8], g[8:10], g[10]) for g in feet("ground")] if on_slopes else None
    wrench = values["wrench"].tolist() if pulled else None
    end, _ = step(math, begin, inputs, PERIOD, robot, under, wrench)
    wanted = {
        "r": end.r,
        "theta": end.theta,
        "dr": end.dr,
        "dtheta": euler_rate(math, end.theta, end.L, robot),
        "p": [x for foot in end.feet for x in foot.p],
        "sigma": [foot.sigma for foot in end.feet],
    }
    for name, numbers in wanted.items():
        np.testing.assert_allclose(found[name], numbers, rtol=1e-11, atol=1e-11, err_msg=name)


def test_what_was_found_stays_when_it_is_asked_again() -> None:
    own = OneStep(KINDS[0], MASS, INERTIA, OFFSET, on_slopes=False, pulled=False)
    own.given["period"][0] = PERIOD
    first = own()["dr"]
    kept = first.copy()
    own.given["force"][:] = 100.0
    assert (own()["dr"] != kept).any()
    np.testing.assert_array_equal(first, kept)
