"""Weights of the costs and bounds of the constraints, by the name of their term.

A value that is not given takes the default of the scenario's profile (`profile.py`), and where that has none
either, the term is not part of the problem.
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from rollgait.config import Config, Flag, NonNegative, Number, Positive, PositiveVector3, Range

UNSET: Any = object()
"""Stands for: as in the other profile."""


def by_profile(paper: Any = None, executable: Any = UNSET) -> Any:
    """A field whose default is the profile's; given once, both have it. None: not part of that profile."""
    defaults = {"paper": paper, "executable": paper if executable is UNSET else executable}
    return Field(default=None, json_schema_extra={"profiles": defaults})


Margin = Annotated[Number, Field(ge=0.0, le=45.0)]
SupportMargin = Annotated[Number, Field(ge=-1.0, le=1.0)]
Share = Annotated[Number, Field(gt=0.0, le=1.0)]


class Weights(Config):
    """Weights of the costs: the paper's six, then those of the profile `executable`. 0 switches off."""

    acc: NonNegative | None = by_profile(1.0)
    """On ‖r̈‖², acceleration of the CoM."""
    goal: NonNegative | None = by_profile(10.0)
    """On ‖r − r_goal‖² + ‖θ − θ_goal‖²."""
    force: NonNegative | None = by_profile(0.0005)
    """On h_ref² ‖Δf / h‖² of neighbouring intervals, forces in N, h_ref = 0.1 s. Of robots lighter than 900 N
    the default is (900 N / weight)² times that (executable)."""
    feet: NonNegative | None = by_profile(20.0)
    """On Σ‖Rzᵀ(p_i − r) − p̄_i‖²."""
    speed: NonNegative | None = by_profile(1.0)
    """On Σ v_i²."""
    yaw: NonNegative | None = by_profile(1.5)
    """On Σ σ̇_i²."""
    tilt: NonNegative | None = by_profile(executable=100.0)
    """On pitch² + roll² (executable)."""
    terminal_goal: NonNegative | None = by_profile(executable=5000.0)
    """On (x, y, yaw) − goal at the end (executable)."""
    lift: NonNegative | None = by_profile(executable=100.0)
    """On (ṗz − that of a smooth lift)² of feet in swing (executable)."""
    swing: NonNegative | None = by_profile(executable=0.1)
    """On the planar velocity of feet in swing that the other costs leave undetermined (executable)."""
    effort: NonNegative | None = by_profile()
    """On (p̈_z / 3 m/s²)² of feet in swing: short swings cost more. `gait.timing` sets it."""
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
    steering_rate_max: Positive | None = by_profile(2.0)
    """Limit of |σ̇|, rad/s; the robot's own limit holds as well."""
    speed_max: Positive | None = by_profile(1.0)
    """Limit of |v| in stance, m/s; the robot's own limit holds as well."""
    swing_speed_max: Positive | None = by_profile(
        3.0, 1.0
    )  # generous in the paper; faster than 1, the knee's 8.8 rad/s is not enough
    """Limit of |v| in swing, m/s."""
    force_min: NonNegative | None = by_profile(
        0.0, 40.0
    )  # a wheel pressed less slips at the first disturbance
    """Smallest normal force in stance, N."""
    force_max: Positive | None = None
    """Largest normal force in stance, N; the robot's own limit holds as well."""
    friction_share: Share | None = by_profile(1.0)
    """Part of the ground's μ that forces may use; the rest is a reserve."""
    inscribed: Flag = False
    """Use the pyramid inside the friction cone: μ/√2."""
    touchdown_speed: Positive | None = by_profile(executable=0.1)
    """Limit of the vertical speed at touch-down, m/s (executable)."""
    touchdown_drift: Positive | None = by_profile()
    """Limit of the horizontal speed of point feet in the last interval of a swing, m/s, each component."""
    acceleration_max: Positive | None = by_profile(executable=2.0)
    """Limit of |Δv|/h of feet that stay on the ground, m/s² (executable)."""
    swing_acceleration_max: Positive | None = by_profile(
        executable=4.0
    )  # a swing of 0.8 s needs no more; 12 jerks the whole body
    """Limit of |Δv|/h of feet in swing or just landed, m/s² (executable)."""
    joint_steering: Flag | None = by_profile(executable=True)
    """Keep hip_yaw and the steering joint within their limits, in place of `steering_deg` (executable)."""
    joint_margin_deg: Margin | None = by_profile(executable=8.6)  # 0.15 rad
    """Distance from the limits of hip_yaw and the steering joint, degrees."""
    reach: Flag | None = by_profile(executable=True)
    """Keep the leg's extension within its limits (executable)."""
    reach_margin: NonNegative | None = by_profile(0.0)
    """Distance from these limits, m."""
    level_at_end: Flag | None = by_profile(executable=True)
    """End with θ̇ = 0 and pitch = roll = 0 (executable)."""
    com_margin: SupportMargin | None = by_profile(executable=0.01)
    """How far inside the feet that stand the CoM stays while one of four swings, m (executable)."""
    capture_margin: SupportMargin | None = by_profile(executable=-0.03)
    """The same for the capture point: where the CoM would come to rest over these feet, m (executable)."""
    body_clearance: NonNegative | None = by_profile(executable=0.03)
    """How far the trunk stays from ground that is not flat, m, hips and thighs by 1 cm at most; of robots
    whose `underside` is known (executable)."""
    without: tuple[str, ...] = ()
    """Names of terms to leave out of the problem."""
