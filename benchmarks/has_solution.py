"""Does a scenario of `random_scenarios.py` have a certified plan at all, by whatever way?

    python benchmarks/has_solution.py NUMBER [NUMBER …] [--seed 0] [--starts 8]

Each is planned at half its interval by condensed and collocation, fatrop and IPOPT, from several starts; it
has a solution if any of these gives a plan that the certificate accepts. Takes minutes each. Prints Markdown.
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
        half = scenario.with_values({"interval": 0.5 * scenario.interval})
        results = []
        for transcription, solver in WAYS:
            results.append(found(half, transcription, solver, options.starts))
            if results[-1] == "certified":
                break
        rows.append((number, *results, *[""] * (len(WAYS) - len(results))))
        print(rows[-1], flush=True)
    print(f"{machine()}; load {load()}.\n")
    print(table(("scenario", *(" + ".join(way) for way in WAYS)), rows))


if __name__ == "__main__":
    main()
