"""`rollgait export`: a plan in a format that others read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rollgait.cli.arguments import PlanFile, rate_from
from rollgait.plan.plan import Plan


def export(
    plan_file: PlanFile,
    file_format: Annotated[
        str, typer.Option("--format", metavar="FORMAT", help="Format of the file.")
    ] = "csv",
    rate: Annotated[str, typer.Option(metavar="HZ", help="Samples per second.")] = "100",
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where to write. Default: <plan>.<format>.")
    ] = None,
) -> None:
    """Write a plan, sampled at a fixed rate, in a format that others read."""
    per_second = rate_from(rate)
    plan = Plan.load(plan_file)
    target = out or Path(f"{plan_file.stem}.{file_format}")
    from rollgait.export import write

    write(plan, target, file_format, per_second)
    print(target)
