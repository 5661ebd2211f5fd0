"""Summaries of plans and certificates for people."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rollgait.cli.output import number, print_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rollgait.plan.certificate import Certificate
    from rollgait.plan.phase_worth import PhaseWorth
    from rollgait.plan.plan import Plan, Statistics

NEAREST = 5
"""Rows of a certificate that pass and are shown nevertheless: where the motion comes nearest to a limit."""


def print_plan(plan: Plan, name: str) -> None:
    """What was planned, how long it took, and what it costs, term by term."""
    s = plan.statistics
    steps = sum(1 for _ in plan.schedule.swings())
    what = f"{plan.robot.name}, {plan.horizon:g} s, {steps} steps, profile {plan.scenario.profile}"
    print(f"{name}: {what}\n")
    parts = ", ".join(f"{name} {seconds:.2f}" for name, seconds in s.seconds.items() if seconds >= 0.005)
    times = f"{s.wall_time:.2f} s: {parts}"
    size = f"{s.variables} variables, {s.constraints} constraints"
    print_table(
        [
            ("result", f"{'solved' if s.solved else 'not solved'} ({s.status}), {_effort(s)}"),
            ("time", times),
            ("problem", f"{s.transcription}, {s.solver}: {size}"),
        ]
    )
    if s.discovery:
        _print_discovery(plan)
    if len(s.starts) > 1:
        _print_starts(s)
    print("\ncost")
    costs = [(term, number(cost, 4)) for term, cost in s.costs.items()]
    print_table([*costs, ("total", number(s.cost, 4))], right=[1])


def _print_discovery(plan: Plan) -> None:
    """Which gaits were tried, and the steps that were found."""
    from rollgait.robot.robot import LEG_NAMES  # here: help does without

    print("\ngaits tried")
    tried = [(r.name, f"{r.horizon:g} s", str(r.steps), r.outcome) for r in plan.statistics.discovery]
    print_table([("gait", "time", "steps", ""), *tried], right=[1, 2])
    times = plan.schedule.node_times
    swings = sorted(plan.schedule.swings(), key=lambda swing: swing.lift_off)
    if not swings:
        print("\nsteps found: none, it drives")
        return
    print("\nsteps found")
    begin, end = (
        plan.sample(times[[getattr(s, node) for s in swings]]) for node in ("lift_off", "touch_down")
    )
    rows: list[tuple[str, ...]] = [("foot", "from", "to", "leaves x, y, z", "lands x, y, z")]
    for k, swing in enumerate(swings):
        places = [", ".join(f"{c:.2f}" for c in at.foot_position[k, swing.leg]) for at in (begin, end)]
        name = LEG_NAMES[swing.leg]
        rows.append((name, f"{times[swing.lift_off]:.2f} s", f"{times[swing.touch_down]:.2f} s", *places))
    print_table(rows, right=[1, 2])


def _effort(statistics: Statistics) -> str:
    """Iterations, and rounds where the ground was looked up again."""
    text = f"{statistics.iterations} iterations"
    rounds = statistics.ground_rounds
    return text if rounds == 1 else f"{text} in {rounds} rounds about the ground"


def _print_starts(statistics: Statistics) -> None:
    """What came of each initial guess, and which one this plan is from."""
    print("\nstarts")
    rows = [("from", "cost", "iterations", "time", "")]
    for start in statistics.starts:
        cost = number(start.cost, 6) if start.solved else "not solved"
        chosen = "chosen" if start.name == statistics.start else ""
        rows.append((start.name, cost, str(start.iterations), f"{start.solve_time:.2f} s", chosen))
    print_table(rows, right=[1, 2, 3])


def print_certificate(certificate: Certificate, full: bool = False) -> None:
    """The verdict, the rows that fail, and those nearest to their limits; `full` shows all rows."""
    count, failures = len(certificate.rows), certificate.failures
    shown = certificate.rows if full else (*failures, *certificate.nearest(NEAREST))
    left = count - len(shown)
    which = ", those that fail and those nearest to their limits" if failures else ", nearest to their limits"
    print(f"\ncertificate: {len(shown)} of {count} rows{which if left else ''}")
    rows = [("row", "worst", "limit", "unit", "leg", "time", "verdict")]
    for row in shown:
        when = "" if row.time is None else f"{row.time:.2f} s"
        sign = "≤" if row.sense == "at most" else "≥"
        limit = "" if row.limit is None else f"{sign} {number(row.limit)}"
        rows.append((row.name, number(row.worst), limit, row.unit, row.leg or "", when, row.verdict))
    print_table(rows, right=[1, 5])
    failed = ", ".join(row.name for row in failures)
    more = "; --full shows all rows" if left else ""
    print(f"  not certified: {failed}{more}" if failed else f"  certified{more}")


def print_timing(worth: Sequence[PhaseWorth]) -> None:
    """What a tenth of a second more would change of the cost, phase by phase."""
    from rollgait.robot.robot import LEG_NAMES  # here: help does without

    print("\ntiming: cost of 0.1 s more (all that comes later moves on)")
    rows = [("phase", "from", "to", "cost")]
    for phase in worth:
        what = "+".join(LEG_NAMES[leg] for leg in phase.swings)
        name = f"swing of {what}" if what else "stance"
        cost = f"{0.1 * phase.cost_per_second:+.2f}"
        rows.append((name, f"{phase.begin:.2f} s", f"{phase.end:.2f} s", cost))
    print_table(rows, right=[1, 2, 3])
