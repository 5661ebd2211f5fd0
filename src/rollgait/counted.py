"""How far long work has come: a bar on a terminal, a line now and then in the log of a cluster."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from rich.progress import Task
    from rich.text import Text

EVERY: Final = 60.0
"""Between two lines where stderr is no terminal, s."""


@contextmanager
def counted(
    total: int, done: int, quiet: bool, *, lines: bool = False, text: str = "planning"
) -> Iterator[Callable[[], None]]:
    """Shows on stderr how much is done, how fast, and when it will be over.

    Args:
        total: number of pieces.
        done: of these before it begins.
        quiet: shows nothing.
        lines: whether to print a line every `EVERY` seconds where stderr is no terminal.
        text: what is done, one word.

    Yields:
        The function that counts one more.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn, TimeRemainingColumn

    console = Console(stderr=True)
    bar_shown = console.is_terminal and not quiet
    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        _rate_column(),
        TimeElapsedColumn(),
        TimeRemainingColumn(elapsed_when_finished=False),
    )
    log = Rate(total, done, text)
    with Progress(*columns, console=console, disable=not bar_shown) as bar:
        task = bar.add_task(text, total=total, completed=done)

        def advance() -> None:
            bar.advance(task)
            if (line := log.advance()) is not None and lines and not quiet and not bar_shown:
                print(line, file=sys.stderr, flush=True)

        yield advance


class Rate:
    """Counts pieces and says now and then how far it is.

    Args:
        total: number of pieces.
        done: of these before it begins.
        text: what is done, one word.
        clock: s.
    """

    def __init__(self, total: int, done: int, text: str, clock: Callable[[], float] = time.monotonic) -> None:
        self._total, self._done, self._text, self._clock = total, done, text, clock
        self._before, self._begin = done, clock()
        self._said = self._begin

    def advance(self) -> str | None:
        """Counts one more; the line that is due, if one is."""
        self._done += 1
        now = self._clock()
        if now - self._said < EVERY and self._done < self._total:
            return None
        self._said = now
        return self.line(now)

    def line(self, now: float) -> str:
        """E.g. `planning: 120 of 2000, 1.9 per second, 16 min left`."""
        rate = (self._done - self._before) / max(now - self._begin, 1e-9)
        left = (self._total - self._done) / rate if rate > 0.0 else float("inf")
        return f"{self._text}: {self._done} of {self._total}, {rate:.3g} per second, {duration(left)} left"


def duration(seconds: float) -> str:
    """A duration as people say it: `40 s`, `16 min`, `5.2 h`, `3.1 days`."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.1f} {unit}" if unit != "min" else f"{seconds / size:.0f} min"
    return f"{seconds:.0f} s"


def _rate_column() -> Any:
    from rich.progress import ProgressColumn
    from rich.text import Text

    class Speed(ProgressColumn):
        """Pieces per second."""

        def render(self, task: Task) -> Text:
            speed = task.finished_speed or task.speed
            return Text("" if speed is None else f"{speed:.3g} per s")

    return Speed()
