"""Figures in space: the paths in three dimensions, and the motion from above. One function each.

The body is drawn as an outline with a nose where the front is, its corners at the hips.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d import Axes3D, proj3d
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from rollgait.plan.plan import Plan
from rollgait.plan.samples import Array, Samples
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.terrain import Terrain
from rollgait.terrain.mesh import mesh_of
from rollgait.view.motion import dense_samples, goal_poses, snapshot_times, swing_times
from rollgait.view.on_ground import is_plane
from rollgait.view.painter import halved
from rollgait.view.relief_map import add_scale, draw_relief
from rollgait.view.shapes import NOSE, hips
from rollgait.view.style import BASE_COLOUR, GOAL_COLOUR, LEG_COLOURS, SECOND_COLOUR, Style, ticks

AROUND: Final = 0.05
"""Ground shown around and below what moves, m."""
LARGEST: Final = 0.2
"""Sides of the ground's triangles, m."""
MOST_CELLS: Final = 4000
"""Cells of a map in a figure: a vector graphic of more is large and slow."""


def draw_paths(figure: Figure, plan: Plan, style: Style) -> None:
    """Paths of the CoM and the feet in three dimensions, with start, goal and touch-downs."""
    figure.set_layout_engine("none")  # it does not know how little of its place a 3-D box fills; `_fit` does
    s, start = dense_samples(plan), plan.sample(0.0)
    axes: Axes3D = figure.add_axes((0.0, 0.0, 1.0, 1.0), projection="3d", proj_type="ortho")
    axes.view_init(elev=28.0, azim=-62.0)
    dot = (3.0 * style.line) ** 2
    points = np.concatenate([s.foot_position.reshape(-1, 3), s.com_position])
    if not is_plane(plan.scenario.terrain):
        axes.computed_zorder = False  # else lines vanish in the ground that they lie on
        _draw_ground(axes, plan.scenario.terrain, points)
    for leg in reversed(range(4)):
        axes.plot(*s.foot_position[:, leg].T, color=LEG_COLOURS[leg])
        axes.plot(*_legs(plan.robot, start)[leg].T, color=SECOND_COLOUR, lw=0.5 * style.line)
    for leg, _, touch_down in swing_times(plan):
        place = plan.sample(touch_down).foot_position[leg]
        axes.scatter(*place, s=dot, color=LEG_COLOURS[leg], depthshade=False, linewidths=0.0)
    axes.plot(*s.com_position.T, color=BASE_COLOUR)
    axes.plot(*outline_of(plan.robot, _pose(start)).T, color=SECOND_COLOUR, lw=0.7 * style.line)
    axes.scatter(*start.com_position, s=dot, color=BASE_COLOUR, depthshade=False, linewidths=0.0)
    corners = [s.foot_position.reshape(-1, 3), s.com_position, outline_of(plan.robot, _pose(start))]
    for goal in _goals(plan):
        outline = outline_of(plan.robot, goal)
        corners.append(outline)
        axes.plot(*outline.T, color=GOAL_COLOUR, lw=0.7 * style.line)
        axes.scatter(*goal[:3], s=6 * dot, marker="*", color=GOAL_COLOUR, depthshade=False, linewidths=0.0)
    _fit(figure, axes, np.concatenate(corners), style)
    figure.legend(
        handles=[
            *_leg_lines(),
            Line2D([], [], color=BASE_COLOUR, label="CoM"),
            Line2D([], [], color=BASE_COLOUR, marker="o", ls="", ms=3.0 * style.line, label="start"),
            Line2D([], [], color=GOAL_COLOUR, marker="*", ls="", ms=6.0 * style.line, label="goal"),
            Line2D([], [], color=SECOND_COLOUR, marker="o", ls="", ms=3.0 * style.line, label="touch-down"),
        ],
        loc="upper center",
        ncols=4,
    )


def _draw_ground(axes: Axes3D, terrain: Terrain, points: Array) -> None:
    """The ground under points (n, 3)."""
    low, high = points[:, :2].min(axis=0) - AROUND, points[:, :2].max(axis=0) + AROUND
    mesh = mesh_of(terrain, low, high, MOST_CELLS)
    corners = mesh.corners
    floor = points[:, 2].min() - AROUND  # a deep ditch has no floor
    seen = corners[..., 2].max(axis=1) >= floor
    corners = np.concatenate([corners[..., :2], np.maximum(corners[..., 2:], floor)], axis=-1)[seen]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    elevation, azimuth = np.radians([axes.elev, axes.azim])
    towards = [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    facing = normal @ np.array(towards) > 1e-9
    corners, number = halved(corners[facing], LARGEST, 8)  # Matplotlib sorts them by their middles
    colours = mesh.colours[seen][facing][number] / 255.0
    axes.add_collection3d(
        Poly3DCollection(corners, facecolors=colours, edgecolors=colours, linewidths=0.2, zorder=-1.0)
    )


def draw_top(figure: Figure, plan: Plan, style: Style) -> None:
    """The motion from above at a few times, with the headings of the feet; one panel per goal."""
    s, goals = dense_samples(plan), _goals(plan)
    edges = [0.0, *(later.at for later in plan.scenario.goal.then), plan.horizon]
    points = np.concatenate([s.foot_position[..., :2].reshape(-1, 2), s.com_position[:, :2]])
    points = np.concatenate([points, *(outline_of(plan.robot, goal)[:, :2] for goal in goals)])
    margin = 0.03 + max(leg.wheel_radius or 0.0 for leg in plan.robot.leg_list)
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    shape = (high[1] - low[1]) / (high[0] - low[0])
    figure.set_size_inches(style.width, (0.22 + min(0.84 * shape, 1.2) * len(goals)) * style.width)
    panels = figure.subplots(len(goals), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    terrain, scale = plan.scenario.terrain, None
    for axes, goal, (begin, end) in zip(panels, goals, pairwise(edges), strict=True):
        if not is_plane(terrain):
            axes.grid(visible=False)
            scale = draw_relief(axes, terrain, low, high, style)
        now = s.at((s.time >= begin) & (s.time <= end))
        for leg in reversed(range(4)):
            axes.plot(*now.foot_position[:, leg, :2].T, color=LEG_COLOURS[leg], lw=0.6 * style.line)
        axes.plot(*now.com_position[:, :2].T, color=BASE_COLOUR, lw=0.6 * style.line)
        axes.plot(*outline_of(plan.robot, goal)[:, :2].T, color=GOAL_COLOUR, lw=0.8 * style.line)
        axes.plot(*goal[:2], ls="", marker="*", ms=7.0 * style.line, color=GOAL_COLOUR, zorder=4)
        for time in snapshot_times(plan, begin, end):
            _snapshot(axes, plan, plan.sample(time), style)
        axes.set_aspect("equal")
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_ylabel("y (m)")
    panels[-1].set_xlabel("x (m)")
    if scale is not None:
        add_scale(figure, scale, panels[len(panels) // 2])
    goal_mark = Line2D([], [], color=GOAL_COLOUR, marker="*", ls="", ms=7.0 * style.line, label="goal")
    com = Line2D([], [], color=BASE_COLOUR, label="CoM")
    figure.legend(handles=[*_leg_lines(), com, goal_mark], loc="outside upper center", ncols=6)


def _snapshot(axes: Axes, plan: Plan, now: Samples, style: Style) -> None:
    """The robot from above at one time."""
    axes.fill(*outline_of(plan.robot, _pose(now))[:, :2].T, color=SECOND_COLOUR, alpha=0.12, lw=0.0)
    axes.plot(*outline_of(plan.robot, _pose(now))[:, :2].T, color=SECOND_COLOUR, lw=0.5 * style.line)
    for leg, (data, line) in enumerate(zip(plan.robot.leg_list, _legs(plan.robot, now), strict=True)):
        axes.plot(*line[:, :2].T, color=SECOND_COLOUR, lw=0.5 * style.line)
        foot, radius = now.foot_position[leg, :2], data.wheel_radius
        air = "none" if not now.contact[leg] else LEG_COLOURS[leg]
        if data.foot == "point" or radius is None:
            axes.plot(*foot, "o", ms=3.0 * style.line, color=LEG_COLOURS[leg], mfc=air, zorder=3)
            continue
        along = radius * np.array([np.cos(now.heading[leg]), np.sin(now.heading[leg])])
        bar = np.stack([foot - along, foot + along])
        axes.plot(*bar.T, color=LEG_COLOURS[leg], lw=3.0 * style.line, zorder=3, solid_capstyle="butt")
        if not now.contact[leg]:  # a hollow bar: the wheel is in the air
            inner = np.stack([foot - 0.8 * along, foot + 0.8 * along])
            axes.plot(*inner.T, color="white", lw=1.6 * style.line, zorder=3, solid_capstyle="butt")
    rear = 0.25 * (hips(plan.robot)[2:, 0].sum())  # half-way from the CoM: the middle shows the goal's star
    x, y, _ = _in_world(np.array([[rear, 0.0]]), _pose(now))[0]
    axes.annotate(
        f"{float(now.time):.1f} s",
        (x, y),
        ha="center",
        va="center",
        zorder=5,
        path_effects=[patheffects.withStroke(linewidth=2.0 * style.line, foreground="white")],
    )


def _pose(now: Samples) -> Array:
    """x, y, z of the CoM (m), yaw, pitch, roll (rad) at one time, shape (6,)."""
    return np.concatenate([now.com_position, now.euler])


def _goals(plan: Plan) -> list[Array]:
    """Poses of all goals in the order of time, shape (6,) each."""
    begins = [0.0, *(later.at for later in plan.scenario.goal.then)]
    return list(goal_poses(plan.scenario, np.array(begins)))


def outline_of(robot: Robot, pose: Array) -> Array:
    """Closed outline of the level body at the height of the CoM, with its nose, world, shape (6, 3), m."""
    fl, fr, hl, hr = hips(robot)
    nose = 0.5 * (fl + fr) + [NOSE, 0.0]
    return _in_world(np.array([fl, nose, fr, hr, hl, fl]), pose)


def _legs(robot: Robot, now: Samples) -> Array:
    """Lines from the hips to the contact points, world, shape (4, 2, 3), m."""
    return np.stack([_in_world(hips(robot), _pose(now)), now.foot_position], axis=1)


def _in_world(points: Array, pose: Array) -> Array:
    c, s = np.cos(pose[3]), np.sin(pose[3])
    xy = pose[:2] + points @ np.array([[c, s], [-s, c]])
    return np.column_stack([xy, np.full(len(points), pose[2])])


def _leg_lines() -> list[Line2D]:
    return [Line2D([], [], color=c, label=n) for n, c in zip(LEG_NAMES, LEG_COLOURS, strict=True)]


def _fit(figure: Figure, axes: Axes3D, points: Array, style: Style) -> None:
    """The same scale on all three axes in a box around the points, and a figure that just holds the box."""
    low, high = points.min(axis=0) - 0.05, points.max(axis=0) + 0.05
    for axis, label, a, b in zip((axes.xaxis, axes.yaxis, axes.zaxis), "xyz", low, high, strict=True):
        axis.set_view_interval(a, b, ignore=True)
        axis.set_major_locator(ticks(max(2, min(6, int((b - a) / 0.3)))))
        axis.set_label_text(f"{label} (m)")
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_tick_params(pad=-0.2 * style.font)
        axis.labelpad = 3.0 * style.font / style.width  # further from the numbers where the box is small
    em = style.font / 72.0  # inch
    figure.set_size_inches(style.width, style.width)
    axes.set_box_aspect(high - low)
    axes.apply_aspect()
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    seen = np.column_stack(proj3d.proj_transform(*corners.T, axes.get_proj())[:2])
    extent = np.ptp(axes.transData.transform(seen), axis=0) / figure.dpi
    left, right = 2.5 * em, 6.5 * em  # numbers and labels of the axes
    zoom = (style.width - left - right) / extent[0]
    axes.set_box_aspect(high - low, zoom=zoom)
    below, above = 3.5 * em, 4.5 * em  # numbers and labels; the legend
    height = below + zoom * extent[1] + above
    figure.set_size_inches(style.width, height)
    middle = below + 0.5 * zoom * extent[1]
    aside = 0.5 * (left - right) / style.width
    axes.set_position((aside, (middle - 0.5 * style.width) / height, 1.0, style.width / height))
