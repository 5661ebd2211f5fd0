"""What commands share that let the controller run: progress, Ctrl-C, events, logs, how they end."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from rollgait.cli.exit_status import INTERRUPTED
from rollgait.cli.progress import StatusLine
from rollgait.cli.simulate import disturbances_from
from rollgait.view.recordings import write_recording

if TYPE_CHECKING:
    from rollgait.mpc.log import MpcLog

DATA = ("npz",)
EVENTS_SHOWN = 12
"""Events that a person reads; --json and the log have all."""
SHOWN_EVERY = 0.2
"""Between two changes of the progress line, s of the robot's time."""


class Watching:
    """Shows how far the run is, here and perhaps to others, and ends it when it shall stop."""

    def __init__(
        self,
        line: StatusLine,
        duration: float,
        stop: threading.Event,
        show: Callable[[], None] | None = None,
    ) -> None:
        self._line, self._duration, self._stop, self._show = line, duration, stop, show
        self._next = 0.0

    def __call__(self, time: float) -> bool:
        if time >= self._next:
            self._line.show(f"running … {time:5.1f} s of {self._duration:g} s")
            self._next = time + SHOWN_EVERY
        if self._show is not None:
            self._show()
        return self._stop.is_set()


@contextmanager
def stopping() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C sets; the second one interrupts. What is logged waits for the report."""
    stop, log = threading.Event(), logging.getLogger("rollgait")
    level = log.level
    before: Any = signal.getsignal(signal.SIGINT)
    main = threading.current_thread() is threading.main_thread()

    def on_signal(*_: object) -> None:
        stop.set()
        signal.signal(signal.SIGINT, before)

    if main:
        signal.signal(signal.SIGINT, on_signal)
    log.setLevel(logging.ERROR)
    try:
        yield stop
    finally:
        log.setLevel(level)
        if main:
            signal.signal(signal.SIGINT, before)


def write_log(log: MpcLog, target: Path) -> Path:
    """Writes the log, a page or a film; the file's path."""
    if target.suffix == ".npz":
        return log.save(target)
    from rollgait.view.mpc_clip import clip_of_mpc

    return write_recording(clip_of_mpc(log, target.stem), target)


def disturbances_of(plant: str, texts: Sequence[str | None], names: str) -> dict[str, Any]:
    """The argument of a loop for payload, friction, radius error, latency and slope; none if none is given.

    Args:
        plant: its name.
        texts: what was given, None where nothing was.
        names: what of these the command has, as a person says it.

    Raises:
        InputError: a text is wrong, or the plant has none of these.
    """
    from rollgait.errors import InputError

    if all(text is None for text in texts):
        return {}
    if plant != "mujoco":
        raise InputError("plant", plant, f"has no {names}; mujoco has")
    return {"disturbances": disturbances_from(None, *texts)}


def print_events(events: Sequence[object]) -> None:
    """The first events, if there are any."""
    if events:
        print("\nevents")
        for event in events[:EVENTS_SHOWN]:
            print(f"  {event}")
        if len(events) > EVENTS_SHOWN:
            print(f"  and {len(events) - EVENTS_SHOWN} more")


def print_written(file: str | None) -> None:
    """Says where the log is, if it was written."""
    if file is not None:
        print(f"\nwritten: {file}")


def leave(stop: threading.Event, passed: bool) -> None:
    """Ends the command: interrupted, not passed, or done."""
    if stop.is_set():
        raise typer.Exit(INTERRUPTED)
    if not passed:
        raise typer.Exit(1)
