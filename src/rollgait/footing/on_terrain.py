"""From a scenario on ground that is not flat to the ways of its feet. Loads SciPy; flat ground needs none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from rollgait.dynamics.step import rotation
from rollgait.errors import NotSolvedError
from rollgait.footing.around import Ways
from rollgait.footing.bends import bends
from rollgait.footing.beneath import BodyPath
from rollgait.footing.carried import REACH, WIDER_REACH, ArcsOf, direct_way
from rollgait.footing.footing import FEET, Array, Footing, Index
from rollgait.footing.pace import driven, poses_of
from rollgait.footing.phases import FeetPaths, Swinging
from rollgait.footing.route import Route, find_route, track_arcs
from rollgait.footing.stepping import route_along
from rollgait.ocp.lift import minimum_jerk
from rollgait.plan.samples import Samples
from rollgait.robot.robot import LEG_NAMES, Robot
from rollgait.scenario.scenario import Scenario
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain.references import base_references
from rollgait.terrain.regions import Regions, regions_about

GRID: Final = 4
"""Times per interval at which a route is found: nodes are among them."""
AROUND: Final = 1.5
"""How far around the way of the base a map is looked at, m: what a robot of this size reaches, and its
windows."""
RISE_SHARE: Final = 0.4
"""Highest step that is tried, in heights of the CoM: CENTAURO's 0.30 m, where its legs end."""
SETTLING: Final = 8
"""How often base and feet are fitted to one another where the robot stands: each time the error falls to a
tenth or so."""
UNSURE: Final = 0.3
"""By so much feet may be elsewhere than expected before anything is solved, m: over so much bends are rounded
at first. A sharp one says nothing right about places so far beside it."""


@dataclass(frozen=True, eq=False)
class OnTerrain:
    """The ways of a scenario over its ground.

    Attributes:
        ways: of its feet.
        route: of base and feet, from which they were found.
        footing: the ground as numbers about that route.
    """

    ways: Ways
    route: Route
    footing: Footing

    def on(self, schedule: ContactSchedule) -> OnTerrain:
        """The same on another mesh of the same contacts."""
        return replace(self, ways=self.ways.on(schedule))

    def cut(self, schedule: ContactSchedule, motion: Callable[[Array], Samples]) -> ContactSchedule:
        """A schedule on a mesh with nodes where the feet of a motion meet bends of the ground."""
        return schedule.cut_at(bends(self.ways.regions, schedule, motion))

    def around(self, motion: Samples) -> Footing:
        """The ground as numbers about a motion, sampled at the nodes."""
        return self.ways.footing(FeetPaths(motion.foot_position[..., :2], motion.heading, motion.euler[:, 0]))

    def expected(self, robot: Robot) -> BodyPath:
        """Where the robot is at the nodes if it goes along the route, standing as the ground asks for."""
        nodes = np.searchsorted(self.route.times, self.ways.schedule.node_times - 1e-12)
        base, feet = self.route.base[nodes], self.route.feet[nodes]
        intervals = np.minimum(np.arange(len(nodes)), self.footing.count - 1)
        ground, pitch, roll = self.footing.base.T
        com = np.column_stack([base[:, :2], ground + robot.height])
        places = np.concatenate([feet, self.footing.height(intervals, feet)[..., None]], axis=-1)
        return BodyPath(com, np.column_stack([base[:, 2], pitch, roll]), places)


def find_ways(
    scenario: Scenario, schedule: ContactSchedule, motion: Callable[[Array], Samples] | None = None
) -> OnTerrain:
    """The ways of a scenario's feet over its ground, those of a motion if there is one.

    Raises `NotSolvedError` where there are none.
    """
    robot, regions = scenario.body, regions_for(scenario)
    if motion is not None:
        route = _route_of(motion(schedule.node_times))
    else:
        route = _carried_route(scenario, schedule, regions) or _tracked_route(scenario, schedule, regions)
    nodes = np.searchsorted(route.times, schedule.node_times - 1e-12)
    yaw = route.base[nodes, 2]
    feet = route.feet[nodes]
    moving = scenario.start.motion
    # where they are given, a little beside the nominal places
    feet[0] = standing_start(scenario)[1][:, :2] if moving is None else moving.feet[:, :2]
    paths = FeetPaths(feet, np.repeat(yaw[:, None], FEET, axis=1), yaw)
    speed = float(scenario.value_of("bounds", "swing_speed_max"))
    how = Swinging(speed, scenario.clearance_over, None if moving is None else moving.feet[:, 2])
    ways = Ways.along(regions, robot.stance, schedule, paths, how)
    footing = ways.footing(paths)
    if footing.may_differ and motion is None:
        footing = ways.footing(paths, UNSURE)
    return OnTerrain(ways, route, footing)


def _route_of(motion: Samples) -> Route:
    """The route of a motion, sampled at the nodes."""
    base = np.column_stack([motion.com_position[:, :2], motion.euler[:, 0]])
    return Route(motion.time, base, motion.foot_position[..., :2].copy())


def _tracked_route(scenario: Scenario, schedule: ContactSchedule, regions: Sequence[Regions]) -> Route:
    """Feet on their tracks, the base where these want it: for wheels, and where steps are too few to say."""
    robot, poses = scenario.body, poses_of(scenario)
    times = np.unique(np.concatenate([_between(schedule.node_times, GRID), schedule.node_times]))
    rolls = [leg.foot != "point" for leg in robot.leg_list]
    progress = _progress(scenario, schedule, poses, times)
    return find_route(times, progress, poses, robot.stance, regions, schedule, rolls, rise_max(robot))


def _carried_route(scenario: Scenario, schedule: ContactSchedule, regions: Sequence[Regions]) -> Route | None:
    """Feet that stand, or roll ahead only, and step in time; None where none is, or they do not get there."""
    if all(leg.foot == "steerable" for leg in scenario.body.leg_list):
        return None
    for reach in (REACH, WIDER_REACH):
        way = direct_way(scenario, arcs_on(regions, rise_max(scenario.body)), reach)
        found = route_along(way, schedule)
        if found is not None and _stands(found[1], schedule, regions):
            return Route(schedule.node_times, *found)
    return None


def _stands(feet: Array, schedule: ContactSchedule, regions: Sequence[Regions]) -> bool:
    """Whether feet (N + 1, 4, 2) stand where they can; a wheel beside its track may not."""
    contact = schedule.contact
    return all(
        region.free(feet[:-1, leg][contact[leg]]).all() and region.free(feet[1:, leg][contact[leg]]).all()
        for leg, region in enumerate(regions)
    )


def arcs_on(regions: Sequence[Regions], rise: float) -> ArcsOf:
    """Finds where tracks of feet can be stood on.

    Args:
        regions: of the foot of each leg.
        rise: the highest step, m.
    """

    def arcs_of(tracks: Array) -> Sequence[Index]:
        number = np.arange(len(tracks), dtype=float)
        found = [track_arcs(regions[leg], tracks[:, leg], number, rise) for leg in range(FEET)]
        for leg, arcs in enumerate(found):
            if not len(arcs):
                place = np.round(tracks[0, leg], 2).tolist()
                raise NotSolvedError(
                    f"no motion found: {LEG_NAMES[leg]} cannot stand at its first place {place} m"
                )
        return [arcs.astype(np.intp) for arcs in found]

    return arcs_of


def rise_max(robot: Robot) -> float:
    """The highest step that a robot is asked to take, m."""
    return RISE_SHARE * robot.height


def regions_for(scenario: Scenario) -> list[Regions]:
    """The regions of each leg's foot on the ground of a scenario."""
    poses = poses_of(scenario)
    legs = scenario.body.leg_list
    radii, rolls = [leg.foot_radius for leg in legs], [leg.foot != "point" for leg in legs]
    return regions_about(scenario.terrain, radii, poses[:, :2], AROUND, rolls)


def standing_start(scenario: Scenario) -> tuple[Array, Array]:
    """How the robot stands at the start: see `standing`."""
    place = np.array([scenario.start.x, scenario.start.y])
    yaw = float(np.radians(scenario.start.yaw_deg))
    return standing(scenario.body, regions_for(scenario), place, yaw)


def standing(robot: Robot, regions: list[Regions], place: Array, yaw: float) -> tuple[Array, Array]:
    """How the robot stands at a place: the base (x, y, z, yaw, pitch, roll), and its feet (4, 3), m and rad.

    The base is as high over the mean ground under its feet, and tilted, as the ground asks for; the feet are
    at their nominal places in the base frame, as far below it as the ground is.
    """
    base = np.array([*place, 0.0, yaw, 0.0, 0.0])
    feet, in_base = np.zeros((FEET, 3)), robot.stance.copy()
    for _ in range(SETTLING):
        feet[:, :2] = base[:2] + (in_base @ np.array(rotation(np, list(base[3:]))).T)[:, :2]
        feet[:, 2] = [region.surface.height(*foot[:2]) for region, foot in zip(regions, feet, strict=True)]
        ground, *base[4:] = base_references(feet[:, 2], robot.stance)
        base[2] = ground + robot.height
        in_base[:, 2] = ((feet - base[:3]) @ np.array(rotation(np, list(base[3:]))))[:, 2]
    return base, feet


def _progress(scenario: Scenario, schedule: ContactSchedule, poses: Array, times: Array) -> Array:
    """How far the base has come at times if nothing were in its way: k at goal number k."""
    switches = [later.at for later in scenario.goal.then if later.at < scenario.horizon]
    borders = [0.0, *switches, schedule.horizon]
    result = np.zeros_like(times)
    steps = not schedule.contact.all()
    for k, (begin, end) in enumerate(pairwise(borders)):
        change = poses[k + 1] - poses[k]
        duration = end - begin
        if steps:  # who steps takes the time that the gait gives; wheels hurry as the cost asks
            result += minimum_jerk((times - begin) / duration)[0]
        else:
            result += driven(scenario, change, duration, times - begin)
    return result


def _between(nodes: Array, parts: int) -> Array:
    """The nodes, and the places that cut each interval into parts."""
    share = np.arange(parts) / parts
    inside = nodes[:-1, None] + np.diff(nodes)[:, None] * share
    return np.append(inside.ravel(), nodes[-1])
