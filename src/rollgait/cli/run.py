"""`rollgait run`: the whole chain for one scenario, and one page that tells of it."""

from __future__ import annotations

from dataclasses import asdict
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollgait.cli.arguments import AsJson, Full, Overwrite, Profile, ScenarioName, Settings, scenario_with
from rollgait.cli.output import print_json
from rollgait.cli.progress import SolverLine
from rollgait.cli.replacing import note_replacing, refuse_other_plan
from rollgait.cli.report import print_certificate, print_plan
from rollgait.cli.simulate import (
    Feedback,
    Friction,
    Latency,
    PayloadText,
    Pushes,
    RadiusError,
    Slope,
    WholeBodyFile,
    conditions,
    disturbances_from,
    print_simulation,
)
from rollgait.cli.track import print_tracking
from rollgait.errors import MissingExtraError, NotSolvedError
from rollgait.files import check_writable

if TYPE_CHECKING:
    from rollgait.plan.plan import Plan
    from rollgait.scenario.scenario import Scenario
    from rollgait.simulation import SimulationLog
    from rollgait.tracking import JointTrajectory

PLAN, JOINTS, LOG, REPORT, VIDEO = "plan.npz", "joints.npz", "simulation.npz", "report.html", "film.mp4"
"""Names of the files in the folder."""


def run(
    scenario: ScenarioName,
    settings: Settings = None,
    profile: Profile = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for all files. Default: <scenario>-run.")
    ] = None,
    feedback: Feedback = False,
    push: Pushes = None,
    payload: PayloadText = None,
    friction: Friction = None,
    radius_error: RadiusError = None,
    latency: Latency = None,
    slope: Slope = None,
    force: Annotated[
        bool, typer.Option("--force", help="Execute the plan even if its certificate fails.")
    ] = False,
    whole_body: WholeBodyFile = None,
    video: Annotated[bool, typer.Option("--video", help="Write a film as well.")] = False,
    overwrite: Overwrite = False,
    full: Full = False,
    as_json: AsJson = False,
) -> None:
    """Plan, check, track, simulate; write one report page.

    Exit status: 0 certified, tracked within its limits, and the robot stays on its feet; 1 otherwise (what
    was found is written), 2 wrong input.
    """
    given = disturbances_from(push, payload, friction, radius_error, latency, slope)
    asked = scenario_with(scenario, settings, profile)
    name = Path(scenario).stem
    folder = out or Path(f"{name}-run")
    check_writable(folder / REPORT)
    _require_whole_body(asked, whole_body)
    from rollgait.simulation.run import STANDING

    given.check_begins(asked.horizon + STANDING)  # before the plan, not after it
    refuse_other_plan(folder / PLAN, asked, overwrite)
    if video:
        from rollgait.simulation.video import check_video

        check_video(folder / VIDEO)
    from rollgait.planner import plan as make_plan
    from rollgait.simulation import simulate
    from rollgait.tracking import track

    try:
        with SolverLine(quiet=as_json) as progress:
            plan = make_plan(asked, progress=progress)
    except NotSolvedError as error:
        if error.plan is not None:
            error.plan.save(folder / f"{Path(PLAN).stem}.failed.npz")
        raise
    note_replacing(folder / PLAN)
    files = [plan.save(folder / PLAN)]
    joints: JointTrajectory | None = None
    log: SimulationLog | None = None
    if force or plan.certificate().passed:
        joints = track(plan, force=force, whole_body=whole_body)
        files.append(joints.save(folder / JOINTS))
        log = simulate(joints, given, feedback=feedback, whole_body=whole_body)
        files.append(log.save(folder / LOG))
        if video:
            from rollgait.cli.simulate import body_of
            from rollgait.simulation.video import save_video

            files.append(save_video(log, folder / VIDEO, body_of(log, whole_body)))
    from rollgait.cli.run_page import page_of

    files.append(page_of(name, plan, joints, log).save(folder / REPORT))
    if as_json:
        print_json(_as_data(plan, joints, log) | {"files": [str(file) for file in files]})
    else:
        _print(name, plan, joints, log, full)
        for file in files:
            print(f"written: {file}")
    if not (plan.certificate().passed and joints and joints.report.passed and log and not log.fallen):
        raise typer.Exit(1)


def _require_whole_body(asked: Scenario, whole_body: Path | None) -> None:
    """Raises what tracking and simulating would raise: before the plan, not after it."""
    from rollgait.robot.whole_body import EXTRA, find_whole_body, load_whole_body

    try:
        for module in ("daqp", "mujoco", "pinocchio"):
            import_module(module)
    except ImportError:
        raise MissingExtraError("'rollgait run'", EXTRA) from None
    if whole_body is None:
        find_whole_body(asked.body)
    else:
        load_whole_body(whole_body)


def _print(
    name: str, plan: Plan, joints: JointTrajectory | None, log: SimulationLog | None, full: bool
) -> None:
    print_plan(plan, name)
    print_certificate(plan.certificate(), full)
    if joints is None or log is None:
        print("\nnot executed: the plan is not certified; --force executes it anyway\n")
        return
    print("\ntracking")
    print_tracking(joints.report)
    how = "with feedback of the base pose" if log.feedback else "open loop"
    print(f"\nphysics, {how}: {conditions(log.disturbances)}")
    print_simulation(log.report())
    print()


def _as_data(plan: Plan, joints: JointTrajectory | None, log: SimulationLog | None) -> dict[str, Any]:
    return {
        "statistics": asdict(plan.statistics),
        "certificate": plan.certificate().to_dict(),
        "tracking": None if joints is None else joints.report.to_dict(),
        "simulation": None if log is None else log.report().to_dict(),
    }
