"""The closed loop: plant → estimator → controller → plant, period by period."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from rollgait.mpc.command import PoseCommand, VelocityCommand
from rollgait.mpc.estimator import Estimator, Truth
from rollgait.mpc.log import LogWriter, MpcLog
from rollgait.mpc.mpc import Mpc
from rollgait.mpc.prediction import Prediction
from rollgait.mpc.script import Script
from rollgait.mpc.stretch import Stretch
from rollgait.plant.control import Control
from rollgait.plant.protocol import Plant
from rollgait.plant.state import RobotState

Watch = Callable[[float], bool | None]
"""Called after each step with the time, s; ends the run if it returns True."""
Ask = Callable[[], VelocityCommand | PoseCommand]
"""What somebody asks for now."""


@contextmanager
def no_collections() -> Iterator[None]:
    """Keeps the garbage collector from running in the middle of a step; nothing in the loop makes cycles."""
    was_enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if was_enabled:
            gc.enable()


class ClosedLoop:
    """A controller and what it controls.

    Args:
        mpc: the controller.
        plant: what it controls.
        estimator: what the controller gets to know; the truth if not given.

    Attributes:
        control, prediction: the last ones; None before the first step.
    """

    def __init__(self, mpc: Mpc, plant: Plant, estimator: Estimator | None = None) -> None:
        self.mpc, self.plant = mpc, plant
        self._estimator = estimator or Truth()
        self.control: Control | None = None
        self.prediction: Prediction | None = None
        self._trouble = ""
        self._stretch = Stretch(mpc.settings.period)

    @property
    def time(self) -> float:
        """Of the plant, s."""
        return self.plant.state.time

    def step(self, command: VelocityCommand | PoseCommand) -> tuple[Control, Prediction]:
        """One period under a command."""
        expected = self.control.end if self.control is not None else None
        known = self._estimator(self.plant.state, expected)
        self.mpc.stretch = self._stretch.update()
        control, prediction = self.mpc.step(known, command, getattr(self.plant, "touching", None))
        self.plant.step(control)
        trouble = getattr(self.plant, "trouble", "")
        if trouble and trouble != self._trouble:
            self.mpc.note(trouble)
        self._trouble = trouble
        self.control, self.prediction = control, prediction
        return control, prediction

    def stall(self, periods: int) -> None:
        """Lets time pass without a step of the controller: the plant goes on as it was told last."""
        for _ in range(periods):
            if self.control is not None:
                self.control = continued(self.control)
                self.plant.step(self.control)

    def run(self, script: Script, watch: Watch | None = None, ask: Ask | None = None) -> MpcLog:
        """Runs a script to its end, or until the robot has fallen.

        Args:
            script: commands and pushes.
            watch: called after each step.
            ask: what is asked for in each period, in place of the script's commands.
        """
        script.check()
        if self.control is None and script.gait is not None:
            self.mpc.reset(script.gait)
        begin = self.time
        writer = LogWriter(self.mpc.robot, self.plant, self.mpc.settings.period)
        pushes = sorted(script.pushes, key=lambda push: push.at)
        fallen_at = None
        with no_collections():
            while (time := self.time - begin) < script.duration - 1e-9:
                while pushes and pushes[0].at <= time + 1e-9:
                    push = pushes.pop(0)
                    self.plant.push(np.array(push.force), push.duration)
                before, pose = self.plant.state, getattr(self.plant, "pose", None)
                control, prediction = self.step(script.command_at(time) if ask is None else ask())
                writer.add(before, control, prediction, self.mpc.wanted, pose)
                stopped = watch is not None and watch(time)
                if self.plant.fallen:
                    fallen_at = self.time
                if stopped or self.plant.fallen:
                    break
        return writer.finish(fallen_at, [event for event in self.mpc.events if event.time >= begin])


def continued(control: Control) -> Control:
    """The same control for another period: everything moves on as fast as it did."""
    begin, period = control.end, control.period
    heading = begin.heading
    velocity = np.zeros((4, 3))
    velocity[:, 0], velocity[:, 1] = begin.speed * np.cos(heading), begin.speed * np.sin(heading)
    lift = (control.end.foot_position[:, 2] - control.begin.foot_position[:, 2]) / period
    velocity[:, 2] = np.where(control.contact, 0.0, lift)
    end: RobotState = replace(
        begin,
        time=begin.time + period,
        com_position=begin.com_position + period * begin.com_velocity,
        euler=begin.euler + period * begin.euler_rate,
        foot_position=begin.foot_position + period * velocity,
        heading=heading + period * control.motion[:, 1],
    )
    return replace(control, begin=begin, end=end)
