"""Does a scenario of `random_scenarios.py` have a certified plan at all, by whatever way?

    python benchmarks/has_solution.py NUMBER [NUMBER …] [--seed 0] [--starts 8]

Each is planned at half its interval by condensed and collocation, fatrop and IPOPT, from several starts; it
has a solution if any of these gives a plan that the certificate accepts. Before that it is planned as it is:
a refusal is right if a change that it names gives a certified plan. Takes minutes each. Prints Markdown.
"""

from __future__ import annotations

import argparse
from itertools import islice

import rollgait as rg
from random_scenarios import scenarios
from reporting import load, machine, table

WAYS = (("condensed", "fatrop"), ("condensed", "ipopt"), ("collocation", "ipopt"))
"""Transcription and solver."""


def found(scenario: rg.Scenario, transcription: str, solver: str, starts: int) -> str:
    """What came of it, in a word."""
    try:
        plan = rg.plan(
            scenario, transcription=transcription, solver=solver, multistart=starts, diagnose=False
        )
    except rg.RollgaitError as error:
        return type(error).__name__.removesuffix("Error")
    return "certified" if plan.certificate().passed else "not certified"


def as_it_is(scenario: rg.Scenario) -> tuple[str, str]:
    """What planning it gives, and, of a refusal, the change that it names and what comes of that."""
    try:
        plan = rg.plan(scenario)
    except rg.NotSolvedError as error:
        return "refused", changed(scenario, error.diagnosis)
    failures = plan.certificate().failures
    return ("not certified", failures[0].name) if failures else ("certified", "")


def changed(scenario: rg.Scenario, diagnosis: rg.Diagnosis | None) -> str:
    """The first change of the diagnosis that gives a certified plan, or what comes of the others."""
    said = []
    for suggestion in diagnosis.suggestions if diagnosis else ():
        try:
            other = scenario.with_values(suggestion.change)
            plan = rg.plan(other, diagnose=False, **suggestion.arguments)
        except rg.RollgaitError as error:
            said.append(f"{suggestion.text}: {type(error).__name__.removesuffix('Error')}")
            continue
        if plan.certificate().passed:
            return f"{suggestion.text}: certified"
        said.append(f"{suggestion.text}: not certified")
    return "; ".join(said) or "no change named"


def main() -> None:
    """Looks at each scenario and prints what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("numbers", type=int, nargs="+", help="of the scenarios")
    parser.add_argument("--seed", type=int, default=0, help="of the scenarios (default: 0)")
    parser.add_argument("--starts", type=int, default=8, help="from which each is planned (default: 8)")
    options = parser.parse_args()
    rows = []
    every = enumerate(islice(scenarios(options.seed), max(options.numbers) + 1))
    for number, scenario in every:
        if number not in options.numbers:
            continue
        verdict, named = as_it_is(scenario)
        print(number, verdict, named, flush=True)
        if verdict == "certified" or named.endswith(": certified"):
            rows.append((number, verdict, named, *[""] * len(WAYS)))
            continue
        half = scenario.with_values({"interval": 0.5 * scenario.interval})
        results = []
        for transcription, solver in WAYS:
            results.append(found(half, transcription, solver, options.starts))
            if results[-1] == "certified":
                break
        rows.append((number, verdict, named, *results, *[""] * (len(WAYS) - len(results))))
        print(rows[-1], flush=True)
    print(f"{machine()}; load {load()}.\n")
    print(table(("scenario", "as it is", "change", *(" + ".join(way) for way in WAYS)), rows))


if __name__ == "__main__":
    main()
