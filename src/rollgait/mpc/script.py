"""Sequences of commands and pushes: written down, random, or those of the paper's motions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from rollgait.config import Config, NonNegative, Number, Positive, Seed, load_yaml, validate
from rollgait.errors import InputError
from rollgait.mpc.command import Command, PoseCommand, VelocityCommand
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.reference import TURN_CRUISE
from rollgait.plant.disturbances import check_begins
from rollgait.scenario.scenario import Goal, LaterGoal, Scenario

Array = NDArray[np.float64]

Pause = Annotated[Number, Field(ge=0.01)]
"""Between two of the same kind, s; shorter ones would be more than a script can hold."""


class TimedCommand(Config):
    """A command and from when on it holds."""

    at: NonNegative = 0.0
    """s."""
    command: Command
    """What is asked for."""


class TimedPush(Config):
    """A force on the base for a time."""

    at: NonNegative
    """s."""
    force: tuple[Number, Number, Number]
    """World frame, N."""
    duration: Positive = 0.2
    """s."""

    def check_begins(self, end: float) -> None:
        """Raises `InputError` if it begins after a run has ended, at `end`, s."""
        check_begins(self.at, end, f"{np.hypot(*self.force[:2]):g}N@{self.at:g}s")


class Script(Config):
    """What happens to the robot: commands in the order of time, and pushes."""

    duration: Positive
    """s."""
    gait: str | None = None
    """Gait at the beginning; that of the controller if not given."""
    commands: tuple[TimedCommand, ...]
    """The first holds from the beginning."""
    pushes: tuple[TimedPush, ...] = ()
    """In any order; they may overlap. Each begins before the end."""

    @classmethod
    def from_yaml(cls, path: str | Path) -> Script:
        """The script in a YAML file. Raises `FileError` or `InputError`."""
        script = validate(cls, load_yaml(Path(path)))
        script.check()
        return script

    def check(self) -> None:
        """Raises `InputError` where the script contradicts itself."""
        if not self.commands:
            raise InputError("commands", [], "must hold at least one command")
        times = [timed.at for timed in self.commands]
        if times != sorted(times):
            raise InputError("commands", times, "must be in the order of their times")
        for timed in self.commands:
            timed.command.check()
        for push in self.pushes:
            push.check_begins(self.duration)
        VelocityCommand(gait=self.gait).check()

    def command_at(self, time: float) -> VelocityCommand | PoseCommand:
        """The command that holds at a time."""
        current = self.commands[0]
        for timed in self.commands:
            if timed.at <= time + 1e-9:
                current = timed
        return current.command


class RandomScript(Config):
    """Random velocities, gaits and pushes."""

    duration: Positive = 60.0
    """s."""
    speed: NonNegative = 0.5
    """Largest, m/s, in any direction."""
    turn_rate: NonNegative = 0.5
    """Largest, rad/s."""
    every: Pause = 4.0
    """A new velocity so often, s."""
    gaits: tuple[str, ...] = ("drive", "crawl", "trot")
    """Gaits that take turns at random."""
    gait_every: Positive = 12.0
    """A new gait so often, s."""
    push: NonNegative = 0.0
    """Horizontal force of pushes, N."""
    push_every: Pause = 5.0
    """A push so often, s."""
    push_duration: Positive = 0.2
    """s."""
    seed: Seed = 0
    """Of the random numbers."""

    def script(self) -> Script:
        """The script: the same seed gives the same one."""
        random = np.random.default_rng(self.seed)
        commands = []
        gait, next_gait = self.gaits[0], self.gait_every
        for at in np.arange(0.0, self.duration, self.every):
            if at >= next_gait - 1e-9:
                others = [name for name in self.gaits if name != gait] or [gait]
                gait = str(random.choice(others))
                next_gait += self.gait_every
            speed, angle = self.speed * math.sqrt(random.uniform()), random.uniform(-math.pi, math.pi)
            velocity = VelocityCommand(
                forward=speed * math.cos(angle),
                lateral=speed * math.sin(angle),
                turn_rate=self.turn_rate * random.uniform(-1.0, 1.0),
                gait=gait,
            )
            commands.append(TimedCommand(at=float(at), command=velocity))
        pushes = []
        if self.push > 0.0:
            for at in np.arange(self.push_every, self.duration, self.push_every):
                angle = random.uniform(-math.pi, math.pi)
                force = (self.push * math.cos(angle), self.push * math.sin(angle), 0.0)
                pushes.append(TimedPush(at=float(at), force=force, duration=self.push_duration))
        return Script(
            duration=self.duration, gait=self.gaits[0], commands=tuple(commands), pushes=tuple(pushes)
        )


CRUISE = 0.3
"""m/s."""
WALKING_SPEED = 0.03
"""Of the legged gait, m/s, starting and stopping included."""
SETTLING = 4.0
"""Time after each goal of a motion in which it is reached closely, s."""
RESTING = 3.0
"""Time at the end with all feet on the ground, s."""
LOCKED_GAIT, STEPPING_GAIT, ROLLING_GAIT = "walk", "crawl", "drive"
RESTS = {LOCKED_GAIT: "stand", STEPPING_GAIT: ROLLING_GAIT}
"""With which gait a motion that steps ends."""


def script_of(scenario: Scenario) -> Script:
    """A scenario's goals as commands, one after the other, with the gait that is most like its own.

    A goal is given up for the next one only when there has been time to reach it.
    """
    swings = scenario.gait.swings(scenario.horizon)
    is_given = scenario.gait.kind != "discover"
    steps = any(swings.values()) or not (is_given or scenario.ground.kind == "flat")
    gait = LOCKED_GAIT if scenario.gait.wheels == "locked" else STEPPING_GAIT if steps else ROLLING_GAIT
    goals: list[tuple[float, Goal | LaterGoal]] = [(0.0, scenario.goal)]
    goals += [(later.at, later) for later in scenario.goal.then]
    speed = WALKING_SPEED if gait == LOCKED_GAIT else CRUISE
    turn_rate = min(TURN_CRUISE, find_gait(gait).turn_rate_max)
    commands, at = [], 0.0
    place: Sequence[float] = (scenario.start.x, scenario.start.y)
    yaw = scenario.start.yaw_deg
    for begin, goal in goals:
        at = max(at, begin)
        command = PoseCommand(x=goal.x, y=goal.y, yaw_deg=goal.yaw_deg, cruise=CRUISE, gait=gait)
        commands.append(TimedCommand(at=at, command=command))
        way = math.dist(place, (goal.x, goal.y)) / speed
        at += max(way, math.radians(abs(goal.yaw_deg - yaw)) / turn_rate) + SETTLING
        place, yaw = (goal.x, goal.y), goal.yaw_deg
    at = max(at, scenario.horizon if is_given else 0.0)
    if gait != ROLLING_GAIT:
        rest = commands[-1].command.model_copy(update={"gait": RESTS[gait]})
        commands.append(TimedCommand(at=at, command=rest))
        at += RESTING
    return Script(duration=at, gait=gait, commands=tuple(commands))
