"""What a diagnosis says."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Final

OPTIONS: Final = {"multistart": "starts"}
"""Options of `rollgait plan` by their names as arguments of `rollgait.plan`."""


@dataclass(frozen=True)
class Reason:
    """A constraint that stands in the way.

    Attributes:
        term: name of the constraint's term.
        description: what would have to happen, in words.
        leg: FL, FR, HL or HR; None for the robot as a whole.
        begin, end: time span in which it is missed, s.
        excess: by how much it would have to be missed at least, at its worst.
        unit: of the excess.
    """

    term: str
    description: str
    leg: str | None
    begin: float
    end: float
    excess: float
    unit: str


@dataclass(frozen=True)
class Suggestion:
    """A change of the scenario.

    Attributes:
        change: values by dotted key, as `Scenario.with_values` takes them.
        text: the change in words.
        verified: whether the changed scenario was solved.
        arguments: of `rollgait.plan`, where it is planned another way; `multistart`, the number of starts.
    """

    change: dict[str, Any]
    text: str
    verified: bool
    arguments: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Diagnosis:
    """Why a scenario cannot be solved.

    Attributes:
        reasons: the smallest set of constraints that was found to stand in the way, the worst first; empty
            if the constraints do not contradict each other.
        suggestions: single changes, each of which makes the scenario solvable; if none was found, next steps
            that there was no time to try: they are not `verified`.
        failed: what was tried and does not help, in words.
        complete: whether the search came to its end before its budget did.
    """

    reasons: tuple[Reason, ...] = ()
    suggestions: tuple[Suggestion, ...] = ()
    failed: tuple[str, ...] = ()
    complete: bool = True

    def to_dict(self) -> dict[str, Any]:
        """The diagnosis as plain data."""
        return asdict(self)

    def __str__(self) -> str:
        lines = ["in the way:"] if self.reasons else ["no constraint is in the way: a motion keeps them all"]
        lines += _aligned([_cells(reason) for reason in self.reasons])
        if self.suggestions:
            lines.append("any one of these makes it solvable:" if self._any_verified else "worth a try:")
            lines += _aligned([(s.text, _settings(s)) for s in self.suggestions])
        elif self.reasons:
            lines.append("no single change was found that makes it solvable")
        if self.failed and not self._any_verified:
            lines += ["tried, and does not help:", *(f"  {text}" for text in self.failed)]
        if not self.complete:
            lines.append(
                "the time for looking was up before all was tried: give it more by --diagnose-seconds"
            )
        return "\n".join(lines)

    @property
    def _any_verified(self) -> bool:
        return any(suggestion.verified for suggestion in self.suggestions)


def _cells(reason: Reason) -> tuple[str, ...]:
    span = f"{reason.begin:.2f} s"
    if reason.end > reason.begin:
        span = f"{reason.begin:.2f} – {reason.end:.2f} s"
    amount = f"by {reason.excess:.3g} {reason.unit}".rstrip()
    return reason.term, reason.leg or "", span, amount, reason.description


def _settings(suggestion: Suggestion) -> str:
    settings = [f"--set {key}={_value(value)}" for key, value in suggestion.change.items()]
    options = [f"--{OPTIONS[name]} {value}" for name, value in suggestion.arguments.items()]
    return "  ".join(settings + options)


def _value(value: Any) -> str:
    if isinstance(value, list | tuple):
        return "[" + ",".join(_value(item) for item in value) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Rows in columns, two spaces apart, indented by two."""
    if not rows:
        return []
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
