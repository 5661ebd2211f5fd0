"""`rollgait track`: from a plan to the joints of the whole body."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import AsJson, PlanFile, rate_from
from rollgait.cli.output import MILLI, number, print_json, print_table
from rollgait.cli.replacing import note_replacing
from rollgait.files import check_writable, npz_path

if TYPE_CHECKING:
    from rollgait.tracking import TrackingReport


def track(
    plan_file: PlanFile,
    rate: Annotated[str, typer.Option(metavar="HZ", help="Steps per second.")] = "200",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write. Default: <plan>.joints.npz.")
    ] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Track the plan even if its certificate fails.")
    ] = False,
    waist: Annotated[
        str, typer.Option(metavar="NAME", help="What is held at its plan: com, or base at a constant offset.")
    ] = "com",
    whole_body: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Whole body (.yaml); the robot's own if not given."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find the joints' motion that executes a plan.

    Angles, velocities and torques, with a report of how well they follow the plan.

    Exit status: 0 if the whole body follows the plan within 1 mm, 0.5 degrees and its limits, 1 otherwise
    (what was found is still written) or if the plan is not certified, 2 wrong input.
    """
    from rollgait.plan.plan import Plan
    from rollgait.tracking import track as track_plan

    per_second = rate_from(rate)
    target = npz_path(out or f"{plan_file.stem}.joints.npz", "out")
    check_writable(target)
    plan = Plan.load(plan_file)
    joints = track_plan(plan, per_second, force=force, waist=waist, whole_body=whole_body)
    note_replacing(target)
    written = joints.save(target)
    if as_json:
        print_json({"file": str(written), **joints.report.to_dict()})
    else:
        count = len(joints.joint_names)
        print(f"{plan_file}: {plan.robot.name}, {count} joints, {per_second:g} steps per second\n")
        print_tracking(joints.report)
        print(f"\nwritten: {written}")
    if not joints.report.passed:
        raise typer.Exit(1)


def print_tracking(report: TrackingReport) -> None:
    """The rows of a report, and what the steps took."""
    rows = [("row", "worst", "limit", "unit", "where", "time", "verdict")]
    for row in report.rows:
        sign = "≥" if row.at_least else "≤"
        limit = "" if row.limit is None else f"{sign} {number(row.limit)}"
        verdict = "" if row.limit is None else "pass" if row.passed else "fail"
        rows.append((row.name, number(row.worst), limit, row.unit, row.where, f"{row.time:.2f} s", verdict))
    print_table(rows, right=[1, 5])
    print()
    mean, longest = (number(MILLI * value) for value in (report.step_time, report.step_time_max))
    print_table(
        [
            (
                "steps",
                f"{report.steps}, {report.bounded_steps} shaped by limits, {report.failed_steps} failed",
            ),
            ("time", f"{mean} ms per step, at most {longest} ms"),
            ("forces", f"{number(report.wrench_mismatch)} N rms missing for the moving legs"),
        ]
    )
