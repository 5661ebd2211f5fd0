"""A plan as a table of pandas or a data set of xarray; certificates as tables. Both are optional."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any, Final

import numpy as np

from rollgait.errors import MissingExtraError
from rollgait.export.csv import columns
from rollgait.plan.certificate import Certificate
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples, rate_of
from rollgait.robot.robot import LEG_NAMES

EXTRA: Final = "tables"
UNITS: Final[Mapping[str, tuple[str, ...]]] = {
    "m": ("com_position", "foot_position", "contact_position"),
    "m/s": ("com_velocity", "foot_velocity", "speed"),
    "rad": ("euler", "heading"),
    "rad/s": ("euler_rate", "heading_rate"),
    "N": ("force",),
    "1": ("contact", "contact_normal"),
}
"""Units of what is sampled."""
ACCELERATIONS: Final[Mapping[str, tuple[str, str, str]]] = {
    "com_acceleration": ("com_velocity", "axis", "m/s²"),
    "euler_acceleration": ("euler_rate", "angle", "rad/s²"),
}
"""What is a difference quotient of what is sampled: of which, along which dimension, and its unit."""
AXES: Final = ("x", "y", "z")
ANGLES: Final = ("yaw", "pitch", "roll")


def data_frame(plan: Plan, rate: float) -> Any:
    """A plan as a `pandas.DataFrame` by time: the columns of the CSV."""
    table = columns(plan.sample_every(rate), plan.robot)
    time = table.pop("time")
    flags = {name: values.astype(bool) for name, values in table.items() if name.endswith("_contact")}
    pandas = _library("pandas", "a plan as a table")
    return pandas.DataFrame(table | flags, index=pandas.Index(time, name="time"))


def dataset(plan: Plan, rate: float) -> Any:
    """A plan as an `xarray.Dataset`."""
    samples = plan.sample_every(rate)
    xarray = _library("xarray", "a plan as a data set")
    coordinates = {
        "time": ("time", samples.time, {"units": "s"}),
        "leg": list(LEG_NAMES),
        "axis": list(AXES),
        "angle": list(ANGLES),
    }
    return xarray.Dataset(variables(samples), coordinates, {"robot": plan.robot.name})


def variables(samples: Samples) -> dict[str, tuple[tuple[str, ...], np.ndarray[Any, Any], dict[str, str]]]:
    """What is sampled: dimensions, values and unit of each, by its name."""
    result: dict[str, Any] = {}
    for unit, names in UNITS.items():
        for name in names:
            values = getattr(samples, name)
            last = "angle" if name.startswith("euler") else "axis"
            legs = ("leg",) if len(LEG_NAMES) in values.shape[1:2] else ()
            vector = (last,) if values.ndim == 2 + len(legs) else ()
            result[name] = (("time", *legs, *vector), values, {"units": unit})
    for name, (of, last, unit) in ACCELERATIONS.items():
        values = rate_of(getattr(samples, of), samples.time)
        result[name] = (("time", last), values, {"units": unit})
    return result


def rows_frame(certificate: Certificate) -> Any:
    """The rows of a certificate as a `pandas.DataFrame` by their names."""
    rows = certificate.to_dict()["rows"]
    pandas = _library("pandas", "a certificate as a table")
    return pandas.DataFrame(rows).set_index("name")


def _library(name: str, feature: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError(feature, EXTRA) from None
