"""A term of one's own serves the planner and the controller alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np
import pytest
from numpy.typing import ArrayLike

import rollgait as rg
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.settings import MpcSettings
from rollgait.mpc.setup import make_loop
from rollgait.ocp.context import Context
from rollgait.ocp.term import INPUT, Data
from rollgait.plant.stance import standing_state


class Lean(rg.Cost):
    """Wants the base to lean by a pitch, which grows with the number of feet on the ground."""

    name = "lean"

    def __init__(self, weight: float, pitch: float) -> None:
        super().__init__(weight)
        self.pitch = pitch

    def data(self, problem: Context) -> Mapping[str, ArrayLike]:  # type: ignore[override]
        return {"pitch": self.pitch * problem.schedule.contact.mean(axis=0)[None, :]}

    def residual(self, x: rg.Instant, d: Data) -> ca.SX:
        return ca.SX(x.theta[1] - d.pitch)


class Slow(rg.Constraint):
    """The CoM goes no faster than that along x."""

    name = "slow"
    places = INPUT
    upper = 0.1
    unit = "m/s"

    def expression(self, x: rg.Instant, d: Data) -> ca.SX:
        return x.dr[0]


class Odd(rg.Cost):
    """No square."""

    name = "odd"

    def expression(self, x: rg.Instant, d: Data) -> ca.SX:
        return x.theta[1] ** 3


def run(**arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    """Pitch and forward speed over 1.5 s of 0.3 m/s on the rigid plant."""
    robot = rg.find_robot("centauro")
    mpc = Mpc(robot, MpcSettings(), kernels=False, **arguments)
    loop = make_loop(robot, kernels=False)
    plant = loop.plant
    pitch, speed = [], []
    for _ in range(150):
        state = plant.state
        control, _ = mpc.step(state, rg.VelocityCommand(forward=0.3))
        plant.step(control)
        pitch.append(state.euler[1])
        speed.append(state.com_velocity[0])
    return np.array(pitch), np.array(speed)


def test_a_cost_of_ones_own_leans_plan_and_controller() -> None:
    term = Lean(1e4, 0.05)
    plan = rg.plan("wheeled", terms=[term], kernels=False)
    assert plan.sample(0.5 * plan.horizon).euler[1] > 0.03
    pitch, _ = run(terms=[term])
    assert pitch[-1] > 0.03
    assert abs(run()[0][-1]) < 0.01


def test_a_constraint_of_ones_own_holds_the_controller_back() -> None:
    free, held = run()[1], run(terms=[Slow()])[1]
    assert free[-1] > 0.2
    assert held[-1] < 0.5 * free[-1]


def test_a_cost_that_is_no_square_is_refused_in_one_sentence() -> None:
    with pytest.raises(rg.InputError, match="terms: 'odd' must be a sum of squares"):
        Mpc("centauro", kernels=False, terms=[Odd()])


def test_two_constants_in_an_expression_are_two_codes() -> None:
    class Constant(rg.Cost):
        name = "constant"

        def __init__(self, place: float) -> None:
            super().__init__(1e3)
            self.place = place

        def residual(self, x: rg.Instant, d: Data) -> ca.SX:
            return ca.SX(x.r[1] - self.place)

    ends = [
        rg.plan("hybrid-forward", terms=[Constant(place)], kernels=False).sample(5.0).com_position[1]
        for place in (0.05, -0.05)
    ]
    assert ends[0] > 0.02
    assert ends[1] < -0.02


def test_the_first_state_is_believed_with_a_term_of_ones_own() -> None:
    robot = rg.find_robot("centauro")
    mpc = Mpc(robot, kernels=False, terms=[Lean(10.0, 0.0)])
    control, _ = mpc.step(standing_state(robot), rg.VelocityCommand())
    assert control.force[:, 2].sum() == pytest.approx(robot.weight, rel=0.05)
