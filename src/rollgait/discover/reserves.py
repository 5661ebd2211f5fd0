"""The margins with which a gait is discovered, as bounds of the problem."""

from __future__ import annotations

from typing import Any

from rollgait.scenario.gait import BaseGait, Discover, Drive
from rollgait.scenario.scenario import Scenario


def driving(scenario: Scenario, gait: Discover) -> Scenario:
    """The scenario with the reserves of its gait, all feet on the ground; its horizon is the longest allowed.

    What the scenario itself says of a bound counts.
    """
    reserves = gait.reserves
    asked = {
        "friction_share": reserves.friction_share,
        "reach_margin": reserves.reach,
        "com_margin": reserves.com_margin,
        "capture_margin": reserves.capture_margin,
    }
    values: dict[str, Any] = {
        f"bounds.{name}": value for name, value in asked.items() if getattr(scenario.bounds, name) is None
    }
    shared = {name: getattr(gait, name) for name in BaseGait.model_fields}
    if scenario.ground.kind != "flat" and gait.clearance is None:
        # every step leads over something; one that the solver leads beside it need be no higher
        shared["clearance"] = scenario.clearance_over
    with_reserves = scenario.with_values({**values, "horizon": scenario.horizon})
    # not checked: on point feet it gets nowhere without its steps
    return with_reserves.model_copy(update={"gait": Drive(**shared)})
