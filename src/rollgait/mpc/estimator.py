"""What the controller gets to know of the plant's state: the truth, or something worse.

An estimator is asked once in each period with the true state and with what the controller expects the state
to be now (None at first). It may return None: no message has come.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.angles import turned
from rollgait.mpc.incoming import fault_of
from rollgait.plant.state import RobotState, largest_gap, unwrapped

Array = NDArray[np.float64]


class Estimator(Protocol):
    """Turns the true state into what is known."""

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        """What is known now."""


class Truth:
    """The true state."""

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        return true


@dataclass
class Noisy:
    """The true state and white noise.

    Attributes:
        position: standard deviation of the CoM and of the feet, m.
        angle: of angles, rad.
        velocity: of velocities, m/s.
        rate: of Euler rates, rad/s.
        seed: of the random numbers.
    """

    position: float = 0.002
    angle: float = 0.002
    velocity: float = 0.02
    rate: float = 0.02
    seed: int = 0

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        def noise(scale: float, like: Array) -> Array:
            return scale * self._random.normal(size=like.shape)

        return replace(
            true,
            com_position=true.com_position + noise(self.position, true.com_position),
            euler=true.euler + noise(self.angle, true.euler),
            com_velocity=true.com_velocity + noise(self.velocity, true.com_velocity),
            euler_rate=true.euler_rate + noise(self.rate, true.euler_rate),
            foot_position=true.foot_position + noise(self.position, true.foot_position),
            heading=true.heading + noise(self.angle, true.heading),
        )


class Delayed:
    """What another estimator said some periods ago. `Blended` with this lag makes up for the age.

    Args:
        periods: age of the message; the first one stays until there are so many.
        inner: the other estimator; the truth if not given.
    """

    def __init__(self, periods: int, inner: Estimator | None = None) -> None:
        self._inner = inner or Truth()
        self._known: deque[RobotState | None] = deque(maxlen=periods + 1)

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        self._known.append(self._inner(true, expected))
        measured = self._known[0]
        return None if measured is None else measured.at(true.time)


@dataclass(frozen=True)
class Trust:
    """Share of the difference between what is measured and what was expected that is believed, 0 … 1.

    Attributes:
        place: of how far CoM and feet together have slid or turned over the ground.
        posture: of where CoM, base and feet are relative to one another.
        motion: of velocities and Euler rates.
    """

    place: float = 1.0
    posture: float = 1.0
    motion: float = 1.0


class Blended:
    """Between what another estimator says and what the controller expected: a first-order observer.

    Joints that are held stiffly at where they are told to be keep the robot near what is expected; a
    controller that starts anew from each measurement would take every sag of a joint for its own will.

    Args:
        trust: shares of the measurement.
        inner: the other estimator; the truth if not given.
        lag: by how many periods the measurement is known to be behind what the robot is told.
        gate: of a measurement of places that is farther than this from what was expected no share is
            believed: it is handed on as it is, for the controller to refuse, m.
    """

    def __init__(
        self, trust: Trust, inner: Estimator | None = None, lag: int = 0, gate: float = math.inf
    ) -> None:
        self._trust, self._inner, self._gate = trust, inner or Truth(), gate
        self._expected: deque[RobotState] = deque(maxlen=lag + 1)

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        measured = self._inner(true, expected)
        if expected is None:
            self._expected.clear()
            if measured is not None:
                self._expected.append(measured)
            return measured
        self._expected.append(expected)
        if measured is None or fault_of(measured):
            return measured  # the controller says so; not even a share of it is believed
        then = self._expected[0]
        measured = unwrapped(measured, then)
        if largest_gap(measured, then) > self._gate:
            return measured  # as above
        result = corrected(expected, then, measured, self._trust)
        # the expectations of the past move along, or the same gap would be corrected again and again
        moved = [corrected(state, then, measured, self._trust) for state in self._expected]
        self._expected.clear()
        self._expected.extend(moved)
        return result.at(true.time)


@dataclass
class Dropping:
    """Loses the messages of given periods (counted from 0): for tests of what happens then."""

    lost: Collection[int]
    inner: Estimator

    def __post_init__(self) -> None:
        self._count = -1

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        self._count += 1
        return None if self._count in self.lost else self.inner(true, expected)


def corrected(base: RobotState, expected: RobotState, measured: RobotState, trust: Trust) -> RobotState:
    """`base`, corrected by shares of the difference between `measured` and `expected`.

    The difference is a motion of the whole robot over the ground, found from its feet, and what is left then.
    """
    was, now = expected.foot_position[:, :2], measured.foot_position[:, :2]
    from_centre, to_centre = was - was.mean(axis=0), now - now.mean(axis=0)
    cross = from_centre[:, 0] @ to_centre[:, 1] - from_centre[:, 1] @ to_centre[:, 0]
    turn = float(np.arctan2(cross, np.sum(from_centre * to_centre)))
    slide = now.mean(axis=0) - was.mean(axis=0)
    full = _moved(expected, turn, slide, was.mean(axis=0))
    moved = _moved(base, trust.place * turn, trust.place * slide, base.foot_position[:, :2].mean(axis=0))

    def left(name: str, share: float) -> Array:
        gap = getattr(measured, name) - getattr(full, name)
        return np.asarray(getattr(moved, name) + share * gap)

    return RobotState(
        time=base.time,
        com_position=left("com_position", trust.posture),
        euler=left("euler", trust.posture),
        com_velocity=left("com_velocity", trust.motion),
        euler_rate=left("euler_rate", trust.motion),
        foot_position=left("foot_position", trust.posture),
        heading=left("heading", trust.posture),
        speed=measured.speed,
    )


def _moved(state: RobotState, turn: float, slide: Array, pivot: Array) -> RobotState:
    """The whole robot turned about a vertical axis through `pivot`, then moved, in the ground plane."""
    centre, shift = np.append(pivot, 0.0), np.append(slide, 0.0)
    return replace(
        state,
        com_position=turned(state.com_position - centre, turn) + centre + shift,
        euler=state.euler + np.array([turn, 0.0, 0.0]),
        com_velocity=turned(state.com_velocity, turn),
        foot_position=turned(state.foot_position - centre, turn) + centre + shift,
        heading=state.heading + turn,
    )
