"""What to make of a state that comes in, or does not: faults are found before they reach the plan."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from rollgait.errors import InputError
from rollgait.mpc.state import SHAPES, Control, RobotState, unwrapped

MISSING_MAX: Final = 0.1
"""So long the robot goes on without a usable state, s."""
STALL: Final = 1.5
"""A state that comes later than so many periods after the last counts as a stall."""
STALL_MAX: Final = 0.3
"""After a stall of this length the last plan is worth nothing any more, s."""
FEET_AWAY_MAX: Final = 1.0
"""No robot has its feet farther from its CoM, on average, m."""
SPEED_MAX: Final = 10.0
"""Nor moves faster, m/s."""
TURN_MAX: Final = 30.0
"""Nor turns faster, rad/s."""
TILT_MAX: Final = np.radians(85.0)
"""Euler angles end at 90 degrees of pitch, rad."""

Note = Callable[[float, str], None]


def is_possible(state: RobotState) -> bool:
    """Whether a robot can have such a state; what is not a number it cannot have."""
    if not state.is_finite():
        return False
    away = state.foot_position[:, :2].mean(axis=0) - state.com_position[:2]
    fast = max(
        float(np.abs(state.com_velocity).max()) / SPEED_MAX,
        float(np.abs(state.euler_rate).max()) / TURN_MAX,
    )
    return bool(
        np.hypot(*away) <= FEET_AWAY_MAX and fast <= 1.0 and np.abs(state.euler[1:]).max() <= TILT_MAX
    )


class Incoming:
    """Judges the states of a controller one by one.

    Args:
        period: at which they should come, s.
        note: hears what is wrong: the time and a sentence.
        stop: hears why the robot must stand.
    """

    def __init__(self, period: float, note: Note, stop: Callable[[str], None]) -> None:
        self._period, self._note, self._stop = period, note, stop
        self.reset()

    def reset(self) -> None:
        """Forgets everything."""
        self._missing_since: float | None = None
        self._measured = -np.inf

    @property
    def missing(self) -> bool:
        """Whether the last state could not be used."""
        return self._missing_since is not None

    def take(self, state: RobotState | None, last: Control | None) -> tuple[RobotState, float]:
        """The state to plan from, and the time since the last one was planned from, s.

        Args:
            state: that has come; None if none has.
            last: what the robot was told to do last; None at the first step.

        Raises:
            InputError: the first state cannot be used.
        """
        fault = self._fault(state)
        if last is None:
            if state is None or fault:
                raise InputError(
                    "state", None if state is None else state.time, f"at the first step: {fault}"
                )
            self._measured = state.time
            return state, 0.0
        if state is None or fault:
            return self._without(last, fault)
        self._missing_since, self._measured = None, state.time
        state = unwrapped(state, last.end)
        elapsed = max(state.time - last.begin.time, 0.0)
        if elapsed > STALL * self._period:
            self._note(state.time, f"the last step was {1e3 * elapsed:.0f} ms ago")
            if elapsed > STALL_MAX:
                self._stop(f"a stall of {elapsed:.2g} s")
        return state, elapsed

    def _fault(self, state: RobotState | None) -> str:
        """Why a state cannot be used; empty if it can."""
        if state is None:
            return "no usable state has come"
        if any(np.shape(getattr(state, name)) != shape for name, shape in SHAPES.items()):
            return "the state has parts of the wrong shape"
        if not state.is_finite():
            return "the state holds a value that is not a number"
        if state.time <= self._measured:
            return "the state is as old as the last one or older"
        return "" if is_possible(state) else "the state is not one that a robot can have"

    def _without(self, last: Control, fault: str) -> tuple[RobotState, float]:
        expected = last.end
        if self._missing_since is None:
            self._missing_since = last.begin.time
            self._note(expected.time, f"{fault}: going on with the expected one")
        if expected.time - self._missing_since > MISSING_MAX:
            self._stop(f"no usable state for {MISSING_MAX:g} s ({fault})")
        return expected, expected.time - last.begin.time
