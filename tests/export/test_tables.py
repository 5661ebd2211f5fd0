"""Plans as tables of other libraries: the same numbers under the same names, or one sentence."""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import pytest

import rollgait as rg
from rollgait.errors import MissingExtraError
from rollgait.export.csv import columns
from rollgait.export.tables import ACCELERATIONS, AXES, variables
from tests.view.builders import motion_plan

RATE = 20.0


@pytest.fixture(scope="module")
def plan() -> rg.Plan:
    return motion_plan(rg.find_scenario("wheeled"))


ABSENT: dict[str, tuple[str, Callable[[rg.Plan], object]]] = {
    "plan, pandas": ("pandas", lambda plan: plan.to_pandas(RATE)),
    "plan, xarray": ("xarray", lambda plan: plan.to_xarray(RATE)),
    "certificate, pandas": ("pandas", lambda plan: plan.certificate().to_pandas()),
}


@pytest.mark.parametrize("case", ABSENT)
def test_one_sentence_where_the_library_is_absent(
    case: str, plan: rg.Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    library, call = ABSENT[case]
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(MissingExtraError, match=r"pip install 'rollgait\[tables\]'"):
        call(plan)


def test_variables_are_all_samples_with_dimensions_and_units(plan: rg.Plan) -> None:
    samples = plan.sample_every(RATE)
    found = variables(samples)
    assert set(found) == set(vars(samples)) - {"time"} | set(ACCELERATIONS)
    sizes = {"time": len(samples.time), "leg": 4, "axis": len(AXES), "angle": 3}
    for name, (dimensions, values, attributes) in found.items():
        assert values.shape == tuple(sizes[dimension] for dimension in dimensions), name
        assert attributes["units"]
    assert found["euler"][0] == ("time", "angle")
    assert found["force"][0] == ("time", "leg", "axis")


def test_a_rate_that_is_none_is_refused(plan: rg.Plan) -> None:
    with pytest.raises(rg.InputError, match="rate"):
        plan.to_pandas(-1.0)
    with pytest.raises(rg.InputError, match="rate"):
        plan.to_xarray(-1.0)


def test_pandas_has_the_columns_of_the_csv(plan: rg.Plan) -> None:
    pytest.importorskip("pandas", reason="needs the extra tables")
    frame, table = plan.to_pandas(RATE), columns(plan.sample_every(RATE), plan.robot)
    assert frame.index.name == "time"
    assert list(frame.columns) == list(table)[1:]
    for name in frame.columns:
        np.testing.assert_array_equal(frame[name], table[name])
    rows = plan.certificate().to_pandas()
    assert list(rows.index) == [row.name for row in plan.certificate().rows]


def test_xarray_selects_by_leg_and_axis(plan: rg.Plan) -> None:
    pytest.importorskip("xarray", reason="needs the extra tables")
    data, samples = plan.to_xarray(RATE), plan.sample_every(RATE)
    np.testing.assert_array_equal(data.force.sel(leg="HL", axis="z"), samples.force[:, 2, 2])
    np.testing.assert_array_equal(data.time, samples.time)
