"""The two profiles: a table of defaults each, nothing else.

`paper` is exactly the paper's problem. `executable` adds what the paper leaves open and a robot needs: it
must not tumble at the end, miss the goal, jump in speed, or ask for what the joints cannot do.
"""

from __future__ import annotations

from typing import Any, Literal

ProfileName = Literal["paper", "executable"]

PAPER: dict[str, dict[str, Any]] = {
    "weights": {"acc": 1.0, "goal": 10.0, "force": 5e-4, "feet": 20.0, "speed": 1.0, "yaw": 1.5},
    "bounds": {
        "steering_rate_max": 2.0,
        "speed_max": 1.0,
        "swing_speed_max": 3.0,  # generous: the paper bounds v in stance only
        "force_min": 0.0,
    },
}

EXECUTABLE: dict[str, dict[str, Any]] = {
    "weights": PAPER["weights"] | {"tilt": 100.0, "terminal_goal": 5000.0, "lift": 100.0, "swing": 0.1},
    "bounds": PAPER["bounds"]
    | {
        "swing_speed_max": 1.0,  # faster, a nearly stretched leg needs more than the knee's 8.8 rad/s
        "force_min": 40.0,  # a wheel pressed less slips at the first disturbance
        "touchdown_speed": 0.1,
        "acceleration_max": 2.0,
        "swing_acceleration_max": 4.0,  # a swing of 0.8 s needs no more; 12 jerks the whole body
        "joint_steering": True,
        "joint_margin_deg": 8.6,  # 0.15 rad
        "reach": True,
        "level_at_end": True,
    },
}

PROFILES: dict[str, dict[str, dict[str, Any]]] = {"paper": PAPER, "executable": EXECUTABLE}
