"""The state of the one-step map inside a vector of variables, and the instant that it stands for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

from rollgait.dynamics.step import Figures, FootState, State, euler_rate
from rollgait.ocp.instant import Body, Inputs, Instant, make_instant
from rollgait.transcription.code import StageSymbols
from rollgait.transcription.layout import StageLayout


def state_of(layout: StageLayout, node: ca.SX, momentum: ca.SX, height: ca.SX, body: Body) -> State:
    """The state in a node vector.

    Args:
        layout: of the node, with theta, L, r, dr, xy and sigma.
        node: the vector.
        momentum: unit of L in the vector, N·m·s.
        height: of the feet above the ground, 4, m.
        body: knows the ground.
    """
    groups = {name: node[layout.node[name]] for name in ("theta", "L", "r", "dr", "xy", "sigma")}
    xy, feet = groups["xy"], height.numel()
    sigma: list[Any] = [0.0] * feet
    for number, leg in enumerate(layout.steerable):
        sigma[leg] = groups["sigma"][number]
    return State(
        r=ca.vertsplit(groups["r"]),
        theta=ca.vertsplit(groups["theta"]),
        dr=ca.vertsplit(groups["dr"]),
        L=[momentum * c for c in ca.vertsplit(groups["L"])],
        feet=tuple(
            FootState(
                [xy[2 * i], xy[2 * i + 1], body.ground_height(i, xy[2 * i : 2 * i + 2]) + height[i]], sigma[i]
            )
            for i in range(feet)
        ),
    )


def state_entries(layout: StageLayout, x: State, momentum: ca.SX) -> list[ca.SX]:
    """The inverse of `state_of`: what the vector holds, in the order theta, L, r, dr, xy, sigma."""
    return [
        *x.theta,
        *(c / momentum for c in x.L),
        *x.r,
        *x.dr,
        *(foot.p[a] for foot in x.feet for a in range(2)),
        *(x.feet[leg].sigma for leg in layout.steerable),
    ]


def instant_of(
    body: Body,
    robot: Figures,
    x: State,
    height: Sequence[ca.SX],
    height_rate: Sequence[ca.SX],
    inputs: Inputs,
    previous: Inputs,
    height_point: int | None = None,
    tau: float = 0.0,
) -> Instant:
    """The instant of a state; the arguments are those of `make_instant`.

    The heights of the feet are given beside the state, which has them in the world: what is fixed at the
    ground must be a variable and nothing else.
    """
    return make_instant(
        body,
        robot.kinds,
        _column([*x.r, *x.theta]),
        _column([*x.dr, *euler_rate(ca, x.theta, x.L, robot)]),
        [_column(foot.p[:2]) for foot in x.feet],
        height,
        [foot.sigma for foot in x.feet],
        height_rate,
        inputs,
        previous,
        height_point,
        tau,
    )


def _column(components: Sequence[Any]) -> ca.SX:
    return ca.SX(ca.vertcat(*components))


def figures(symbols: StageSymbols) -> Figures:
    """What a step knows of the robot, as symbols of a stage."""
    return Figures(
        mass=symbols.body.mass,
        inertia_inverse=[[symbols.inertia_inverse[i, j] for j in range(3)] for i in range(3)],
        kinds=symbols.outline.kinds,
        heading_offset=ca.vertsplit(symbols.body.heading_offset),
    )
