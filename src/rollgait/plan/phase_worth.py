"""What more time for a phase of a plan is worth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PhaseWorth:
    """What more time for a phase would change.

    Attributes:
        begin, end: of the phase, s.
        swings: which feet swing, 0 … 3.
        cost_per_second: dJ/dT; all that comes later moves on by as much, goals that switch among it.
    """

    begin: float
    end: float
    swings: tuple[int, ...]
    cost_per_second: float
