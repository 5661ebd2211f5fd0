"""From a scenario that drives to one that takes the steps its ground asks for, one foot at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rollgait.discover.candidate import goals_along
from rollgait.discover.crossings import Crossing, crossings, lengths
from rollgait.discover.timing import Pace, Timed, timed
from rollgait.footing.footing import Array
from rollgait.footing.on_terrain import regions_for, rise_max
from rollgait.footing.pace import poses_of
from rollgait.footing.route import BaseWay
from rollgait.robot.robot import turn_lever
from rollgait.scenario.gait import BaseGait
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
    poses = poses_of(scenario)
    way = BaseWay.through(poses, turn_lever(scenario.body.stance))
    found = crossings(way, scenario.body.stance, regions_for(scenario), rise_max(scenario.body))
    plan = timed(found, way.s, lengths(way), pace or Pace())
    values = gait_values(way, poses, found, plan, scenario.gait)
    return scenario.with_values({key: value for key, value in values.items() if key != "goal"})


def gait_values(
    way: BaseWay,
    poses: Array,
    found: Sequence[Crossing],
    plan: Timed,
    gait: BaseGait,
    lever: float = 0.0,
) -> dict[str, object]:
    """What a gait along a way sets of a scenario: `gait` where it steps, `horizon`, `goal`.

    Args:
        way: of the base.
        poses: that it leads through, the start first, (n + 1, 3), m and rad.
        found: the steps.
        plan: in time.
        gait: what else it is, e.g. its clearance.
        lever: what a turn of 1 rad counts as in the lengths of the plan, m.
    """
    length = lengths(way, lever)
    times = [plan.time_at(float(np.interp(k, way.s, length))) for k in range(1, len(poses) - 1)]
    values: dict[str, object] = {"horizon": plan.horizon, "goal": goals_along(poses[1:], times)}
    if found:
        shared = {name: getattr(gait, name) for name in BaseGait.model_fields}
        values["gait"] = plan.gait.model_copy(update=shared).model_dump(mode="json")
    return values
