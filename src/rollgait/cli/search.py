"""`rollgait search`: fewer or more steps, other orders, pairs: a table of what each costs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import AsJson, Kernels, Profile, ScenarioName, Settings, scenario_with
from rollgait.cli.output import MILLI, number, print_json, print_table
from rollgait.cli.progress import StatusLine
from rollgait.cli.replacing import note_replacing
from rollgait.files import check_writable, npz_path

if TYPE_CHECKING:
    from rollgait.discover.step_search import StepSearch, Tried


def search(
    scenario: ScenarioName,
    change: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="What to try: fewer, more, pairs or orders; repeatable. Default: fewer, pairs, orders.",
        ),
    ] = None,
    candidates: Annotated[int, typer.Option(metavar="N", min=1, help="How many gaits to plan at most.")] = 40,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where the best plan is written (.npz).")
    ] = None,
    settings: Settings = None,
    profile: Profile = None,
    kernels: Kernels = True,
    as_json: AsJson = False,
) -> None:
    """Change the steps of a gait as long as that saves cost.

    Each gait is planned and certified; the table says what it costs, what is left of its margins beyond their
    limits, and how much work wheels and legs do.

    Exit status: 0 a certified gait was found, 1 none, 2 wrong input.
    """
    from rollgait.discover.step_search import CHANGES
    from rollgait.searching import search_steps

    target = None if out is None else npz_path(out, "out")
    if target is not None:
        check_writable(target)
    asked = scenario_with(scenario, settings, profile)
    with StatusLine("planning the gait as given …", quiet=as_json) as line:
        count = 0

        def tell(tried: Tried) -> None:
            nonlocal count
            count += 1
            line.show(f"{count} of at most {candidates} gaits … last: {tried.change}, {_result(tried)}")

        found = search_steps(
            asked, changes=change or CHANGES, candidates=candidates, kernels=kernels, tell=tell
        )
    best, file = found.best, None
    if target is not None and best is not None and best.plan is not None:
        note_replacing(target)
        file = best.plan.save(target)
    if as_json:
        number_of_best = None if best is None else found.tried.index(best)
        tried = [each.to_dict() for each in found.tried]
        print_json({"tried": tried, "best": number_of_best, "cut": found.cut, "file": file and str(file)})
    else:
        _print(found, candidates)
        if file is not None:
            print(f"\nwrote {file}")
    if best is None:
        raise typer.Exit(1)


def _print(found: StepSearch, candidates: int) -> None:
    head = ("", "gait", "swings", "result", "cost", "CoM", "capture", "work", "time")
    rows: list[tuple[str, ...]] = [head, ("", "", "", "", "", "mm", "mm", "J", "s")]
    best = found.best
    for tried in found.tried:
        rows.append(
            (
                "→" if tried is best else "",
                tried.change,
                str(sum(len(step.legs) for step in tried.steps)),
                _result(tried),
                number(tried.cost, 4),
                _millimetres(tried, "com_margin"),
                _millimetres(tried, "capture_margin"),
                number(tried.work, 3),
                f"{tried.seconds:.2f}",
            )
        )
    print_table(rows, right=[2, 4, 5, 6, 7, 8], indent=0)
    if found.cut:
        print(f"\nThere were more to try than {candidates} (--candidates).")


def _result(tried: Tried) -> str:
    return tried.verdict if tried.verdict != "not certified" else f"not certified: {tried.reason}"


def _millimetres(tried: Tried, margin: str) -> str:
    value = tried.margins.get(margin)
    return number(None if value is None else MILLI * value, 2)
