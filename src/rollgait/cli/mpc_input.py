"""What `rollgait mpc` is told on the command line: commands, pushes, settings, plants."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from rollgait.config import load_yaml, parse_setting, parse_value, set_key, validate
from rollgait.errors import FileError, InputError, UnknownNameError
from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.footwork import ANYWHERE, Footwork
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.script import RandomScript, Script, TimedCommand, TimedPush, script_of
from rollgait.mpc.settings import MpcSettings
from rollgait.plant.disturbances import PUSH_DURATION, Push, check_begins
from rollgait.robot.robot import Robot
from rollgait.scenario import Scenario, find_scenario, scenario_names

RANDOM: Final = "random"
REPLAY: Final = "replay:"
OUTSIDE: Final = "cmd_vel"
"""The command that is whatever others ask for on topics."""
DURATION: Final = 20.0
"""Of a run whose command does not say how long it takes, s."""
DURATION_OUTSIDE: Final = 60.0
"""The same of one that somebody drives by hand, s."""
DURATION_MAX: Final = 86400.0
"""s; the log of a longer run would not fit into memory."""

_EVERY: Final = re.compile(r"([0-9.eE+-]+)N/([0-9.eE+-]+)s?(?::([0-9.eE+-]+)s?)?")


@dataclass(frozen=True)
class Asked:
    """What the robot shall do.

    Attributes:
        script: commands and pushes.
        words: the same for a person.
        scenario: that it is from, if it is.
        outside: whether others say it, on topics; the script then says for how long, and its pushes.
    """

    script: Script
    words: str
    scenario: Scenario | None = None
    outside: bool = False


def asked_from(
    text: str, gait: str | None, duration: float | None, seed: int, pushes: Sequence[str]
) -> Asked:
    """Commands and pushes as the options of the command line ask for them. Raises `InputError`."""
    if gait is not None:
        find_gait(gait)
    if duration is not None and not 0.0 < duration <= DURATION_MAX:
        raise InputError("duration", duration, f"must be greater than 0 and at most {DURATION_MAX:g} s")
    asked = _commands(text, duration, seed)
    script = asked.script
    if duration is not None:
        # who cuts a script short wants what is in it until then
        kept = tuple(push for push in script.pushes if push.at < duration)
        script = script.model_copy(update={"duration": duration, "pushes": kept})
    if gait is not None:
        script = _in_gait(script, gait)
    more = [push for text in pushes for push in pushes_from(text, script.duration, seed)]
    script = script.model_copy(update={"pushes": (*script.pushes, *more)})
    return replace(asked, script=script)


def first_gait(asked: Asked, robot: Robot) -> str:
    """The gait with which a run begins: its own, or else one in which the robot's feet can follow it."""
    script = asked.script
    if script.gait is not None:
        return script.gait
    commands = [timed.command for timed in script.commands]
    return Footwork(robot).fitting(
        [ANYWHERE]
        if asked.outside
        else [
            (command.forward, command.lateral, command.turn_rate)
            if isinstance(command, VelocityCommand)
            else ANYWHERE
            for command in commands
        ]
    )


def pushes_from(text: str, duration: float, seed: int) -> list[TimedPush]:
    """`100N@5s` as for `rollgait simulate`, or `100N/5s`: every 5 s, in random directions.

    Args:
        text: one of both.
        duration: of the run, s: pushes begin before its end.
        seed: of the directions.

    Raises:
        InputError: it is neither, or there would be no push in the run.
    """
    every = _EVERY.fullmatch(text.strip())
    if every is not None:
        force, period, length = (parse_value(part) if part else PUSH_DURATION for part in every.groups())
        try:
            random = RandomScript(
                push=force, push_every=period, push_duration=length, duration=duration, seed=seed
            )
        except InputError as error:
            raise InputError("push", text, f"must hold positive numbers: {error}") from None
        if not (pushes := random.script().pushes):
            rule = f"must push more often than every {duration:g} s: then the run ends"
            raise InputError("push", text, rule)
        return list(pushes)
    try:
        push = Push.parse(text)
    except InputError as error:
        if error.field != "push":
            raise
        rule = "must be FORCE@START, e.g. 100N@5s or 50N:-y@3s:0.2s, or FORCE/TIME for a push so often"
        raise InputError("push", text, f"{rule}, e.g. 100N/5s") from None
    check_begins(push.start, duration, text)
    return [TimedPush(at=push.start, force=push.vector, duration=push.duration)]


def settings_from(values: dict[str, Any], texts: Sequence[str]) -> MpcSettings:
    """The settings of the controller, keys that are None left as they are. Raises `InputError`."""
    data = MpcSettings().model_dump(mode="json")
    for key, value in values.items():
        if value is not None:
            set_key(data, key, value)
    for text in texts:
        set_key(data, *parse_setting(text))
    return validate(MpcSettings, data)


def _commands(text: str, given: float | None, seed: int) -> Asked:
    duration = given or DURATION
    if text == OUTSIDE:
        still = (TimedCommand(command=VelocityCommand()),)
        script = Script(duration=given or DURATION_OUTSIDE, commands=still)
        return Asked(script, "what comes on /cmd_vel or /goal_pose", outside=True)
    if text == RANDOM:
        return Asked(RandomScript(duration=duration, seed=seed).script(), f"random commands, seed {seed}")
    if text.endswith((".yaml", ".yml")):
        return _in_file(text)
    if "=" in text:
        command = command_from(text)
        script = Script(duration=duration, gait=command.gait, commands=(TimedCommand(command=command),))
        script.check()
        return Asked(script, text)
    if text in scenario_names():
        scenario = find_scenario(text)
        return Asked(script_of(scenario), f"the goals of {text}", scenario)
    rule = "is neither 'random' nor KEY=VALUE,… nor a .yaml file nor a scenario"
    raise UnknownNameError("command", text, [RANDOM, OUTSIDE, *scenario_names()], rule)


def _in_file(path: str) -> Asked:
    """A script, or a scenario, which has a goal."""
    data = load_yaml(Path(path))
    if "commands" in data:
        return Asked(Script.from_yaml(path), path)
    if "goal" in data:
        scenario = find_scenario(path)
        return Asked(script_of(scenario), f"the goals of {path}", scenario)
    raise FileError("command", path, "must hold commands, as a script does, or a goal, as a scenario does")


def command_from(text: str) -> VelocityCommand | PoseCommand:
    """`forward=0.3,turn_rate=0.2`, or a pose: `x=1,y=0.5,yaw_deg=90`. Raises `InputError`."""
    data: dict[str, Any] = {}
    for part in text.split(","):
        key, equals, value = part.partition("=")
        if not equals or not key.strip():
            raise InputError("command", text, "must be KEY=VALUE,KEY=VALUE, e.g. forward=0.3,turn_rate=0.2")
        data[key.strip()] = parse_value(value)
    is_pose = data.get("kind") == "pose" or not data.keys().isdisjoint(("x", "y", "yaw_deg", "cruise"))
    kind: type[VelocityCommand] | type[PoseCommand] = PoseCommand if is_pose else VelocityCommand
    return validate(kind, data, "command")


def _in_gait(script: Script, gait: str) -> Script:
    """The same commands in one gait all the time."""
    commands = tuple(
        timed.model_copy(update={"command": timed.command.model_copy(update={"gait": gait})})
        for timed in script.commands
    )
    return script.model_copy(update={"gait": gait, "commands": commands})
