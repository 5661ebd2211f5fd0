"""The figures of a plan, by name: built, marked, written. A new figure is one function and one line here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure

from rollgait.errors import UnknownNameError
from rollgait.files import replacing
from rollgait.plan.plan import Plan
from rollgait.view.in_space import draw_paths, draw_top
from rollgait.view.over_time import draw_base, draw_forces, draw_gait, draw_wheels
from rollgait.view.profile import draw_profile
from rollgait.view.style import MARK_COLOUR, Style, find_style

Draw = Callable[[Figure, Plan, Style], None]
"""Draws one figure, with its size and one legend for the whole."""

FIGURES: Final[dict[str, Draw]] = {
    "paths": draw_paths,
    "top": draw_top,
    "profile": draw_profile,
    "base": draw_base,
    "forces": draw_forces,
    "wheels": draw_wheels,
    "gait": draw_gait,
}
"""Every figure by its name, in the order in which one looks at them."""

IMAGE_FORMATS: Final[dict[str, dict[str, Any]]] = {
    "png": {"Software": None},
    "pdf": {"Creator": None, "Producer": None, "CreationDate": None},
    "svg": {"Creator": None, "Date": None},
}
"""Formats, and the metadata that would make two files of the same plan differ."""


def figure(plan: Plan, name: str, style: str = "screen") -> Figure:
    """One figure of a plan, marked where the plan is no success.

    Args:
        plan: what to draw.
        name: a key of `FIGURES`.
        style: `screen`, or `paper`: the width of a column, 8 pt.

    Raises:
        UnknownNameError: there is no such figure or style.
        InputError: numbers of the motion are none.
    """
    plan.require_numbers()
    if name not in FIGURES:
        raise UnknownNameError("figure", name, FIGURES)
    look = find_style(style)
    with look.applied():
        result = Figure(layout="constrained")
        FIGURES[name](result, plan, look)
        _put_mark(result, mark_of(plan))
    return result


def save_figures(
    plan: Plan, folder: str | Path, formats: Sequence[str] = ("png",), style: str = "screen"
) -> list[Path]:
    """Writes all figures of a plan as `<folder>/<figure>.<format>`; returns their paths.

    Args:
        plan: what to draw.
        folder: where to; created if it is missing.
        formats: keys of `IMAGE_FORMATS`: `png`, `pdf`, `svg`.
        style: as in `figure`.

    Raises:
        UnknownNameError: there is no such format or style.
        InputError: numbers of the motion are none.
        FileError: the folder cannot be written to.
    """
    for image_format in formats:
        if image_format not in IMAGE_FORMATS:
            raise UnknownNameError("format", image_format, IMAGE_FORMATS)
    look = find_style(style)
    paths = []
    for name in FIGURES:
        picture = figure(plan, name, style)
        for image_format in formats:
            path = Path(folder) / f"{name}.{image_format}"
            with look.applied(), replacing(path) as temporary:
                picture.savefig(temporary, format=image_format, metadata=IMAGE_FORMATS[image_format])
            paths.append(path)
    return paths


def require_image_format(path: Path) -> str:
    """The format that a file's suffix means. Raises `UnknownNameError` if it is none of `IMAGE_FORMATS`."""
    suffix = path.suffix.lower().removeprefix(".")
    if suffix not in IMAGE_FORMATS:
        raise UnknownNameError("format", suffix, IMAGE_FORMATS)
    return suffix


def _put_mark(picture: Figure, mark: str) -> None:
    """Writes the mark over the legend, where it takes room of its own and covers nothing."""
    for legend in picture.legends[:1] if mark else []:
        legend.set_title(mark)
        legend.get_title().set(color=MARK_COLOUR, weight="bold")


def mark_of(plan: Plan) -> str:
    """What a figure must say of a plan that is no success: `not solved`, `not certified`, or nothing."""
    if not plan.solved:
        return "not solved"
    return "" if plan.certificate().passed else "not certified"
