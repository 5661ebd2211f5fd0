"""A motion as one SVG that moves by itself, without a script: from the side and from above."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array
from rollgait.view.in_space import outline_of
from rollgait.view.shapes import hips
from rollgait.view.style import GOAL_COLOUR, LEG_COLOURS, SECOND_COLOUR

RATE: Final = 12.0
"""Values per second; the browser draws straight lines between them."""
WIDTH: Final = 900.0
"""Of the drawing in its own units."""
AROUND: Final = 0.3
"""Shown around all that moves, m."""
PROFILE_STEP: Final = 0.02
"""Between two heights of the ground's profile, m."""

Place = Callable[[Array], Array]
"""From points (…, 2), m, to the drawing."""


def moving_picture(plan: Plan) -> str:
    """The motion in its own time, again and again; an SVG element for an HTML page."""
    s = plan.sample_every(RATE)
    seconds, robot = plan.horizon, plan.robot
    poses = np.concatenate([s.com_position, s.euler], axis=1)
    body = np.stack([outline_of(robot, pose) for pose in poses])  # (n, 6, 3)
    rim = np.array([leg.foot_radius for leg in robot.leg_list])
    axle = s.foot_position + rim[:, None] * [0.0, 0.0, 1.0]
    c, d = np.cos(s.euler[:, 0, None]), np.sin(s.euler[:, 0, None])
    hx, hy = hips(robot).T
    hip = np.stack([c * hx - d * hy, d * hx + c * hy, np.zeros((len(c), 4))], axis=-1)
    hip += s.com_position[:, None]
    low = np.minimum(body.min(axis=(0, 1)), axle.min(axis=(0, 1))) - AROUND
    high = np.maximum(body.max(axis=(0, 1)), axle.max(axis=(0, 1))) + AROUND
    scale = WIDTH / (high[0] - low[0])
    side, above = scale * (high[2] - low[2]), scale * (high[1] - low[1])

    def from_the_side(points: Array) -> Array:
        return np.stack([scale * (points[..., 0] - low[0]), scale * (high[2] - points[..., 1])], axis=-1)

    def from_above(points: Array) -> Array:
        return np.stack(
            [scale * (points[..., 0] - low[0]), side + scale * (high[1] - points[..., 1])], axis=-1
        )

    x = np.arange(low[0], high[0], PROFILE_STEP)
    ground = np.column_stack([x, plan.scenario.terrain.height(x, np.zeros_like(x))])
    known = np.isfinite(ground[:, 1])
    parts = [
        f'<polyline points="{_points(from_the_side(ground[known]))}" stroke="{SECOND_COLOUR}" fill="none"/>'
    ]
    goal = plan.scenario.goal_at(np.array([plan.horizon]))[0]
    wanted = from_above(outline_of(robot, goal)[:, :2])
    parts.append(f'<polygon points="{_points(wanted)}" fill="none" stroke="{GOAL_COLOUR}"/>')
    for place, columns in ((from_the_side, [0, 2]), (from_above, [0, 1])):
        shape = place(body[..., columns])
        parts.append(_animated("polygon", {"points": [_points(each) for each in shape]}, seconds, _BODY))
        for leg, colour in enumerate(LEG_COLOURS):
            (x1, y1), (x2, y2) = place(hip[:, leg, columns]).T, place(axle[:, leg, columns]).T
            line = {"x1": x1, "y1": y1, "x2": x2, "y2": y2}
            parts.append(_animated("line", _numbers(line), seconds, f'stroke="{SECOND_COLOUR}"'))
            radius = f'r="{max(0.03, rim[leg]) * scale if place is from_the_side else 5.0:.1f}"'
            look = f'{radius} fill="{colour}" fill-opacity="0.6" stroke="{colour}"'
            parts.append(_animated("circle", _numbers({"cx": x2, "cy": y2}), seconds, look))
    return (
        f'<svg viewBox="0 0 {WIDTH:.0f} {side + above:.0f}" role="img" stroke-width="2" '
        'style="width:100%;height:auto">'
        "<title>The motion from the side and from above</title>" + "".join(parts) + "</svg>"
    )


_BODY: Final = f'fill="{SECOND_COLOUR}" fill-opacity="0.25" stroke="{SECOND_COLOUR}"'


def _animated(tag: str, attributes: dict[str, Sequence[str]], seconds: float, look: str) -> str:
    """An element whose attributes take one value after the other, evenly over the time."""
    first = " ".join(f'{name}="{values[0]}"' for name, values in attributes.items())
    moves = "".join(
        f'<animate attributeName="{name}" dur="{seconds:.6g}s" repeatCount="indefinite" '
        f'values="{";".join(values)}"/>'
        for name, values in attributes.items()
        if len(set(values)) > 1
    )
    return f"<{tag} {first} {look}>{moves}</{tag}>"


def _numbers(values: dict[str, Array]) -> dict[str, Sequence[str]]:
    return {name: [f"{value:.1f}" for value in series] for name, series in values.items()}


def _points(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
