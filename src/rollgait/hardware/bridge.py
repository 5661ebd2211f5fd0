"""A robot behind a transport, brought up, controlled and laid down; in doubt it stands."""

from __future__ import annotations

import logging
import time as wall
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, Literal

import numpy as np
from numpy.typing import NDArray

from rollgait.config import Config, Positive
from rollgait.errors import InputError
from rollgait.hardware.last_stage import StageLimits
from rollgait.hardware.operator import COMMAND_TIMEOUT, STAND, Operator
from rollgait.hardware.plant import NAME, Fresh, HardwarePlant
from rollgait.hardware.postures import JointMotion, RiseSettings, rise_of
from rollgait.hardware.reports import ERROR, OK, WARN, Health
from rollgait.hardware.transports.transport import Transport
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.gaits import find_gait
from rollgait.mpc.incoming import STALL_MAX
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.mpc import EVENTS_KEPT, Mpc
from rollgait.mpc.prediction import Event, Prediction
from rollgait.mpc.setup import observer
from rollgait.plant.stance import standing_control, standing_state
from rollgait.tracking.follower import JointTarget

if TYPE_CHECKING:
    from rollgait.plan.plan import Plan

log = logging.getLogger("rollgait")
Array = NDArray[np.float64]
Phase = Literal["off", "rising", "active", "lying", "stopped"]

STATE_TIMEOUT: Final = 0.1
"""Sensors that have said nothing for so long are lost, s."""
SENSORS_WITHIN: Final = 2.0
"""Sensors that have said nothing by then are missed: DDS takes a second to find who speaks, s."""
REST_SPEED: Final = 0.02
"""A base slower than that rests, m/s."""
REST_WITHIN: Final = 3.0
"""So long the robot is waited for to come to rest before it lies down, s."""


class BridgeSettings(Config):
    """How a robot is handled, beside its controller."""

    command_timeout: Positive = COMMAND_TIMEOUT
    """Silence of an operator after which the robot stands, s."""
    state_timeout: Positive = STATE_TIMEOUT
    """Silence of the sensors after which it stands until it is enabled anew, s."""
    limits: StageLimits = StageLimits()
    """Of the last stage."""
    rise: RiseSettings = RiseSettings()
    """How it comes up and lies down."""


class Bridge:
    """From messages to joint commands, a period at a time.

    >>> bridge = Bridge(Mpc("centauro"), transport)           # doctest: +SKIP
    >>> while True: bridge.step()                            # doctest: +SKIP

    Args:
        mpc: the controller.
        transport: to robot and operator.
        clock: seconds that only go on; `transport.receive` lets them pass.
        gait: in which commands are followed.
        plans: to be carried out once the robot is up, one after the other, while an operator is there; the
            controller takes the ground of the first for the ground.
        settings: of the bridge.

    Attributes:
        phase: `off`, `rising`, `active`, `lying` or `stopped`.
        plant: the robot.
        operator: who is above.
        loop: the closed loop; None unless the robot has been up since it was off.
        events: what happened, newest last; those of the controller are its own.

    Raises:
        InputError: the robot has no whole body, or cannot stand; a plan is of another robot, or begins
            elsewhere than the one before it ends.
        UnknownNameError: there is no such gait.
    """

    def __init__(
        self,
        mpc: Mpc,
        transport: Transport,
        *,
        clock: Callable[[], float] = wall.perf_counter,
        gait: str = "drive",
        plans: Sequence[Plan] = (),
        settings: BridgeSettings | None = None,
    ) -> None:
        self.mpc, self._gait, self._plans = mpc, find_gait(gait).name, tuple(plans)
        self.settings = settings or BridgeSettings()
        self.plant = HardwarePlant(mpc.robot, transport, clock, mpc.settings.period, self.settings.limits)
        self.operator = Operator(transport, clock, self.note, self.settings.command_timeout)
        self._rise = rise_of(self.plant.follower.model, mpc.robot)
        self._standing_torque = self._torque_of_standing()
        self.phase: Phase = "off"
        self.loop: ClosedLoop | None = None
        self.events: deque[Event] = deque(maxlen=EVENTS_KEPT)
        self._motion: JointMotion | None = None
        self._effort: tuple[Array, Array] = (self._standing_torque, self._standing_torque)
        self._since = 0.0
        self._stands_alone = False
        self._lies_down = False
        self._clock, self._missed_from, self._silence_told = clock, clock() + SENSORS_WITHIN, ""
        if self._plans:
            self._check_plans()

    def _check_plans(self) -> None:
        """Raises `InputError` for plans that cannot follow one another, before anything moves."""
        from rollgait.mpc.plans.path import PlanPath

        self.mpc.reset()
        self.mpc.follow(*self._plans)
        self.mpc.reset()
        if (terrain := PlanPath(self._plans[0]).terrain) is not None:
            self.mpc.set_ground(terrain)

    def _torque_of_standing(self) -> Array:
        robot = self.mpc.robot
        state = standing_state(robot)
        self.plant.follower.reset(state)
        return self.plant.follower.follow(standing_control(robot, state, self.mpc.settings.period)).torque

    # -- a period ---------------------------------------------------------------------------------------

    def step(self) -> None:
        """One period; it takes as long."""
        self._take_map()
        self._turn_switch()
        self._watch()
        if self.phase == "off":
            self._tell_silence()
            self.plant.wait()
        elif self.phase in ("rising", "lying"):
            self._move()
        elif self.phase == "active":
            self._control()
        else:
            self._stand()

    def note(self, text: str) -> None:
        """Adds an event of now."""
        self.events.append(Event(self.plant.time, text))
        log.info("t = %.2f s: %s", self.plant.time, text)

    def end(self) -> None:
        """The robot is to lie down, as if `/enable` had been set to false."""
        self._switch_off()

    @property
    def standing(self) -> bool:
        """Whether the controller has brought the robot to a stand for good, or joints are held."""
        return self.phase == "stopped"

    @property
    def prediction(self) -> Prediction | None:
        """What the controller has planned last; None while it has not."""
        return None if self.loop is None else self.loop.prediction

    def health(self) -> Health:
        """Phase, sensors, last stage, and what happened last."""
        plant, sensors = self.plant, self.plant.sensors
        age = sensors.age
        latest = [event.text for event in (*self.events, *self.mpc.events)][-1:]
        level = ERROR if self.phase == "stopped" else OK if age <= self.settings.state_timeout else WARN
        values = {
            "phase": self.phase,
            "age of the oldest sensor, s": f"{age:.3f}",
            "messages lost": sensors.lost,
            "messages refused": sum(stream.refused for stream in sensors.streams.values()),
            "targets cut by the last stage": plant.stage.cuts,
            "periods missed": plant.stalls,
            "operator": self.operator.presence,
        }
        message = latest[0] if latest else self.phase
        return Health(level, "rollgait: bridge", message, self.mpc.robot.name, values)

    def _silence(self) -> str:
        return self.plant.sensors.silent(self.settings.state_timeout)

    def _tell_silence(self) -> None:
        """Notes which sensors are not there, once somebody could miss them, and when they are."""
        if self._clock() >= self._missed_from and (silence := self._silence()) != self._silence_told:
            self.note(silence or "all sensors speak")
            self._silence_told = silence

    # -- the switch -------------------------------------------------------------------------------------

    def _turn_switch(self) -> None:
        while (edge := self.operator.edge()) is not None:
            if edge:
                self._switch_on()
            else:
                self._switch_off()

    def _switch_on(self) -> None:
        if self.phase not in ("off", "stopped"):
            return
        why = ""
        if self.plant.sensors.age > self.settings.state_timeout:
            why = self._silence()
        elif not self.plant.is_upright:
            why = "its base is tilted"
        if why:
            self.note(f"the robot is not enabled: {why}")
            return
        self.operator.forget()
        if self.phase == "stopped" and self.loop is not None:
            self.mpc.reset(STAND)
            self.loop.control = None
            self._enter("active", "enabled anew")
            return
        self._begin_rise()

    def _take_map(self) -> None:
        """Takes a map that has come, while the joints are told nothing: it takes the controller a second."""
        if self.loop is not None or self.phase not in ("off", "stopped"):
            return
        if (ground := self.operator.ground()) is not None:
            self.mpc.set_ground(ground)
            self.plant.resume()
            self.note("the ground is that of the last map")

    def _begin_rise(self) -> None:
        joints = self.plant.sensors.joints
        if joints is None:
            return
        if self.phase == "off":
            self.plant.take_hold(joints.position)
            self.plant.estimator.reset()
        told = self.plant.stage.target.position
        self._motion = JointMotion(self._rise.way_up(told), self.settings.rise.speed)
        self._effort = joints.effort, self._standing_torque
        self._enter("rising", f"rises, in {self._motion.duration:.1f} s")

    def _switch_off(self) -> None:
        if self.phase == "active":
            self.mpc.leave()
            self._lies_down, self._since = True, self.plant.time
        elif self.phase == "rising":
            self._begin_lying()  # from `stopped` it must be enabled first: somebody shall have had a look

    def _begin_lying(self) -> None:
        told = self.plant.stage.target
        self._motion = JointMotion(self._rise.way_down(told.position), self.settings.rise.speed)
        self._effort = told.torque, self._standing_torque
        self._enter("lying", f"lies down, in {self._motion.duration:.1f} s")

    def _enter(self, phase: Phase, why: str) -> None:
        self.phase, self._since, self._lies_down = phase, self.plant.time, False
        self.note(f"{phase}: {why}")

    # -- dead man ---------------------------------------------------------------------------------------

    def _watch(self) -> None:
        """Brings the robot to a stand where it must not go on."""
        if self.phase in ("off", "stopped"):
            return
        if self.plant.sensors.age > self.settings.state_timeout:
            self._stop(f"no state for {self.settings.state_timeout:g} s: {self._silence()}")
        elif self.plant.stall > STALL_MAX:
            self._stop(f"a stall of {self.plant.stall:.2g} s")
        elif not self.plant.is_upright:
            self._stop("its base is tilted by more than 45 degrees")
        elif self._is_on_its_way and self.operator.silent:
            self._stop(f"no command for {self.settings.command_timeout:g} s while a plan is followed")

    @property
    def _is_on_its_way(self) -> bool:
        """Whether a plan is followed that has not come to its end."""
        progress = self.mpc.progress if self.phase == "active" else None
        return progress is not None and progress.phase != "done"

    def _stop(self, why: str) -> None:
        if self.phase == "active":
            self.mpc.stop(why)
        self._stands_alone = self.phase == "active"
        self._enter("stopped", f"{why}; the robot stands until it is enabled anew")

    # -- phases -----------------------------------------------------------------------------------------

    def _move(self) -> None:
        """A period of the motion through postures."""
        motion, plant, period = self._motion, self.plant, self.mpc.settings.period
        if motion is None:
            raise RuntimeError("there is no motion to carry out")
        elapsed = plant.time - self._since + period
        position, before = motion.at(elapsed), motion.at(elapsed - period)
        share = min(1.0, elapsed / max(motion.duration, period))
        torque = (1.0 - share) * self._effort[0] + share * self._effort[1]
        plant.tell(JointTarget(position, (position - before) / period, torque))
        plant.wait()
        if plant.time - self._since < motion.duration + self.settings.rise.settle:
            return
        if self.phase == "lying":
            plant.stage.release()
            self.loop = None
            self._enter("off", "lies; nothing is told to the joints")
        else:
            self._begin_control()

    def _begin_control(self) -> None:
        plant, mpc = self.plant, self.mpc
        state = plant.state
        x, y, _ = state.com_position.tolist()
        plant.begin_at(standing_state(mpc.robot, plant.time, x, y, float(state.euler[0])))
        mpc.reset(STAND)
        self.loop = ClosedLoop(mpc, plant, observer(NAME, mpc.settings.period, Fresh()))
        if self._plans:
            mpc.follow(*self._plans)
        self._enter("active", "the controller has it")

    def _control(self) -> None:
        """A period of the closed loop under what is asked for."""
        loop = self._loop()
        if loop.control is None and not self.plant.is_fresh:  # to begin with, there must be a state
            self._hold()
            return
        stand = VelocityCommand(gait=STAND)
        try:
            loop.step(stand if self._lies_down else self.operator.command(self._gait))
        except InputError as error:  # a plan that begins elsewhere, or no state at the first step
            self.note(f"not followed: {error}")
            self._stop("there is nothing to begin with")
            self._hold()
            return
        if loop.prediction is not None and loop.prediction.status.mode == "standing":
            self._stop("the controller has brought it to a stand")
        elif self._lies_down and self._rests():
            self._begin_lying()

    def _rests(self) -> bool:
        loop = self._loop()
        stands = loop.control is not None and bool(loop.control.contact.all())
        slow = float(np.linalg.norm(self.plant.state.com_velocity)) < REST_SPEED
        return stands and (slow or self.plant.time - self._since > REST_WITHIN)

    def _stand(self) -> None:
        """A period of standing: by the controller, which lets feet down, or with the joints held."""
        if self.loop is not None and self.loop.control is not None and self._stands_alone:
            self.loop.step(VelocityCommand())
        else:
            self._hold()

    def _hold(self) -> None:
        """A period in which the joints are where they were told to be."""
        self.plant.hold()
        self.plant.wait()

    def _loop(self) -> ClosedLoop:
        if self.loop is None:
            raise RuntimeError("the closed loop has not begun")
        return self.loop
