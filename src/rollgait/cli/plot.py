"""`rollgait plot`: the figures of a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.arguments import PlanFile


def plot(
    plan_file: PlanFile,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Folder for the figures. Default: <plan>-figures.")
    ] = None,
    formats: Annotated[
        list[str] | None, typer.Option("--format", metavar="FORMAT", help="png, pdf or svg; repeatable.")
    ] = None,
    style: Annotated[str, typer.Option(metavar="NAME", help="screen or paper.")] = "screen",
) -> None:
    """Draw the figures of a plan.

    Paths, ground under the feet, base pose, forces, wheels, gait.
    """
    from rollgait.plan.plan import Plan

    plan = Plan.load(plan_file)
    folder = out or Path(f"{plan_file.stem}-figures")
    from rollgait.view.figures import save_figures  # loads Matplotlib: only once the plan is known to be one

    for path in save_figures(plan, folder, formats=tuple(formats or ["png"]), style=style):
        print(path)
