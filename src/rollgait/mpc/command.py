"""What a person or a planner above asks of the controller."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Discriminator

from rollgait.config import Config, NonNegative, Number, validate
from rollgait.errors import InputError
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.settings import CommandLimits


class BaseCommand(Config):
    """What all commands share."""

    gait: str | None = None
    """Gait from the next lift-off on; nothing changes if not given."""
    height_change: Number = 0.0
    """Of the CoM from its nominal height, m."""

    def check(self) -> None:
        """Raises `UnknownNameError` if there is no such gait."""
        if self.gait is not None:
            find_gait(self.gait)


class VelocityCommand(BaseCommand):
    """Velocities in the base-yaw frame, kept until the next command."""

    kind: Literal["velocity"] = "velocity"
    """Kind of the command."""
    forward: Number = 0.0
    """m/s."""
    lateral: Number = 0.0
    """To the left, m/s."""
    turn_rate: Number = 0.0
    """Yaw rate, rad/s."""

    def within(self, limits: CommandLimits) -> tuple[VelocityCommand, str]:
        """The command cut to the limits, and a sentence about what was cut, empty if nothing was."""
        speed = math.hypot(self.forward, self.lateral)
        share = min(1.0, limits.speed / speed) if speed > 0.0 else 1.0
        turn = max(-limits.turn_rate, min(limits.turn_rate, self.turn_rate))
        height, note = _within_height(self.height_change, limits)
        notes = [note] if note else []
        if share < 1.0:
            notes.append(f"speed {speed:.3g} m/s is cut to {limits.speed:.3g} m/s")
        if turn != self.turn_rate:
            notes.append(f"turn rate {self.turn_rate:.3g} rad/s is cut to {turn:.3g} rad/s")
        cut = {
            "forward": share * self.forward,
            "lateral": share * self.lateral,
            "turn_rate": turn,
            "height_change": height,
        }
        return (self.model_copy(update=cut) if notes else self), "; ".join(notes)


class PoseCommand(BaseCommand):
    """A place and a yaw in the world, to be reached and held."""

    kind: Literal["pose"] = "pose"
    """Kind of the command."""
    x: Number
    """x of the CoM, m."""
    y: Number = 0.0
    """y of the CoM, m."""
    yaw_deg: Number = 0.0
    """Yaw, degrees; not reduced: 360 is a full turn."""
    cruise: NonNegative = 0.3
    """Largest speed on the way, m/s."""

    def within(self, limits: CommandLimits) -> tuple[PoseCommand, str]:
        """The command cut to the limits, and a sentence about what was cut, empty if nothing was."""
        height, note = _within_height(self.height_change, limits)
        notes = [note] if note else []
        if self.cruise > limits.speed:
            notes.append(f"cruise {self.cruise:.3g} m/s is cut to {limits.speed:.3g} m/s")
        cut = {"cruise": min(self.cruise, limits.speed), "height_change": height}
        return (self.model_copy(update=cut) if notes else self), "; ".join(notes)


Command = Annotated[VelocityCommand | PoseCommand, Discriminator("kind")]
"""One of the commands, told apart by `kind`."""


def _within_height(value: float, limits: CommandLimits) -> tuple[float, str]:
    if abs(value) <= limits.height_change:
        return value, ""
    cut = math.copysign(limits.height_change, value)
    return cut, f"height change {value:.3g} m is cut to {cut:.3g} m"


def check_command(command: VelocityCommand | PoseCommand) -> None:
    """Raises `InputError` for what is no command, or holds what is none of its values."""
    if not isinstance(command, VelocityCommand | PoseCommand):
        raise InputError("command", command, "must be a VelocityCommand or a PoseCommand")
    validate(type(command), dict(command), "command")  # copies and the like are not checked when made
    command.check()
