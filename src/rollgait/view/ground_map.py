"""A map of ground from above: its height, its edges, and where a wheel can roll and stand."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from rollgait.files import replacing
from rollgait.terrain.mesh import within
from rollgait.terrain.regions import Regions
from rollgait.view.figures import IMAGE_FORMATS, require_image_format
from rollgait.view.relief_map import add_scale, draw_edges
from rollgait.view.style import MARK_COLOUR, Style, find_style, ticks

CELLS: Final = 400
"""Cells along the longer side of the picture."""
REGION_COLOURS: Final = ("#0072B2", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#D55E00")
"""Of the regions in turn: those of the legs' palette, which all can tell apart."""
SHADE: Final = 0.45
"""Opacity of the regions over the height."""
GREYS: Final = LinearSegmentedColormap.from_list("greys", ["#808080", "#FFFFFF"])
"""Of the heights: light, so that the colours over them are told apart."""
WIDE: Final = 5.0
"""Width of a figure from which on its legend has one row, inches."""
CONTOURS: Final = 6
"""About so many lines of equal height on a map."""
Window = tuple[tuple[float, float], tuple[float, float]]


def save_ground(regions: Regions, window: Window, path: Path, style: str = "screen") -> Path:
    """Writes the picture of a ground; returns its path.

    Args:
        regions: of a wheel.
        window: smallest and largest (x, y), m.
        path: where to; its suffix is the format.
        style: `screen` or `paper`.

    Raises:
        UnknownNameError: there is no such format or style.
        FileError: the file cannot be written.
    """
    image_format = require_image_format(path)
    look = find_style(style)
    with look.applied():
        picture = Figure(layout="constrained")
        draw_ground(picture, regions, window, look)
        with replacing(path) as temporary:
            picture.savefig(temporary, format=image_format, metadata=IMAGE_FORMATS[image_format])
    return path


def draw_ground(picture: Figure, regions: Regions, window: Window, style: Style) -> None:
    """Draws the ground in a window with the regions of a wheel.

    Grey is the height, a colour a region that can be rolled and stood on, red is too near to an edge or too
    steep, what is hatched is not known.

    Args:
        picture: where to; gets its size.
        regions: of a wheel.
        window: smallest and largest (x, y), m.
        style: sizes.
    """
    (x0, y0), (x1, y1) = window
    step = max(x1 - x0, y1 - y0) / CELLS
    x, y = np.arange(x0 + 0.5 * step, x1, step), np.arange(y0 + 0.5 * step, y1, step)
    points = np.stack(np.meshgrid(x, y), axis=-1)
    height = regions.terrain.height(points[..., 0], points[..., 1])
    labels = regions.label(points.reshape(-1, 2)).reshape(height.shape)
    place: dict[str, Any] = {"extent": (x0, x1, y0, y1), "origin": "lower", "interpolation": "nearest"}

    picture.set_size_inches(
        style.width, style.width * min(max(0.85 * (y1 - y0) / (x1 - x0), 0.25), 1.2) + 0.8
    )
    axes = picture.subplots()
    axes.grid(visible=False)
    relief = axes.imshow(height, cmap=GREYS, **place)
    if not regions.terrain.planar and np.isfinite(height).any():
        line = 0.3 * style.line
        axes.contour(
            x, y, height, locator=ticks(CONTOURS), colors="black", linewidths=line, linestyles="solid"
        )
    axes.contourf(x, y, np.isnan(height), levels=[0.5, 1.5], colors="none", hatches=["////"])
    shown = np.ma.masked_less(labels, 0)
    colours = ListedColormap(REGION_COLOURS)
    axes.imshow(
        np.ma.mod(shown, len(REGION_COLOURS)), cmap=colours, vmin=-0.5, vmax=5.5, alpha=SHADE, **place
    )
    forbidden = np.ma.masked_equal((labels < 0) & np.isfinite(height), False)
    axes.imshow(forbidden, cmap=ListedColormap([MARK_COLOUR]), alpha=SHADE, **place)
    draw_edges(axes, within(regions.terrain.planes, np.array(window[0]), np.array(window[1])), style)
    axes.set(xlim=(x0, x1), ylim=(y0, y1), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    add_scale(picture, relief, axes)
    radius = regions.surface.radius
    foot = f"{radius:g} m wheel" if radius > 0.0 else "point foot"
    marks = [
        Patch(color=REGION_COLOURS[0], alpha=SHADE, label=f"region of a {foot}"),
        Patch(color=MARK_COLOUR, alpha=SHADE, label="too steep or near edges"),
        Patch(facecolor="none", edgecolor="black", hatch="////", label="not known"),
    ]
    picture.legend(handles=marks, loc="outside upper center", ncols=3 if style.width > WIDE else 1)
    if not (labels >= 0).any():
        axes.set_title("nowhere to stand", color=MARK_COLOUR)
