"""Records a drive, as a log of the controller: what `rollgait mpc` writes, and the viewer shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from rollgait.mpc.log import LogWriter
from rollgait.mpc.loop import ClosedLoop

LONGEST: Final = 300.0
"""s: a recording ends by itself then; it would be beyond what a page opens."""


class Recorder:
    """The recording of one drive, if there is one.

    Attributes:
        written: the last file, "" if there is none yet.
    """

    def __init__(self) -> None:
        self.written = ""
        self._file = ""
        self._writer: LogWriter | None = None
        self._begin = 0.0
        self._now = 0.0

    @property
    def seconds(self) -> float:
        """How long the recording is, s."""
        return 0.0 if self._writer is None else self._now - self._begin

    def want(self, file: str, loop: ClosedLoop) -> None:
        """Begins to record into a file, or ends with "". One file is recorded once."""
        if self._writer is not None and file != self._file:
            self.end(loop)
        if file and self._writer is None and file not in (self.written, self._file):
            self._file = file
            self._begin = self._now = loop.time
            self._writer = LogWriter(loop.mpc.robot, loop.plant, loop.mpc.settings.period)

    def add(self, before: Any, pose: Any, loop: ClosedLoop) -> None:
        """A step, with the true state and the pose of the whole body before it."""
        if self._writer is None or loop.control is None or loop.prediction is None:
            return
        self._writer.add(before, loop.control, loop.prediction, loop.mpc.wanted, pose)
        self._now = loop.time
        if loop.plant.fallen or self.seconds >= LONGEST:
            self.end(loop)

    def end(self, loop: ClosedLoop) -> None:
        """Writes what was recorded; its time begins at 0."""
        writer, self._writer = self._writer, None
        if writer is None or self._now <= self._begin:
            return
        begin = self._begin
        fallen_at = self._now - begin if loop.plant.fallen else None
        events = [
            replace(event, time=event.time - begin)
            for event in loop.mpc.events
            if begin <= event.time <= self._now
        ]
        log = writer.finish(fallen_at, events)
        self.written = str(replace(log, time=log.time - log.time[0]).save(Path(self._file)))
