"""Plots on the page: drawn once as SVG, with a line that follows the time and the values there.

Only the line and the numbers are sent while the motion plays: a plot itself never is.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Final

import numpy as np
from numpy.typing import NDArray

from rollgait.plan.samples import Array
from rollgait.robot.robot import LEG_NAMES
from rollgait.view.clip import Clip
from rollgait.view.margins import friction_use, support_margin
from rollgait.view.style import LEG_COLOURS, SWING_SHADE

WIDTH, HEIGHT = 300, 64
"""Of the picture's own coordinates; it is scaled to the page."""
TEXT_COLOUR: Final = "var(--mantine-color-text, #000000)"
"""Of what is not a leg: that of the page's text, on light and on dark."""
MOST_POINTS: Final = 400
"""Points of a line: as many as the page has pixels for."""


@dataclass(frozen=True)
class Line:
    """One line of a plot."""

    name: str
    colour: str
    values: Array


@dataclass(frozen=True)
class Plot:
    """One plot.

    Attributes:
        title: what and in which unit.
        lines: over the frames of the clip.
        low, high: range of the axis.
        digits: decimals of the numbers.
    """

    title: str
    lines: tuple[Line, ...]
    low: float
    high: float
    digits: int


def plots_of(clip: Clip) -> list[Plot]:
    """The plots of a clip."""
    s = clip.samples
    height = 100.0 * (s.foot_position[..., 2] - clip.foot_ground)
    result = [
        _by_leg("normal force (N)", s.force[..., 2], 0, low=0.0),
        _by_leg("wheel speed (m/s)", s.speed, 2),
        _by_leg("foot height (cm)", height, 1),
        _by_leg("friction used (%)", friction_use(clip), 0, low=0.0, high=100.0),
        _plot("CoM inside support (cm)", (Line("CoM", TEXT_COLOUR, 100.0 * support_margin(clip)),), 1),
    ]
    return [plot for plot in result if any(np.ptp(_finite(line.values)) > 0.0 for line in plot.lines)]


def draw(plot: Plot, clip: Clip) -> str:
    """The plot as HTML with an SVG in it."""
    step = max(1, len(clip.time) // MOST_POINTS)
    x = WIDTH * clip.time[::step] / clip.horizon
    parts = [_shade(clip), _zero(plot)]
    for line in reversed(plot.lines):
        y = HEIGHT * (1.0 - (line.values[::step] - plot.low) / (plot.high - plot.low))
        parts.append(
            f'<path d="{_path(x, y)}" fill="none" stroke="{line.colour}" stroke-width="1.4" '
            'vector-effect="non-scaling-stroke" stroke-linejoin="round"/>'
        )
    ends = (
        f'<span style="position:absolute;left:2px;top:-1px">{plot.high:.{plot.digits}f}</span>'
        f'<span style="position:absolute;left:2px;bottom:0px">{plot.low:.{plot.digits}f}</span>'
    )
    return (
        f'<div style="margin:0 0.75em"><div style="position:relative;height:{HEIGHT}px;'
        'font:9px system-ui,sans-serif;color:#888;background:rgba(127,127,127,0.07);border-radius:3px">'
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" preserveAspectRatio="none" '
        f'style="width:100%;height:100%;display:block">{"".join(parts)}</svg>{ends}</div></div>'
    )


def cursor(plot: Plot, clip: Clip, index: int) -> str:
    """The line at a frame, to lie over the plot, and the values there as HTML."""
    part = 100.0 * clip.time[index] / clip.horizon
    numbers = " ".join(
        f'<span style="color:{line.colour};font-weight:600" title="{escape(line.name)}">'
        f"{_number(line.values[index], plot.digits)}</span>"
        for line in plot.lines
    )
    return (
        f'<div style="margin:0 0.75em;height:0;position:relative;z-index:2;pointer-events:none">'
        f'<div style="position:absolute;left:{part:.3f}%;top:1.25em;width:0;height:{HEIGHT}px;'
        'border-left:1.5px solid #B00020"></div></div>'
        '<div style="margin:0.35em 0.75em 0;display:flex;justify-content:space-between;'
        'font:11px system-ui,sans-serif;line-height:1.25em">'
        f"<span>{escape(plot.title)}</span>"
        f'<span style="display:flex;gap:0.7em;font-variant-numeric:tabular-nums">{numbers}</span></div>'
    )


def legend() -> str:
    """The colours of the legs."""
    names = "".join(
        f'<span style="color:{colour};font-weight:600">&#9632; {name}</span>'
        for name, colour in zip(LEG_NAMES, LEG_COLOURS, strict=True)
    )
    return (
        '<div style="margin:0.4em 0.75em 0;display:flex;gap:1em;font:12px system-ui,sans-serif">'
        f"{names}</div>"
    )


def _by_leg(
    title: str, values: Array, digits: int, low: float | None = None, high: float | None = None
) -> Plot:
    lines = zip(LEG_NAMES, LEG_COLOURS, values.T, strict=True)
    return _plot(title, tuple(Line(*line) for line in lines), digits, low, high)


def _plot(
    title: str, lines: tuple[Line, ...], digits: int, low: float | None = None, high: float | None = None
) -> Plot:
    every = np.concatenate([_finite(line.values) for line in lines])
    bottom = float(every.min()) if low is None else low
    top = float(every.max()) if high is None else high
    air = 0.08 * max(top - bottom, 1e-3)
    return Plot(
        title, lines, bottom - (air if low is None else 0.0), top + (air if high is None else 0.0), digits
    )


def _finite(values: Array) -> Array:
    finite = values[np.isfinite(values)]
    return finite if finite.size else np.zeros(1)


def _path(x: Array, y: Array) -> str:
    """Path commands; a gap where a value is not finite."""
    words, pen = [], "M"
    for a, b in zip(x, y, strict=True):
        if np.isfinite(b):
            words.append(f"{pen}{a:.1f} {b:.1f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(words)


def _zero(plot: Plot) -> str:
    if not plot.low < 0.0 < plot.high:
        return ""
    y = HEIGHT * plot.high / (plot.high - plot.low)
    line = 'stroke="#999" stroke-width="0.6" vector-effect="non-scaling-stroke"'
    return f'<path d="M0 {y:.1f}L{WIDTH} {y:.1f}" {line}/>'


def _shade(clip: Clip) -> str:
    """The time in the air, in the colour of its leg."""
    parts = []
    for leg, colour in enumerate(LEG_COLOURS):
        for begin, end in _runs(~clip.samples.contact[:, leg]):
            a, b = (WIDTH * clip.time[i] / clip.horizon for i in (begin, end))
            size = f'x="{a:.1f}" y="0" width="{b - a:.1f}" height="{HEIGHT}"'
            parts.append(f'<rect {size} fill="{colour}" opacity="{SWING_SHADE}"/>')
    return "".join(parts)


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(min(b, len(flags) - 1))) for a, b in edges.reshape(-1, 2)]


def _number(value: float, digits: int) -> str:
    return f"{value:z.{digits}f}".replace("-", "−") if np.isfinite(value) else "–"
