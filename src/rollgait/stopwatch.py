"""Where wall time goes: named parts that sum to the whole."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Stopwatch:
    """Adds up wall time by name; what is named inside another part counts for the inner name alone.

    >>> watch = Stopwatch()
    >>> with watch("build"):
    ...     pass
    >>> sorted(watch.parts())
    ['build', 'other']
    """

    def __init__(self) -> None:
        self._begin = self._mark = time.perf_counter()
        self._seconds: dict[str, float] = {}
        self._names = ["other"]

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """The time until the block ends counts for this name."""
        self._credit()
        self._names.append(name)
        try:
            yield
        finally:
            self._credit()
            self._names.pop()

    def parts(self) -> dict[str, float]:
        """Seconds by name until now; `other` is what no name claims."""
        self._credit()
        return dict(self._seconds)

    def _credit(self) -> None:
        now = time.perf_counter()
        name = self._names[-1]
        self._seconds[name] = self._seconds.get(name, 0.0) + now - self._mark
        self._mark = now
