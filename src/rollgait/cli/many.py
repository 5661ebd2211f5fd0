"""`rollgait many`: many scenarios at once, each with its own plan on disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rollgait.cli.arguments import AsJson, Kernels, Profile, Seed, Settings, Starts, scenario_with
from rollgait.cli.output import number, print_json, print_table
from rollgait.errors import InputError, NotSolvedError, RollgaitError

if TYPE_CHECKING:
    from rollgait.many import Outcome


def many(
    scenarios: Annotated[
        list[str], typer.Argument(metavar="SCENARIO...", help="Names of scenarios, or YAML files.")
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where the plans are written.")] = Path("plans"),
    workers: Annotated[
        int, typer.Option(metavar="N", help="How many to plan at once. Default: one per core.")
    ] = -1,
    settings: Settings = None,
    profile: Profile = None,
    starts: Starts = 1,
    seed: Seed = 0,
    kernels: Kernels = True,
    as_json: AsJson = False,
) -> None:
    """Plan many motions at once, each into its own file.

    A file is written as soon as its plan is there. Plans that are in the folder already are not made
    again: after an interruption, repeat the command.

    Exit status: 0 all solved and certified, 1 not all, 2 wrong input (the other scenarios are planned
    nevertheless).
    """
    from rollgait.many import plan_many

    wrong, right = {}, {}
    for name in scenarios:
        try:
            stem = Path(name).stem
            right[name if stem in right else stem] = scenario_with(name, settings, profile)
        except RollgaitError as error:
            wrong[name] = error
    found = plan_many(
        right, workers=workers, folder=out, quiet=as_json, multistart=starts, seed=seed, kernels=kernels
    )
    outcomes = {outcome.name: _facts(outcome) for outcome in found}
    outcomes |= {name: {"result": "wrong input", "message": str(error)} for name, error in wrong.items()}
    if as_json:
        print_json(outcomes)
    else:
        _print(outcomes)
    results = {facts["result"] for facts in outcomes.values()}
    if results != {"certified"}:
        raise typer.Exit(2 if "wrong input" in results else 1)


def _facts(outcome: Outcome) -> dict[str, Any]:
    if outcome.plan is None:
        return {"result": _kind(outcome.error), "message": str(outcome.error)}
    statistics = outcome.plan.statistics
    return {
        "result": "certified" if outcome.certified else "not certified",
        "cost": statistics.cost,
        "solve_time": statistics.solve_time,
        "file": str(outcome.file),
    }


def _kind(error: RollgaitError | None) -> str:
    if isinstance(error, InputError):
        return "wrong input"
    return "not solved" if isinstance(error, NotSolvedError) else "failed"


def _print(outcomes: dict[str, dict[str, Any]]) -> None:
    rows = [("scenario", "result", "cost", "time", "file")]
    for name, facts in outcomes.items():
        time = f"{facts['solve_time']:.2f} s" if "solve_time" in facts else ""
        cost = number(facts["cost"], 4) if "cost" in facts else ""
        rows.append((name, facts["result"], cost, time, facts.get("file", facts.get("message", ""))))
    print_table(rows, right=[2, 3], indent=0)
