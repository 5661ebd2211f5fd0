"""The ground along the way of each foot, as a section, with the path of the foot over it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array
from rollgait.robot.robot import LEG_NAMES
from rollgait.view.motion import dense_samples
from rollgait.view.style import BASE_COLOUR, LEG_COLOURS, SECOND_COLOUR, Style, ticks

GROUND_FILL: Final = "#D9D4C7"
"""Of the ground below its surface."""
SAMPLES: Final = 0.004
"""Between places at which the ground is looked up, m: a riser looks upright."""
ALONG_X: Final = 0.995
"""Cosine of the angle to the x axis below which the way counts as along x."""
DEEP: Final = 0.3
"""So far below the feet the ground is still drawn, m."""
SPAN_MIN: Final = 0.06
"""Smallest range of heights, m: rounding errors are not magnified."""


def draw_profile(figure: Figure, plan: Plan, style: Style) -> None:
    """Heights of the ground under each foot and of the foot along the way; strong where it stands."""
    s = dense_samples(plan)
    direction, label = way_of(s.com_position[:, :2])
    origin = np.zeros(2) if label == "x (m)" else s.com_position[0, :2]
    figure.set_size_inches(style.width, 1.05 * style.width)
    panels = figure.subplots(4, 1, sharex=True, sharey=True)
    lines = [ground_line(plan, s.foot_position[:, leg, :2]) for leg in range(4)]
    low, high = _range([s.foot_position[..., 2].ravel(), *(line[:, 2] for line in lines)])
    for leg, (axes, line, colour) in enumerate(zip(panels, lines, LEG_COLOURS, strict=True)):
        way, z = (line[:, :2] - origin) @ direction, line[:, 2]
        for part in runs(way):
            axes.fill_between(way[part], low, z[part], color=GROUND_FILL, linewidth=0.0)
        axes.plot(way, z, color=BASE_COLOUR, lw=0.7 * style.line)
        foot = s.foot_position[:, leg]
        along = (foot[:, :2] - origin) @ direction
        axes.plot(along, foot[:, 2], color=colour, lw=0.7 * style.line)
        standing = np.where(s.contact[:, leg], foot[:, 2], np.nan)
        axes.plot(along, standing, color=colour, lw=2.0 * style.line, solid_capstyle="butt")
        axes.set_ylim(low, high)
        axes.yaxis.set_major_locator(ticks(3))
        axes.set_ylabel(f"{LEG_NAMES[leg]} z (m)", color=colour)
        axes.margins(x=0.02)
    figure.align_ylabels(panels)
    panels[-1].set_xlabel(label)
    panels[-1].xaxis.set_major_locator(ticks(6))
    figure.legend(
        handles=[
            Patch(facecolor=GROUND_FILL, edgecolor=BASE_COLOUR, lw=0.7 * style.line, label="ground"),
            Line2D([], [], color=SECOND_COLOUR, lw=2.0 * style.line, label="stands"),
            Line2D([], [], color=SECOND_COLOUR, lw=0.7 * style.line, label="swings"),
        ],
        loc="outside upper center",
        ncols=3,
    )


def runs(way: Array) -> Iterator[slice]:
    """The parts of a way (n,) that only go ahead or only back: as one area they would take each other out."""
    steps = np.sign(np.diff(way))
    moves = np.flatnonzero(steps)
    turns = moves[1:][np.diff(steps[moves]) != 0.0]
    for first, last in pairwise([0, *turns.tolist(), len(way) - 1]):
        yield slice(first, last + 1)


def way_of(places: Array) -> tuple[Array, str]:
    """Direction (2,) from the begin of a way (n, 2) to its farthest place, and the name of such an axis."""
    away = places - places[0]
    far = away[np.linalg.norm(away, axis=1).argmax()]
    length = float(np.linalg.norm(far))
    if length < SPAN_MIN or abs(far[0]) > ALONG_X * length:
        return np.array([1.0, 0.0]), "x (m)"
    return far / length, "way (m)"


def ground_line(plan: Plan, path: Array) -> Array:
    """The ground under a path (n, 2): places on it and heights, (m, 3), m; NaN where it is not known."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    kept = np.append(True, np.diff(way) > 0.0)
    places = np.unique(np.append(way, np.arange(0.0, way[-1], SAMPLES)))
    xy = np.column_stack([np.interp(places, way[kept], path[kept, k]) for k in range(2)])
    return np.column_stack([xy, plan.scenario.terrain.height(*xy.T)])


def _range(heights: list[Array]) -> tuple[float, float]:
    """Of the axis: all heights, with ground below and air above them; a deep ditch has no floor."""
    every = np.concatenate(heights)
    every = every[np.isfinite(every)]
    feet = heights[0]
    low, high = max(float(every.min()), float(feet.min()) - DEEP), float(every.max())
    span = max(high - low, SPAN_MIN)
    return low - 0.25 * span, high + 0.12 * span
