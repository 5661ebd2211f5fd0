"""A drive: the closed loop, period by period, under whatever the page asks for last."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from rollgait.errors import RollgaitError, UnknownNameError
from rollgait.mpc.command import VelocityCommand
from rollgait.mpc.loop import ClosedLoop
from rollgait.mpc.plans.manoeuvres import Manoeuvre, ahead
from rollgait.mpc.plans.performer import Performer
from rollgait.pace import WINDOW, Pace
from rollgait.terrain.terrain import Terrain
from rollgait.view.driving.hands import PATIENCE
from rollgait.view.driving.messages import (
    AHEAD,
    NO_FORCE,
    PUSHES_MAX,
    Array,
    Body,
    PushRequest,
    Request,
    Snapshot,
    Vector,
)
from rollgait.view.driving.recorder import Recorder

if TYPE_CHECKING:
    from rollgait.hardware.window import Window

SILENCE_MAX: Final = PATIENCE
"""A page that asks for nothing for so long is gone, as a browser is: the robot stops, s."""
GONE_AFTER: Final = 1.0
"""The same for a manoeuvre, s: nobody holds it as a joystick is held, and half a step is no good place."""
EVENTS_SHOWN: Final = 6
TWIST: Final = ("forward", "lateral", "turn_rate")
"""What of a command moves the robot."""


class Session:
    """A robot that is driven.

    Args:
        make: builds the loop, at first and after a fall.
        clock: seconds of wall time that only go on.
        terrain: the ground of that loop, for manoeuvres; level if None.
        manoeuvres: that may be asked for by name.
        window: through which others look, and perhaps drive while the page asks for nothing.
    """

    def __init__(
        self,
        make: Callable[[], ClosedLoop],
        clock: Callable[[], float] = time.perf_counter,
        terrain: Terrain | None = None,
        manoeuvres: Sequence[Manoeuvre] = (),
        window: Window | None = None,
    ) -> None:
        self._make, self._clock, self._window = make, clock, window
        self._terrain, self._manoeuvres = terrain, {one.name: one for one in manoeuvres}
        self._performer: Performer | None = None
        self._stopped_outside = False
        self._recorder = Recorder()
        self._begin()
        self._request = Request(VelocityCommand())
        self._heard = clock()

    def _begin(self) -> None:
        self.loop = self._make()
        robot, period = self.loop.mpc.robot, self.loop.mpc.settings.period
        self.period = period
        worker = None if self._performer is None else self._performer.worker
        self._performer = Performer(self.loop.mpc, self._terrain, worker)
        self.pace = Pace(period)
        self._radius = np.array([leg.wheel_radius or np.inf for leg in robot.leg_list])
        self._wheel_angle: Array = np.zeros(4)
        self._acting: list[tuple[float, PushRequest]] = []
        self._solve: deque[float] = deque(maxlen=round(WINDOW / period))
        self.loop.step(VelocityCommand())  # from here on there is a control and a prediction

    def handle(self, request: Request) -> None:
        """Takes a request. One that cannot be is not taken: an event says why, and the one before holds."""
        self._heard = self._clock()
        try:
            request.check()
        except RollgaitError as error:
            self.loop.mpc.note(f"the page's request was refused: {error}")
            return
        resumed = self._request.paused and not request.paused
        stopped = request.stops != self._request.stops
        self._stopped_outside |= stopped
        self._request = request
        self._recorder.want(request.record, self.loop)
        if request.reset:
            self._recorder.end(self.loop)
            self._reset()
        elif resumed:
            self.pace.restart()
        for push in request.pushes:
            self._push(push)
        if request.halt or stopped:
            self.performer.halt()
        elif request.manoeuvre:
            self._perform(request.manoeuvre, request.distance)

    @property
    def performer(self) -> Performer:
        """Of manoeuvres."""
        assert self._performer is not None
        return self._performer

    def _perform(self, name: str, distance: float) -> None:
        """Begins a manoeuvre; one that cannot be is an event."""
        try:
            if name == AHEAD:
                asked = ahead(self.loop.mpc.robot, distance)
            elif name in self._manoeuvres:
                asked = self._manoeuvres[name]
            else:
                raise UnknownNameError("manoeuvre", name, [*self._manoeuvres, AHEAD])
        except RollgaitError as error:
            self.loop.mpc.note(f"the page's request was refused: {error}")
            return
        self.performer.ask(asked, self.loop.plant.state)

    def close(self) -> None:
        """Ends what runs beside the loop."""
        self.performer.close()

    def _reset(self) -> None:
        if self.loop.plant.fallen:
            self._begin()
        else:
            self._performer = Performer(self.loop.mpc, self._terrain, self.performer.worker)
            self.loop.mpc.reset()
            self.loop.control = None
            self.loop.step(VelocityCommand())
        self.pace.restart()

    def _push(self, push: PushRequest) -> None:
        if not self.loop.plant.fallen and len(self._acting) < PUSHES_MAX:
            self.loop.plant.push(np.array(push.force), push.duration)
            self._acting.append((self.loop.time + push.duration, push))

    @property
    def command(self) -> VelocityCommand:
        """What is asked for now; nothing but gait and height by a page that is silent.

        The page goes before who commands from outside: whoever sits there sees the robot.
        """
        command = self._request.command
        if self._silent:
            command = command.model_copy(update=dict.fromkeys(TWIST, 0.0))
        outside = self._from_outside()
        if outside is None or any(getattr(command, name) for name in TWIST):
            return command
        return command.model_copy(update={name: getattr(outside, name) for name in TWIST})

    def _from_outside(self) -> VelocityCommand | None:
        """What is asked for from outside; after a stop on the page only once it has been silent there."""
        operator = None if self._window is None else self._window.operator
        if operator is None or operator.silent:
            self._stopped_outside = False
            return None
        asked = operator.command(self._request.command.gait)
        return asked if isinstance(asked, VelocityCommand) and not self._stopped_outside else None

    @property
    def pull(self) -> Vector:
        """Force with which somebody pulls now, N."""
        return NO_FORCE if self._silent else self._request.pull

    @property
    def _silent(self) -> bool:
        return self._clock() - self._heard > SILENCE_MAX

    def step(self) -> None:
        """One period; a robot that has fallen lies still, and in a pause all does."""
        loop = self.loop
        if self._window is not None:
            self._window.listen()
        if loop.plant.fallen or self._request.paused:
            return
        if self.pull != NO_FORCE:
            loop.plant.push(np.array(self.pull), self.period)
        if self._clock() - self._heard > GONE_AFTER:
            self.performer.halt()
        before, pose = loop.plant.state, getattr(loop.plant, "pose", None)
        _, prediction = loop.step(self.performer.command(self.command))
        self.performer.update(loop.plant.state)
        self._recorder.add(before, pose, loop)
        self._solve.append(prediction.status.seconds)
        self._wheel_angle = self._wheel_angle + loop.plant.state.speed / self._radius * self.period
        self._acting = [(end, push) for end, push in self._acting if end > loop.time + 1e-9]
        if self._window is not None:
            self._window.after(loop, self.pace.factor)

    def snapshot(self) -> Snapshot:
        """How it goes now."""
        loop = self.loop
        state, control, prediction = loop.plant.state, loop.control, loop.prediction
        if control is None or prediction is None:
            raise RuntimeError("the loop has not made a step yet")
        c, s = np.cos(state.euler[0]), np.sin(state.euler[0])
        vx, vy, _ = state.com_velocity
        fallen = loop.plant.fallen
        pushes = [] if fallen else [*(push.force for _, push in self._acting), self.pull]
        pushed = np.sum([NO_FORCE, *pushes], axis=0)
        plant: Any = loop.plant
        pose = getattr(plant, "pose", None)
        solve = np.array(self._solve or [0.0])
        return Snapshot(
            state=state,
            body=None if pose is None else Body(*pose),
            joint_names=tuple(getattr(plant, "joint_names", ())),
            wheel_angle=self._wheel_angle,
            force=np.asarray(getattr(plant, "contact_force", control.force)),
            contact=control.contact,
            pushed=pushed,
            com_path=prediction.com_position,
            foot_path=prediction.foot_position,
            foot_contact=prediction.contact,
            command=self.command,
            wanted=loop.mpc.wanted,
            actual=(float(c * vx + s * vy), float(c * vy - s * vx), float(state.euler_rate[0])),
            gait=loop.mpc.clock.gait.name,
            mode="fallen" if fallen else "paused" if self._request.paused else prediction.status.mode,
            solve=(float(np.median(solve)), float(np.percentile(solve, 99))),
            rate=self.pace.rate,
            factor=self.pace.factor,
            recorded=self._recorder.seconds,
            written=self._recorder.written,
            manoeuvre=self.performer.said(loop.plant.state),
            events=tuple((event.time, event.text) for event in list(loop.mpc.events)[-EVENTS_SHOWN:]),
        )
