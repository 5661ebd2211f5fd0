"""Settings of the controller: horizon, weights and bounds, as data that users write."""

from __future__ import annotations

import math
from typing import Annotated, Final

from pydantic import Field, ValidationInfo, field_validator

from rollgait.config import Config, Flag, NonNegative, Number, Positive, Whole

INTERVALS_MAX: Final = 500
"""Most intervals of a horizon: a step with more takes far longer than any period."""
PERIOD_MIN: Final = 1e-3
"""s; the physics have no shorter steps."""


class MpcWeights(Config):
    """Weights of the costs. The first six are the paper's terms, about references that move."""

    acc: NonNegative = 1.0
    """On ‖r̈‖², acceleration of the CoM."""
    goal: NonNegative = 200.0
    """On (x, y, yaw) − reference, squared."""
    height: NonNegative = 2000.0
    """On (z − z_ref)²."""
    force: NonNegative = 5e-4
    """On h_ref² ‖Δf / h‖² of neighbouring intervals, forces in N."""
    feet: NonNegative = 100.0
    """On Σ‖Rzᵀ(p_i − r) − p̄_i‖² in the ground plane."""
    speed: NonNegative = 1.0
    """On Σ (v_i − v_i,ref)²."""
    yaw: NonNegative = 1.5
    """On Σ σ̇_i²."""
    tilt: NonNegative = 400.0
    """On pitch² + roll²."""
    velocity: NonNegative = 20.0
    """On ‖ṙ − ṙ_ref‖²."""
    rotation: NonNegative = 10.0
    """On ‖θ̇ − θ̇_ref‖²."""
    heading: NonNegative = 5.0
    """On Σ (σ_i − σ_i,ref)²."""
    share: NonNegative = 20.0
    """On Σ‖f_i − its share of the weight‖², forces in weights of the robot."""
    idle: NonNegative = 20.0
    """On the squares of inputs that have no effect: forces in swing, rolling of locked wheels."""
    workspace: NonNegative = 2e4
    """On the square of what box, reach and joints are exceeded by, m² and rad²."""
    support: NonNegative = 2e4
    """On the square of what `com_margin` is missed by, m²."""
    foothold: NonNegative = 5e3
    """On the square of how far feet on the ground are where they should not be: on edges, m²."""
    terminal: NonNegative = 5.0
    """Factor on the costs of states at the end of the horizon, over those of an interval."""


class MpcBounds(Config):
    """Bounds of the inputs (hard) and of the states (by a cost beyond them)."""

    friction: Positive = 0.5
    """Friction coefficient that the forces may use; the ground should have more."""
    force_min: NonNegative | None = None
    """Smallest normal force in stance, N. Default: 40, less for light robots."""
    speed_max: Positive = 1.0
    """Limit of |v| in stance, m/s; the robot's own limit holds as well."""
    swing_speed_max: Positive = 1.0
    """Limit of |v| in swing, m/s."""
    acceleration_max: Positive = 2.0
    """Limit of |v̇| of feet that stay on the ground, m/s²."""
    swing_acceleration_max: Positive = 4.0
    """Limit of |v̇| of feet in swing, m/s²."""
    steering_rate_max: Positive = 2.0
    """Limit of |σ̇|, rad/s; the robot's own limit holds as well."""
    com_margin: NonNegative = 0.02
    """How far inside the feet that stand the CoM is wanted while one of four swings, m: joints give way, and
    states are not known, by as much in a small robot."""
    workspace: Flag = True
    """Keep the feet within box, reach and joint angles."""
    joint_margin_deg: Annotated[Number, Field(ge=0.0, le=45.0)] = 8.6
    """Distance from the limits of hip_yaw and the steering joint, degrees."""


class CommandLimits(Config):
    """The fastest that may be asked for; what is more is cut, and said so."""

    speed: Positive = 0.8
    """Of the CoM over the ground, m/s."""
    turn_rate: Positive = 0.8
    """Yaw rate, rad/s."""
    height_change: Positive = 0.05
    """Farthest of the CoM from its nominal height, m."""
    acceleration: Positive = 0.6
    """With which the reference speeds up and brakes, m/s²."""
    turn_acceleration: Positive = 1.0
    """The same for the yaw rate, rad/s²."""


class MpcSettings(Config):
    """Everything about a controller but the robot."""

    horizon: Positive = 1.0
    """s."""
    interval: Positive = 0.1
    """h, s; the horizon is cut into round(T / h) equal intervals."""
    period: Positive = 0.01
    """Time between two steps of the controller, s."""
    iterations: Annotated[Whole, Field(ge=1, le=500)] = 1
    """Largest number of iterations in a step; 1 is the real-time iteration."""
    deadline: Positive | None = None
    """s of wall time after which a step returns what it has; the period if not given."""
    weights: MpcWeights = MpcWeights()
    """Weights of the costs."""
    bounds: MpcBounds = MpcBounds()
    """Bounds."""
    limits: CommandLimits = CommandLimits()
    """Limits of commands."""

    @field_validator("interval")
    @classmethod
    def _divides_the_horizon(cls, value: float, others: ValidationInfo) -> float:
        horizon = others.data.get("horizon", math.nan)
        if math.isfinite(horizon) and not 1.5 <= horizon / value <= INTERVALS_MAX + 0.5:
            raise ValueError(f"must divide the horizon of {horizon:g} s into 2 to {INTERVALS_MAX} intervals")
        return value

    @field_validator("period")
    @classmethod
    def _fits_the_interval(cls, value: float, others: ValidationInfo) -> float:
        longest = others.data.get("interval", math.inf)
        if not PERIOD_MIN <= value <= longest:
            raise ValueError(f"must lie between {PERIOD_MIN:g} s and the interval of {longest:g} s")
        return value

    @property
    def intervals(self) -> int:
        """N."""
        return round(self.horizon / self.interval)
