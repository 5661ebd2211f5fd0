"""What a user says of a data set: families of scenarios, and how their values are distributed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from statistics import NormalDist
from typing import Annotated, Any, Final, Self

import numpy as np
from pydantic import Field, model_validator

from rollgait.config import (
    Config,
    Count,
    Flag,
    NonNegative,
    Number,
    Positive,
    Range,
    Seed,
    load_yaml,
    validate,
)
from rollgait.errors import InputError

KINDS: Final = ("uniform", "normal", "choice", "list", "grid")
"""How a value may be distributed; each is a key of `Distribution`."""
DECIMALS: Final = 9
"""Drawn numbers are rounded to so many, as the last bit of a logarithm differs between machines."""


Values = Annotated[tuple[Any, ...], Field(min_length=1)]


class Distribution(Config):
    """Of one value of a scenario: exactly one of `uniform`, `normal`, `choice`, `list` and `grid`."""

    uniform: Range | None = None
    """[smallest, largest]: any number in between, equally likely."""
    normal: tuple[Number, NonNegative] | None = None
    """[mean, standard deviation]."""
    within: Range | None = None
    """With `normal`: [smallest, largest]; the rest of the bell is cut off."""
    choice: Values | None = None
    """One of these at random: numbers, names, or mappings."""
    weights: tuple[Positive, ...] | None = None
    """With `choice`: how likely each is, in any unit. Default: all alike."""
    list: Values | None = None
    """One after the other, from row to row of the family, then again from the first."""
    grid: Values | None = None
    """Every combination with the other grids of the family, one per row, then again from the first."""

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        said = [name for name in KINDS if getattr(self, name) is not None]
        if len(said) != 1:
            given = " and ".join(said) or "none"
            raise ValueError(f"must have exactly one of {', '.join(KINDS)}, not {given}")
        for name, kind in (("within", "normal"), ("weights", "choice")):
            if getattr(self, name) is not None and said != [kind]:
                raise ValueError(f"must not have {name!r} with {said[0]!r}: it belongs to {kind!r}")
        if self.weights is not None and self.choice is not None and len(self.weights) != len(self.choice):
            raise ValueError(f"must have {len(self.choice)} weights, one for each choice")
        if self.normal is not None and self.within is not None and self._share_within() <= 0.0:
            raise ValueError("must have a bell that reaches into 'within'")
        return self

    @property
    def values(self) -> tuple[Any, ...]:
        """All that it can be; none for ranges of numbers."""
        return self.choice or self.list or self.grid or ()

    @property
    def is_numeric(self) -> bool:
        """Whether all of its values are numbers."""
        return all(isinstance(v, int | float) and not isinstance(v, bool) for v in self.values)

    def with_values(self, values: tuple[Any, ...]) -> Distribution:
        """The same distribution of other values, as many as `self.values`."""
        name = next(name for name in ("choice", "list", "grid") if getattr(self, name) is not None)
        return self.model_copy(update={name: values})

    def at(self, share: float, place: int) -> Any:
        """A value.

        Args:
            share: of the probability that lies below it, in [0, 1): a uniform random number.
            place: for `list` and `grid`, which value; taken modulo their length.
        """
        if self.uniform is not None:
            low, high = self.uniform
            return round(low + (high - low) * share, DECIMALS)
        if self.normal is not None:
            return round(self._of_bell(share), DECIMALS)
        if self.choice is not None:
            weights = self.weights or (1.0,) * len(self.choice)
            left = share * math.fsum(weights)
            for value, weight in zip(self.choice, weights, strict=True):
                left -= weight
                if left < 0.0:
                    return value
            return self.choice[-1]
        return self.values[place % len(self.values)]

    def _of_bell(self, share: float) -> float:
        mean, deviation = self.normal or (0.0, 0.0)
        if deviation == 0.0:
            return mean
        low, high = self.within or (-math.inf, math.inf)
        below = NormalDist(mean, deviation).cdf(low) if math.isfinite(low) else 0.0
        inside = below + share * self._share_within()
        inside = min(max(inside, 2.0**-53), 1.0 - 2.0**-53)  # the ends are at infinity
        return min(max(NormalDist(mean, deviation).inv_cdf(inside), low), high)

    def _share_within(self) -> float:
        """Share of the bell that lies within `within`."""
        mean, deviation = self.normal or (0.0, 0.0)
        if self.within is None:
            return 1.0
        if deviation == 0.0:
            return float(self.within[0] <= mean <= self.within[1])
        bell = NormalDist(mean, deviation)
        return bell.cdf(self.within[1]) - bell.cdf(self.within[0])


class Family(Config):
    """Scenarios that are alike: a base, and what varies about it."""

    base: str | dict[str, Any]
    """Name of a scenario of the library, a YAML file beside the spec, or a scenario spelled out."""
    share: Count = 1
    """Rows of this family in each round through all families: 2 and 1 are two thirds and one third."""
    vary: dict[str, Distribution] = Field(default_factory=dict)
    """Dotted keys of the scenario, as `--set` takes them, and their distributions."""


class Spec(Config):
    """A data set: what to plan, how much of it, and from which seed."""

    description: str = ""
    """One line for people."""
    count: Count
    """Number of rows. It may be raised later: the first rows stay as they are."""
    seed: Seed = 0
    """Row i depends on the seed and on i, and on nothing else."""
    families: dict[str, Family] = Field(min_length=1)
    """Families by name; rows take turns by their shares."""
    vary: dict[str, Distribution] = Field(default_factory=dict)
    """What varies in all families; a family's own distribution of a key goes before it."""
    starts: Count = 1
    """Initial guesses that are solved for each plan, to take the cheapest result."""
    diagnose: Flag = False
    """Whether to look for the reason where there is no plan, up to 10 s each."""

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Spec:
        """The spec in a mapping. Raises `InputError`."""
        return validate(cls, data)

    @classmethod
    def from_yaml(cls, path: str | Path) -> Spec:
        """The spec in a YAML file. Raises `FileError` or `InputError`."""
        return cls.from_dict(load_yaml(Path(path)))

    def distributions(self, family: str) -> dict[str, Distribution]:
        """All that varies in a family, outer keys before those within them (`robot`, then `robot.mass`)."""
        merged = self.vary | self.families[family].vary
        return {key: merged[key] for key in sorted(merged, key=lambda key: (key.count("."), key))}

    def require_row(self, row: Any) -> int:
        """A row that there is. Raises `InputError` for others."""
        if isinstance(row, int | np.integer) and row is not True and 0 <= row < self.count:
            return int(row)
        raise InputError("row", row, f"must be a whole number from 0 to {self.count - 1}")
