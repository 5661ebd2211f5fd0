"""What to make of a state that comes in, or does not: faults are found before they reach the plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from numbers import Real
from typing import Any, Final

import numpy as np

from rollgait.errors import MISSING, InputError
from rollgait.mpc.following import Following, Unchanged
from rollgait.plant.control import Control
from rollgait.plant.state import SHAPES, RobotState, unwrapped
from rollgait.robot.robot import LEG_NAMES

MISSING_MAX: Final = 0.1
"""So long the robot goes on without a usable state, s."""
STALL: Final = 1.5
"""A state that comes later than so many periods after the last counts as a stall."""
STALL_MAX: Final = 0.3
"""After a stall of this length the last plan is worth nothing any more, s."""
AGE_MAX: Final = 0.1
"""A state that is older than what is expected of now by more is no use, s."""
AHEAD_MAX: Final = 10.0
"""Nor is one from farther in the future, s: it is its clock that leapt."""
TIME_MAX: Final = 1e12
"""No clock shows more, s."""
PLACE_MAX: Final = 1e6
"""No robot is farther from the origin, m."""
WOUND_MAX: Final = 1e4
"""Nor has turned farther, rad."""
FEET_AWAY_MAX: Final = 1.0
"""No robot has its feet farther from its CoM, on average, in the ground plane, m."""
FOOT_AWAY_MAX: Final = 5.0
"""Nor one of them, m."""
SPEED_MAX: Final = 10.0
"""Nor moves faster, m/s."""
TURN_MAX: Final = 30.0
"""Nor turns faster, rad/s."""
TILT_MAX: Final = np.radians(85.0)
"""Euler angles end at 90 degrees of pitch, rad."""
LEAP_MAX: Final = {
    "com_position": (0.1, "m"),
    "foot_position": (0.1, "m"),
    "euler": (0.15, "rad"),
    "heading": (1.0, "rad"),
    "com_velocity": (1.0, "m/s"),
    "euler_rate": (2.0, "rad/s"),
}
"""Farthest that a part of a state may be from what was expected of it one period before, and its unit: a few
times what a push or an estimator's noise does, and less than a robot with two legs swapped shows."""
LEAP_TIME: Final = 0.05
"""s: a stall of so long doubles what is allowed."""
ASTRAY: Final = 0.25
"""Speed at which feet on the ground may go elsewhere than they are told, m/s: slipping wheels stay below."""
UNCHANGED_MAX: Final = 0.005
"""So far the robot may be told to go while its state stays the same to the last bit, m."""

Note = Callable[[float, str], None]


def fault_of(state: Any) -> str:
    """Why something cannot be the state of a robot: which part breaks which rule. Empty if it can."""
    return _malformed(state) or _impossible(state)


def _malformed(state: Any) -> str:
    if not isinstance(state, RobotState):
        return f"the state is no RobotState but of type {type(state).__name__}"
    if not _is_time(state.time):
        return "the state's time is no number of seconds"
    for name, shape in SHAPES.items():
        part = getattr(state, name)
        if not isinstance(part, np.ndarray):
            return f"the state's {name} is no NumPy array but of type {type(part).__name__}"
        if part.shape != shape:
            return f"the state's {name} has the shape {part.shape}, which must be {shape}"
        if part.dtype.kind not in "fiu":
            return f"the state's {name} holds no real numbers but {part.dtype}"
        if not all(map(math.isfinite, part.ravel().tolist())):
            return f"the state's {name} holds a value that is not a number"
    return ""


def _is_time(value: Any) -> bool:
    number: Any = value if isinstance(value, Real) else np.nan
    return bool(abs(number) < TIME_MAX)


def _impossible(state: RobotState) -> str:
    # Python's numbers: of so few they are quicker than NumPy's, and say nothing of what is too large for them
    r, euler = state.com_position.tolist(), state.euler.tolist()
    levers = [[a - b for a, b in zip(p, r, strict=True)] for p in state.foot_position.tolist()]
    x, y = (sum(lever[axis] for lever in levers) / len(levers) for axis in range(2))
    for what, values, most, unit in (
        ("CoM is beside its feet by", [math.hypot(x, y)], FEET_AWAY_MAX, "m"),
        ("farthest foot is away by", [math.hypot(*lever) for lever in levers], FOOT_AWAY_MAX, "m"),
        ("com_position is", r, PLACE_MAX, "m"),
        ("com_velocity is", state.com_velocity.tolist(), SPEED_MAX, "m/s"),
        ("euler_rate is", state.euler_rate.tolist(), TURN_MAX, "rad/s"),
        ("pitch or roll is", euler[1:], TILT_MAX, "rad"),
        ("yaw is", euler[:1], WOUND_MAX, "rad"),
        ("heading is", state.heading.tolist(), WOUND_MAX, "rad"),
    ):
        largest = float(max(map(abs, values)))
        if not largest <= most:
            rule = f"{largest:.3g} {unit}, at most {most:.3g} {unit}"
            return f"the state is not one that a robot can have: its {what} {rule}"
    return ""


def _leap(state: RobotState, expected: RobotState, stall: float) -> str:
    """Which part of a state is too far from what was expected of it; empty if none is."""
    grown = 1.0 + stall / LEAP_TIME
    for name, (most, unit) in LEAP_MAX.items():
        gap = np.abs(getattr(state, name) - getattr(expected, name))
        if not gap.max() <= grown * most:
            # of what has a row or a number for each leg, which one
            leg = f" of {LEG_NAMES[np.unravel_index(gap.argmax(), gap.shape)[0]]}" if len(gap) == 4 else ""
            return f"the state's {name}{leg} is {gap.max():.3g} {unit} from what was expected"
    return ""


class Incoming:
    """Judges the states of a controller one by one.

    States that were far from what the robot was told until it had to stand are believed no more until
    `reset`: old ones agree with one another, and would seem right again once the robot rests.

    Args:
        period: at which they should come, s.
        note: hears what is wrong: the time and a sentence.
        stop: hears why the robot must stand.
        follows: whether the states are those of a robot that does what it is told; a recording does not.
    """

    def __init__(self, period: float, note: Note, stop: Callable[[str], None], follows: bool = True) -> None:
        self._period, self._note, self._stop, self._follows = period, note, stop, follows
        self._following, self._unchanged = Following(period), Unchanged(period)
        self.reset()

    def reset(self) -> None:
        """Forgets everything."""
        self._missing_since: float | None = None
        self._measured = -np.inf
        self._disowned = ""
        self._following.reset()
        self._unchanged.reset()

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
        fault = "no usable state has come" if state is None else fault_of(state)
        if last is None:
            if state is None or fault:
                raise InputError("state", MISSING, f"cannot be used for the first step: {fault}")
            self._measured = state.time
            return state, 0.0
        if state is not None and not fault:
            state = unwrapped(state, last.end)
            fault = self._disowned or self._contradiction(state, last)
        if state is None or fault:
            return self._without(last, fault)
        self._missing_since, self._measured = None, state.time
        elapsed = max(state.time - last.begin.time, 0.0)
        if elapsed > STALL * self._period:
            self._note(state.time, f"the last step was {1e3 * elapsed:.0f} ms ago")
            if elapsed > STALL_MAX:
                self._stop(f"a stall of {elapsed:.2g} s")
        return state, elapsed

    def _contradiction(self, state: RobotState, last: Control) -> str:
        """What of a state does not go with what came before; empty if all does."""
        if state.time <= self._measured:
            return "the state is as old as the last one or older"
        late = state.time - last.end.time
        if late < -AGE_MAX:
            return f"the state is {-late:.2g} s old"
        if late > AHEAD_MAX:
            return f"the state's time is {late:.3g} s ahead"
        if fault := _leap(state, last.end, max(late, 0.0)):
            self._disowned = fault if self._missing_for(last) > MISSING_MAX else ""
            return fault
        if self._follows and (way := self._unchanged.way(state, last)) > UNCHANGED_MAX:
            self._disowned = (
                f"the state stays the same while the robot is told to go {1e3 * way:.1f} mm: "
                "as if its source had stopped"
            )
            return self._disowned
        is_next = abs(late) < (STALL - 1.0) * self._period
        if self._follows and is_next and (speed := self._following.speed(state, last)) > ASTRAY:
            self._disowned = (
                f"the state's feet do not follow what they are told, by {speed:.2g} m/s: as if it were old"
            )
        return self._disowned

    def _missing_for(self, last: Control) -> float:
        """How long no state could be used, s."""
        return 0.0 if self._missing_since is None else last.end.time - self._missing_since

    def _without(self, last: Control, fault: str) -> tuple[RobotState, float]:
        expected = last.end
        if self._missing_since is None:
            self._missing_since = last.begin.time
            self._note(expected.time, f"{fault}: going on with the expected one")
        if self._missing_for(last) > MISSING_MAX:
            self._stop(f"no usable state for {MISSING_MAX:g} s ({fault})")
        return expected, expected.time - last.begin.time
