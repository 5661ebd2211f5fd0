"""`rollgait mpc`: the controller drives a model or the simulated robot, and a report says how well."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollgait.cli.arguments import AsJson, GroundName, Kernels
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
from rollgait.cli.live import (
    Bridged,
    Domain,
    FoxgloveCommands,
    FoxglovePort,
    WithFoxglove,
    opened,
    reach_if,
    shown,
)
from rollgait.cli.output import MILLI, number, print_json, print_table
from rollgait.cli.progress import StatusLine
from rollgait.cli.simulate import Friction, Latency, PayloadText, RadiusError, Slope
from rollgait.view.recordings import check_recording

if TYPE_CHECKING:
    from rollgait.cli.mpc_input import Asked
    from rollgait.mpc.log import MpcLog, MpcReport
    from rollgait.mpc.loop import ClosedLoop
    from rollgait.mpc.settings import MpcSettings


def mpc(
    robot: Annotated[
        str | None,
        typer.Argument(metavar="ROBOT", help="Name of a robot or a YAML file. Default: centauro."),
    ] = None,
    plant: Annotated[
        str, typer.Option(metavar="NAME", help="What is controlled: rigid, mujoco or replay:LOG.npz.")
    ] = "rigid",
    command: Annotated[
        str,
        typer.Option(
            metavar="WHAT",
            help="random; velocities such as forward=0.3,turn_rate=0.2; a pose such as x=1,yaw_deg=90; a "
            "script or a scenario (.yaml, or a scenario's name); with --bridge also cmd_vel: what comes on "
            "that topic.",
        ),
    ] = "random",
    gait: Annotated[
        str | None, typer.Option(metavar="NAME", help="One gait all the time: stand, drive, crawl …")
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option(metavar="S", help="Length of the run. Default: 20, or the command's."),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of all that is random.")] = 0,
    push: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORCE@START",
            help="Push the base, e.g. 100N@5s or 50N:-y@3s:0.2s; 100N/5s is every 5 s in random directions. "
            "Repeatable.",
        ),
    ] = None,
    estimator: Annotated[
        str, typer.Option(metavar="NAME", help="What is known of the state: truth, noisy or delayed.")
    ] = "truth",
    horizon: Annotated[float | None, typer.Option(metavar="S", help="Of the controller.")] = None,
    interval: Annotated[float | None, typer.Option(metavar="S", help="Of its horizon.")] = None,
    iterations: Annotated[
        int | None, typer.Option(metavar="N", help="Most iterations of a step; 1 is the real-time iteration.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Set a key of the controller, e.g. weights.acc=2; repeatable.",
        ),
    ] = None,
    payload: PayloadText = None,
    friction: Friction = None,
    radius_error: RadiusError = None,
    latency: Latency = None,
    slope: Slope = None,
    ground: GroundName = None,
    kernels: Kernels = True,
    bridge: Bridged = False,
    domain: Domain = None,
    foxglove: WithFoxglove = False,
    foxglove_port: FoxglovePort = None,
    foxglove_commands: FoxgloveCommands = False,
    record: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the log (.npz), a page (.html) or a film.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Let the controller follow commands.

    Reports how well and how quickly it did.

    Exit status: 0 if the robot stays on its feet, 1 if it falls or stands for good, 2 wrong input.
    """
    from rollgait.cli.mpc_input import REPLAY, asked_from, settings_from

    if record is not None:
        check_recording(record, "record", DATA)
    given = {"horizon": horizon, "interval": interval, "iterations": iterations}
    asked = asked_from(command, gait, duration, seed, push or ())
    chosen = settings_from(given, settings or ())
    disturbed = (payload, friction, radius_error, latency, slope)
    reach = reach_if(bridge, domain, foxglove, foxglove_port, foxglove_commands)
    _check_outside(asked, command, bridge, foxglove_commands)
    with (
        opened(reach, quiet=as_json) as others,
        StatusLine("building the controller …", quiet=as_json) as line,
    ):
        loop = _loop(robot, plant, asked, chosen, estimator, disturbed, ground, kernels, seed)
        if plant.startswith(REPLAY):
            asked = _no_longer(asked, loop)
        with stopping() as stop, shown(loop, others, "mpc", heard=asked.outside) as live:
            watch = Watching(line, asked.script.duration, stop, live)
            log = loop.run(asked.script, watch, None if live is None else live.ask)
    file = None if record is None else str(write_log(log, record))
    report = log.report()
    if as_json:
        print_json({"file": file, "command": asked.words, **report.to_dict()})
    else:
        _print(log, report, asked, chosen, estimator)
        print_written(file)
    leave(stop, report.passed)


def _check_outside(asked: Asked, command: str, bridge: bool, foxglove_commands: bool) -> None:
    """Raises `InputError` where commands shall come from outside and cannot, or could and shall not."""
    from rollgait.cli.mpc_input import OUTSIDE
    from rollgait.errors import InputError

    if asked.outside and not bridge:
        raise InputError("command", command, "goes with --bridge: it is heard on the topics of ROS 2")
    if foxglove_commands and not asked.outside:
        raise InputError("foxglove-commands", True, f"goes with --command {OUTSIDE}: else nobody is heard")


def _loop(
    robot: str | None,
    plant: str,
    asked: Asked,
    settings: MpcSettings,
    estimator: str,
    disturbed: tuple[str | None, ...],
    ground: str | None,
    kernels: bool,
    seed: int,
) -> ClosedLoop:
    """The closed loop that the options ask for. Raises what they have wrong."""
    from rollgait.cli.ground_input import ground_from, terrain_of
    from rollgait.cli.mpc_input import REPLAY, first_gait
    from rollgait.errors import InputError, UnknownNameError
    from rollgait.mpc.setup import PLANTS, make_loop
    from rollgait.robot.library import find_robot

    options: dict[str, Any] = {
        "estimator": estimator,
        "kernels": kernels,
        "seed": seed,
    }
    options |= disturbances_of(plant, disturbed, "payload, friction, radius error, latency or slope")
    if plant.startswith(REPLAY):
        from rollgait.mpc.log import MpcLog
        from rollgait.mpc.plants.replay import Replay

        if asked.script.pushes:
            raise InputError("push", plant, "is a recording, which cannot be pushed")
        if ground is not None:
            raise InputError("ground", ground, "cannot be chosen for a recording: it was made on its own")
        log = MpcLog.load(plant.removeprefix(REPLAY))
        body = log.robot if robot is None else find_robot(robot)
        return make_loop(body, Replay(log), settings, gait=first_gait(asked, body), **options)
    if plant not in PLANTS:
        raise UnknownNameError("plant", plant, (*PLANTS, f"{REPLAY}FILE"))
    if asked.scenario is not None:
        options["start"] = asked.scenario.start
        options["terrain"] = terrain_of(asked.scenario.ground)
        options["loads"] = asked.scenario.loads
    if ground is not None:
        options["terrain"] = terrain_of(ground_from(ground)[0])
    usual = asked.scenario.robot if asked.scenario is not None else "centauro"
    chosen = usual if robot is None else robot
    body = find_robot(chosen) if isinstance(chosen, str) else chosen
    return make_loop(body, plant, settings, gait=first_gait(asked, body), **options)


def _no_longer(asked: Asked, loop: ClosedLoop) -> Asked:
    """The same, no longer than the recording."""
    from dataclasses import replace

    length = min(asked.script.duration, loop.plant.duration)  # type: ignore[attr-defined]
    return replace(asked, script=asked.script.model_copy(update={"duration": length}))


def _print(log: MpcLog, report: MpcReport, asked: Asked, settings: MpcSettings, estimator: str) -> None:
    """The report for a person."""
    length = f"{number(report.duration)} s of {number(asked.script.duration)} s"
    print(f"{log.robot.name}, {log.plant}, {length}: {asked.words}")
    times = "1 iteration" if settings.iterations == 1 else f"up to {settings.iterations} iterations"
    horizon = f"horizon {number(settings.horizon)} s in intervals of {number(settings.interval)} s"
    pushes = f", {len(asked.script.pushes)} pushes" if asked.script.pushes else ""
    print(f"  {horizon}, {times} a step, state: {estimator}{pushes}\n")
    print_table(
        [
            ("rate", number(report.rate), "Hz"),
            ("step, median", number(report.median_ms), "ms"),
            ("step, 99 %", number(report.p99_ms), "ms"),
            ("step, worst", number(report.worst_ms), "ms"),
            ("missed deadlines", str(report.late), f"of {report.steps} steps"),
            ("forward, rms", number(MILLI * report.forward_rms), "mm/s from what is asked for"),
            ("lateral, rms", number(MILLI * report.lateral_rms), "mm/s"),
            ("turn rate, rms", number(math.degrees(report.turn_rms)), "deg/s"),
            ("place, rms", number(MILLI * report.place_rms), "mm from the reference"),
            ("final place", number(MILLI * report.final_place), "mm"),
            ("final yaw", number(report.final_yaw_deg), "deg"),
            ("violation", number(report.violation), "largest of a constraint, scaled"),
            ("tilt, largest", number(report.tilt_deg), "deg from upright"),
            ("outside the box", number(MILLI * report.outside), "mm, a foot at most"),
            ("coasting", str(report.coasting), "steps on an older plan"),
            ("standing", str(report.standing), "steps after a fault"),
        ],
        right=[1],
    )
    print_events(report.events)
    print(f"\n  {report.verdict}")
