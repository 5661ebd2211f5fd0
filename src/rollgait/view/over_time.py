"""Figures over time: forces, pose of the base, wheels, gait. One function each.

Where a leg is in the air, the time is shaded in its colour.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array
from rollgait.robot.robot import LEG_NAMES
from rollgait.view.motion import dense_samples, goal_poses, swing_times
from rollgait.view.style import (
    BASE_COLOUR,
    GOAL_COLOUR,
    LEG_COLOURS,
    SECOND_COLOUR,
    SWING_SHADE,
    Style,
    ticks,
)

TIME_LABEL = "time (s)"
DASHED = (0, (2.5, 1.5))


def draw_forces(figure: Figure, plan: Plan, style: Style) -> None:
    """Contact force of each leg in world axes, and the heights of the feet."""
    figure.set_size_inches(style.width, 1.3 * style.width)
    s = dense_samples(plan)
    panels = figure.subplots(5, 1, sharex=True)
    thin = 0.8 * style.line
    for leg, (axes, name, colour) in enumerate(zip(panels[:4], LEG_NAMES, LEG_COLOURS, strict=True)):
        _shade(axes, plan, leg)
        axes.plot(s.time, s.force[:, leg, 0], color=SECOND_COLOUR, lw=thin)
        axes.plot(s.time, s.force[:, leg, 1], color=SECOND_COLOUR, lw=thin, ls=DASHED)
        axes.plot(s.time, s.force[:, leg, 2], color=colour)
        axes.set_ylim(*_limits(s.force, 50.0))
        axes.yaxis.set_major_locator(ticks(3))
        axes.set_ylabel(f"{name} (N)", color=colour)
    _shade(panels[4], plan)
    x, y, z = np.moveaxis(s.foot_position, -1, 0)
    height = 100.0 * (z - plan.scenario.terrain.height(x, y))
    _by_leg(panels[4], plan, s.time, height)
    panels[4].set_ylim(*_limits(height, 2.0))
    panels[4].set_ylabel("height (cm)")
    panels[4].yaxis.set_major_locator(ticks(3))
    figure.align_ylabels(panels)
    _time_axis(panels[4], plan)
    _legend(
        figure,
        [
            Line2D([], [], color=BASE_COLOUR, label="$f_z$ (in the colour of its leg)"),
            Line2D([], [], color=SECOND_COLOUR, lw=thin, label="$f_x$"),
            Line2D([], [], color=SECOND_COLOUR, lw=thin, ls=DASHED, label="$f_y$"),
        ],
    )


def draw_base(figure: Figure, plan: Plan, style: Style) -> None:
    """Place of the CoM and orientation of the base over time, with the goal."""
    figure.set_size_inches(style.width, 0.95 * style.width)
    s = dense_samples(plan)
    goal = goal_poses(plan.scenario, s.time)
    panels = figure.subplots(3, 2, sharex=True)
    place = ("x (m)", "y (m)", "z (m)")
    angle = ("yaw (°)", "pitch (°)", "roll (°)")
    for column, (labels, pose, wish, span) in enumerate(
        [
            (place, s.com_position, goal[:, :3], 0.02),
            (angle, np.degrees(s.euler), np.degrees(goal[:, 3:]), 2.0),
        ]
    ):
        for row, label in enumerate(labels):
            axes = panels[row, column]
            _shade(axes, plan)
            axes.plot(s.time, wish[:, row], color=GOAL_COLOUR, ls=DASHED)
            axes.plot(s.time, pose[:, row], color=BASE_COLOUR)
            axes.set_ylim(*_limits(np.stack([pose[:, row], wish[:, row]]), span))
            axes.yaxis.set_major_locator(ticks(4))
            axes.set_ylabel(label)
    for column in range(2):
        figure.align_ylabels(panels[:, column])
        _time_axis(panels[2, column], plan)
    _legend(
        figure,
        [
            Line2D([], [], color=BASE_COLOUR, label="base"),
            Line2D([], [], color=GOAL_COLOUR, ls=DASHED, label="goal"),
            *_legs_in_the_air(plan),
        ],
    )


def draw_wheels(figure: Figure, plan: Plan, style: Style) -> None:
    """Speed of each foot on its way, and the headings of the wheels in the world and from the base."""
    wheeled = [leg for leg, data in enumerate(plan.robot.leg_list) if data.foot != "point"]
    s = dense_samples(plan)
    planar = np.linalg.norm(s.foot_velocity[..., :2], axis=-1)
    speed = np.where(np.isin(np.arange(4), wheeled), s.speed, planar)
    heading = np.degrees(s.heading)
    rows = [("speed (m/s)", speed, 0.05, list(range(4)))]
    if wheeled:
        rows += [
            ("heading (°)", heading, 4.0, wheeled),
            ("heading from base (°)", heading - np.degrees(s.euler[:, :1]), 4.0, wheeled),
        ]
    figure.set_size_inches(style.width, (0.2 + 0.36 * len(rows)) * style.width)
    panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (label, values, span, legs) in zip(panels, rows, strict=True):
        _shade(axes, plan)
        _by_leg(axes, plan, s.time, values, legs)
        axes.set_ylim(*_limits(values[:, legs], span))
        axes.yaxis.set_major_locator(ticks(5))
        axes.set_ylabel(label)
    figure.align_ylabels(panels)
    _time_axis(panels[-1], plan)
    _legend(figure, [Line2D([], [], color=c, label=n) for n, c in zip(LEG_NAMES, LEG_COLOURS, strict=True)])


def draw_gait(figure: Figure, plan: Plan, style: Style) -> None:
    """Which foot is on the ground when: a bar is stance, a gap is swing."""
    figure.set_size_inches(style.width, 0.45 * style.width)
    axes = figure.subplots()
    for leg, colour in enumerate(LEG_COLOURS):
        edges = np.array(
            [0.0, *(t for i, *times in swing_times(plan) if i == leg for t in times), plan.horizon]
        )
        bars = [(begin, end - begin) for begin, end in edges.reshape(-1, 2) if end > begin]
        axes.broken_barh(bars, (leg - 0.36, 0.72), facecolor=colour, linewidth=0.0)
    axes.set_yticks(range(4), LEG_NAMES)
    axes.tick_params(axis="y", length=0.0)
    axes.set_ylim(3.6, -0.6)
    axes.grid(False, axis="y")
    _time_axis(axes, plan)
    swing = Patch(facecolor="white", edgecolor=SECOND_COLOUR, label="swing")
    _legend(figure, [Patch(color=SECOND_COLOUR, label="stance"), swing])


def _by_leg(axes: Axes, plan: Plan, time: Array, values: Array, legs: Sequence[int] = range(4)) -> None:
    """One line per leg, the front ones over the hind ones where they coincide."""
    for leg in reversed(legs):
        axes.plot(time, values[:, leg], color=LEG_COLOURS[leg])


def _shade(axes: Axes, plan: Plan, only: int | None = None) -> None:
    """Shades the swings of one leg or of all."""
    for leg, begin, end in swing_times(plan):
        if only is None or leg == only:
            axes.axvspan(begin, end, color=LEG_COLOURS[leg], alpha=SWING_SHADE, linewidth=0.0)


def _legs_in_the_air(plan: Plan) -> list[Patch]:
    """What the shades mean, for a legend."""
    legs = sorted({leg for leg, *_ in swing_times(plan)})
    labels = [("swing of " if leg == legs[0] else "") + LEG_NAMES[leg] for leg in legs]
    return [
        Patch(color=LEG_COLOURS[leg], alpha=2 * SWING_SHADE, lw=0.0, label=label)
        for leg, label in zip(legs, labels, strict=True)
    ]


def _limits(values: Array, smallest_span: float) -> tuple[float, float]:
    """Range of an axis: all values with some air, and no magnified rounding errors."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    middle, span = 0.5 * (low + high), max(high - low, smallest_span)
    return middle - 0.56 * span, middle + 0.56 * span


def _time_axis(axes: Axes, plan: Plan) -> None:
    axes.set_xlim(0.0, plan.horizon)
    axes.xaxis.set_major_locator(ticks(6))
    axes.set_xlabel(TIME_LABEL)


def _legend(figure: Figure, handles: Sequence[Line2D | Patch]) -> None:
    """One legend over all panels, in two rows if one would not fit a column of a paper."""
    rows = 1 if len(handles) <= 4 else 2
    figure.legend(handles=handles, loc="outside upper center", ncols=math.ceil(len(handles) / rows))
