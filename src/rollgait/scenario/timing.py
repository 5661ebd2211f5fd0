"""Which times of a gait may change, and within which limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import AfterValidator, Field

from rollgait.config import Config, Flag, NonNegative, Number, Positive

SHORTEST: Final = 0.05
"""s; a foot cannot be lifted and set down in less."""


def _rising(value: tuple[float, float]) -> tuple[float, float]:
    if value[0] > value[1]:
        raise ValueError(f"must name the shortest and the longest swing, not [{value[0]}, {value[1]}]")
    return value


Span = Annotated[
    tuple[Annotated[Number, Field(ge=SHORTEST)], Annotated[Number, Field(ge=SHORTEST)]],
    AfterValidator(_rising),
]


class Timing(Config):
    """Lift-offs and touch-downs when it is best, in the order in which the gait has them."""

    optimize: Flag = True
    """Whether the times may change."""
    swing: Span = (0.4, 1.5)
    """Shortest and longest swing, s."""
    stance_min: Positive = 0.1
    """Shortest time between two changes of contacts or goals that are not both ends of one swing, s."""
    effort: NonNegative = 1.0
    """Weight of the effort of swings (`weights.effort`), if the scenario gives none: short ones cost more."""
    price: NonNegative | None = None
    """What a second costs: the horizon is the longest one then. `horizon: {max, price}` sets it."""


def with_price_in_gait(data: Mapping[str, Any]) -> dict[str, Any]:
    """The data of a scenario with its horizon as a number; a price of it becomes one of the gait's timing."""
    result, horizon = dict(data), data.get("horizon")
    if not isinstance(horizon, Mapping):
        return result
    if unknown := set(horizon) - {"max", "price"}:
        raise ValueError(f"horizon has no {min(map(str, unknown))}; valid: max, price")
    if missing := {"max", "price"} - set(horizon):
        raise ValueError(f"horizon needs its {min(missing)}, or is a number of seconds")
    gait = result.get("gait", "drive")
    gait = {"kind": gait} if isinstance(gait, str) else gait
    if not isinstance(gait, Mapping):
        gait = gait.model_dump(mode="json")
    timing = gait.get("timing") or {}
    timing = timing if isinstance(timing, Mapping) else timing.model_dump(mode="json")
    result["gait"] = dict(gait) | {"timing": dict(timing) | {"price": horizon["price"]}}
    result["horizon"] = horizon["max"]
    return result
