"""The two profiles: a table of defaults each, which the fields of weights and bounds state.

`paper` is exactly the paper's problem. `executable` adds what the paper leaves open and a robot needs: it
must not tumble at the end, miss the goal, jump in speed, or ask for what the joints cannot do.
"""

from __future__ import annotations

from typing import Any, Literal

from rollgait.config import Config
from rollgait.scenario.weights import Bounds, Weights

CLEARANCE = 0.08
"""z_fly, m, of a robot of CENTAURO's size."""
CLEARANCE_OF_HEIGHT = 0.135
"""The most that it is, as a part of the CoM's height: what CENTAURO's 0.08 m are of its 0.6 m."""
CLEARANCE_OVER = 0.05
"""The most that it is above something that a foot goes over, m: legs end, and what is gone over is known."""
FORCE_OF_WEIGHT = 0.045
"""The most that the smallest normal force is, as a part of the weight: 40 N of the lighter CENTAURO's."""
WEIGHT_LIGHT = 900.0
"""N. Below it the default weight on changes of forces is larger, as these are less: otherwise hardly anything
would keep a small robot from turning and tilting by jerks."""

ProfileName = Literal["paper", "executable"]


def _table(profile: str) -> dict[str, dict[str, Any]]:
    """Defaults of a profile by group and key, as the fields state them."""
    groups: dict[str, type[Config]] = {"weights": Weights, "bounds": Bounds}
    table: dict[str, dict[str, Any]] = {}
    for group, model in groups.items():
        table[group] = {}
        for name, field in model.model_fields.items():
            extra = field.json_schema_extra
            stated = extra.get("profiles") if isinstance(extra, dict) else None
            if isinstance(stated, dict) and stated[profile] is not None:
                table[group][name] = stated[profile]
    return table


PROFILES: dict[str, dict[str, dict[str, Any]]] = {name: _table(name) for name in ("paper", "executable")}
