"""How figures look: colours, sizes, units. Nothing here draws.

Colours are those of Okabe and Ito, "Color Universal Design" (2008), which people with any kind of colour
vision can tell apart. A leg keeps its colour in all figures; what is not a leg takes the other ones.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Final

import matplotlib as mpl
from matplotlib.ticker import MaxNLocator

from rollgait.errors import UnknownNameError

LEG_COLOURS: Final[tuple[str, str, str, str]] = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
"""Blue, vermillion, green, purple: FL, FR, HL, HR."""
BASE_COLOUR: Final = "#000000"
"""Of the base and its CoM."""
GOAL_COLOUR: Final = "#E69F00"
"""Of the goal: orange."""
SECOND_COLOUR: Final = "#666666"
"""Of what stands behind the main quantity of a panel."""
MARK_COLOUR: Final = "#B00020"
"""Of the mark on a plan that is no success."""
SWING_SHADE: Final = 0.15
"""Opacity of the shade, in the colour of the leg, where that leg is in the air."""


@dataclass(frozen=True)
class Style:
    """Sizes of a figure for one use.

    Attributes:
        width: of the figure, inches.
        font: size of all text, points.
        line: width of lines, points.
        dpi: pixels per inch of a PNG.
    """

    width: float
    font: float
    line: float
    dpi: int

    def applied(self) -> AbstractContextManager[None]:
        """A context in which figures are built and written in this style."""
        return mpl.rc_context(self._settings())  # type: ignore[arg-type]  # the stubs list every key

    def _settings(self) -> dict[str, Any]:
        """Settings of Matplotlib, by their names there."""
        thin = 0.5 * self.line
        sizes = ("font.size", "axes.labelsize", "axes.titlesize", "xtick.labelsize", "ytick.labelsize")
        return {
            **dict.fromkeys((*sizes, "legend.fontsize", "figure.titlesize", "figure.labelsize"), self.font),
            "font.family": "DejaVu Sans",  # comes with Matplotlib: the same text everywhere
            "lines.linewidth": self.line,
            "axes.linewidth": thin,
            "axes.grid": True,
            "axes.axisbelow": True,
            "grid.linewidth": 0.5 * thin,
            "grid.color": "#D0D0D0",
            "xtick.major.width": thin,
            "ytick.major.width": thin,
            "xtick.major.size": 0.35 * self.font,
            "ytick.major.size": 0.35 * self.font,
            "legend.frameon": False,
            "legend.handlelength": 1.6,
            "legend.columnspacing": 1.2,
            "legend.handletextpad": 0.5,
            "figure.dpi": self.dpi,
            "savefig.dpi": self.dpi,
            "pdf.fonttype": 42,  # TrueType outlines: what journals accept, and text stays text
            "svg.fonttype": "path",  # an SVG looks the same where the font is missing
            "svg.hashsalt": "rollgait",  # the same plan gives the same file
            "path.simplify": True,
        }


STYLES: Final[dict[str, Style]] = {
    "screen": Style(width=7.0, font=10.0, line=1.5, dpi=150),
    "paper": Style(width=3.4, font=8.0, line=1.0, dpi=600),  # the width of a column in a two-column paper
}


def ticks(count: int) -> MaxNLocator:
    """Places of about `count` ticks at round numbers."""
    return MaxNLocator(count, steps=[1, 2, 5, 10] if count > 2 else [1, 2, 4, 5, 10])


def find_style(name: str) -> Style:
    """The style of this name. Raises `UnknownNameError`."""
    if name not in STYLES:
        raise UnknownNameError("style", name, STYLES)
    return STYLES[name]
