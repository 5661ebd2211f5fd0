"""The planner's step on numbers, for one period of the controller: one CasADi function for each kind of
robot.

It is made of the very expressions that the problem has (`dynamics.step`), once in a process. To evaluate it
takes some 10 µs, where Python's own numbers take 200.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.dynamics.ground import MODEL_SIZE, FootGround
from rollgait.dynamics.step import Figures, FootInput, FootState, State, angular_momentum, euler_rate, step
from rollgait.dynamics.wrench import WRENCH_SIZE
from rollgait.robot.robot import FootKind
from rollgait.transcription.buffered import Buffered
from rollgait.transcription.layout import Layout

Array = NDArray[np.float64]

FEET: Final = 4
GIVEN: Final = Layout(
    [
        ("mass", 1),
        ("inertia", 9),
        ("inertia_inverse", 9),
        ("heading_offset", FEET),
        ("period", 1),
        ("r", 3),
        ("theta", 3),
        ("dr", 3),
        ("dtheta", 3),
        ("p", 3 * FEET),
        ("sigma", FEET),
        ("force", 3 * FEET),
        ("motion", 2 * FEET),
        ("lift_rate", 2 * FEET),
        ("wrench", WRENCH_SIZE),
        ("ground", FEET * (MODEL_SIZE + 3)),
    ]
)
"""What a step depends on: of feet one after the other. Under each is a model, a slope and a radius."""
REACHED: Final = Layout([("r", 3), ("theta", 3), ("dr", 3), ("dtheta", 3), ("p", 3 * FEET), ("sigma", FEET)])
"""What it reaches."""


class OneStep:
    """The step of one robot; its numbers but for the state and the inputs stay from call to call.

    Args:
        kinds: of its feet.
        mass: kg.
        inertia: I_B, (3, 3), kg·m².
        heading_offset: headings of fixed wheels in the base, (4,), rad.
        on_slopes: whether the ground has any.
        pulled: whether there are wrenches from outside.

    Attributes:
        given: by the names of `GIVEN`, to be written to.
    """

    def __init__(
        self,
        kinds: Sequence[FootKind],
        mass: float,
        inertia: Array,
        heading_offset: Sequence[float],
        on_slopes: bool,
        pulled: bool,
    ) -> None:
        values: Array = np.zeros(GIVEN.size)
        self.given = GIVEN.parts(values)
        self.given["mass"][:] = mass
        self.given["inertia"][:] = inertia.ravel()
        self.given["inertia_inverse"][:] = np.linalg.inv(inertia).ravel()
        self.given["heading_offset"][:] = heading_offset
        self._evaluate = Buffered(_function(tuple(kinds), on_slopes, pulled), [values])

    def put_ground(self, under: Sequence[FootGround]) -> None:
        """What is under the feet."""
        self.given["ground"][:] = [x for g in under for x in (*g.model, *g.contact_slope, g.radius)]

    def __call__(self) -> dict[str, Array]:
        """What is reached, by the names of `REACHED`, in memory of its own."""
        return REACHED.parts(self._evaluate()[0].copy())


@lru_cache(maxsize=16)
def _function(kinds: tuple[FootKind, ...], on_slopes: bool, pulled: bool) -> ca.Function:
    values = ca.SX.sym("given", GIVEN.size)

    def parts(name: str, size: int) -> list[list[Any]]:
        return [ca.vertsplit(part) for part in ca.vertsplit(values[GIVEN[name]], size)]

    def part(name: str) -> list[Any]:
        return list(ca.vertsplit(values[GIVEN[name]]))

    (mass,), (h,) = part("mass"), part("period")
    robot = Figures(mass, parts("inertia_inverse", 3), kinds, part("heading_offset"))
    theta = part("theta")
    L = angular_momentum(ca, theta, part("dtheta"), parts("inertia", 3))
    feet = tuple(FootState(p, sigma) for p, sigma in zip(parts("p", 3), part("sigma"), strict=True))
    inputs = zip(parts("force", 3), parts("motion", 2), parts("lift_rate", 2), strict=True)
    under = None
    if on_slopes:
        split = (MODEL_SIZE, MODEL_SIZE + 2)
        under = [
            FootGround(of_foot[: split[0]], of_foot[split[0] : split[1]], of_foot[split[1]])
            for of_foot in parts("ground", MODEL_SIZE + 3)
        ]
    wrench = part("wrench") if pulled else None
    begin = State(part("r"), theta, part("dr"), L, feet)
    end, _ = step(ca, begin, [FootInput(*of_foot) for of_foot in inputs], h, robot, under, wrench)
    reached = ca.vertcat(
        *end.r,
        *end.theta,
        *end.dr,
        *euler_rate(ca, end.theta, end.L, robot),
        *(component for foot in end.feet for component in foot.p),
        *(foot.sigma for foot in end.feet),
    )
    return ca.Function("one_step", [values], [reached], {"cse": True})
