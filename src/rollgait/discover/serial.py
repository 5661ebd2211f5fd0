"""From a scenario that drives to one that takes the steps its ground asks for, one foot at a time."""

from __future__ import annotations

from rollgait.discover.crossings import crossings, lengths
from rollgait.discover.timing import Pace, timed
from rollgait.footing.on_terrain import poses_of, regions_for, rise_max
from rollgait.footing.pace import turn_lever
from rollgait.footing.route import BaseWay
from rollgait.scenario.scenario import Scenario


def stepping_gait(scenario: Scenario, pace: Pace | None = None) -> Scenario:
    """The same scenario with the gait that takes the necessary steps in their order, and the time it needs.

    For robots on wheels: between the steps they roll. Where no step is needed the gait stays what it is.

    Args:
        scenario: with its ground, a start and goals; its horizon need only be long enough to be valid.
        pace: how fast steps follow one another; the usual one if not given.

    Raises:
        InputError: the gait or the horizon does not suit the scenario, e.g. its later goals.
    """
    stance = scenario.body.stance
    way = BaseWay.through(poses_of(scenario), turn_lever(stance))
    found = crossings(way, stance, regions_for(scenario), rise_max(scenario.body))
    gait, horizon = timed(found, way.s, lengths(way), pace or Pace())
    values: dict[str, object] = {"horizon": horizon}
    if found:
        values["gait"] = gait.model_dump(mode="json")
    return scenario.with_values(values)
