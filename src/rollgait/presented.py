"""What a notebook shows of plans, certificates, scenarios, robots and outcomes, and plans as tables.

What draws and tabulates knows all of these. They find it by name, as an import would close a circle.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


class Shown:
    """Is a card with a verdict and a small picture where it is the last line of a notebook's cell."""

    def _repr_html_(self) -> str:
        return str(import_module("rollgait.view.cards").card(self))


class Tabular:
    """Can be had as tables of other libraries, which are not needed for anything else."""

    def to_pandas(self, rate: float = 100.0) -> Any:
        """As a `pandas.DataFrame` by time (s), with the columns of the CSV (page "Formats").

        Args:
            rate: samples per second, Hz.

        Raises:
            InputError: the rate is not positive, or too high.
            MissingExtraError: pandas is not installed.
        """
        return import_module("rollgait.export.tables").data_frame(self, rate)

    def to_xarray(self, rate: float = 100.0) -> Any:
        """As an `xarray.Dataset` over `time` (s), `leg` and `axis`; each variable says its unit.

        Args:
            rate: samples per second, Hz.

        Raises:
            InputError: the rate is not positive, or too high.
            MissingExtraError: xarray is not installed.
        """
        return import_module("rollgait.export.tables").dataset(self, rate)
