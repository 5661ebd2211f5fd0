"""Cards: what a notebook shows of a plan, a certificate, a scenario, a robot or what came of one.

HTML with styles of its own and no script; colours of the text are the notebook's, so that it is read on light
and on dark. Text from files is escaped.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from functools import singledispatch
from html import escape
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rollgait.many import Outcome
from rollgait.plan.certificate import Certificate, Row
from rollgait.plan.plan import Plan
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.scenario import Scenario
from rollgait.view.figures import figure
from rollgait.view.in_space import outline_of
from rollgait.view.marks import measure
from rollgait.view.motion import goal_poses
from rollgait.view.on_ground import is_plane
from rollgait.view.relief_map import draw_relief
from rollgait.view.style import GOAL_COLOUR, LEG_COLOURS, SECOND_COLOUR, find_style

GOOD: Final = "#2E9E4F"
BAD: Final = "#D6455D"
"""Read on white and on black."""
WIDTH: Final = 460
"""Of a picture, pixels."""
DPI: Final = 110
NEAREST: Final = 5
"""Rows of a certificate beside those that fail."""
STYLE: Final = "screen"


@singledispatch
def card(thing: object) -> str:
    """The card of something. A kind that has none is its text."""
    return f"<pre>{escape(repr(thing))}</pre>"


@card.register
def _(plan: Plan) -> str:
    s, certificate = plan.statistics, plan.certificate()
    steps = sum(1 for _ in plan.schedule.swings())
    facts = [
        f"{plan.horizon:g} s, {steps} steps, profile {plan.scenario.profile}",
        f"{s.iterations} iterations of {s.solver}, {s.wall_time:.2f} s in all; cost {s.cost:.4g}",
    ]
    verdict = _verdict(certificate) if plan.solved else _said("not solved", False)
    picture = _image(figure(plan, "top", STYLE), "the motion from above")
    return _box(f"Plan · {escape(plan.robot.name)}", verdict, facts, picture)


@card.register
def _(certificate: Certificate) -> str:
    shown = (*certificate.failures, *certificate.nearest(NEAREST))
    left = len(certificate.rows) - len(shown)
    facts = [f"{left} more rows: print(certificate)"] if left else []
    return _box("Certificate", _verdict(certificate), facts, _bars(shown))


@card.register
def _(scenario: Scenario) -> str:
    body, goal = scenario.body, scenario.goal
    last = goal.then[-1] if goal.then else goal
    steps = sum(1 for _ in scenario.schedule.swings())
    facts = [
        f"goal {last.x:g} m, {last.y:g} m, {last.yaw_deg:g}° in {scenario.horizon:g} s",
        f"{scenario.gait.kind}, {steps} steps, ground {scenario.ground.kind}, profile {scenario.profile}",
    ]
    picture = _image(_scenario_figure(scenario), "start and goals from above")
    return _box(f"Scenario · {escape(body.name)}", escape(scenario.description), facts, picture)


@card.register
def _(robot: Robot) -> str:
    feet = ", ".join(dict.fromkeys(leg.foot for leg in robot.leg_list))
    radii = ", ".join(dict.fromkeys(f"{leg.foot_radius:g} m" for leg in robot.leg_list))
    facts = [
        f"{robot.mass:.4g} kg, CoM {robot.height:.3g} m above the ground",
        f"feet {feet}, radius {radii}",
    ]
    picture = _image(_robot_figure(robot), "the robot from above")
    return _box(f"Robot · {escape(robot.name)}", escape(robot.description), facts, picture)


@card.register
def _(outcome: Outcome) -> str:
    name = f"<b>{escape(outcome.name)}</b>"
    if outcome.plan is not None:
        return f"<div>{name}{card(outcome.plan)}</div>"
    return _box(f"Outcome · {escape(outcome.name)}", _said("no plan", False), [escape(str(outcome.error))])


def _box(title: str, verdict: str, facts: Sequence[str], picture: str = "") -> str:
    lines = "".join(f"<div>{fact}</div>" for fact in facts)
    return (
        '<div style="font:13px/1.5 system-ui,sans-serif;max-width:34em;padding:0.4em 0">'
        f"<div><b>{title}</b></div><div>{verdict}</div>{lines}{picture}</div>"
    )


def _verdict(certificate: Certificate) -> str:
    failed = ", ".join(row.name for row in certificate.failures)
    return _said(f"not certified: {failed}" if failed else "certified", not failed)


def _said(text: str, good: bool) -> str:
    return f'<span style="color:{GOOD if good else BAD};font-weight:600">{escape(text)}</span>'


def _bars(rows: Sequence[Row]) -> str:
    """How near the rows are to their limits, as bars of which the whole length is the limit."""
    lines = []
    for row in rows:
        failed = row.verdict == "fail"
        share, colour = 1.0 if failed else min(row.nearness, 1.0), BAD if failed else GOOD
        value = measure(row.worst, row.limit, row.unit, row.sense == "at least")
        where = " ".join(filter(None, [row.leg, "" if row.time is None else f"{row.time:.2f} s"]))
        bar = (
            '<div style="width:7em;height:0.7em;border:1px solid #8888;display:inline-block">'
            f'<div style="width:{100.0 * share:.0f}%;height:100%;background:{colour}"></div></div>'
        )
        cells = (escape(row.name), bar, escape(value), escape(where))
        lines.append(
            "<tr>"
            + "".join(f'<td style="text-align:left;white-space:nowrap">{cell}</td>' for cell in cells)
            + "</tr>"
        )
    return f'<table style="font-size:12px;font-variant-numeric:tabular-nums">{"".join(lines)}</table>'


def _image(picture: Figure, alt: str) -> str:
    stream = io.BytesIO()
    with find_style(STYLE).applied():
        picture.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    style = f"width:{WIDTH}px;max-width:100%;background:white"
    return f'<img alt="{alt}" style="{style}" src="data:image/png;base64,{data}">'


def _scenario_figure(scenario: Scenario) -> Figure:
    """Ground, start and goals from above."""
    start = scenario.start
    times = np.array([0.0, *(later.at for later in scenario.goal.then)])
    first = np.array([start.x, start.y, scenario.height, np.radians(start.yaw_deg), 0.0, 0.0])
    around = [outline_of(scenario.body, pose)[:, :2] for pose in (first, *goal_poses(scenario, times))]
    points = np.concatenate(around)
    low, high = points.min(axis=0) - 0.3, points.max(axis=0) + 0.3
    picture, axes = _ground_plan(low, high)
    if not is_plane(scenario.terrain):
        draw_relief(axes, scenario.terrain, low, high, find_style(STYLE))
    for number, line in enumerate(around):
        axes.plot(*line.T, color=GOAL_COLOUR if number else SECOND_COLOUR)
    _stand(axes, scenario.body, first)
    return picture


def _robot_figure(robot: Robot) -> Figure:
    """Body and feet from above."""
    reach = np.abs(robot.stance[:, :2]).max(axis=0) + np.array(robot.box[:2])
    picture, axes = _ground_plan(-reach, reach)
    pose = np.zeros(6)
    axes.plot(*outline_of(robot, pose)[:, :2].T, color=SECOND_COLOUR)
    for (x, y), colour in zip(robot.stance[:, :2], LEG_COLOURS, strict=True):
        dx, dy, _ = robot.box
        axes.fill([x - dx, x + dx, x + dx, x - dx], [y - dy, y - dy, y + dy, y + dy], color=colour, alpha=0.1)
    _stand(axes, robot, pose, names=True)
    return picture


def _ground_plan(low: Any, high: Any) -> tuple[Figure, Axes]:
    """An empty figure of the ground between two corners (2,), m, x to the right."""
    style = find_style(STYLE)
    with style.applied():
        width, depth = high - low
        picture = Figure(layout="constrained", figsize=(4.2, max(1.4, min(4.2, 0.8 + 3.6 * depth / width))))
        axes = picture.subplots()
        axes.set_aspect("equal")
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_xlabel("x (m)")
        axes.set_ylabel("y (m)")
    return picture, axes


def _stand(axes: Axes, robot: Robot, pose: Any, names: bool = False) -> None:
    """The feet of a standing robot: bars as long as the wheels, dots for points."""
    c, s = np.cos(pose[3]), np.sin(pose[3])
    turn = np.array([[c, -s], [s, c]])
    for leg, colour, name in zip(robot.leg_list, LEG_COLOURS, LEG_NAMES, strict=True):
        place = pose[:2] + turn @ np.array(leg.stance[:2])
        if leg.foot == "point":
            axes.plot(*place, "o", color=colour)
        else:
            along = leg.foot_radius * (turn @ [np.cos(leg.heading), np.sin(leg.heading)])
            axes.plot(*np.stack([place - along, place + along]).T, color=colour, lw=4.0)
        if names:
            axes.annotate(name, place, xytext=(6.0, 6.0), textcoords="offset points", color=colour)
