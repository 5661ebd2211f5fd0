"""`rollgait execute`: the controller carries out plans on a model or the simulated robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollgait.cli.arguments import AsJson, Kernels
from rollgait.cli.controlled import (
    DATA,
    Watching,
    disturbances_of,
    leave,
    print_events,
    print_written,
    stopping,
    write_log,
)
from rollgait.cli.live import Bridged, Domain, FoxglovePort, WithFoxglove, opened, reach_if, shown
from rollgait.cli.output import MILLI, number, print_json, print_table
from rollgait.cli.progress import StatusLine
from rollgait.cli.simulate import Friction, Latency, PayloadText, RadiusError
from rollgait.view.recordings import check_recording

if TYPE_CHECKING:
    from rollgait.mpc.execution import ExecutionReport
    from rollgait.mpc.loop import ClosedLoop
    from rollgait.plan.plan import Plan


def execute(
    plans: Annotated[
        list[Path],
        typer.Argument(
            metavar="PLAN...", help="What 'rollgait plan' wrote (.npz); each begins where the last one ends."
        ),
    ],
    plant: Annotated[
        str, typer.Option(metavar="NAME", help="What is controlled: rigid, or mujoco, the whole robot.")
    ] = "mujoco",
    push: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORCE@START",
            help="Push the base, e.g. 50N@3s or 50N:-y@3s:0.2s; 50N/5s is every 5 s in random directions. "
            "Repeatable.",
        ),
    ] = None,
    payload: PayloadText = None,
    friction: Friction = None,
    radius_error: RadiusError = None,
    latency: Latency = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of all that is random.")] = 0,
    estimator: Annotated[
        str, typer.Option(metavar="NAME", help="What is known of the state: truth, noisy or delayed.")
    ] = "truth",
    replan: Annotated[
        bool,
        typer.Option("--replan", help="Replace a plan that no longer fits, while the robot moves."),
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Execute plans even if their certificates fail.")
    ] = False,
    kernels: Kernels = True,
    bridge: Bridged = False,
    domain: Domain = None,
    foxglove: WithFoxglove = False,
    foxglove_port: FoxglovePort = None,
    record: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the log (.npz), a page (.html) or a film.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Let the controller carry out plans, one after the other.

    Reports how near it came to them.

    Exit status: 0 if the robot carries them out on its feet, 1 if it falls, stands for good or gives up, or a
    plan is not certified, 2 wrong input.
    """
    if record is not None:
        check_recording(record, "record", DATA)
    reach = reach_if(bridge, domain, foxglove, foxglove_port)
    from rollgait.cli.mpc_input import pushes_from
    from rollgait.mpc.execution import execute as execute_plans
    from rollgait.mpc.execution import run_length
    from rollgait.plan.plan import Plan
    from rollgait.tracking.entry import refuse_uncertified

    loaded = [Plan.load(path) for path in plans]
    if not force:
        for plan in loaded:
            refuse_uncertified(plan)
    planned = sum(plan.horizon for plan in loaded)
    pushes = [one for text in push or () for one in pushes_from(text, run_length(loaded), seed)]
    disturbed = (payload, friction, radius_error, latency)
    with (
        opened(reach, quiet=as_json) as others,
        StatusLine("building the controller …", quiet=as_json) as line,
    ):
        loop = _loop(loaded, plant, estimator, disturbed, kernels, seed)
        with stopping() as stop, shown(loop, others, "execute") as live:
            watch = Watching(line, planned, stop, live)
            found = execute_plans(loaded, loop, watch, pushes, replan)
    file = None if record is None else str(write_log(found.log, record))
    report = found.report
    if as_json:
        print_json({"file": file, "plans": [str(path) for path in plans], **report.to_dict()})
    else:
        _print(plans, found.log.plant, report)
        print_written(file)
    leave(stop, report.passed)


def _loop(
    plans: Sequence[Plan],
    plant: str,
    estimator: str,
    disturbed: tuple[str | None, str | None, str | None, str | None],
    kernels: bool,
    seed: int,
) -> ClosedLoop:
    """The closed loop that the options ask for. Raises what they have wrong."""
    from rollgait.errors import UnknownNameError
    from rollgait.mpc.execution import loop_for
    from rollgait.mpc.setup import PLANTS

    if plant not in PLANTS:
        raise UnknownNameError("plant", plant, PLANTS)
    options: dict[str, Any] = {"estimator": estimator, "kernels": kernels, "seed": seed}
    options |= disturbances_of(plant, (*disturbed, None), "payload, friction, radius error or latency")
    return loop_for(plans[0], plant, *plans[1:], **options)


def _print(plans: Sequence[Path], plant: str, report: ExecutionReport) -> None:
    """The report for a person."""
    names = ", ".join(str(path) for path in plans)
    print(f"{names}: {plant}, {number(report.end)} s for {number(report.planned)} s of plan\n")
    steps = len(report.footholds)
    rows = [
        ("final place", number(MILLI * report.final_distance), "mm from the plan in the ground plane"),
        ("final height", number(MILLI * report.final_height), "mm above the plan"),
        ("final angle", number(math.degrees(report.final_angle)), "deg from the plan"),
        ("of it yaw", number(math.degrees(report.final_yaw)), "deg"),
        ("footholds, largest", number(MILLI * report.foothold_worst), f"mm from the plan, of {steps}"),
        ("footholds, rms", number(MILLI * report.foothold_rms), "mm"),
        ("CoM, rms", number(MILLI * report.com_rms), "mm from the plan at its time"),
        ("CoM, largest", number(MILLI * report.com_worst), "mm"),
        ("tilt, largest", number(math.degrees(report.tilt)), "deg from upright"),
        ("tilt error", number(math.degrees(report.tilt_error)), "deg from the plan, largest"),
        ("late at the end", number(report.shift), "s"),
        ("waited", str(report.holds), "times, pushed off"),
        ("torque, largest", number(100.0 * report.torque_share), "% of its limit, any joint"),
        ("at a torque limit", number(report.at_limit), "s, any joint"),
        ("step, median", number(report.controller.median_ms), "ms"),
        ("step, 99 %", number(report.controller.p99_ms), "ms"),
        ("coasting", str(report.controller.coasting), "steps on an older solution"),
        ("standing", str(report.controller.standing), "steps after a fault"),
    ]
    if report.replacements:
        done = sum(one.done for one in report.replacements)
        rows.append(("plans replaced", str(done), f"of {len(report.replacements)} that no longer fitted"))
    print_table(rows, right=[1])
    print_events(report.controller.events)
    for contact in report.unplanned:
        where = f"{contact.link} touches the ground at {number(contact.time)} s"
        print(f"\nunplanned contact: {where}, with up to {number(contact.force)} N")
    print(f"\n  {report.verdict}")
