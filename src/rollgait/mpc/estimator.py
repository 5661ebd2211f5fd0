"""What the controller gets to know of the plant's state: the truth, or something worse.

An estimator is asked once in each period with the true state and with what the controller expects the state
to be now (None at first). It may return None: no message has come.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rollgait.mpc.state import RobotState

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
    """What another estimator said some periods ago, moved on by what the controller has expected since.

    Args:
        periods: age of the message.
        inner: the other estimator; the truth if not given.
    """

    def __init__(self, periods: int, inner: Estimator | None = None) -> None:
        self._inner = inner or Truth()
        self._known: deque[tuple[RobotState | None, RobotState | None]] = deque(maxlen=periods + 1)

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        self._known.append((self._inner(true, expected), expected))
        measured, expected_then = self._known[0]
        if measured is None or expected is None or expected_then is None:
            return measured.at(true.time) if measured is not None else None
        return corrected(expected, expected_then, measured, Trust())


@dataclass(frozen=True)
class Trust:
    """Share of the difference between what is measured and what was expected that is believed, 0 … 1.

    Attributes:
        place: of CoM and feet in the ground plane, and of yaw and headings.
        posture: of the height of the CoM, pitch and roll.
        motion: of velocities and Euler rates.
        feet: of the feet's places relative to the CoM.
    """

    place: float = 1.0
    posture: float = 1.0
    motion: float = 1.0
    feet: float = 1.0


@dataclass
class Blended:
    """Between what another estimator says and what the controller expected: a first-order observer.

    Joints that are held stiffly at where they are told to be keep the robot near what is expected; a
    controller that starts anew from each measurement would take every sag of a joint for its own will.
    """

    trust: Trust
    inner: Estimator

    def __call__(self, true: RobotState, expected: RobotState | None) -> RobotState | None:
        measured = self.inner(true, expected)
        if measured is None or expected is None or not measured.is_finite():
            return measured
        return corrected(expected, expected, measured, self.trust)


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
    """`base`, corrected by shares of `measured` − `expected`."""
    gap = measured.com_position - expected.com_position
    euler = measured.euler - expected.euler
    angle_share = np.array([trust.place, trust.posture, trust.posture])
    feet = measured.foot_position - expected.foot_position
    # what CoM and feet have in common is a drift over the ground; the rest is the posture
    drift = np.concatenate([feet[:, :2].mean(axis=0), [0.0]])
    com = drift * trust.place + (gap - drift) * trust.posture
    return RobotState(
        time=measured.time if base is expected else base.time,
        com_position=base.com_position + com,
        euler=base.euler + angle_share * euler,
        com_velocity=base.com_velocity + trust.motion * (measured.com_velocity - expected.com_velocity),
        euler_rate=base.euler_rate + trust.motion * (measured.euler_rate - expected.euler_rate),
        foot_position=base.foot_position + trust.place * drift + trust.feet * (feet - drift),
        heading=base.heading + trust.place * (measured.heading - expected.heading),
        speed=measured.speed,
    )
