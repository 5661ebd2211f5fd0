"""A scenario that begins in the middle of a motion: what must fit, and how a measured state is made to."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import InputError
from rollgait.plant.moving import MOVING_SHAPES, MotionState
from rollgait.plant.state import RobotState
from rollgait.robot.robot import LEG_NAMES
from rollgait.scenario.begun import ON_GROUND
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.start import Motion

Array = NDArray[np.float64]

PUT_DOWN: Final = 0.02
"""Farthest that a foot which stands by the gait may be measured off the ground, m: legs sag by 1 cm."""
TOO_FAST: Final = 0.2
"""By how much a foot may be measured faster than its limit, m/s."""
TURNED: Final = 0.1
"""By how much a wheel that does not steer may be measured to point elsewhere, rad."""
WORTH_SAYING: Final = 1e-6
"""A change by less is rounding, SI units."""


def begun_at(scenario: Scenario, state: RobotState) -> tuple[Scenario, tuple[str, ...]]:
    """The scenario with a state as its start, and what of the state was changed so that it can be one.

    A state without contacts and forces is that of a robot which stands on all feet. Feet that stand by the
    gait are put on the ground, feet are not faster than their limits, and what does not steer points ahead.

    Args:
        scenario: its gait says which feet stand at t = 0.
        state: of the robot then.

    Raises:
        InputError: the state is none, or too far from one with which this gait can begin.
    """
    moving = state if isinstance(state, MotionState) else _moving(state)
    _check_shapes(moving)
    fit = _Fit(scenario, moving)
    return scenario.with_values({"start": {"motion": fit.motion().model_dump(mode="json")}}), tuple(
        fit.changes
    )


def _moving(state: Any) -> MotionState:
    if not isinstance(state, RobotState):
        rule = "must be a RobotState or a MotionState; plan.state_at(time) gives one"
        raise InputError("start", type(state), rule)
    return MotionState.of(state)


def _check_shapes(state: MotionState) -> None:
    for name, shape in MOVING_SHAPES.items():
        value = getattr(state, name)
        if name == "force" and value is None:
            continue
        array = np.asarray(value)
        if array.shape != shape:
            raise InputError(f"start.{name}", array.shape, f"must have the shape {shape}")
        if not np.isfinite(array).all():
            raise InputError(f"start.{name}", array, "must be finite")


class _Fit:
    """A measured state made to fit a scenario."""

    def __init__(self, scenario: Scenario, state: MotionState) -> None:
        self._scenario, self._state = scenario, state
        self.changes: list[str] = []

    def motion(self) -> Motion:
        """The start."""
        state, scenario = self._state, self._scenario
        in_air = np.array(scenario.schedule.begun) > 0.0
        place, velocity = state.foot_position.copy(), state.foot_velocity.copy()
        heading, speed = state.heading.copy(), state.speed.copy()
        self._put_down(place, in_air)
        velocity[~in_air, 2] = 0.0
        for leg, data in enumerate(scenario.body.leg_list):
            if data.foot == "point":
                heading[leg] = speed[leg] = 0.0
                if not in_air[leg]:
                    velocity[leg] = 0.0
            elif data.foot == "fixed":
                ahead = state.euler[0] + data.heading
                self._note(leg, "heading", heading[leg] - ahead, TURNED, "rad")
                heading[leg] = ahead
        for leg in range(len(LEG_NAMES)):
            self._limit(leg, bool(in_air[leg]), heading, velocity, speed)
        force = None if state.force is None else np.where(in_air[:, None], 0.0, state.force)
        values = {
            "com_position": state.com_position,
            "euler": state.euler,
            "com_velocity": state.com_velocity,
            "euler_rate": state.euler_rate,
            "foot_position": place,
            "foot_velocity": velocity,
            "heading": heading,
            "speed": speed,
        }
        numbers: dict[str, Any] = {name: np.asarray(value).tolist() for name, value in values.items()}
        return Motion(**numbers, force=None if force is None else force.tolist())

    def _put_down(self, place: Array, in_air: NDArray[np.bool_]) -> None:
        """Feet that stand are on the ground, and none is in it."""
        ground = self._ground(place)
        for leg in range(len(LEG_NAMES)):
            off = float(place[leg, 2] - ground[leg])
            if in_air[leg] and off >= 0.0:
                continue
            on_slope = self._scenario.ground.kind != "flat"
            if on_slope and not in_air[leg] and abs(off) < 5.0 * ON_GROUND:
                continue  # a plan's own ground, which is not the very surface
            self._note(leg, "height above the ground", off, PUT_DOWN, "m")
            place[leg, 2] = ground[leg]

    def _ground(self, place: Array) -> Array:
        """z of the ground under the feet, (4,), m."""
        scenario = self._scenario
        if scenario.ground.kind == "flat":
            return np.full(len(LEG_NAMES), scenario.ground.height)
        from rollgait.terrain.wheel_surface import WheelSurface  # loads SciPy

        legs, terrain = scenario.body.leg_list, scenario.terrain
        surfaces = {leg.foot_radius: WheelSurface(terrain, leg.foot_radius) for leg in legs}
        found = [surfaces[leg.foot_radius].height(*p[:2]) for leg, p in zip(legs, place, strict=True)]
        return np.array(found, dtype=float)

    def _limit(self, leg: int, in_air: bool, heading: Array, velocity: Array, speed: Array) -> None:
        """A foot is no faster than it may be."""
        scenario = self._scenario
        limit = float(scenario.value_of("bounds", "swing_speed_max")) if in_air else scenario.speed_max(leg)
        kind = scenario.body.leg_list[leg].foot
        if kind != "point":
            self._note(leg, "speed", self._beyond(speed[leg], limit), TOO_FAST, "m/s")
            speed[leg] = np.clip(speed[leg], -limit, limit)
        if kind == "steerable" or not in_air:
            return
        c, s = np.cos(heading[leg]), np.sin(heading[leg])
        axes = np.array([[c, s], [-s, c]])
        parts = axes @ velocity[leg, :2]
        for part in parts:
            self._note(leg, "speed", self._beyond(part, limit), TOO_FAST, "m/s")
        velocity[leg, :2] = axes.T @ np.clip(parts, -limit, limit)

    @staticmethod
    def _beyond(value: float, limit: float) -> float:
        return float(value - np.clip(value, -limit, limit))

    def _note(self, leg: int, what: str, change: float, most: float, unit: str) -> None:
        """Writes down a change; raises `InputError` if it is too large."""
        if not abs(change) <= most:
            rule = f"must be within {most:g} {unit} of what the gait, the ground and the limits allow"
            raise InputError(f"start.{LEG_NAMES[leg]}.{what}", f"{change:+.3g} {unit}", rule)
        if abs(change) > WORTH_SAYING:
            self.changes.append(f"{what} of {LEG_NAMES[leg]} changed by {-change:+.3g} {unit}")
