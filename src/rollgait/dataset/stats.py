"""What came of a data set, in figures and in one picture."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dataset.columns import CERTIFIED, STATUSES
from rollgait.dataset.reading import Reader
from rollgait.files import replacing

PERCENTILES: Final = (5, 50, 95, 100)
REASONS: Final = 10
"""Most frequent reasons that are told."""
TIGHT: Final = 12
"""Rows of the certificate that are told: those that come nearest to their limits."""
REASON_LENGTH: Final = 100
"""Beginning of a reason by which it is counted, characters: numbers that follow differ from row to row."""


@dataclass(frozen=True)
class Stats:
    """What came of the rows.

    Attributes:
        asked: rows that the spec asks for.
        there: rows that are there.
        statuses: number of rows by status.
        families: the same for each family.
        figures: percentiles (`PERCENTILES`) of cost, seconds, iterations and horizon of certified rows.
        tight: of certified rows, by the row of the certificate: median and largest nearness to its limit (1
            is at it).
        reasons: why there is no certified plan, and how often, the most frequent first.
        bytes_per_row: size of all files over the number of rows.
    """

    asked: int
    there: int
    statuses: dict[str, int]
    families: dict[str, dict[str, int]]
    figures: dict[str, dict[str, float]]
    tight: dict[str, tuple[float, float]]
    reasons: dict[str, int]
    bytes_per_row: float

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return asdict(self)

    @classmethod
    def of(cls, dataset: Reader) -> Stats:
        """Of all rows that are there."""
        names = ["family", "status", "reason", "cost", "seconds", "iterations", "horizon"]
        table = dataset.table(names).to_pydict()
        status, family = table["status"], table["family"]
        good = [k for k, one in enumerate(status) if one == CERTIFIED]
        figures = {}
        for name in names[3:]:
            if values := [table[name][k] for k in good]:
                at = np.percentile(np.array(values, dtype=float), PERCENTILES)
                figures[name] = {f"p{p}": float(v) for p, v in zip(PERCENTILES, at, strict=True)}
        pairs = Counter(zip(family, status, strict=True))
        families = {
            name: {one: pairs[name, one] for one in STATUSES if pairs[name, one]}
            for name in dataset.spec.families
        }
        counted = Counter(status)
        reasons = Counter(
            f"{one}: {why[:REASON_LENGTH]}"
            for one, why in zip(status, table["reason"], strict=True)
            if one != CERTIFIED
        )
        return cls(
            asked=dataset.spec.count,
            there=len(status),
            statuses={one: counted[one] for one in STATUSES if counted[one]},
            families=families,
            figures=figures,
            tight=_tight(dataset),
            reasons=dict(reasons.most_common(REASONS)),
            bytes_per_row=dataset.size / len(status) if status else 0.0,
        )


def _tight(dataset: Reader) -> dict[str, tuple[float, float]]:
    """Rows of certificates that come nearest to their limits: median and largest nearness."""
    from rollgait.plan.certificate.rows import nearness

    found: dict[str, list[float]] = {}
    for table in dataset.pieces(["status", "certificate"]):
        for status, rows in zip(table["status"].to_pylist(), table["certificate"].to_pylist(), strict=True):
            for row in rows if status == CERTIFIED else ():
                if row["verdict"] == "pass":
                    near = nearness(row["worst"], row["limit"], row["sense"] == "at least")
                    found.setdefault(row["name"], []).append(near)
    both = {name: (float(np.median(values)), max(values)) for name, values in found.items()}
    return dict(sorted(both.items(), key=lambda item: -item[1][1])[:TIGHT])


def draw(dataset: Reader, path: str | Path) -> Path:
    """Draws goals by verdict, costs, times and margins into one picture; returns its path."""
    import matplotlib

    from rollgait.view.style import BASE_COLOUR, LEG_COLOURS, MARK_COLOUR, SECOND_COLOUR

    matplotlib.use("Agg", force=False)
    from matplotlib.figure import Figure

    names = ["status", "family", "goal", "cost", "seconds"]
    table = dataset.table(names).to_pydict()
    status = np.array(table["status"], dtype=str)
    good = status == CERTIFIED
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    (goals, costs), (times, margins) = figure.subplots(2, 2)
    _draw_goals(goals, table, (LEG_COLOURS[0], MARK_COLOUR))
    for axes, name, unit in ((costs, "cost", ""), (times, "seconds", ", s")):
        for family in dataset.spec.families:
            mine = [
                value
                for value, one, ok in zip(table[name], table["family"], good, strict=True)
                if ok and one == family
            ]
            if mine:
                axes.hist(np.array(mine), bins=_bins(np.array(mine)), alpha=0.6, label=family)
        axes.set_xlabel({"cost": "cost of certified plans", "seconds": "time of a plan"}[name] + unit)
        axes.set_ylabel("plans")
        if good.any():
            axes.legend(frameon=False)
    tight = list(Stats.of(dataset).tight.items())[::-1]
    margins.barh(
        [name for name, _ in tight], [most for _, (_, most) in tight], color=SECOND_COLOUR, label="largest"
    )
    margins.barh(
        [name for name, _ in tight], [mid for _, (mid, _) in tight], color=BASE_COLOUR, label="median"
    )
    margins.axvline(1.0, color=MARK_COLOUR, linewidth=1.0)
    margins.set_xlabel("nearness to the limit (1: at it), certified plans")
    if tight:
        margins.legend(frameon=False, loc="lower left")
    figure.suptitle(f"{dataset.folder.name}: {good.sum()} certified of {len(status)}")
    target = Path(path)
    with replacing(target) as temporary:
        figure.savefig(temporary, dpi=110)
    return target


def _draw_goals(axes: Any, table: dict[str, Any], colours: tuple[str, str]) -> None:
    """Where certified plans go, and those that are not; rows without a plan have no goal here."""
    for wanted, colour, marker in ((True, colours[0], "."), (False, colours[1], "x")):
        xy = [
            goal[:2]
            for goal, status in zip(table["goal"], table["status"], strict=True)
            if goal is not None and (status == CERTIFIED) == wanted
        ]
        if xy:
            label = "certified" if wanted else "not certified"
            axes.plot(*np.array(xy).T, marker, color=colour, label=label, alpha=0.7)
    axes.set(xlabel="goal x, m", ylabel="goal y, m")
    axes.set_aspect("equal", adjustable="datalim")
    if axes.lines:
        axes.legend(frameon=False)


def _bins(values: NDArray[np.float64]) -> int:
    return int(np.clip(np.sqrt(len(values)) * 2.0, 5, 60))
