"""`rollgait plan`: from a scenario to a certified plan on disk."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import (
    AsJson,
    Full,
    Kernels,
    Overwrite,
    Profile,
    ScenarioName,
    Seed,
    Settings,
    Starts,
    scenario_with,
)
from rollgait.cli.output import print_json
from rollgait.cli.progress import SolverLine
from rollgait.cli.replacing import note_replacing, refuse_other_plan
from rollgait.cli.report import print_certificate, print_plan
from rollgait.diagnosis.budget import SECONDS
from rollgait.errors import NotSolvedError
from rollgait.files import check_writable, npz_path

if TYPE_CHECKING:
    from rollgait.diagnosis.report import Diagnosis
    from rollgait.plan.certificate import Certificate
    from rollgait.plan.plan import Plan
    from rollgait.scenario.scenario import Scenario


def plan(
    scenario: ScenarioName,
    settings: Settings = None,
    profile: Profile = None,
    transcription: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="How continuous time becomes an NLP: condensed or collocation."),
    ] = None,
    solver: Annotated[
        str | None, typer.Option(metavar="NAME", help="What solves the NLP: fatrop or ipopt.")
    ] = None,
    warm_start: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="PLAN", help="Start from a plan, perhaps for another goal or horizon."
        ),
    ] = None,
    starts: Starts = 1,
    seed: Seed = 0,
    kernels: Kernels = True,
    diagnose_seconds: Annotated[
        float,
        typer.Option(metavar="S", help="How long to look for the reason where there is no plan."),
    ] = SECONDS,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Where to write. Default: <scenario>.npz in this folder."),
    ] = None,
    overwrite: Overwrite = False,
    full: Full = False,
    as_json: AsJson = False,
) -> None:
    """Plan a motion, show its certificate, write it to a file.

    Exit status: 0 solved and certified, 1 not solved or not certified (what was found is still written,
    marked), 2 wrong input.
    """
    asked = scenario_with(scenario, settings, profile)
    if out is not None:
        check_writable(out)
    target = npz_path(out or f"{Path(scenario).stem}.npz", "out")
    check_writable(target)
    refuse_other_plan(target, asked, overwrite)
    from rollgait.plan.plan import Plan

    earlier = None if warm_start is None else Plan.load(warm_start)
    from rollgait.planner import plan as make_plan  # loads CasADi: only once the input is known to be right

    try:
        with SolverLine(quiet=as_json) as progress:
            found = make_plan(
                asked,
                transcription=transcription,
                solver=solver,
                warm_start=earlier,
                multistart=starts,
                seed=seed,
                kernels=kernels,
                diagnose_seconds=diagnose_seconds,
                progress=progress,
            )
    except NotSolvedError as error:
        _keep_iterate(error, target, as_json)
        raise
    certificate = found.certificate()
    note_replacing(target)
    found.save(target)
    diagnosis = _why_no_goal(asked, certificate, kernels, diagnose_seconds, as_json)
    if as_json:
        report = {"file": str(target), "solved": found.solved, "certified": certificate.passed}
        report |= {"statistics": asdict(found.statistics), "certificate": certificate.to_dict()}
        report["diagnosis"] = None if diagnosis is None else diagnosis.to_dict()
        print_json(report)
    else:
        print_plan(found, Path(scenario).stem)
        print_certificate(certificate, full)
        if diagnosis is not None:
            print(f"\nwhy the goal is missed\n{diagnosis}")
        mark = "" if certificate.passed else "  (not certified)"
        print(f"\nwritten: {target}{mark}")
        print(f"next:    rollgait plot {target}")
    if not (found.solved and certificate.passed):
        raise typer.Exit(1)


def _why_no_goal(
    scenario: Scenario, certificate: Certificate, kernels: bool, seconds: float, quiet: bool
) -> Diagnosis | None:
    """Why a plan does not get to its goal; None if it does."""
    if not any(row.name in ("goal_distance", "goal_yaw") for row in certificate.failures):
        return None
    from rollgait.diagnosis.entry import diagnose

    with SolverLine(quiet) as progress:
        return diagnose(scenario, kernels=kernels, progress=progress, seconds=seconds)


def _keep_iterate(error: NotSolvedError, target: Path, as_json: bool) -> None:
    """Saves the solver's last iterate beside the place of the plan, and says so."""
    iterate: Plan | None = error.plan
    beside = None if iterate is None else iterate.save(target.with_name(f"{target.stem}.failed.npz"))
    if as_json:
        statistics = None if iterate is None else asdict(iterate.statistics)
        file = None if beside is None else str(beside)
        report = {"file": file, "solved": False, "certified": False, "message": str(error)}
        diagnosis = None if error.diagnosis is None else error.diagnosis.to_dict()
        print_json(report | {"statistics": statistics, "diagnosis": diagnosis})
    elif beside is not None:
        print(
            f"last iterate: {beside}  (not a plan; 'rollgait check' and 'rollgait plot' show what went wrong)"
        )
