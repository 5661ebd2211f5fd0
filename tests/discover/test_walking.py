"""Laws of gaits that are found over ground that is not flat for feet that cannot roll everywhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.discover.reserves import driving
from rollgait.errors import NotSolvedError
from rollgait.footing.on_terrain import find_ways, regions_for
from rollgait.robot.robot import LEG_NAMES
from tests.discover.worlds import candidates

KERB = {"kind": "step", "x": 0.6, "height": 0.06}
GAP = {"kind": "gap", "x": 0.6, "length": 0.08}
OBLIQUE = {"kind": "step", "x": 0.7, "height": 0.05, "yaw_deg": 20.0}
MIRRORED = {"FL": "FR", "FR": "FL", "HL": "HR", "HR": "HL"}


def asked(*parts: dict[str, Any], robot: str = "strider", **goal: float) -> rg.Scenario:
    gait = {"kind": "discover", "search": {"seconds": 600.0}}
    where = {"x": 1.3, **goal}
    return rg.Scenario.from_dict({"robot": robot, "goal": where, "gait": gait, "ground": {"parts": [*parts]}})


def found(scenario: rg.Scenario) -> rg.Scenario:
    return candidates(scenario, 1)[0].of(driving(scenario, scenario.gait))


@pytest.mark.parametrize("part", [KERB, GAP, OBLIQUE], ids=["kerb", "gap", "oblique"])
@pytest.mark.parametrize("yaw", [0.0, 30.0])
def test_feet_stand_where_they_can_and_in_their_boxes_from_start_to_goal(
    part: dict[str, Any], yaw: float
) -> None:
    scenario = found(asked(part, yaw_deg=yaw))
    schedule, body = scenario.schedule, scenario.body
    ways = find_ways(scenario, schedule)
    route = ways.route
    np.testing.assert_allclose(route.base[-1], [1.3, 0.0, np.radians(yaw)], atol=1e-6)
    c, s = np.cos(route.base[:, 2]), np.sin(route.base[:, 2])
    boxes = body.foot_boxes(scenario.bounds.box)[..., :2]
    for leg, regions in enumerate(regions_for(scenario)):
        stands = schedule.contact[leg]
        for feet in (route.feet[:-1, leg][stands], route.feet[1:, leg][stands]):
            assert regions.free(feet).all()
        still = np.diff(route.feet[:, leg], axis=0)[stands]
        np.testing.assert_allclose(still, 0.0, atol=1e-4)  # a point foot that stands does not move
        x, y = (route.feet[:, leg] - route.base[:, :2]).T
        seen = np.stack([c * x + s * y, c * y - s * x], axis=-1) - body.stance[leg, :2]
        room = 0.03  # what a body that does not jerk strays from where its feet would have it
        inside = (seen >= boxes[leg, 0] - room) & (seen <= boxes[leg, 1] + room)
        assert inside.all(axis=1).mean() > 0.95  # it is a guess: the solver keeps the boxes


@pytest.mark.parametrize("part", [KERB, OBLIQUE], ids=["kerb", "oblique"])
def test_the_mirrored_world_has_the_mirrored_steps(part: dict[str, Any]) -> None:
    turned = {**part, "yaw_deg": -part.get("yaw_deg", 0.0)}
    here, there = found(asked(part, y=0.2, yaw_deg=20.0)), found(asked(turned, y=-0.2, yaw_deg=-20.0))
    own, other = (s.gait.swings(s.horizon) for s in (here, there))
    for name in LEG_NAMES:
        np.testing.assert_allclose(np.array(own[name]), np.array(other[MIRRORED[name]]), atol=1e-6)


def test_where_nothing_is_in_the_way_steps_are_those_of_flat_ground() -> None:
    far = {"kind": "step", "x": 9.0, "height": 0.01}
    here, flat = (
        found(asked(far)),
        found(rg.Scenario.from_dict({"robot": "strider", "goal": {"x": 1.3}, "gait": "discover"})),
    )
    assert abs(sum(1 for _ in here.schedule.swings()) - sum(1 for _ in flat.schedule.swings())) <= 2


def test_a_gap_that_is_too_wide_is_refused_and_walked_over_when_it_is_as_much_narrower() -> None:
    wide = {**GAP, "length": 0.25}
    with pytest.raises(
        NotSolvedError, match=r"no landing between x = 0\.5\d and 0\.8\d m for F.: that is"
    ) as no:
        candidates(asked(wide))
    more = float(str(no.value).split("that is ")[1].split(" m")[0])
    assert 0.02 < more < 0.2
    assert candidates(asked({**GAP, "length": 0.25 - more}), 1)


def test_wheels_that_are_locked_walk_too() -> None:
    scenario = asked({"kind": "step", "x": 0.9, "height": 0.15}, robot="centauro", x=1.6)
    locked = found(scenario.with_values({"gait.wheels": "locked"}))
    assert all(len(own) >= 2 for own in locked.gait.swings(locked.horizon).values())
    assert locked.gait.wheels == "locked"


def test_fixed_wheels_step_over_the_edge_and_where_they_would_have_to_go_sideways() -> None:
    scenario = asked({"kind": "step", "x": 0.6, "height": 0.08}, robot="rover", x=1.6)
    straight = [c.of(driving(scenario, scenario.gait)) for c in candidates(scenario)]
    assert min(sum(1 for _ in s.schedule.swings()) for s in straight) == 4
    turning = asked({"kind": "step", "x": 0.6, "height": 0.08}, robot="rover", x=1.6, yaw_deg=80.0)
    names = {c.name: c.of(driving(turning, turning.gait)) for c in candidates(turning)}
    walked = [s for name, s in names.items() if name.startswith("steps on")]
    assert walked
    assert all(sum(1 for _ in s.schedule.swings()) > 4 for s in walked)


def test_a_kerb_is_walked_up_on_point_feet_with_reserves() -> None:
    plan = rg.plan(asked({**KERB, "x": 0.4}, x=0.75))
    assert plan.certificate().passed
    assert plan.scenario.bounds.friction_share == 0.8
    end = plan.sample(np.array([plan.horizon]))
    np.testing.assert_allclose(end.foot_position[0, :, 2], 0.06, atol=1e-3)
    np.testing.assert_allclose(end.com_position[0, :2], [0.75, 0.0], atol=0.01)
