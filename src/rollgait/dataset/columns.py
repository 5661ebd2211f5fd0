"""The columns of the table, and what stands between them and a plan: a row is one, or why there is none."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, replace
from importlib import import_module
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.dataset.sampler import Asked, Sampler
from rollgait.errors import InputError, MissingExtraError
from rollgait.npz import KINDS
from rollgait.plan.certificate import Certificate, Row
from rollgait.plan.plan import Plan
from rollgait.plan.trajectory import Trajectory
from rollgait.terrain.height_map import HeightMap

EXTRA: Final = "dataset"
FORMAT_VERSION: Final = 1
"""Version of the table; a data set with another one is refused."""

CERTIFIED: Final = "certified"
NOT_CERTIFIED: Final = "not certified"
NOT_SOLVED: Final = "not solved"
REFUSED: Final = "refused"
FAULTY: Final = "faulty"
DIED: Final = "died"
STATUSES: Final = {
    CERTIFIED: "there is a plan and its certificate passes",
    NOT_CERTIFIED: "there is a plan; its certificate fails, `reason` names the rows",
    NOT_SOLVED: "no start converged, or there is no way",
    REFUSED: "what was drawn contradicts itself or the robot",
    FAULTY: "an unexpected error, which should be reported",
    DIED: "the process that planned it died, also when it was tried alone",
}
PARTS: Final = ("load", "build", "guess", "solve", "certify", "discover", "other")
"""What the time of a plan went into, as its statistics have it."""

TRAJECTORY: Final = "trajectory/"
ASKED: Final = "asked/"
SECONDS: Final = "seconds/"
KIND: Final = "condensed"
"""Kind of the trajectories that the table holds."""
WHOLE: Final = "lengths"
"""The array that is kept in double precision: times are sums of it."""

Record = dict[str, Any]
"""One row, by the names of the columns."""


def arrow() -> Any:
    """The library of the table. Raises `MissingExtraError`."""
    try:
        import_module("pyarrow.parquet")
        import_module("pyarrow.dataset")
        return import_module("pyarrow")
    except ImportError:
        raise MissingExtraError("a data set", EXTRA) from None


def layout() -> dict[str, tuple[str, tuple[int, ...]]]:
    """Kind of number and shape per interval of each array of a trajectory."""
    kind = Trajectory.registry[KIND]
    described = {**kind.layout("N"), **kind.layout_of_wrenches("N")}
    return {name: (k, tuple(int(n) for n in shape[1:])) for name, (k, shape) in described.items()}


def schema(sampler: Sampler) -> Any:
    """The columns of the table of a data set, as Arrow has them."""
    pa = arrow()
    word = pa.dictionary(pa.int32(), pa.string())
    row = pa.struct(
        [
            ("name", pa.string()),
            ("worst", pa.float64()),
            ("limit", pa.float64()),
            ("unit", pa.string()),
            ("sense", pa.string()),
            ("verdict", pa.string()),
            ("leg", pa.string()),
            ("time", pa.float64()),
        ]
    )
    pose = pa.list_(pa.float64())
    columns = [
        ("row", pa.int64()),
        ("family", word),
        ("status", word),
        ("reason", pa.string()),
        *(
            (ASKED + key, pa.float64() if numeric else pa.string())
            for key, numeric in _asked(sampler).items()
        ),
        ("robot_name", word),
        ("gait", word),
        ("ground", word),
        ("start", pose),
        ("goal", pose),
        ("horizon", pa.float64()),
        ("cost", pa.float64()),
        ("iterations", pa.int32()),
        ("violation", pa.float64()),
        ("seconds", pa.float64()),
        *((SECONDS + part, pa.float64()) for part in PARTS),
        ("nearness", pa.float64()),
        ("certificate", pa.list_(row)),
        ("robot", word),
        ("scenario", pa.string()),
        ("statistics", pa.string()),
        ("map", pa.string()),
        *((TRAJECTORY + name, pa.list_(_type_of(name, kind))) for name, (kind, _) in layout().items()),
    ]
    about = {"rollgait": json.dumps({"version": FORMAT_VERSION, "shapes": _shapes()})}
    return pa.schema(columns, metadata=about)


def _type_of(name: str, kind: str) -> Any:
    pa = arrow()
    if kind == "b":
        return pa.bool_()
    return pa.float64() if name == WHOLE else pa.float32()


def _shapes() -> dict[str, list[int]]:
    """Shape per interval of each array, for readers who do not know rollgait."""
    return {name: list(shape) for name, (_, shape) in layout().items()}


def _asked(sampler: Sampler) -> dict[str, bool]:
    """Keys that vary in some family, and whether they are numbers in all."""
    numeric: dict[str, bool] = {}
    for family in sampler.spec.families:
        for key, one in sampler.spec.distributions(family).items():
            numeric[key] = numeric.get(key, True) and one.is_numeric
    return numeric


# -- a plan as a row ---------------------------------------------------------------------------------------


def record(sampler: Sampler, asked: Asked, status: str, reason: str, seconds: float) -> Record:
    """A row without a plan."""
    numeric = _asked(sampler)
    values = {ASKED + k: v if numeric[k] else json.dumps(v) for k, v in asked.values.items()}
    return {
        "row": asked.row,
        "family": asked.family,
        "status": status,
        "reason": reason,
        "seconds": seconds,
        **values,
    }


def as_stored(plan: Plan) -> Plan:
    """The plan as the table holds it, in single precision, for which its certificate is then made."""
    arrays = {
        name: array.astype(np.float32).astype(float) if array.dtype.kind == "f" and name != WHOLE else array
        for name, array in plan.trajectory.arrays().items()
    }
    return replace(plan, trajectory=type(plan.trajectory).from_arrays(arrays))


def columns_of(plan: Plan) -> Record:
    """What a row says of its plan, which is `as_stored`."""
    header, _ = plan.parts()
    scenario, statistics = header["scenario"], plan.statistics
    certificate = plan.certificate()
    last = plan.scenario.goal_at(np.array([plan.horizon]))[0]
    start = plan.scenario.start
    heights = plan.scenario.ground.heights
    return {
        "robot_name": plan.robot.name,
        "gait": plan.scenario.gait.kind,
        "ground": plan.scenario.ground.kind,
        "start": [start.x, start.y, start.yaw_deg],
        "goal": [float(last[0]), float(last[1]), math.degrees(last[3])],
        "horizon": plan.horizon,
        "cost": statistics.cost,
        "iterations": statistics.iterations,
        "violation": statistics.violation,
        **{SECONDS + part: statistics.seconds.get(part, 0.0) for part in PARTS},
        "nearness": max((r.nearness for r in certificate.rows if r.verdict != "not promised"), default=0.0),
        "certificate": [_row(row) for row in certificate.rows],
        "robot": json.dumps([scenario.pop("robot"), header["robot"]]),
        "scenario": json.dumps(scenario),
        "statistics": json.dumps(header["statistics"]),
        "map": None if heights is None else heights.digest,
        **{TRAJECTORY + name: array.ravel() for name, array in plan.trajectory.arrays().items()},
    }


def _row(row: Row) -> dict[str, Any]:
    data = asdict(row)
    return {name: data[name] for name in _ROW}


_ROW: Final = ("name", "worst", "limit", "unit", "sense", "verdict", "leg", "time")


# -- and back ----------------------------------------------------------------------------------------------


def plan_of(found: Mapping[str, Any], maps: Mapping[str, HeightMap]) -> Plan:
    """The plan in a row.

    Raises:
        InputError: the row has no plan, or its columns do not fit together.
    """
    if found["scenario"] is None:
        raise InputError("row", found["row"], f"has no plan: {found['status']}: {found['reason']}")
    bare, robot = json.loads(found["robot"])
    header = {
        "kind": KIND,
        "robot": robot,
        "scenario": {**json.loads(found["scenario"]), "robot": bare},
        "statistics": json.loads(found["statistics"]),
    }
    arrays = _arrays(found)
    if found["map"] is not None:
        heights = maps[found["map"]]
        header["map"] = heights.place()
        arrays["ground/heights"] = heights.values
    return Plan.from_parts(header, arrays)


def _arrays(found: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """The arrays of its trajectory, as a plan's file has them."""
    result = {}
    for name, (kind, shape) in layout().items():
        values = found[TRAJECTORY + name]
        if values is None:
            continue
        flat = np.asarray(values, dtype=KINDS[kind][0])
        if flat.size % max(1, math.prod(shape)):
            raise InputError(name, flat.size, f"must be a multiple of {math.prod(shape)} numbers")
        result[TRAJECTORY + name] = flat.reshape(-1, *shape)
    result["contact"] = result[TRAJECTORY + "contact"].T
    result["lengths"] = result[TRAJECTORY + WHOLE]
    return result


def certificate_of(found: Mapping[str, Any]) -> Certificate:
    """The certificate in a row, as it was made when the row was planned; without descriptions."""
    return Certificate(tuple(Row(description="", **row) for row in found["certificate"] or ()))
