"""The table of a data set for reading: rows, plans, samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.dataset import columns
from rollgait.dataset.sampler import Sampler
from rollgait.dataset.spec import Spec
from rollgait.dataset.store import Store
from rollgait.errors import InputError, MissingExtraError, UnknownNameError
from rollgait.plan.certificate import Certificate
from rollgait.plan.plan import Plan
from rollgait.plan.samples import Samples
from rollgait.scenario.scenario import Scenario


class Reader:
    """What a folder with a data set holds.

    Args:
        folder: where it is.

    Raises:
        FileError: there is none, or one of another version, or it is damaged.
        MissingExtraError: the extra `dataset` is not installed.
    """

    def __init__(self, folder: str | Path) -> None:
        self._store = Store.open(folder)

    def __repr__(self) -> str:
        return f"<Dataset: {len(self)} of {self.spec.count} rows in {self.folder}>"

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def folder(self) -> Path:
        """Where it is."""
        return self._store.folder

    @property
    def sampler(self) -> Sampler:
        """What says what is asked in each row."""
        return self._store.sampler

    @property
    def spec(self) -> Spec:
        """What was asked for."""
        return self.sampler.spec

    @property
    def rows(self) -> NDArray[np.int64]:
        """The rows that are there, in order, (n,)."""
        return np.flatnonzero(self._store.planned())

    @property
    def size(self) -> int:
        """Size of all of its files, bytes."""
        return self._store.size()

    # -- the table --

    def table(self, columns: Sequence[str] | None = None) -> Any:
        """The table, or some of its columns beside `row`, as a `pyarrow.Table` in the order of rows.

        Raises `InputError` for a column that there is not.
        """
        schema = self._store.schema
        for name in columns or ():
            if name not in schema.names:
                raise UnknownNameError("columns", name, schema.names, "is no column")
        found = list(self._store.tables(columns))
        if not found:
            names = schema.names if columns is None else ["row", *(n for n in columns if n != "row")]
            return schema.empty_table().select(names)
        pa = _arrow()
        return pa.concat_tables([one.unify_dictionaries() for one in found]).sort_by("row")

    def to_pandas(self, columns: Sequence[str] | None = None) -> Any:
        """The table as a `pandas.DataFrame` by row; all columns but those of trajectories if none are named.

        Raises:
            InputError: there is no such column.
            MissingExtraError: pandas is not installed.
        """
        names = columns or [name for name in self._store.schema.names if "trajectory/" not in name]
        try:
            return self.table(names).to_pandas().set_index("row")
        except ImportError:
            raise MissingExtraError("a table of pandas", "tables") from None

    def pieces(self, columns: Sequence[str] | None = None) -> Iterator[Any]:
        """The same as `table` file by file, as they come: only one is in memory at a time."""
        return self._store.tables(columns)

    def held(self) -> Iterator[int]:
        """The row of every line in every file: a row that was written twice comes twice."""
        return self._store.held()

    def record(self, row: int) -> dict[str, Any]:
        """One row, by the names of the columns. Raises `InputError` if it is not there."""
        found = self._store.find(self.spec.require_row(row))
        if found is None:
            raise InputError("row", row, "is not planned yet")
        return found

    # -- motions --

    def plan(self, row: int) -> Plan:
        """The plan of a row, in single precision. Raises `InputError` if it has none."""
        return columns.plan_of(self.record(row), self.sampler.maps)

    def scenario(self, row: int) -> Scenario:
        """What is asked in a row, planned or not. Raises `InputError` if it contradicts itself."""
        return self.sampler.scenario(self.sampler.asked(row))

    def certificate(self, row: int) -> Certificate:
        """The certificate as it was when the row was planned. Raises `InputError` if it has none."""
        found = self.record(row)
        if found["certificate"] is None:
            raise InputError("row", row, f"has no plan: {found['status']}: {found['reason']}")
        return columns.certificate_of(found)

    def plans(self, rows: Sequence[int] | None = None) -> Iterator[tuple[int, Plan]]:
        """Rows and their plans, file by file; only one file is in memory at a time.

        Args:
            rows: which; all whose certificate passes if not given.
        """
        wanted = None if rows is None else {self.spec.require_row(int(row)) for row in rows}
        for table in self._store.tables():
            for found in _each(table):
                keep = found["status"] == columns.CERTIFIED if wanted is None else found["row"] in wanted
                if keep:
                    yield found["row"], columns.plan_of(found, self.sampler.maps)

    def resampled(self, rate: float, rows: Sequence[int] | None = None) -> Iterator[tuple[int, Samples]]:
        """Rows and their motions at a fixed rate (Hz), both ends included; see `plans`."""
        for row, plan in self.plans(rows):
            yield row, plan.sample_every(rate)


def _each(table: Any) -> Iterator[dict[str, Any]]:
    """The rows of a table one by one, so that only one is held as Python objects."""
    for number in range(table.num_rows):
        yield table.slice(number, 1).to_pylist()[0]


def _arrow() -> Any:
    return columns.arrow()
