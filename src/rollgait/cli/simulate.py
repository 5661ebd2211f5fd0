"""`rollgait simulate`: the whole body executes a plan in MuJoCo."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import AsJson
from rollgait.cli.motion_file import load_motion
from rollgait.cli.output import MILLI, number, print_json, print_table
from rollgait.cli.replacing import note_replacing
from rollgait.files import check_writable, npz_path

if TYPE_CHECKING:
    from rollgait.robot.whole_body import WholeBody
    from rollgait.simulation import Disturbances, SimulationLog, SimulationReport

MOST_USED = 3
"""Number of joints whose torques are shown."""

Feedback = Annotated[
    bool, typer.Option("--feedback", help="Correct the base pose by the wheels' speeds and headings.")
]
Pushes = Annotated[
    list[str] | None,
    typer.Option(
        "--push",
        metavar="FORCE@START",
        help="Push the base, e.g. 50N@3s or 50N:-y@3s:0.2s (direction, duration); repeatable.",
    ),
]
PayloadText = Annotated[
    str | None,
    typer.Option(
        "--payload", metavar="MASS", help="Unplanned load on the base link, e.g. 5kg or 5kg@0.1,0.1,0.2 (m)."
    ),
]
Friction = Annotated[str | None, typer.Option(metavar="MU", help="Friction of the ground. Default: 0.8.")]
RadiusError = Annotated[
    str | None,
    typer.Option("--radius-error", metavar="SHARE", help="True wheels are larger than known, e.g. 1%."),
]
Latency = Annotated[str | None, typer.Option(metavar="TIME", help="Age of signals and commands, e.g. 3ms.")]
Slope = Annotated[str | None, typer.Option(metavar="ANGLE", help="The ground rises along x, e.g. 2deg.")]
WholeBodyFile = Annotated[
    Path | None,
    typer.Option("--whole-body", metavar="FILE", help="Whole body (.yaml); the robot's own if not given."),
]


def simulate(
    motion: Annotated[
        Path,
        typer.Argument(metavar="PLAN|JOINTS", help="What 'rollgait plan' or 'rollgait track' wrote (.npz)."),
    ],
    record: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the log (.npz).")] = None,
    video: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a film: .mp4, .gif, .webp.")
    ] = None,
    viewer: Annotated[
        bool, typer.Option("--viewer", help="Show it in MuJoCo's window, where there is a display.")
    ] = False,
    feedback: Feedback = False,
    push: Pushes = None,
    payload: PayloadText = None,
    friction: Friction = None,
    radius_error: RadiusError = None,
    latency: Latency = None,
    slope: Slope = None,
    wheels: Annotated[
        str, typer.Option(metavar="NAME", help="Wheels follow the integrated angle, or velocity only.")
    ] = "angle",
    force: Annotated[
        bool, typer.Option("--force", help="Execute the plan even if its certificate fails.")
    ] = False,
    whole_body: WholeBodyFile = None,
    as_json: AsJson = False,
) -> None:
    """Let the whole body execute a motion in MuJoCo.

    Reports how well it does.

    Exit status: 0 if the robot stays on its feet, 1 if it falls or the plan is not certified, 2 wrong input.
    """
    given = disturbances_from(push, payload, friction, radius_error, latency, slope)
    if record is not None:
        record = npz_path(record, "record")
        check_writable(record)
    if video is not None:
        from rollgait.simulation.video import check_video

        check_video(video)
    if viewer:
        from rollgait.simulation.viewer import check_viewer

        check_viewer()
    from rollgait.simulation import simulate as simulate_motion

    planned = load_motion(motion)
    log = simulate_motion(
        planned, given, feedback=feedback, wheels=wheels, force=force, whole_body=whole_body
    )
    files = _write(log, record, video, whole_body)
    report = log.report()
    if as_json:
        print_json({"files": files, "disturbances": given.model_dump(), **report.to_dict()})
    else:
        how = "with feedback of the base pose" if feedback else "open loop"
        print(f"{motion}: {log.robot.name}, {number(report.end)} s in MuJoCo, {how}")
        print(f"  {conditions(given)}\n")
        print_simulation(report)
        for file in files:
            print(f"\nwritten: {file}")
    if viewer:
        from rollgait.simulation.viewer import show

        show(log, body_of(log, whole_body))
    if log.fallen:
        raise typer.Exit(1)


def disturbances_from(
    push: list[str] | None,
    payload: str | None,
    friction: str | None,
    radius_error: str | None,
    latency: str | None,
    slope: str | None,
) -> Disturbances:
    """The disturbances that the options of the command line ask for. Raises `InputError`."""
    from rollgait.plant.disturbances import Disturbances, Payload, Push, parse_quantity

    values: dict[str, object] = {"pushes": tuple(Push.parse(text) for text in push or ())}
    if payload is not None:
        values["payload"] = Payload.parse(payload)
    options = {
        "friction": ("friction", friction),
        "radius_error": ("radius-error", radius_error),
        "latency": ("latency", latency),
        "slope_deg": ("slope", slope),
    }
    for name, (option, text) in options.items():
        if text is not None:
            values[name] = parse_quantity(option, text)
    return Disturbances(**values)  # type: ignore[arg-type]  # the model checks them


def conditions(given: Disturbances) -> str:
    """The disturbances in words."""
    parts = [f"friction {number(given.friction)}"]
    if given.payload is not None:
        x, y, z = (number(value) for value in given.payload.place)
        parts.append(f"payload {number(given.payload.mass)} kg at ({x}, {y}, {z}) m")
    if given.radius_error:
        parts.append(f"wheels {number(100.0 * given.radius_error)} % larger")
    if given.latency:
        parts.append(f"latency {number(MILLI * given.latency)} ms")
    if given.slope_deg:
        parts.append(f"slope {number(given.slope_deg)} deg")
    for push in given.pushes:
        where = f"{number(push.direction_deg)} deg"
        when = f"{number(push.start)} s for {number(push.duration)} s"
        parts.append(f"push {number(push.force)} N to {where} at {when}")
    return ", ".join(parts)


def summary_rows(report: SimulationReport) -> list[tuple[str, str, str]]:
    """The report as rows (what, value, unit)."""
    return [
        ("final place", number(MILLI * report.final_distance), "mm from the plan in the ground plane"),
        ("final height", number(MILLI * report.final_height), "mm above the plan"),
        ("final angle", number(math.degrees(report.final_angle)), "deg from the plan"),
        ("of it yaw", number(math.degrees(report.final_yaw)), "deg"),
        ("tilt, largest", number(math.degrees(report.tilt)), "deg from upright"),
        ("tilt error", number(math.degrees(report.tilt_error)), "deg from the plan, largest"),
        ("CoM, rms", number(MILLI * report.com_rms), "mm from the plan"),
        ("CoM, largest", number(MILLI * report.com_worst), "mm"),
        ("slip, median", number(MILLI * report.slip_p50), "mm/s of loaded feet"),
        ("slip, 95 %", number(MILLI * report.slip_p95), "mm/s"),
        ("simulated", number(report.real_time_factor), "s of motion per s of computing"),
    ]


def print_simulation(report: SimulationReport) -> None:
    """The report for a person."""
    from rollgait.robot.robot import LEG_NAMES

    print_table(summary_rows(report), right=[1])
    print("\ncontact forces, rms")
    rows = [("leg", "measured − planned", "planned", "unit")]
    for name, difference, planned in zip(LEG_NAMES, report.force_rms, report.force_planned_rms, strict=True):
        rows.append((name, number(difference), number(planned), "N"))
    print_table(rows, right=[1, 2])
    print("\ntorques, the most used limits")
    print_table(
        [
            (use.joint, f"{number(use.torque)} N m", f"{number(100.0 * use.share)} %", f"{use.time:.2f} s")
            for use in report.joints[:MOST_USED]
        ],
        right=[1, 2, 3],
    )
    for contact in report.unplanned:
        where = f"{contact.link} touches the ground at {number(contact.time)} s"
        print(f"\nunplanned contact: {where}, with up to {number(contact.force)} N")
    print(f"\n  {report.verdict}")


def _write(log: SimulationLog, record: Path | None, video: Path | None, whole_body: Path | None) -> list[str]:
    files = []
    for path in (record, video):
        if path is not None:
            note_replacing(path)
    if record is not None:
        files.append(str(log.save(record)))
    if video is not None:
        from rollgait.simulation.video import save_video

        files.append(str(save_video(log, video, body_of(log, whole_body))))
    return files


def body_of(log: SimulationLog, whole_body: Path | None) -> WholeBody:
    """The whole body that was simulated."""
    from rollgait.robot.whole_body import find_whole_body, load_whole_body

    return find_whole_body(log.robot) if whole_body is None else load_whole_body(whole_body)
