"""Row i of a data set, from the seed and i alone: no state, no foreign random numbers, the same everywhere.

Each value has a random number of its own, a hash of seed, row and key. So a further key, family or row leaves
the others as they are, and a worker needs no other row.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import blake2b
from itertools import accumulate
from pathlib import Path
from typing import Any, Final, Self

from rollgait.config import set_key, validate
from rollgait.dataset.spec import Distribution, Spec
from rollgait.errors import InputError
from rollgait.robot.library import find_robot
from rollgait.scenario.library import find_scenario
from rollgait.scenario.scenario import Scenario
from rollgait.terrain.ground import Ground
from rollgait.terrain.height_map import HeightMap

BITS: Final = 53
"""Of a hash that make a number: what a double holds."""
FILES: Final = (".yaml", ".yml")
LOOKED_AT: Final = 20
"""Rows of each family, the first, that are looked at before any is planned."""


@dataclass(frozen=True)
class Asked:
    """What is asked in a row: the family's base, with these values."""

    row: int
    family: str
    values: Mapping[str, Any]

    @property
    def kind(self) -> str:
        """What the compiled problem may depend on: the family, and all values that are no numbers."""
        plain = {
            k: v for k, v in self.values.items() if isinstance(v, bool) or not isinstance(v, int | float)
        }
        return json.dumps([self.family, plain], sort_keys=True)


def share_of(seed: int, row: int, key: str) -> float:
    """A uniform random number in [0, 1), by nothing but these three."""
    digest = blake2b(f"{seed}/{row}/{key}".encode(), digest_size=8).digest()
    return float((int.from_bytes(digest, "big") >> (64 - BITS)) * 2.0**-BITS)


@dataclass(frozen=True)
class Sampler:
    """A spec with all that its names and files mean: needs no other file, can be sent to a worker.

    Attributes:
        spec: as the user wrote it, but for robots and maps in files, which are spelled out.
        bases: base of each family as plain data.
        maps: heights of all maps, by their digests.
    """

    spec: Spec
    bases: Mapping[str, dict[str, Any]]
    maps: Mapping[str, HeightMap] = field(default_factory=dict)

    @classmethod
    def of(cls, spec: Spec, folder: Path = Path()) -> Self:
        """The sampler of a spec.

        Args:
            spec: the spec.
            folder: where files that it names lie.

        Raises:
            InputError: a base, a robot or a map is not to be had.
        """
        maps: dict[str, HeightMap] = {}
        bases = {}
        for name, family in spec.families.items():
            base = _in_place(f"families.{name}.base", family.base, folder)
            ground = base.ground.self_contained()
            if ground.heights is not None:
                maps[ground.heights.digest] = ground.heights
            bases[name] = {
                **base.to_dict(),
                "robot": _robot(base.to_dict()["robot"], folder),
                "ground": ground.model_dump(mode="json"),
            }
            if "horizon" not in base.model_fields_set:
                del bases[name]["horizon"]

        def prepared(vary: Mapping[str, Distribution]) -> dict[str, Distribution]:
            return {key: _prepared(key, one, folder, maps) for key, one in vary.items()}

        families = {
            name: family.model_copy(update={"vary": prepared(family.vary)})
            for name, family in spec.families.items()
        }
        spelled = spec.model_copy(update={"families": families, "vary": prepared(spec.vary)})
        return cls(spelled, bases, maps)

    def asked(self, row: int) -> Asked:
        """What is asked in a row. Raises `InputError` if there is no such row."""
        spec = self.spec
        spec.require_row(row)
        ends = list(accumulate(family.share for family in spec.families.values()))
        turn, place = divmod(row, ends[-1])
        number = bisect_right(ends, place)
        name, family = list(spec.families.items())[number]
        rank = turn * family.share + place - (ends[number] - family.share)  # among the rows of its family
        values, rest = {}, rank
        for key, one in spec.distributions(name).items():
            place = rank
            if one.grid is not None:
                rest, place = divmod(rest, len(one.grid))
            values[key] = one.at(share_of(spec.seed, row, key), place)
        return Asked(row, name, values)

    def scenario(self, asked: Asked) -> Scenario:
        """The scenario of a row. Raises `InputError` if it contradicts itself."""
        data = _copy(self.bases[asked.family])
        for key, value in asked.values.items():
            if key == "gait" and isinstance(value, str):
                value = {"kind": value}
            if key.startswith("robot.") and isinstance(data["robot"], str):
                data["robot"] = find_robot(data["robot"]).model_dump(mode="json")
            set_key(data, key, _copy(value))
        keys = data.get("ground", {}).get("map") if isinstance(data.get("ground"), dict) else None
        heights = self.maps.get(keys.get("digest")) if keys else None
        return Scenario.from_dict(data, heights=heights)

    def require_sense(self) -> None:
        """Raises `InputError` if the first rows of a family, `LOOKED_AT` of them, are all refused.

        Some may be: goals out of reach, gaits that do not fit. All are by a slip, as a key that there is not.
        """
        ends = list(accumulate(family.share for family in self.spec.families.values()))
        for end, (name, family) in zip(ends, self.spec.families.items(), strict=True):
            turns = (divmod(rank, family.share) for rank in range(LOOKED_AT))
            rows = [turn * ends[-1] + end - family.share + place for turn, place in turns]
            first: InputError | None = None
            for row in (row for row in rows if row < self.spec.count):
                try:
                    self.scenario(self.asked(row))
                    break
                except InputError as error:
                    first = first or error
            else:
                if first is not None:
                    rule = f"{first.rule}, and so in all rows of this family that were looked at"
                    varies = "vary." if first.field in self.spec.distributions(name) else ""
                    raise InputError(
                        f"families.{name}.{varies}{first.field}", first.value, rule, first.choices
                    )

    # -- as plain data --

    def to_dict(self) -> dict[str, Any]:
        """All but the heights of maps, as plain data."""
        return {"spec": self.spec.model_dump(mode="json"), "bases": dict(self.bases)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], maps: Mapping[str, HeightMap]) -> Self:
        """The inverse of `to_dict`. Raises `InputError`."""
        return cls(validate(Spec, data["spec"]), data["bases"], maps)


def _in_place(field: str, base: str | dict[str, Any], folder: Path) -> Scenario:
    """The base of a family. Raises `InputError`, which names the field."""
    try:
        if isinstance(base, dict):
            return Scenario.from_dict(base, folder)
        return find_scenario(str(folder / base) if base.endswith(FILES) else base)
    except InputError as error:
        raise InputError(f"{field}.{error.field}", error.value, error.rule, error.choices) from None


def _prepared(key: str, one: Distribution, folder: Path, maps: dict[str, HeightMap]) -> Distribution:
    """The same distribution with files of robots and maps read."""
    if key == "robot" and one.values:
        return one.with_values(tuple(_robot(value, folder) for value in one.values))
    if key == "ground" and one.values:
        return one.with_values(tuple(_ground(value, folder, maps) for value in one.values))
    return one


def _robot(value: Any, folder: Path) -> Any:
    if isinstance(value, str) and value.endswith(FILES):
        beside = folder / value
        return find_robot(str(beside if beside.exists() else value)).model_dump(mode="json")
    return value


def _ground(value: Any, folder: Path, maps: dict[str, HeightMap]) -> Any:
    if not isinstance(value, Mapping) or value.get("map") is None:
        return value
    ground = validate(Ground, value, "ground").read(folder).self_contained()
    if ground.heights is not None:
        maps[ground.heights.digest] = ground.heights
    return ground.model_dump(mode="json")


def _copy(value: Any) -> Any:
    """A copy of plain data, that can be changed."""
    if isinstance(value, Mapping):
        return {key: _copy(one) for key, one in value.items()}
    return [_copy(one) for one in value] if isinstance(value, list | tuple) else value
