"""`rollgait check`: the certificate of a plan."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from rollgait.cli.arguments import AsJson, Full, PlanFile
from rollgait.cli.output import print_json
from rollgait.cli.report import print_certificate, print_timing

if TYPE_CHECKING:
    from rollgait.plan.phase_worth import PhaseWorth

Timing = Annotated[bool, typer.Option("--timing", help="Also say what more time for each phase would save.")]


def check(plan_file: PlanFile, full: Full = False, timing: Timing = False, as_json: AsJson = False) -> None:
    """Show the certificate of a plan.

    It is computed by code that shares nothing with the planner.

    Exit status: 0 only if the solver converged and every row passes, 1 otherwise, 2 if the file is no plan.
    """
    from rollgait.plan.plan import Plan

    plan = Plan.load(plan_file)
    certificate = plan.certificate()
    worth: tuple[PhaseWorth, ...] = ()
    if timing:
        from rollgait.timing.worth import timing_gradient  # here: a certificate needs no solver

        worth = timing_gradient(plan)
    if as_json:
        report = {"file": str(plan_file), "solved": plan.solved, "certified": certificate.passed}
        told = {"timing": [asdict(phase) for phase in worth]} if timing else {}
        print_json(report | {"certificate": certificate.to_dict()} | told)
    else:
        s = plan.statistics
        print(f"{plan_file}: {'solved' if plan.solved else 'not solved'} ({s.status})")
        print_certificate(certificate, full)
        if timing:
            print_timing(worth)
    if not (plan.solved and certificate.passed):
        raise typer.Exit(1)
