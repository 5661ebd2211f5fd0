"""How a gait was found: the gaits that were tried in vain, and the regions that footholds were given."""

from __future__ import annotations

from typing import Final

import numpy as np

from rollgait.errors import RollgaitError
from rollgait.footing.footing import FEET
from rollgait.plan.plan import CandidateResult
from rollgait.plan.samples import Array
from rollgait.view.clip import Clip
from rollgait.view.layers.layer import Layer, single
from rollgait.view.on_ground import laid_segments
from rollgait.view.style import LEG_COLOURS, SECOND_COLOUR

LIFTED: Final = 0.008
"""Height over the ground, m: above the ground's own lines."""
CROSS: Final = 0.04
"""Half the size of the mark of a foothold, m."""


class GaitsInVain(Layer):
    """Ways of the base and footholds of gaits that were tried before the one that is shown, as ghosts."""

    title = "gaits tried in vain"

    @classmethod
    def suits(cls, clip: Clip) -> bool:
        return bool(in_vain(clip))

    def draw(self) -> None:
        terrain, colour = self.clip.terrain, self.look.of(SECOND_COLOUR)
        for number, tried in enumerate(in_vain(self.clip)):
            marks = [cross(np.array(place)) for place in tried.footholds]
            lines = [np.array(tried.way), *(line for mark in marks for line in mark)]
            laid = np.concatenate([laid_segments(terrain, line, LIFTED) for line in lines if len(line) > 1])
            if len(laid):
                self.scene.add_line_segments(self.at(str(number)), single(laid), colour, thickness=0.006)


class FootholdRegions(Layer):
    """The convex regions that the feet were given to stand in, on ground that is not flat."""

    title = "foothold regions"
    shown = False

    @classmethod
    def suits(cls, clip: Clip) -> bool:
        return clip.plan is not None and not clip.plan.scenario.terrain.is_flat

    def draw(self) -> None:
        terrain = self.clip.terrain
        for leg, polygons in enumerate(foothold_regions(self.clip)):
            laid = [laid_segments(terrain, polygon, LIFTED) for polygon in polygons]
            if laid:
                self.scene.add_line_segments(
                    self.at(f"leg{leg}"),
                    single(np.concatenate(laid)),
                    self.look.of(LEG_COLOURS[leg]),
                    thickness=0.006,
                )


def in_vain(clip: Clip) -> tuple[CandidateResult, ...]:
    """What was tried before the gait of a clip was found; all of it, if none was."""
    if clip.plan is None:
        return ()
    tried = clip.plan.statistics.discovery
    return tuple(each for each in tried if each.outcome != "certified")


def cross(place: Array) -> tuple[Array, Array]:
    """Two lines through a place (2,), m."""
    return (
        place + CROSS * np.array([[-1.0, -1.0], [1.0, 1.0]]),
        place + CROSS * np.array([[-1.0, 1.0], [1.0, -1.0]]),
    )


def foothold_regions(clip: Clip) -> list[list[Array]]:
    """The closed outlines (n, 2), m, of the regions of each leg, each once; none where they are not known."""
    from rollgait.footing.on_terrain import find_ways  # loads SciPy

    found: list[list[Array]] = [[] for _ in range(FEET)]
    if clip.plan is None:
        return found
    try:
        phases = find_ways(clip.plan.scenario, clip.plan.schedule).ways.phases
    except RollgaitError:  # a plan of other hands
        return found
    for leg, own in enumerate(phases):
        regions = {id(phase.region): phase.region for phase in own if phase.region is not None}
        corners = [region.vertices for region in regions.values()]
        found[leg] = [np.vstack([c, c[:1]]) for c in corners if len(c) > 2]
    return found
