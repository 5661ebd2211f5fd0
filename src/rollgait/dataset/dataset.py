"""A data set: its table, and what that amounts to."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from rollgait.dataset.reading import Reader
from rollgait.scenario.scenario import Scenario

if TYPE_CHECKING:
    from rollgait.dataset.checking import Check
    from rollgait.dataset.nearest import Index
    from rollgait.dataset.stats import Stats


class Dataset(Reader):
    """Thousands of plans in one folder, as `plan_dataset` writes them. May be read while it is written.

    >>> library = Dataset("drives")                              # doctest: +SKIP
    >>> plan = library.plan(17)                                  # doctest: +SKIP
    >>> near = library.nearest("wheeled")                        # doctest: +SKIP

    Args:
        folder: where it is.

    Raises:
        FileError: there is none, or one of another version, or it is damaged.
        MissingExtraError: the extra `dataset` is not installed.
    """

    def nearest(self, scenario: Scenario | str, count: int = 1) -> list[tuple[int, float]]:
        """Rows of certified plans for nearly the same: a plan of one is a good `warm_start`.

        Args:
            scenario: what is to be planned, or its name.
            count: how many rows.

        Returns:
            Rows and how far they are (see `dataset.nearest`), the nearest first; none of another robot or
            gait.
        """
        return self._index.nearest(scenario, count)

    @cached_property
    def _index(self) -> Index:
        from rollgait.dataset.nearest import Index

        return Index.of(self)

    def stats(self) -> Stats:
        """What came of the rows: counts, costs, times, margins, reasons."""
        from rollgait.dataset.stats import Stats

        return Stats.of(self)

    def check(self, count: int = 20, seed: int = 0) -> Check:
        """Certifies rows anew, from nothing but the table, and counts the rows.

        Args:
            count: how many rows, drawn at random; all if there are fewer.
            seed: of the draw.
        """
        from rollgait.dataset.checking import Check

        return Check.of(self, count, seed)
