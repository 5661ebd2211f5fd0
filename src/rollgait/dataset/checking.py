"""Whether a data set is what it says: rows certified anew from nothing but the table, and counted."""

from __future__ import annotations

import json
import math
from collections import Counter
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np

from rollgait.dataset import columns
from rollgait.dataset.reading import Reader
from rollgait.errors import InputError, RollgaitError
from rollgait.plan.certificate import Certificate, certify

TOLERANCE: Final = 1e-6
"""By how much a figure may differ from that in the table, relative to its limit or itself: it is the same sum
on another processor."""


@dataclass(frozen=True)
class Check:
    """What was found.

    Attributes:
        asked: rows that the spec asks for.
        there: rows that are there.
        twice: rows that more than one file of the table holds.
        certified: rows that were certified anew.
        wrong: what differs from the table: a row, and what of it.
    """

    asked: int
    there: int
    twice: tuple[int, ...]
    certified: tuple[int, ...]
    wrong: tuple[tuple[int, str], ...]

    @property
    def passed(self) -> bool:
        """Whether every row is there once and none that was looked at is wrong."""
        return self.there == self.asked and not self.twice and not self.wrong

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {"passed": self.passed, **asdict(self)}

    @classmethod
    def of(cls, dataset: Reader, count: int, seed: int) -> Check:
        """Looks at `count` random rows; raises `InputError` for less than one."""
        if count < 1:
            raise InputError("rows", count, "must be at least 1")
        table = dataset.table(["status"])
        status = dict(zip(table["row"].to_pylist(), table["status"].to_pylist(), strict=True))
        there = sorted(status)
        drawn = np.random.default_rng(seed).permutation(there)[:count]
        wrong = tuple((int(row), why) for row in sorted(drawn) for why in _wrong(dataset, int(row)))
        held = Counter(dataset.held())
        twice = tuple(sorted(row for row, times in held.items() if times > 1))
        return cls(dataset.spec.count, len(there), twice, tuple(sorted(int(r) for r in drawn)), wrong)


def _wrong(dataset: Reader, row: int) -> list[str]:
    """What of a row differs from what the spec asks, and from what its motion is."""
    found = dataset.record(row)
    asked = dataset.sampler.asked(row)
    wrong = []
    for key, value in asked.values.items():
        stored = found[columns.ASKED + key]
        if (json.loads(stored) if isinstance(stored, str) else stored) != _plain(value):
            wrong.append(f"{key} is {stored}, the spec draws {value}")
    if found["scenario"] is None:
        return wrong
    try:
        certificate = certify(dataset.plan(row))
    except RollgaitError as error:
        return [*wrong, str(error)]
    verdict = columns.CERTIFIED if certificate.passed else columns.NOT_CERTIFIED
    if verdict != found["status"]:
        wrong.append(f"is {verdict}, the table says {found['status']}")
    return wrong + _differences(certificate, columns.certificate_of(found))


def _differences(certificate: Certificate, stored: Certificate) -> list[str]:
    names = [row.name for row in certificate.rows]
    if names != [row.name for row in stored.rows]:
        return ["has other rows of the certificate"]
    return [
        f"{one.name} is {one.worst:.9g}, the table says {other.worst:.9g}"
        for one, other in zip(certificate.rows, stored.rows, strict=True)
        if not math.isclose(
            one.worst, other.worst, rel_tol=TOLERANCE, abs_tol=TOLERANCE * abs(one.limit or 1.0)
        )
        and not (math.isnan(one.worst) and math.isnan(other.worst))
    ]


def _plain(value: Any) -> Any:
    """A value as JSON gives it back; numbers in columns are floating."""
    return json.loads(json.dumps(value))
