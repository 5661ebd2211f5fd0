"""The report page of `rollgait run`: what the terminal shows, and the figures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from rollgait.cli.output import number
from rollgait.cli.report import NEAREST
from rollgait.cli.simulate import conditions, summary_rows
from rollgait.plan.certificate import Row
from rollgait.plan.plan import Plan
from rollgait.robot.robot import LEG_NAMES
from rollgait.simulation import SimulationLog, SimulationReport
from rollgait.tracking import JointTrajectory, TrackingReport
from rollgait.view.figures import figure
from rollgait.view.moving_picture import moving_picture
from rollgait.view.page import Folded, Moving, Page, Part, Picture, Pictures, Sentence, Table
from rollgait.view.physics import physics_figure

PLAN_FIGURES = {
    "top": "From above: paths of the CoM and the feet",
    "base": "Base over time, with the goal",
    "wheels": "Wheels: speeds and headings",
    "gait": "Gait: which foot stands when",
    "forces": "Planned contact forces and heights of the feet",
}
PHYSICS_CAPTIONS = {
    "error": "Base link less its plan; the line marks the end of the motion",
    "contact-forces": "Normal contact forces, measured and planned; shaded: planned swing",
    "torques": "Torques of the most used joints as a share of their limits",
}
NEAR = "The rows nearest to their limits; all pass:"


def page_of(name: str, plan: Plan, joints: JointTrajectory | None, log: SimulationLog | None) -> Page:
    """The page of a plan, and of its execution where there was one."""
    page = Page(f"{name}: {plan.robot.name}")
    certificate = plan.certificate()
    says = (
        "certified"
        if certificate.passed
        else "not certified: " + ", ".join(row.name for row in certificate.failures)
    )
    stays = "it was not executed" if log is None else log.report().verdict
    page.add("Verdict", Sentence(f"The plan is {says}; {stays}.", True))
    page.add(
        "Motion", Moving(moving_picture(plan), "The plan, from the side and from above, in its own time")
    )
    page.add("Plan", Table(list(_plan_rows(plan)), right=[1]), _folded(_plan_pictures(plan)))
    shown = (*certificate.failures, *certificate.nearest(NEAREST))
    page.add(
        "Certificate",
        Sentence("The rows that fail, and those nearest to their limits:" if certificate.failures else NEAR),
        Table(list(_certificate_rows(shown)), right=[1]),
        Folded("All rows", [Table(list(_certificate_rows(certificate.rows)), right=[1])]),
    )
    if joints is not None:
        page.add("Whole body", *_tracking_parts(joints.report))
    if log is not None:
        page.add("Physics", *_physics_parts(log))
    return page


def _folded(pictures: list[Picture]) -> Folded:
    """Figures a click away: they are four screens."""
    return Folded(f"{len(pictures)} figures", [Pictures(pictures)])


def _plan_rows(plan: Plan) -> Iterator[tuple[str, str, str]]:
    s = plan.statistics
    yield ("quantity", "value", "unit")
    yield ("duration", number(plan.horizon), "s")
    yield ("profile", plan.scenario.profile, "")
    yield ("solver", s.solver, "")
    yield ("iterations", str(s.iterations), "")
    yield ("time to solve", number(s.solve_time), "s")
    for term, cost in s.costs.items():
        yield (f"cost: {term}", number(cost, 4), "")
    yield ("cost: total", number(s.cost, 4), "")


def _plan_pictures(plan: Plan) -> list[Picture]:
    return [Picture(figure(plan, name), caption) for name, caption in PLAN_FIGURES.items()]


def _certificate_rows(rows: Iterable[Row]) -> Iterator[tuple[str, ...]]:
    yield ("row", "worst", "limit", "unit", "leg", "time", "verdict")
    for row in rows:
        when = "" if row.time is None else f"{row.time:.2f} s"
        limit = "" if row.limit is None else f"{'≤' if row.sense == 'at most' else '≥'} {number(row.limit)}"
        yield (row.name, number(row.worst), limit, row.unit, row.leg or "", when, row.verdict)


def _tracking_parts(report: TrackingReport) -> list[Part]:
    rows: list[tuple[str, ...]] = [("row", "worst", "limit", "unit", "where", "time", "verdict")]
    for row in report.rows:
        limit = "" if row.limit is None else f"{'≥' if row.at_least else '≤'} {number(row.limit)}"
        said = "" if row.limit is None else "pass" if row.passed else "fail"
        rows.append((row.name, number(row.worst), limit, row.unit, row.where, f"{row.time:.2f} s", said))
    steps = f"{report.steps} steps, {report.bounded_steps} shaped by limits, {report.failed_steps} failed."
    return [Table(rows, right=[1]), Sentence(steps)]


def _physics_parts(log: SimulationLog) -> list[Part]:
    report = log.report()
    how = "with feedback of the base pose" if log.feedback else "open loop"
    return [
        Sentence(f"MuJoCo, {how}: {conditions(log.disturbances)}."),
        Table([("quantity", "value", "unit"), *summary_rows(report)], right=[1]),
        Table(list(_force_rows(report)), right=[1, 2]),
        Folded("All joints", [Table(list(_joint_rows(report)), right=[1, 2, 3])]),
        _folded([Picture(physics_figure(log, name), caption) for name, caption in PHYSICS_CAPTIONS.items()]),
    ]


def _force_rows(report: SimulationReport) -> Iterator[tuple[str, ...]]:
    yield ("leg", "force, measured − planned, rms", "planned, rms", "unit")
    for name, difference, planned in zip(LEG_NAMES, report.force_rms, report.force_planned_rms, strict=True):
        yield (name, number(difference), number(planned), "N")


def _joint_rows(report: SimulationReport) -> Iterator[tuple[str, ...]]:
    yield ("joint", "largest torque (N m)", "of its limit (%)", "at (s)")
    for use in report.joints:
        share = number(100.0 * use.share) if np.isfinite(use.share) else ""
        yield (use.joint, number(use.torque), share, f"{use.time:.2f}")
