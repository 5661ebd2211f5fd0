"""What a certificate says: rows of plain data."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rollgait.errors import UnknownNameError
from rollgait.presented import Shown
from rollgait.robot.robot import LEG_NAMES, LegName

MICROSECONDS = 6
"""Decimals of a row's time in s: samples lie a little inside their interval, which is of no interest here."""

Verdict = Literal["pass", "fail", "not promised"]


@dataclass(frozen=True)
class Row:
    """One thing that was measured.

    Attributes:
        name: short name, unique in a certificate.
        description: what was measured, one line.
        worst: the worst value found, in `unit`.
        limit: what `worst` is compared with; None if the scenario sets no limit.
        unit: unit of `worst` and `limit` ("" for a count).
        leg: the leg where the worst value was found; None if the row is not about legs.
        time: when, s; None if the row is not about a time.
        verdict: "pass", "fail", or "not promised": shown, but it does not count.
        sense: "at most" or "at least": how `worst` must stand to `limit`.
        failing: where it fails: for each interval (or other moment) with a bad value the time of its worst,
            s.
    """

    name: str
    description: str
    worst: float
    limit: float | None
    unit: str
    leg: LegName | None
    time: float | None
    verdict: Verdict
    sense: Literal["at most", "at least"] = "at most"
    failing: tuple[float, ...] = ()

    @property
    def nearness(self) -> float:
        """How near it is to its limit: 1 is at it, 0 far away, more than 1 beyond it; 0 without a limit."""
        return 0.0 if self.limit is None else nearness(self.worst, self.limit, self.sense == "at least")

    def __str__(self) -> str:
        sign = "≤" if self.sense == "at most" else "≥"
        limit = "" if self.limit is None else f"{sign} {self.limit:.4g}"
        where = f"{self.leg or ''}".ljust(2) + ("" if self.time is None else f" {self.time:8.3f} s")
        measure = f"{self.worst:>11.4g} {limit:>10} {self.unit:<6}"
        return f"{self.verdict:<12}  {self.name:<26} {measure} {where}".rstrip()


@dataclass(frozen=True)
class Certificate(Shown):
    """What was measured of a plan, and whether it keeps what it promises.

    Attributes:
        rows: everything that was measured. What the plan has nothing of (swings, joints) has no row.
    """

    rows: tuple[Row, ...]

    @property
    def passed(self) -> bool:
        """Whether no row fails. Rows that are "not promised" do not count."""
        return not self.failures

    @property
    def failures(self) -> tuple[Row, ...]:
        """The rows that fail."""
        return tuple(row for row in self.rows if row.verdict == "fail")

    def nearest(self, count: int) -> tuple[Row, ...]:
        """Of the rows that pass those nearest to their limits, the nearest first, at most `count`."""
        passing = [row for row in self.rows if row.verdict == "pass"]
        return tuple(sorted(passing, key=lambda row: row.nearness, reverse=True)[:count])

    def row(self, name: str) -> Row:
        """The row of this name. Raises `UnknownNameError`."""
        for row in self.rows:
            if row.name == name:
                return row
        raise UnknownNameError(
            "row", name, [row.name for row in self.rows], "is not a row of this certificate"
        )

    def __repr__(self) -> str:
        failed = ", ".join(row.name for row in self.failures)
        return f"<Certificate: {len(self.rows)} rows, {f'not passed: {failed}' if failed else 'passed'}>"

    def to_pandas(self) -> Any:
        """The rows as a `pandas.DataFrame` by their names. Raises `MissingExtraError` without pandas."""
        return import_module("rollgait.export.tables").rows_frame(self)

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; a number that is not finite becomes None."""
        rows = [{key: _plain(value) for key, value in asdict(row).items()} for row in self.rows]
        return {"passed": self.passed, "rows": rows}

    def __str__(self) -> str:
        return "\n".join(str(row) for row in self.rows)


def nearness(worst: float, limit: float, at_least: bool) -> float:
    """How near a value is to its limit: 1 is at it, 0 far away, more than 1 beyond it."""
    if not math.isfinite(worst):
        return math.inf
    if at_least and limit > 0.0:
        return math.inf if worst <= 0.0 else limit / worst
    if at_least:
        worst, limit = -worst, -limit
    if limit <= 0.0:
        return math.inf if worst > limit else 0.0
    return max(0.0, worst / limit)


def measured(
    name: str,
    description: str,
    unit: str,
    values: NDArray[np.float64],
    limit: float | None,
    time: NDArray[np.float64],
    *,
    where: NDArray[np.bool_] | bool = True,
    at_least: bool = False,
    promised: bool = True,
) -> Iterator[Row]:
    """The row of the worst of many values; no row if there are none.

    Args:
        name: see `Row`, as are `description` and `unit`.
        values: measured values, with the shape of `time`, or one axis of length 4 more: the legs.
        limit: what every value must keep; None: nothing is promised.
        time: when each value holds, s.
        where: which values count; broadcast to the shape of `values`.
        at_least: whether the limit is the smallest allowed value instead of the largest.
        promised: whether the scenario promises it.
    """
    mask = np.broadcast_to(where, values.shape)
    if not mask.any():
        return
    badness = np.where(mask, -values if at_least else values, -np.inf)
    badness = np.where(mask & np.isnan(values), np.inf, badness)
    place = np.unravel_index(int(np.argmax(badness)), values.shape)
    has_legs = values.ndim > time.ndim
    worst = float(values[place])
    verdict = _verdict(worst, limit, at_least, promised)
    yield Row(
        name=name,
        description=description,
        worst=worst,
        limit=limit,
        unit=unit,
        leg=LEG_NAMES[int(place[-1])] if has_legs else None,
        time=round(float(time[place[:-1] if has_legs else place]), MICROSECONDS),
        verdict=verdict,
        sense="at least" if at_least else "at most",
        failing=_failing(badness, -limit if at_least else limit, time)
        if verdict == "fail" and limit is not None
        else (),
    )


def _failing(badness: NDArray[np.float64], limit: float, time: NDArray[np.float64]) -> tuple[float, ...]:
    """Times of the worst value of each entry of the first axis in which one exceeds the limit."""
    flat, times = badness.reshape(len(badness), -1), time.reshape(len(time), -1)
    per_time = flat.shape[1] // times.shape[1]  # legs, if there are any
    worst = flat.argmax(axis=1)
    found = times[np.arange(len(flat)), worst // per_time]
    return tuple(np.round(found[flat.max(axis=1) > limit], MICROSECONDS).tolist())


def _verdict(worst: float, limit: float | None, at_least: bool, promised: bool) -> Verdict:
    if limit is None or not promised:
        return "not promised"
    return "pass" if (worst >= limit if at_least else worst <= limit) else "fail"


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not np.isfinite(value) else value
