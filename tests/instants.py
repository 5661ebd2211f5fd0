"""Random instants of a robot: the same numbers in plain NumPy and as the problem's expressions see them."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from rollgait.ocp.instant import Body, Inputs, Instant, make_instant
from rollgait.ocp.problem import Problem
from rollgait.ocp.term import FootConstraint, Term
from rollgait.robot.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Numbers:
    """A robot's state and inputs at one instant, world frame, SI units, legs FL, FR, HL, HR."""

    r: Array
    theta: Array
    dr: Array
    dtheta: Array
    p: Array
    sigma: Array
    p_rate_z: Array
    force: Array
    motion: Array
    lift_rate: Array
    previous_force: Array
    previous_motion: Array
    interval: float = 0.1
    ground: float = 0.2

    @property
    def yaw(self) -> float:
        """θz."""
        return float(self.theta[0])


def random_numbers(seed: int, robot: Robot) -> Numbers:
    """Numbers of a robot in disorder, its feet about where they belong."""
    rng = np.random.default_rng(seed)

    def some(*shape: int, size: float = 1.0) -> Array:
        return rng.uniform(-size, size, shape)

    return Numbers(
        r=some(3),
        theta=some(3) * [3.0, 0.5, 0.5],
        dr=some(3),
        dtheta=some(3),
        p=robot.stance + some(4, 3),
        sigma=some(4, size=3.0),
        p_rate_z=some(4),
        force=some(4, 3, size=500.0),
        motion=some(4, 2),
        lift_rate=some(4, 2),
        previous_force=some(4, 3, size=500.0),
        previous_motion=some(4, 2),
    )


def as_instant(robot: Robot, n: Numbers, height_point: int | None = None) -> Instant:
    """The numbers as the terms of a problem get them."""
    constant = ca.SX
    body = Body(
        mass=constant(robot.mass),
        weight=constant(robot.weight),
        inertia=constant(robot.inertia_matrix),
        stance=constant(robot.stance.T),
        heading_offset=constant([leg.heading for leg in robot.leg_list]),
        interval=constant(n.interval),
        ground=constant([n.ground] * 4),
    )

    def rows(values: Array) -> list[ca.SX]:
        return [constant(value) for value in values]

    return make_instant(
        body,
        [leg.foot for leg in robot.leg_list],
        constant(np.concatenate([n.r, n.theta])),
        constant(np.concatenate([n.dr, n.dtheta])),
        rows(n.p[:, :2]),
        rows(n.p[:, 2] - n.ground),
        rows(n.sigma),
        rows(n.p_rate_z),
        Inputs(rows(n.force), rows(n.motion), rows(n.lift_rate)),
        Inputs(rows(n.previous_force), rows(n.previous_motion), rows(n.lift_rate)),
        height_point,
    )


def data_of(term: Term, problem: Problem, interval: int = 0, leg: int = 0) -> SimpleNamespace:
    """The numbers that a term reads in one interval."""
    values = term.data(problem, leg) if isinstance(term, FootConstraint) else term.data(problem)
    columns = {}
    for name, value in values.items():
        array = np.asarray(value, dtype=float)
        columns[name] = ca.SX(array[:, interval] if array.ndim == 2 else array)
    return SimpleNamespace(**columns)
