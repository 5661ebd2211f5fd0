"""The map of a ground shows each region, what is not known, and its units."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from rollgait.terrain import Terrain, regions_of
from rollgait.view.ground_map import draw_ground
from rollgait.view.style import find_style

WINDOW = ((-1.0, -1.0), (2.0, 1.0))


def drawn(terrain: Terrain) -> Figure:
    style = find_style("screen")
    with style.applied():
        picture = Figure(layout="constrained")
        draw_ground(picture, regions_of(terrain, 0.124), WINDOW, style)
        picture.canvas.draw_idle()
    return picture


def test_each_region_has_a_colour_and_edges_have_none() -> None:
    picture = drawn(Terrain.from_parts([{"kind": "step", "x": 0.5, "height": 0.15}]))
    (axes,) = picture.axes
    _, regions, forbidden = axes.images
    shown = regions.get_array()
    assert set(np.unique(shown.compressed())) == {0, 1}
    x = np.linspace(-1.0, 2.0, shown.shape[1])
    row = np.ma.getmaskarray(shown)[shown.shape[0] // 2]
    blank = x[row]
    assert blank.min() < 0.5 - 0.124
    assert blank.max() + 0.02 >= 0.5 + 0.03
    assert not row[x < 0.3].any()
    red = ~np.ma.getmaskarray(forbidden.get_array())
    np.testing.assert_array_equal(red, np.ma.getmaskarray(shown))
    (bar,) = axes.child_axes
    assert (axes.get_xlabel(), axes.get_ylabel(), bar.get_ylabel()) == ("x (m)", "y (m)", "height (m)")
    assert "0.124 m" in picture.legends[0].get_texts()[0].get_text()


def test_ground_without_a_place_to_stand_says_so() -> None:
    steep = Terrain.from_parts([{"kind": "ramp", "x": -10.0, "length": 20.0, "slope_deg": 40.0}])
    assert drawn(steep).axes[0].get_title() == "nowhere to stand"
