"""The ground from above, in colours of its height: vectors, exact where it is made of parts."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize, TwoSlopeNorm
from matplotlib.figure import Figure

from rollgait.plan.samples import Array
from rollgait.terrain import Terrain
from rollgait.terrain.edges import JUMP, borders
from rollgait.terrain.facet import Facet, bands
from rollgait.terrain.mesh import within
from rollgait.terrain.relief import HIGH_COLOUR, LEVEL_COLOUR, LOW_COLOUR, SPAN_MIN
from rollgait.view.style import Style, ticks

CELLS: Final = 160
"""Cells along the longer side of the picture of a map."""
BANDS: Final = 24
"""Steps of colour on a slope from its lowest to its highest place in the picture."""
COLOURS: Final = LinearSegmentedColormap.from_list(
    "ground", [tuple(part / 255.0 for part in colour) for colour in (LOW_COLOUR, LEVEL_COLOUR, HIGH_COLOUR)]
)
"""As in space: what is low is blue, what is high is sand."""


def draw_relief(axes: Axes, terrain: Terrain, low: Array, high: Array, style: Style) -> ScalarMappable:
    """Draws the ground in a rectangle; returns its scale of heights.

    Args:
        axes: where to.
        terrain: the ground.
        low: smallest x and y, (2,), m.
        high: largest x and y, (2,), m.
        style: sizes.
    """
    if terrain.planar:
        planes = within(terrain.planes, low, high)
        heights = np.concatenate([plane.z(plane.polygon) for plane in planes])
        scale = height_scale(heights, terrain.level)
        pieces = [piece for plane in planes for piece in bands(plane, BANDS)]
        colours = scale.to_rgba(np.array([piece.z(piece.polygon).mean() for piece in pieces]))
        outlines = [piece.polygon for piece in pieces]
        axes.add_collection(
            PolyCollection(outlines, facecolors=colours, edgecolors=colours, linewidths=0.3, zorder=0)
        )
    else:
        step = (high - low).max() / CELLS
        x, y = (np.arange(a, b + step, step) for a, b in zip(low, high, strict=True))
        heights = terrain.height(x, y[:, None])
        scale = height_scale(heights[np.isfinite(heights)])
        levels = np.linspace(scale.norm.vmin or 0.0, scale.norm.vmax or 1.0, BANDS + 1)
        filled = axes.contourf(
            x, y, np.ma.masked_invalid(heights), levels, cmap=COLOURS, norm=scale.norm, zorder=0
        )
        filled.set_edgecolor("face")
        axes.contourf(x, y, np.isnan(heights), [0.5, 1.5], colors="none", hatches=["////"], zorder=0)
        planes = within(terrain.planes, low, high)
    draw_edges(axes, planes, style)
    return scale


def draw_edges(axes: Axes, planes: tuple[Facet, ...], style: Style) -> None:
    """Lines where planes meet that are not one."""
    for border in borders(planes):
        if border.own < border.other and not planes[border.own].coplanar(planes[border.other]):
            ends = np.array([border.begin, border.end])
            axes.plot(*ends.T, color="black", linewidth=0.4 * style.line, zorder=0.5)


def height_scale(heights: Array, level: float | None = None) -> ScalarMappable:
    """Colours of heights (m) about a level, or about their middle; of all colours those that are needed."""
    middle = float(np.median(heights)) if level is None and len(heights) else level or 0.0
    lowest, highest = (float(f(heights)) if len(heights) else middle for f in (np.min, np.max))
    spread = TwoSlopeNorm(middle, min(lowest, middle - SPAN_MIN), max(highest, middle + SPAN_MIN))
    every = np.linspace(lowest, max(highest, lowest + JUMP), 256)
    return ScalarMappable(Normalize(every[0], every[-1]), ListedColormap(COLOURS(spread(every))))


def add_scale(figure: Figure, scale: ScalarMappable, axes: Axes) -> None:
    """Puts a scale of heights beside a panel, as high as that."""
    bar = figure.colorbar(scale, cax=axes.inset_axes((1.02, 0.0, 0.02, 1.0)), label="height (m)")
    bar.outline.set_linewidth(0.0)
    bar.locator = ticks(4)
    bar.update_ticks()
