"""Where time goes: named parts that sum to the whole."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Stopwatch:
    """Adds up time by name; what is named inside another part counts for the inner name alone.

    Args:
        clock: what is read, s: wall time, or `time.process_time` where other programs are not to count.

    >>> watch = Stopwatch()
    >>> with watch("build"):
    ...     pass
    >>> sorted(watch.parts())
    ['build', 'other']
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._mark = clock()
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
        now = self._clock()
        name = self._names[-1]
        self._seconds[name] = self._seconds.get(name, 0.0) + now - self._mark
        self._mark = now
