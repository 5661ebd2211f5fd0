"""The controller with another solver than fatrop called directly: slower, the same motion."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from rollgait.errors import InputError, UnknownNameError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.plants.rigid import RigidPlant
from rollgait.mpc.prediction import Status
from rollgait.mpc.settings import MpcSettings
from rollgait.robot.library import find_robot
from rollgait.solvers import fatrop_library, kernels
from rollgait.solvers.fatrop import Fatrop
from rollgait.solvers.fatrop_direct import DirectFatrop
from rollgait.solvers.ipopt import Ipopt

CONVERGED = MpcSettings(iterations=30, deadline=60.0)
STEPS = 30
"""0.3 s: the first feet of a trot have left the ground and land."""


def run(mpc: Mpc) -> tuple[np.ndarray, list[Status]]:
    """Where robot and feet are after each step of a trot along a curve, (STEPS, 22), and how it went."""
    plant, places, status = RigidPlant(find_robot("centauro")), [], []
    for _ in range(STEPS):
        control, prediction = mpc.step(plant.state, VelocityCommand(forward=0.3, turn_rate=0.2, gait="trot"))
        plant.step(control)
        status.append(prediction.status)
        s = plant.state
        places.append(np.concatenate([s.com_position, s.euler, s.foot_position.ravel(), s.heading]))
    return np.array(places), status


@pytest.fixture(scope="module")
def wanted() -> np.ndarray:
    """The motion with fatrop called directly, which lets each step converge."""
    mpc = Mpc("centauro", CONVERGED, kernels=False)
    assert isinstance(mpc._solver, DirectFatrop)
    places, status = run(mpc)
    assert all(s.converged for s in status)
    return places


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    """Another machine, whose CasADi has another fatrop; what is logged there."""

    def unknown() -> None:
        raise fatrop_library.InterfaceError("fatrop 1.1 is not in CasADi's wheel")

    monkeypatch.setattr(fatrop_library, "library", unknown)
    kernels.say_once.cache_clear()
    caplog.set_level(logging.INFO, logger="rollgait")
    return caplog


def with_another_fatrop(settings: MpcSettings, log: pytest.LogCaptureFixture) -> Mpc:
    for _ in range(2):
        mpc = Mpc("centauro", settings, kernels=False)
    assert isinstance(mpc._solver, Fatrop)
    assert log.messages == ["fatrop 1.1 is not in CasADi's wheel: calling it through CasADi, which is slower"]
    return mpc


def without_fatrop(settings: MpcSettings, log: pytest.LogCaptureFixture) -> Mpc:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ca, "has_nlpsol", lambda name: name != "fatrop")
        for _ in range(2):
            mpc = Mpc("centauro", settings, kernels=False)
        with pytest.raises(InputError, match="'fatrop' is not part of this CasADi; valid: ipopt"):
            Mpc("centauro", settings, kernels=False, solver="fatrop")
    assert isinstance(mpc._solver, Ipopt)
    (line,) = log.messages
    assert line.endswith("is not part of this CasADi; valid: ipopt: solving with ipopt, which is slower")
    return mpc


@pytest.mark.parametrize("fallback", [with_another_fatrop, without_fatrop])
def test_a_fallback_finds_the_same_motion_however_late(
    fallback: Callable[[MpcSettings, pytest.LogCaptureFixture], Mpc],
    wanted: np.ndarray,
    elsewhere: pytest.LogCaptureFixture,
) -> None:
    # one iteration at once is asked for: these take what they need, and the status says that they are late
    mpc = fallback(MpcSettings(deadline=1e-4), elsewhere)
    found, status = run(mpc)
    np.testing.assert_allclose(found, wanted, atol=2e-4)
    assert all(s.mode == "tracking" and s.converged and s.late for s in status)
    assert not mpc.events


def test_a_solver_can_be_named() -> None:
    assert isinstance(Mpc("centauro", solver="ipopt", kernels=False)._solver, Ipopt)
    with pytest.raises(UnknownNameError, match="solver: 'snopt' is not known; valid: "):
        Mpc("centauro", solver="snopt", kernels=False)


def test_what_no_solver_is_asked_is_a_failed_solve(mpc: Mpc) -> None:
    plant, ahead, nlp = RigidPlant(find_robot("centauro")), VelocityCommand(forward=0.2), mpc._problem.nlp
    control, _ = mpc.step(plant.state, ahead)
    plant.step(control)
    row = nlp.row_numbers(nlp.blocks[0])[mpc._problem.interval.rows("second_motion")][0, 0]
    before, nlp.g_lower[row] = nlp.g_lower[row], nlp.g_upper[row] + 1.0
    try:
        _, prediction = mpc.step(plant.state, ahead)
    finally:
        nlp.g_lower[row] = before
    assert prediction.status.mode == "coasting"
    (event,) = mpc.events
    assert (
        "a solve failed (no solution exists: second_motion would have to lie between 3 and 2)" in event.text
    )


def test_a_solver_that_gets_lost_does_not_take_the_controller_along(caplog: pytest.LogCaptureFixture) -> None:
    mpc = Mpc("centauro", CONVERGED, kernels=False)
    before, _ = run(mpc)
    lost = 1e3 * np.random.default_rng(0).normal(size=mpc._problem.nlp.size)
    solution = mpc._solver.solve(lost, warm=True, until=time.perf_counter() + 0.1)
    assert (solution.solved, solution.status) == (False, "No_Answer")
    assert "it is left behind" in caplog.text
    mpc.reset()
    np.testing.assert_array_equal(run(mpc)[0], before)  # as if nothing had been
