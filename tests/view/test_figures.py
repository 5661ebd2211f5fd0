"""Figures: every one, in every format and style, says what it shows, with units, and fits its page."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from rollgait.errors import FileError, UnknownNameError
from rollgait.plan.plan import Plan
from rollgait.robot import LEG_NAMES
from rollgait.scenario import find_scenario
from rollgait.view.figures import FIGURES, IMAGE_FORMATS, figure, mark_of, save_figures
from rollgait.view.motion import SNAPSHOT_SPACING, dense_samples, snapshot_times, swing_times
from rollgait.view.profile import GROUND_FILL, runs
from rollgait.view.style import LEG_COLOURS, STYLES
from tests.library import FLAT
from tests.view.builders import motion_plan

MAGIC = {"png": b"\x89PNG\r\n\x1a\n", "pdf": b"%PDF-", "svg": b"<?xml"}
PLANS = {name: motion_plan(find_scenario(name), solved=False) for name in FLAT}
every_plan = pytest.mark.parametrize("plan", PLANS.values(), ids=list(PLANS))
every_figure = pytest.mark.parametrize("name", FIGURES)
LABELS = {
    "paths": {"x (m)", "y (m)", "z (m)"},
    "top": {"x (m)", "y (m)"},
    "profile": {"x (m)", *(f"{leg} z (m)" for leg in LEG_NAMES)},
    "base": {"time (s)", "x (m)", "y (m)", "z (m)", "yaw (°)", "pitch (°)", "roll (°)"},
    "forces": {"time (s)", "height (cm)", *(f"{leg} (N)" for leg in LEG_NAMES)},
    "wheels": {"time (s)", "speed (m/s)", "heading (°)", "heading from base (°)"},
    "gait": {"time (s)"},
}


def drawn(picture: Figure) -> Figure:
    """The figure with everything in its place."""
    FigureCanvasAgg(picture).draw()
    return picture


def labels(picture: Figure) -> set[str]:
    return {
        text
        for axes in picture.axes
        for which in ("x", "y", "z")
        if hasattr(axes, f"get_{which}label") and (text := getattr(axes, f"get_{which}label")())
    }


def ink(text: Text) -> Bbox:
    """Where a text is, in pixels, without the air above and below its letters."""
    box = text.get_window_extent()
    air = 0.1 * min(box.width, box.height)
    return box.padded(-air)


@every_figure
@pytest.mark.parametrize("style", STYLES)
def test_axes_have_names_and_units(name: str, style: str) -> None:
    assert labels(figure(PLANS["hybrid-goback"], name, style)) == LABELS[name]


@every_plan
@every_figure
@pytest.mark.parametrize("style", STYLES)
def test_figures_fit_their_page(plan: Plan, name: str, style: str) -> None:
    """The width is that of the style, the font too, and the legend lies inside and covers no panel."""
    picture = drawn(figure(plan, name, style))
    assert picture.get_figwidth() == pytest.approx(STYLES[style].width)
    assert 0.3 < picture.get_figheight() / picture.get_figwidth() < 2.7
    (legend,) = picture.legends
    box = legend.get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= picture.bbox.x1
    assert box.y1 <= picture.bbox.y1 + 1.0
    assert {text.get_fontsize() for text in legend.get_texts()} == {STYLES[style].font}
    for axes in picture.axes:
        for axis in (getattr(axes, f"{which}axis", None) for which in "xyz"):
            if axis is not None and axis.label.get_text():
                place = ink(axis.label)
                assert picture.bbox.contains(place.x0, place.y0), axis.label.get_text()
                assert picture.bbox.contains(place.x1, place.y1), axis.label.get_text()
    if name != "paths":  # there the panel is a box in space
        assert all(not axes.get_window_extent().overlaps(box) for axes in picture.axes)


@pytest.mark.parametrize("name", [name for name in FIGURES if name not in ("paths", "top")])
@every_plan
@pytest.mark.parametrize("style", STYLES)
def test_no_text_covers_another(plan: Plan, name: str, style: str) -> None:
    picture = drawn(figure(plan, name, style))
    texts = list(picture.legends[0].get_texts())
    for axes in picture.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
            texts += [axis.label, *(tick.label1 for tick in ticks)]
    boxes = [(t.get_text(), ink(t)) for t in texts if t.get_visible() and t.get_text()]
    assert len(boxes) > 5
    for (one, here), (other, there) in combinations(boxes, 2):
        assert not here.overlaps(there), f"{one} and {other}"


def test_every_format_is_written(tmp_path: Path) -> None:
    paths = save_figures(PLANS["hybrid-goback"], tmp_path / "new", list(IMAGE_FORMATS), "paper")
    assert [path.name for path in paths] == [f"{name}.{kind}" for name in FIGURES for kind in IMAGE_FORMATS]
    assert sorted(paths) == sorted((tmp_path / "new").iterdir())  # and nothing else
    for path in paths:
        content = path.read_bytes()
        assert content.startswith(MAGIC[path.suffix[1:]])
        assert len(content) > 4000
        assert b"image/png" not in content  # vectors, not a picture in a wrapper
        assert b"/Subtype /Image" not in content


def test_the_same_plan_gives_the_same_files(tmp_path: Path) -> None:
    once = save_figures(PLANS["wheeled"], tmp_path / "once", list(IMAGE_FORMATS))
    again = save_figures(PLANS["wheeled"], tmp_path / "again", list(IMAGE_FORMATS))
    for one, other in zip(once, again, strict=True):
        assert one.read_bytes() == other.read_bytes(), one.name


@every_figure
def test_what_is_no_success_carries_a_mark(name: str) -> None:
    unsolved = PLANS["hybrid-forward"]
    solved = replace(unsolved, statistics=replace(unsolved.statistics, solved=True))
    assert mark_of(unsolved) == "not solved"
    assert not solved.certificate().passed  # forces by hand: the base does not follow them
    assert mark_of(solved) == "not certified"
    for plan in (unsolved, solved):
        title = drawn(figure(plan, name)).legends[0].get_title()
        assert title.get_visible()
        assert title.get_text() == mark_of(plan)


def test_swings_are_shaded_in_the_colour_of_their_leg() -> None:
    plan = PLANS["hybrid-goback"]
    picture = figure(plan, "forces")
    for leg, axes in enumerate(picture.axes[:4]):
        shades = [(p.get_x(), p.get_x() + p.get_width()) for p in axes.patches]  # type: ignore[attr-defined]
        np.testing.assert_allclose(shades, [(a, b) for i, a, b in swing_times(plan) if i == leg])
        assert {p.get_facecolor()[:3] for p in axes.patches} == {to_rgb(LEG_COLOURS[leg])}


def test_a_leg_keeps_its_colour() -> None:
    s = dense_samples(PLANS["hybrid-goback"])
    wheels = figure(PLANS["hybrid-goback"], "wheels").axes[0]
    forces = figure(PLANS["hybrid-goback"], "forces").axes
    for leg, colour in enumerate(LEG_COLOURS):
        (speed,) = [line for line in wheels.lines if line.get_color() == colour]
        (normal,) = [line for line in forces[leg].lines if line.get_color() == colour]
        np.testing.assert_array_equal(speed.get_ydata(), s.speed[:, leg])
        np.testing.assert_array_equal(normal.get_ydata(), s.force[:, leg, 2])


def test_bars_and_gaps_of_the_gait_fill_the_horizon() -> None:
    plan = PLANS["hybrid-goback"]
    axes = figure(plan, "gait").axes[0]
    assert [text.get_text() for text in axes.get_yticklabels()] == list(LEG_NAMES)
    for leg, bars in enumerate(axes.collections):
        stance = sum(np.ptp(path.vertices[:, 0]) for path in bars.get_paths())
        assert stance == pytest.approx(plan.schedule.contact[leg] @ plan.schedule.lengths)


def test_on_an_unequal_mesh_lines_have_a_point_at_every_node() -> None:
    asked = find_scenario("hybrid-goback")
    plan = motion_plan(asked, schedule=asked.schedule.refined([3, 14, 15, 60], 3))
    s = dense_samples(plan)
    nodes = plan.schedule.node_times
    assert np.abs(s.time[:, None] - nodes).min(axis=0).max() < 1e-9
    assert np.all(np.diff(s.time) > 0.0)
    even = sorted(swing_times(motion_plan(asked)))
    np.testing.assert_allclose(sorted(swing_times(plan)), even, atol=1e-9)


def test_point_feet_have_no_headings() -> None:
    assert labels(figure(PLANS["legged-forward"], "wheels")) == {"time (s)", "speed (m/s)"}


def test_a_jump_is_drawn_upright() -> None:
    s = dense_samples(PLANS["hybrid-forward"])
    jumps = np.abs(np.diff(s.force, axis=0)).max(axis=(1, 2)) > 1e-9
    assert np.diff(s.time)[jumps].max() < 1e-6


@every_plan
def test_snapshots_stand_clear_of_each_other(plan: Plan) -> None:
    times = snapshot_times(plan, 0.0, plan.horizon)
    place = plan.sample(times).com_position[:, :2]
    yaw = plan.sample(times).euler[:, 0]
    assert times[-1] == plan.horizon
    assert 1 <= len(times) <= 6
    for a, b in combinations(range(len(times)), 2):
        assert (
            np.hypot(np.linalg.norm(place[a] - place[b]), 0.5 * (yaw[a] - yaw[b])) >= SNAPSHOT_SPACING - 1e-9
        )


def test_unknown_names_list_the_valid_ones(tmp_path: Path) -> None:
    plan = PLANS["wheeled"]
    for call, first, known in [
        (lambda: figure(plan, "force"), "forces", FIGURES),
        (lambda: figure(plan, "gait", "papre"), "paper", STYLES),
        (lambda: save_figures(plan, tmp_path, ["pgn"]), "png", IMAGE_FORMATS),
        (lambda: save_figures(plan, tmp_path, ["png"], "poster"), None, STYLES),
    ]:
        with pytest.raises(UnknownNameError) as caught:
            call()
        assert set(caught.value.choices) == set(known)
        assert first in (None, caught.value.choices[0])
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be written"):
        save_figures(PLANS["wheeled"], tmp_path / "file")


def test_drawing_leaves_the_settings_of_matplotlib_alone() -> None:
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    figure(PLANS["wheeled"], "gait", "paper")
    assert dict(mpl.rcParams) == before


@pytest.mark.parametrize(
    "way", [[0.0, 1.0, 0.5, 0.5, 2.0], [0.0, 0.0, -1.0, -1.0], [3.0, 3.0], [0.0, 1.0, 0.0]]
)
def test_a_way_is_cut_where_it_turns(way: list[float]) -> None:
    values = np.array(way)
    parts = [values[part] for part in runs(values)]
    assert all((np.diff(part) >= 0.0).all() or (np.diff(part) <= 0.0).all() for part in parts)
    assert [part[-1] for part in parts[:-1]] == [part[0] for part in parts[1:]]
    assert sum(len(part) - 1 for part in parts) == len(values) - 1


@every_plan
def test_ground_is_wherever_a_foot_is(plan: Plan) -> None:
    """Also where it goes and comes back: what is filled twice must not be empty."""
    s = dense_samples(plan)
    picture = figure(plan, "profile")
    for leg, axes in enumerate(picture.axes):
        fills = [each for each in axes.collections if to_rgb(each.get_facecolor()[0]) == to_rgb(GROUND_FILL)]
        outlines = [path for fill in fills for path in fill.get_paths()]
        way = axes.lines[-1].get_xdata()
        below = 0.5 * (axes.get_ylim()[0] + s.foot_position[:, leg, 2].min())
        inside = np.linspace(way.min() + 2e-3, way.max() - 2e-3, 40)
        assert all(any(path.contains_point((x, below)) for path in outlines) for x in inside)
