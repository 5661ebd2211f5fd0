"""The ground about a motion as numbers: models where its feet are, references of its base."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from rollgait.dynamics.ground import MODEL_SIZE, FootGround
from rollgait.footing.footing import FEET, LEAVE_SIZE, Array, Footing, SwingOver
from rollgait.footing.phases import ACROSS, OVER_CLEARANCE, FeetPaths, Phase, Swinging, phases_of
from rollgait.scenario.schedule import ContactSchedule
from rollgait.terrain.convex_region import SIDES
from rollgait.terrain.local_models import models_along
from rollgait.terrain.references import base_references
from rollgait.terrain.regions import Regions

LEFT_MAX: Final = 0.4
"""Ground farther from where a foot lands is none that it has left but a ditch, in heights of the CoM: no
robot is asked for a higher step."""
SLOPED: Final = 1.0e-6
"""Steepest slope that is level: rounding."""


@dataclass(frozen=True, eq=False)
class Ways:
    """What was decided about the feet on some ground: where each stands, and what its swings go over.

    Attributes:
        regions: of the wheel of each leg.
        stance: nominal places of the feet, base-yaw frame, (4, 3), m.
        schedule: the contacts.
        phases: of each leg, interval by interval.
        swings: how high they go.
        nearer: how much nearer to an edge than it may be each foot begins, (4,), m.
    """

    regions: Sequence[Regions]
    stance: Array
    schedule: ContactSchedule
    phases: list[list[Phase]]
    swings: tuple[SwingOver, ...]
    nearer: Array

    @classmethod
    def along(
        cls,
        regions: Sequence[Regions],
        stance: Array,
        schedule: ContactSchedule,
        paths: FeetPaths,
        how: Swinging,
    ) -> Ways:
        """The ways of feet that go along paths; the arguments and errors are those of `phases_of`."""
        return cls(regions, stance, schedule, *phases_of(regions, schedule, paths, how))

    def on(self, schedule: ContactSchedule) -> Ways:
        """The same on another mesh of the same contacts."""
        origin = self.schedule.mesh.interval_at(schedule.mesh.middles)
        first = np.searchsorted(origin, np.arange(self.schedule.intervals))
        phases = []
        for own in self.phases:
            mapped = []
            for k, old in enumerate(origin):
                phase, stance = own[old], own[old].stance
                if stance == old:
                    stance = k
                elif stance >= 0:  # the nearest of the intervals into which that one was cut
                    stance = int(first[stance]) if stance > old else int(first[stance + 1]) - 1
                mapped.append(Phase(phase.region, stance, phase.top))
            phases.append(mapped)
        node = np.append(first, schedule.intervals)
        swings = tuple(
            replace(s, lift_off=int(node[s.lift_off]), touch_down=int(node[s.touch_down]))
            for s in self.swings
        )
        return replace(self, schedule=schedule, phases=phases, swings=swings)

    def footing(self, paths: FeetPaths, reach: float = 0.0) -> Footing:
        """The ground as numbers about a motion that goes these ways; `reach` as of `models_along`."""
        count = self.schedule.intervals
        model = np.zeros((FEET, count, MODEL_SIZE))
        slope, friction = np.zeros((FEET, count, 2)), np.zeros((FEET, count))
        A, b = np.zeros((FEET, count, SIDES, 2)), np.ones((FEET, count, SIDES))
        floor = np.zeros((FEET, count, 2))
        curved = False
        swings = tuple(self._looked_up(swing, paths) for swing in self.swings)
        tops = self._tops(swings)
        for leg, (region, own) in enumerate(zip(self.regions, self.phases, strict=True)):
            stands = self.schedule.contact[leg]
            refs = 0.5 * (paths.xy[:-1, leg] + paths.xy[1:, leg])
            begin, end = paths.xy[:-1, leg][stands], paths.xy[1:, leg][stands]
            models = models_along(region, begin, end, paths.heading[:-1, leg][stands], reach)
            numbers = np.array([m.numbers() for m in models]).reshape(-1, MODEL_SIZE)
            curved |= any(m.curved for m in models)
            model[leg, stands] = numbers
            slope[leg, stands] = numbers[:, 3:5]
            friction[leg] = region.terrain.friction_at(*refs.T)
            for k, phase in enumerate(own):
                if not stands[k]:
                    model[leg, k] = _ground_in_air(phase, tops[leg, k], model[leg], refs[k], region)
                if phase.region is not None:
                    A[leg, k], b[leg, k] = phase.region.padded(SIDES)
            self._raise_floor(leg, swings, model[leg], paths.xy[:, leg], floor[leg])
        return Footing(
            model=model,
            leave=_leaves(model, self.schedule),
            contact_slope=slope,
            friction=friction,
            A=A,
            b=b,
            floor=floor,
            swings=swings,
            base=self._base(model, paths),
            radius=np.array([region.surface.radius for region in self.regions]),
            is_curved=curved,
            is_sloped=bool(np.abs(slope).max() > SLOPED),
        )

    def _base(self, model: Array, paths: FeetPaths) -> Array:
        """Ground, pitch and roll of the base at the nodes, (N + 1, 3): feet in the air count on their way."""
        times, count, contact = self.schedule.node_times, self.schedule.intervals, self.schedule.contact
        under = np.empty((count + 1, FEET))
        for leg in range(FEET):
            for node in range(count + 1):
                k = min(node, count - 1)
                if node and not contact[leg, k]:
                    k = node - 1
                under[node, leg] = _height(model[leg, k], paths.xy[node, leg])
        for s in self.swings:
            nodes = np.arange(s.lift_off, s.touch_down + 1)
            begun = self.schedule.begun[s.leg] if s.lift_off == 0 else 0.0
            lift_off = times[nodes[0]] - begun
            passed = (times[nodes] - lift_off) / (times[nodes[-1]] - lift_off)
            before, after = under[nodes[[0, -1]], s.leg]
            if begun > 0.0:  # what it has left nobody knows any more: what is below it counts
                below = float(self.regions[s.leg].terrain.height(*paths.xy[0, s.leg]))
                before = below if abs(below - after) <= -LEFT_MAX * self.stance[s.leg, 2] else after
            under[nodes, s.leg] = before + passed * (after - before)
        return base_references(under, self.stance)

    def _looked_up(self, swing: SwingOver, paths: FeetPaths) -> SwingOver:
        """A swing over something, as high as what is now on its way: not where its footholds were once."""
        if not swing.over or (swing.lift_off == 0 and self.schedule.begun[swing.leg] > 0.0):
            return swing
        nodes = np.arange(swing.lift_off, swing.touch_down + 1)
        places = np.linspace(nodes[0], nodes[-1], max(ACROSS, len(nodes)))
        way = [np.interp(places, nodes, paths.xy[nodes, swing.leg, axis]) for axis in (0, 1)]
        heights = self.regions[swing.leg].surface.height(*way)
        if np.isnan(heights[[0, -1]]).any():
            return swing
        before, top, after = heights[0], np.nanmax(heights), heights[-1]
        return replace(swing, before=float(before), top=float(top), after=float(after))

    def _tops(self, swings: Sequence[SwingOver]) -> Array:
        """Height of the level plane above which a foot goes over something, (4, N), m; NaN where none is."""
        tops = np.full((FEET, self.schedule.intervals), np.nan)
        for swing in swings:
            for k in range(swing.lift_off, swing.touch_down):
                if not np.isnan(self.phases[swing.leg][k].top):
                    tops[swing.leg, k] = swing.top
        return tops

    def _raise_floor(
        self, leg: int, swings: Sequence[SwingOver], model: Array, xy: Array, floor: Array
    ) -> None:
        """The least heights (N, 2) of a foot, where it goes over something."""
        for swing in swings:
            if swing.leg != leg or not swing.over:
                continue
            inside = range(swing.lift_off, swing.touch_down)
            above = [k for k in inside if not np.isnan(self.phases[leg][k].top)]
            floor[above] = OVER_CLEARANCE
            after = above[-1] + 1
            if above[0] == swing.lift_off:  # the foot is still on the ground at its first node
                floor[above[0], 0] = model[above[0] - 1, 2] - swing.top if above[0] else 0.0
            if after < swing.touch_down:  # the node between belongs to both
                floor[after, 0] = swing.top + OVER_CLEARANCE - _height(model[after], xy[after])


def _ground_in_air(phase: Phase, top: float, model: Array, ref: Array, region: Regions) -> Array:
    if not np.isnan(top):
        return np.array([*ref, top, 0.0, 0.0, 0.0, 0.0, 0.0])
    if phase.stance >= 0:
        return np.asarray(model[phase.stance])
    return np.array([*ref, float(region.surface.height(*ref)), 0.0, 0.0, 0.0, 0.0, 0.0])


def _height(model: Array, xy: Array) -> float:
    return float(FootGround(model, np.zeros(2), 0.0).height(xy))


def _leaves(model: Array, schedule: ContactSchedule) -> Array:
    """By how much the ground of each interval lies above that of the next, about the first one's place."""
    leave = np.zeros((*model.shape[:2], LEAVE_SIZE))
    here, there = model[:, :-1], model[:, 1:]
    shift = here[..., :2] - there[..., :2]
    xx, mixed, yy = np.moveaxis(there[..., 5:], -1, 0)
    x, y = np.moveaxis(shift, -1, 0)
    bent = np.stack([xx * x + mixed * y, mixed * x + yy * y], axis=-1)
    height = there[..., 2] + ((there[..., 3:5] + 0.5 * bent) * shift).sum(axis=-1)
    leave[:, :-1, 0] = here[..., 2] - height
    leave[:, :-1, 1:3] = here[..., 3:5] - there[..., 3:5] - bent
    leave[:, :-1, 3:] = here[..., 5:] - there[..., 5:]
    stays = schedule.contact[:, :-1] & schedule.contact[:, 1:]
    same = (here == there).all(axis=-1)
    leave[:, :-1][stays | same] = 0.0
    return leave
