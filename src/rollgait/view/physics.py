"""Figures of a simulation beside its plan: how far the body is from its plan, contact forces, torques."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rollgait.errors import UnknownNameError
from rollgait.robot.robot import LEG_NAMES
from rollgait.simulation.log import SimulationLog
from rollgait.simulation.report import rotation_matrices
from rollgait.view.style import (
    BASE_COLOUR,
    LEG_COLOURS,
    MARK_COLOUR,
    SECOND_COLOUR,
    SWING_SHADE,
    Style,
    find_style,
)

MOST_USED: Final = 6
"""Number of joints whose torques are drawn."""


def draw_error(figure: Figure, log: SimulationLog, style: Style) -> None:
    """Distance of the base link from its planned place, and its angles from its planned orientation."""
    figure.set_size_inches(style.width, 0.7 * style.width)
    place, angle = figure.subplots(2, 1, sharex=True)
    away = 1e3 * (log.base_position - log.planned_base_position)
    for axis, colour in enumerate(LEG_COLOURS[:3]):
        place.plot(log.time, away[:, axis], color=colour, label="xyz"[axis])
    place.set_ylabel("base − plan (mm)")
    R = rotation_matrices(log.base_quaternion) @ rotation_matrices(log.planned_base_quaternion).transpose(
        0, 2, 1
    )
    for axis, colour in enumerate(LEG_COLOURS[:3]):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        angle.plot(log.time, np.degrees(0.5 * (R[:, j, i] - R[:, i, j])), color=colour)
    angle.set_ylabel("rotation (deg)")
    angle.set_xlabel("time (s)")
    figure.legend(loc="outside upper center", ncols=3)
    _mark_end(log, place, angle)


def draw_contact_forces(figure: Figure, log: SimulationLog, style: Style) -> None:
    """Normal contact force of each leg, measured and planned."""
    figure.set_size_inches(style.width, 1.1 * style.width)
    panels = figure.subplots(4, 1, sharex=True, sharey=True)
    for leg, (axes, name, colour) in enumerate(zip(panels, LEG_NAMES, LEG_COLOURS, strict=True)):
        axes.plot(log.time, log.planned_force[:, leg, 2], color=SECOND_COLOUR)
        axes.plot(log.time, log.force[:, leg, 2], color=colour, lw=0.7 * style.line)
        axes.fill_between(
            log.time,
            0.0,
            1.0,
            where=~log.planned_contact[:, leg],
            transform=axes.get_xaxis_transform(),
            color=colour,
            alpha=SWING_SHADE,
            lw=0.0,
        )
        axes.set_ylabel(f"{name} (N)", color=colour)
    top = float(np.percentile(log.force[..., 2], 99.5))
    panels[0].set_ylim(-20.0, 1.2 * max(top, float(log.planned_force[..., 2].max())))
    panels[-1].set_xlabel("time (s)")
    figure.legend(
        handles=[
            Line2D([], [], color=BASE_COLOUR, label="measured (in the colour of its leg)"),
            Line2D([], [], color=SECOND_COLOUR, label="planned"),
        ],
        loc="outside upper center",
        ncols=2,
    )
    _mark_end(log, *panels)


def draw_torques(figure: Figure, log: SimulationLog, style: Style) -> None:
    """Largest share of its limit that each of the most used joints needs."""
    figure.set_size_inches(style.width, 0.5 * style.width)
    axes = figure.subplots()
    for number, use in enumerate(log.report().joints[:MOST_USED]):
        if not np.isfinite(use.share) or use.share == 0.0:
            continue
        joint = log.joint_names.index(use.joint)
        share = 100.0 * log.torque_peak[:, joint] / log.effort_max[joint]
        colour = LEG_COLOURS[number % len(LEG_COLOURS)]
        dashes = "-" if number < len(LEG_COLOURS) else ":"
        axes.plot(log.time, share, color=colour, ls=dashes, lw=0.7 * style.line, label=use.joint)
    axes.axhline(100.0, color=MARK_COLOUR, lw=0.5 * style.line)
    axes.set_ylim(0.0, 110.0)
    axes.set_ylabel("torque (% of limit)")
    axes.set_xlabel("time (s)")
    if len(axes.lines) > 1:  # joints whose drives have no limit are not drawn
        figure.legend(loc="outside upper center", ncols=3)
    _mark_end(log, axes)


Draw = Callable[[Figure, SimulationLog, Style], None]

PHYSICS_FIGURES: Final[dict[str, Draw]] = {
    "error": draw_error,
    "contact-forces": draw_contact_forces,
    "torques": draw_torques,
}
"""Every figure of a simulation by its name."""


def physics_figure(log: SimulationLog, name: str, style: str = "screen") -> Figure:
    """One figure of a simulation.

    Raises:
        UnknownNameError: there is no such figure or style.
    """
    if name not in PHYSICS_FIGURES:
        raise UnknownNameError("figure", name, PHYSICS_FIGURES)
    look = find_style(style)
    with look.applied():
        result = Figure(layout="constrained")
        PHYSICS_FIGURES[name](result, log, look)
    return result


def _mark_end(log: SimulationLog, *panels: Axes) -> None:
    """A line where the motion ends, and a red one where the robot fell."""
    for axes in panels:
        if log.fallen_at is not None:
            axes.axvline(log.fallen_at, color=MARK_COLOUR)
        elif log.motion_end < log.time[-1]:
            axes.axvline(log.motion_end, color=SECOND_COLOUR, lw=0.8)
