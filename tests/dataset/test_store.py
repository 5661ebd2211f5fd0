"""What is planned is kept, once, whatever dies; others can read it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rollgait as rg
from rollgait.config import dump_yaml
from rollgait.dataset import Sampler, Spec
from rollgait.dataset.store import Store
from rollgait.errors import FileError
from tests.clusters import dask_cluster
from tests.dataset.builders import BASE, spec

pandas = pytest.importorskip("pandas")


def facts(library: rg.Dataset) -> Any:
    return library.table(["status", "cost", "seconds"]).to_pydict()


def split(library: rg.Dataset, folder: Path) -> Path:
    """A copy whose rows are in files of their own, as an interrupted run leaves them."""
    import pyarrow.parquet as parquet

    shutil.copytree(library.folder, folder)
    (part,) = (folder / "parts").iterdir()
    table = parquet.read_table(part)
    (folder / "rows").mkdir(exist_ok=True)
    for row in range(len(table)):
        parquet.write_table(table.slice(row, 1), folder / "rows" / f"row-{row:08d}.parquet")
    part.unlink()
    return folder


def again(folder: Path, count: int = 6, **changes: Any) -> rg.Dataset:
    return rg.plan_dataset(Spec.from_dict(spec(count, **changes)), folder, workers=1, quiet=True)


def test_a_row_says_what_came_of_it(library: rg.Dataset) -> None:
    table = library.to_pandas()
    assert list(table.status) == ["certified"] * 5 + ["refused"]
    assert "goal" in table.reason[5]
    assert np.isnan(table.cost[5])
    assert (table["asked/goal.x"][:2] == [library.sampler.asked(r).values["goal.x"] for r in (0, 1)]).all()
    with pytest.raises(rg.InputError, match=r"row: 5 has no plan: refused"):
        library.plan(5)
    with pytest.raises(rg.InputError, match="row: 6 must be a whole number from 0 to 5"):
        library.record(6)
    with pytest.raises(rg.InputError, match="columns: 'cots' is no column; valid: cos"):
        library.table(["cots"])


def test_a_plan_of_the_table_is_the_plan_in_single_precision(library: rg.Dataset) -> None:
    stored, made = library.plan(1), rg.plan(library.scenario(1), seed=1)
    assert stored.scenario == made.scenario
    assert stored.robot == made.robot
    for name, array in made.trajectory.arrays().items():
        rounded = array.astype(np.float32) if array.dtype.kind == "f" and name != "lengths" else array
        np.testing.assert_allclose(stored.trajectory.arrays()[name], rounded, rtol=2e-6, atol=2e-6)
    assert [(r.name, r.worst, r.verdict) for r in stored.certificate().rows] == [
        (r.name, r.worst, r.verdict) for r in library.certificate(1).rows
    ]
    assert [row for row, _ in library.plans()] == [0, 1, 2, 3, 4]
    ((row, samples),) = library.resampled(50.0, rows=[2])
    assert row == 2
    np.testing.assert_array_equal(samples.com_position, library.plan(2).sample(samples.time).com_position)


def test_others_read_the_table_without_rollgait(library: rg.Dataset) -> None:
    import pyarrow.parquet as parquet

    (part,) = (library.folder / "parts").iterdir()
    table = pandas.read_parquet(part).set_index("row")
    shapes = json.loads(parquet.read_schema(part).metadata[b"rollgait"])["shapes"]
    plan = library.plan(0)
    nodes = np.cumsum([0.0, *table["trajectory/lengths"][0][:-1]])
    r = table["trajectory/r"][0].reshape(-1, *shapes["r"])
    np.testing.assert_allclose(r, plan.sample(nodes).com_position, atol=1e-12)
    worst = {one["name"]: one["worst"] for one in table.certificate[0]}
    assert worst["goal_distance"] == plan.certificate().row("goal_distance").worst


def test_nothing_is_planned_twice_and_what_is_damaged_is(library: rg.Dataset, tmp_path: Path) -> None:
    folder = split(library, tmp_path / "again")
    lost, damaged = (folder / "rows" / f"row-{row:08d}.parquet" for row in (1, 3))
    lost.unlink()
    damaged.write_bytes(damaged.read_bytes()[:100])
    (folder / "rows" / ".row-00000004-x.parquet").write_bytes(b"half")
    before, after = facts(library), facts(again(folder))
    assert after["row"] == before["row"]
    assert after["status"] == before["status"]
    anew = [row for row in after["row"] if after["seconds"][row] != before["seconds"][row]]
    assert anew == [1, 3]
    assert not list((folder / "rows").iterdir())


def test_a_row_in_two_files_counts_once(library: rg.Dataset, tmp_path: Path) -> None:
    """As it is left by what dies between writing a part and removing its rows."""
    folder = split(library, tmp_path / "twice")
    shutil.copytree(library.folder / "parts", folder / "parts", dirs_exist_ok=True)
    both = rg.Dataset(folder)
    assert facts(both) == facts(library)
    assert both.check(1).twice == (0, 1, 2, 3, 4, 5)
    assert not both.check(1).passed
    assert again(folder).check(6).passed


def test_a_reader_loses_no_row_that_becomes_part_of_another_file(library: rg.Dataset, tmp_path: Path) -> None:
    """The writer makes a part of all rows after the reader has read the first and listed the others."""
    folder = split(library, tmp_path / "moving")
    reader = Store.open(folder)
    tables = reader.tables(["status"])
    found = next(tables)["row"].to_pylist()
    assert found == [0]
    writer = Store.open(folder)
    with writer.writing():
        writer.merge()
    for table in tables:
        found += table["row"].to_pylist()
    assert found == [0, 1, 2, 3, 4, 5]
    assert reader.find(4) is not None


def test_a_reader_knows_the_count_that_was_when_it_came(library: rg.Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "raised"
    shutil.copytree(library.folder, folder)
    reader = rg.Dataset(folder)
    again(folder, 8)
    assert facts(reader) == facts(library)
    assert len(reader) == 6


def test_a_family_that_is_refused_as_a_whole_is_a_slip(tmp_path: Path) -> None:
    def families(**vary: Any) -> dict[str, Any]:
        return {"near": {"base": BASE, "vary": vary}, "fine": {"base": BASE}}

    for key, one, message in (
        ("goal.q", {"uniform": [0.0, 1.0]}, "families.near.vary.goal.q: 'q' is not a known key.*valid: x, y"),
        ("horizon", {"choice": [-1.0, -2.0]}, r"families.near.vary.horizon: -\d.* must be greater than 0"),
    ):
        with pytest.raises(rg.InputError, match=message):
            again(tmp_path / "slip", families=families(**{key: one}))
    assert not (tmp_path / "slip").exists()
    Sampler.of(Spec.from_dict(spec(families=families(horizon={"list": [-1.0, 1.6]})))).require_sense()


def test_a_higher_count_leaves_the_first_rows_as_they_are(library: rg.Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "more"
    shutil.copytree(library.folder, folder)
    more = again(folder, 8)
    assert len(more) == 8
    assert facts(library)["seconds"] == facts(more)["seconds"][:6]
    assert len(again(folder, 6)) == 8  # fewer is what is there already
    assert more.check(8).passed


def test_another_spec_a_second_writer_and_other_folders_are_refused(
    library: rg.Dataset, tmp_path: Path
) -> None:
    with pytest.raises(rg.InputError, match="another spec"):
        again(library.folder, seed=6)
    with (
        Store.open(library.folder).writing(),
        pytest.raises(FileError, match="another process"),
    ):
        again(library.folder)
    (tmp_path / "letter.txt").write_text("dear", encoding="utf-8")
    with pytest.raises(FileError, match="holds other files"):
        again(tmp_path)
    with pytest.raises(FileError, match="is no data set"):
        rg.Dataset(tmp_path)
    (tmp_path / "dataset.json").write_text('{"format": "rollgait-dataset", "version": 99}', encoding="utf-8")
    with pytest.raises(FileError, match="has format version 99"):
        rg.Dataset(tmp_path)
    (tmp_path / "dataset.json").write_text('{"format": "rollgait-dataset", "version": 1}', encoding="utf-8")
    with pytest.raises(FileError, match="is damaged"):
        rg.Dataset(tmp_path)


def test_a_check_finds_what_was_changed(library: rg.Dataset, tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    assert library.check().passed
    folder = tmp_path / "changed"
    shutil.copytree(library.folder, folder)
    (part,) = (folder / "parts").iterdir()
    table = parquet.read_table(part)
    column = table.schema.get_field_index("trajectory/force")
    forces = [None if f is None else [1.01 * x for x in f] for f in table.column(column).to_pylist()]
    field = table.schema.field(column)
    parquet.write_table(table.set_column(column, field, pa.array(forces, field.type)), part)
    found = rg.Dataset(folder).check()
    assert {row for row, _ in found.wrong} == {0, 1, 2, 3, 4}
    assert not found.passed


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGINT])
def test_a_killed_run_goes_on_where_it_was(tmp_path: Path, end: signal.Signals) -> None:
    """What is there stays, as it is; the set in the end is the one of a run that nobody disturbed."""
    file = tmp_path / "many.yaml"
    file.write_text(dump_yaml(spec(60)), encoding="utf-8")
    rows = tmp_path / "many" / "rows"
    process = subprocess.Popen(
        [sys.executable, "-m", "rollgait", "dataset", str(file), "--workers", "2"],
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    while len(list(rows.glob("row*"))) < 4:
        assert process.poll() is None
        time.sleep(0.02)
    if end is signal.SIGKILL:
        process.kill()
    else:
        os.killpg(process.pid, end)
    assert process.wait(300.0) != 0
    there = rg.Dataset(tmp_path / "many")
    before = there.table(["seconds"]).to_pydict()
    assert 4 <= len(before["row"]) < 60
    done = rg.plan_dataset(file, workers=1, quiet=True)
    seconds = dict(zip(*done.table(["seconds"]).to_pydict().values(), strict=True))
    assert {row: seconds[row] for row in before["row"]} == dict(zip(*before.values(), strict=True))
    assert done.check(3).passed


def test_a_dask_cluster_makes_the_same_rows(library: rg.Dataset, tmp_path: Path) -> None:
    with dask_cluster():
        other = rg.plan_dataset(Spec.from_dict(spec(3)), tmp_path / "dask", quiet=True)
    assert (
        other.table(["status", "cost"]).to_pydict()
        == library.table(["status", "cost"]).slice(0, 3).to_pydict()
    )


def test_maps_wrenches_and_failures_of_certificates_come_back(tmp_path: Path) -> None:
    """A map lies beside the table once; a plan pulled at has arrays of its own; a failure says its rows."""
    heights = np.zeros((60, 40))
    np.save(tmp_path / "flat.npy", heights)
    ground = {"map": {"file": "flat.npy", "resolution": 0.1, "origin": [-2.0, -2.0]}}
    pulled = {"loads.wrench": {"choice": [[{"force": [20.0, 0.0, 0.0]}]]}}
    families = {
        "mapped": {"base": BASE | {"ground": ground}},
        "pulled": {"base": BASE, "vary": pulled},
        "heavy": {"base": BASE | {"bounds": {"force_max": 50.0}}},
    }
    file = tmp_path / "kinds.yaml"
    file.write_text(dump_yaml({"count": 3, "families": families}), encoding="utf-8")
    kinds = rg.plan_dataset(file, workers=1, quiet=True)
    assert list(kinds.to_pandas().status) == ["certified", "certified", "not solved"]
    assert len(list((kinds.folder / "maps").iterdir())) == 1
    again = rg.Dataset(kinds.folder)
    mapped, wrenched = again.plan(0), again.plan(1)
    assert mapped.scenario.ground.heights is not None
    np.testing.assert_array_equal(mapped.scenario.ground.heights.values, heights)
    assert wrenched.trajectory.arrays()["wrench"].any()
    assert again.check().passed
    file.unlink()
    (tmp_path / "flat.npy").unlink()
    assert again.scenario(0).to_dict()["ground"] == mapped.scenario.to_dict()["ground"]
