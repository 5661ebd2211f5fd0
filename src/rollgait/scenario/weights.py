"""Weights of the costs and bounds of the constraints, by the name of their term.

A value that is not given takes the default of the scenario's profile (`profile.py`), and where that has none
either, the term is not part of the problem.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from rollgait.config import Config, Flag, NonNegative, Number, Positive, PositiveVector3, Range

Margin = Annotated[Number, Field(ge=0.0, le=45.0)]


class Weights(Config):
    """Weights of the costs: the paper's six, then those of the profile `executable`. 0 switches off."""

    acc: NonNegative | None = None
    """On ‖r̈‖², acceleration of the CoM."""
    goal: NonNegative | None = None
    """On ‖r − r_goal‖² + ‖θ − θ_goal‖²."""
    force: NonNegative | None = None
    """On h_ref² ‖Δf / h‖² of neighbouring intervals, forces in N, h_ref = 0.1 s."""
    feet: NonNegative | None = None
    """On Σ‖Rzᵀ(p_i − r) − p̄_i‖²."""
    speed: NonNegative | None = None
    """On Σ v_i²."""
    yaw: NonNegative | None = None
    """On Σ σ̇_i²."""
    tilt: NonNegative | None = None
    """On pitch² + roll² (executable)."""
    terminal_goal: NonNegative | None = None
    """On (x, y, yaw) − goal at the end (executable)."""
    lift: NonNegative | None = None
    """On (ṗz − that of a smooth lift)² of feet in swing (executable)."""
    swing: NonNegative | None = None
    """On the planar velocity of feet in swing that the other costs leave undetermined (executable)."""
    speed_in_contact_only: Flag = False
    """Leave v of feet in swing out of `speed`: the paper's knob between car-like and walking behaviour."""


class Bounds(Config):
    """Bounds of the constraints."""

    box: PositiveVector3 | None = None
    """b: half-sizes of the foot's box about its nominal place, m. Default: the robot's."""
    full_rotation: Flag = False
    """Express the box in the base frame R(θ) instead of the base-yaw frame Rz."""
    steering_deg: Range | None = None
    """Range of σ − θz, degrees. Default: the robot's, leg by leg."""
    steering_rate_max: Positive | None = None
    """Limit of |σ̇|, rad/s; the robot's own limit holds as well."""
    speed_max: Positive | None = None
    """Limit of |v| in stance, m/s; the robot's own limit holds as well."""
    swing_speed_max: Positive | None = None
    """Limit of |v| in swing, m/s."""
    force_min: NonNegative | None = None
    """Smallest normal force in stance, N."""
    force_max: Positive | None = None
    """Largest normal force in stance, N; the robot's own limit holds as well."""
    inscribed: Flag = False
    """Use the pyramid inside the friction cone: μ/√2."""
    touchdown_speed: Positive | None = None
    """Limit of the vertical speed at touch-down, m/s (executable)."""
    acceleration_max: Positive | None = None
    """Limit of |Δv|/h of feet that stay on the ground, m/s² (executable)."""
    swing_acceleration_max: Positive | None = None
    """Limit of |Δv|/h of feet in swing or just landed, m/s² (executable)."""
    joint_steering: Flag | None = None
    """Keep hip_yaw and the steering joint within their limits, in place of `steering_deg` (executable)."""
    joint_margin_deg: Margin | None = None
    """Distance from the limits of hip_yaw and the steering joint, degrees."""
    reach: Flag | None = None
    """Keep the leg's extension within its limits (executable)."""
    level_at_end: Flag | None = None
    """End with θ̇ = 0 and pitch = roll = 0 (executable)."""
    without: tuple[str, ...] = ()
    """Names of terms to leave out of the problem."""
