"""`rollgait drive`: drive a robot live, in the browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import GroundName
from rollgait.cli.ground_input import ground_from, terrain_of
from rollgait.cli.live import (
    Bridged,
    Domain,
    FoxgloveCommands,
    FoxglovePort,
    WithFoxglove,
    opened,
    reach_if,
)
from rollgait.cli.view import DEFAULT_PORT, Port, port_from
from rollgait.errors import UnknownNameError
from rollgait.view.recordings import need_view

if TYPE_CHECKING:
    from rollgait.mpc.plans.manoeuvres import Manoeuvre
    from rollgait.scenario.scenario import Scenario


def drive(
    robot: Annotated[
        str, typer.Argument(metavar="ROBOT", help="Name of a robot ('rollgait robots') or a YAML file.")
    ] = "centauro",
    plant: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="What is driven: mujoco, the whole robot, or rigid, the planner's."
        ),
    ] = "mujoco",
    gait: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Gait with which it begins. Default: drive, or trot where only steps turn it.",
        ),
    ] = None,
    ground: GroundName = None,
    manoeuvre: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SCENARIO",
            help="Offer this motion as a button: a scenario of the library, a YAML file, or a plan's (.npz). "
            "Repeatable; by default those of the library for this robot on level ground.",
        ),
    ] = None,
    port: Port = DEFAULT_PORT,
    browser: Annotated[bool, typer.Option("--open/--no-open", help="Open the page in the browser.")] = False,
    bridge: Bridged = False,
    domain: Domain = None,
    foxglove: WithFoxglove = False,
    foxglove_port: FoxglovePort = None,
    foxglove_commands: FoxgloveCommands = False,
    seconds: Annotated[
        float | None, typer.Option(metavar="S", min=0.0, help="End after this time; by default at Ctrl-C.")
    ] = None,
) -> None:
    """Drive a robot live, in the browser.

    Joystick or keyboard move it; buttons change its gait, push it, and let it carry out manoeuvres.
    Keys: w a s d drive, q e turn, space stops. With --bridge others see it on the topics of ROS 2, and
    drive it by cmd_vel while the page asks for nothing. Runs until Ctrl-C.
    """
    number = port_from(port)
    begins_with = _check(robot, plant, gait)
    offered = _manoeuvres(robot, manoeuvre)
    terrain = None if ground is None else terrain_of(ground_from(ground)[0])
    reach = reach_if(bridge, domain, foxglove, foxglove_port, foxglove_commands)
    from rollgait.view.driving.page import DrivePage
    from rollgait.view.driving.process import Setup

    with opened(reach) as others:
        page = DrivePage(Setup(robot, plant, begins_with, terrain, offered, others), port=number)
        try:
            print(f"open {page.url} in a browser; Ctrl-C ends", flush=True)
            if browser:
                webbrowser.open(page.url)
            page.wait(seconds)
            now = page.snapshot
            print(f"drove {now.state.time:.1f} s at {now.rate:.0f} Hz, real time × {now.factor:.2f}")
        except KeyboardInterrupt:
            print()
        finally:
            page.close()


def _manoeuvres(robot: str, asked: list[str] | None) -> tuple[Manoeuvre, ...]:
    """What is offered on the page. Raises what is wrong with it."""
    from rollgait.mpc.plans.manoeuvres import Manoeuvre, check_manoeuvre, manoeuvres_of
    from rollgait.robot.library import find_robot

    body = find_robot(robot)
    if asked is None:
        return manoeuvres_of(body)
    found = {Path(name).stem: Manoeuvre(Path(name).stem, _scenario(name)) for name in asked}
    for one in found.values():
        check_manoeuvre(one, body)
    return tuple(found.values())


def _scenario(name: str) -> Scenario:
    """Of a name or a file, also that of a plan."""
    from rollgait.scenario.library import find_scenario

    if not name.endswith(".npz"):
        return find_scenario(name)
    from rollgait.plan.plan import Plan

    return Plan.load(name).scenario


def _check(robot: str, plant: str, gait: str | None) -> str:
    """The gait with which it begins. Raises what is wrong before anything is built."""
    from rollgait.mpc.footwork import ANYWHERE, Footwork
    from rollgait.mpc.gaits import find_gait
    from rollgait.mpc.setup import PLANTS
    from rollgait.robot.library import find_robot

    feet = Footwork(find_robot(robot))
    chosen = find_gait(gait or feet.fitting(ANYWHERE)).name
    if plant not in PLANTS:
        raise UnknownNameError("plant", plant, PLANTS)
    need_view("driving", "websockets")
    return chosen
