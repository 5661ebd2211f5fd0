"""`rollgait bridge`: drive a robot over the topics of ROS 2, or a simulated one in another process."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import GroundName, Kernels
from rollgait.cli.controlled import stopping
from rollgait.cli.live import Domain, FoxgloveCommands, FoxglovePort, WithFoxglove, reach_from
from rollgait.cli.progress import StatusLine

if TYPE_CHECKING:
    from rollgait.hardware.bridge import Bridge
    from rollgait.hardware.transports.transport import Slowed
    from rollgait.mpc.prediction import Event
    from rollgait.plan.plan import Plan
    from rollgait.robot.robot import Robot
    from rollgait.terrain import Terrain


def bridge(
    robot: Annotated[
        str, typer.Argument(metavar="ROBOT", help="Name of a robot ('rollgait robots') or a YAML file.")
    ] = "centauro",
    plan: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="PLAN.npz",
            help="Carry out this plan once the robot is up, while /enable is repeated. "
            "Repeatable: one after the other.",
        ),
    ] = None,
    gait: Annotated[str, typer.Option(metavar="NAME", help="Gait in which commands are followed.")] = "drive",
    domain: Domain = None,
    simulate: Annotated[
        bool, typer.Option("--simulate", help="Start a simulated robot in another process, and drive that.")
    ] = False,
    ground: GroundName = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Seed of the simulated sensors.")] = 0,
    slow: Annotated[
        float,
        typer.Option(metavar="FACTOR", min=1.0, max=50.0, help="Simulate in slow motion, so slow."),
    ] = 1.0,
    foxglove: WithFoxglove = False,
    foxglove_port: FoxglovePort = None,
    foxglove_commands: FoxgloveCommands = False,
    torque: Annotated[
        float, typer.Option(metavar="SHARE", min=0.01, max=1.0, help="Of the torque limits that may be used.")
    ] = 1.0,
    speed: Annotated[
        float, typer.Option(metavar="SHARE", min=0.01, max=1.0, help="Of the joints' speed limits, likewise.")
    ] = 1.0,
    kernels: Kernels = True,
    seconds: Annotated[
        float | None, typer.Option(metavar="S", min=0.0, help="End after this time; by default at Ctrl-C.")
    ] = None,
) -> None:
    """Drive a robot over ROS 2's topics, without ROS.

    Reads joint states, IMU and odometry, cmd_vel or goal_pose; writes joint commands, plan, tf, markers and
    diagnostics. Nothing moves before /enable turns from false to true; with false the robot lies down, and so
    it does at Ctrl-C. A second Ctrl-C ends at once. Read docs/hardware.md before you drive a robot with it.

    Exit status: 0 if the robot lies or was never enabled, 1 if it had to stand, 2 wrong input.
    """
    from rollgait.errors import InputError
    from rollgait.mpc.gaits import find_gait
    from rollgait.robot.library import find_robot
    from rollgait.robot.whole_body import find_whole_body

    reach = reach_from(domain, foxglove, foxglove_port, foxglove_commands)
    body = find_robot(robot)
    find_whole_body(body)
    find_gait(gait)
    from rollgait.hardware.robot_process import RobotProcess, RobotSetup
    from rollgait.hardware.transports.reach import opened
    from rollgait.hardware.transports.transport import Slowed
    from rollgait.plan.plan import Plan as PlanFile

    plans = [PlanFile.load(path) for path in plan or ()]
    if slow != 1.0 and not simulate:
        raise InputError("slow", slow, "is for simulated robots: hardware does not wait")
    terrain, place = _ground_of(ground, plans, body)
    transport, said = opened(reach)
    print("\n".join(said), flush=True)
    slowed = Slowed(transport, slow)
    other = None
    try:
        with StatusLine("building the controller …"):
            if simulate:
                other = RobotProcess(
                    RobotSetup(robot, reach.domain, seed, slow=slow, place=place, terrain=terrain)
                )
            driven = _built(body, slowed, gait, plans, (speed, torque), kernels)
            if terrain is not None and not plans:  # that of a plan the bridge has taken
                driven.mpc.set_ground(terrain)
            driven.plant.resume()
        _run(driven, slowed, seconds)
    finally:
        transport.close()
        if other is not None:
            other.close()
    if driven.phase == "stopped":
        raise typer.Exit(1)


def _ground_of(
    ground: str | None, plans: list[Plan], robot: Robot
) -> tuple[Terrain | None, tuple[float, float, float]]:
    """The ground, and x, y of the CoM and yaw where a simulated robot stands on it: as a plan begins.

    Raises what is wrong with them.
    """
    from rollgait.cli.ground_input import ground_from, terrain_of
    from rollgait.errors import InputError

    if plans:
        from rollgait.mpc.plans.path import PlanPath

        if ground is not None:
            raise InputError("ground", ground, "cannot be chosen for a plan, which has its own")
        path = PlanPath(plans[0])
        state = path.state(0.0)
        x, y, _ = state.com_position.tolist()
        return path.terrain, (x, y, float(state.euler[0]))
    terrain = None if ground is None else terrain_of(ground_from(ground)[0])
    if terrain is not None:
        from rollgait.scenario.standing import require_stance

        require_stance(terrain, robot, (0.0, 0.0, 0.0), "ground", with_margin=False)
    return terrain, (0.0, 0.0, 0.0)


def _built(
    robot: Robot,
    transport: Slowed,
    gait: str,
    plans: list[Plan],
    shares: tuple[float, float],
    kernels: bool,
) -> Bridge:
    """The bridge. Raises what is wrong with the robot or the shares."""
    from rollgait.hardware.bridge import Bridge, BridgeSettings
    from rollgait.hardware.last_stage import StageLimits
    from rollgait.mpc.mpc import Mpc

    speed, torque = shares
    settings = BridgeSettings(limits=StageLimits(speed_share=speed, torque_share=torque))
    mpc = Mpc(robot, kernels=kernels)
    return Bridge(mpc, transport, clock=transport.clock, gait=gait, plans=plans, settings=settings)


def _run(bridge: Bridge, transport: Slowed, seconds: float | None) -> None:
    """Runs it, and says what happens as it does."""
    from rollgait.hardware.reports import Reports
    from rollgait.hardware.running import run

    print("waits for /enable to turn from false to true; Ctrl-C ends", flush=True)
    begin = transport.clock()
    with stopping() as stop:

        def ends() -> bool:
            return stop.is_set() or (seconds is not None and transport.clock() - begin >= seconds)

        def hear(event: Event) -> None:
            print(f"{event.time:7.2f} s  {event.text}", flush=True)

        run(bridge, Reports(transport, transport.clock), ends, hear)
    lost, missed = bridge.plant.sensors.lost, bridge.plant.stalls
    print(f"{bridge.phase} after {bridge.plant.time:.1f} s; {lost} messages lost, {missed} periods missed")
