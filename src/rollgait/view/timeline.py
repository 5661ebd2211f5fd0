"""Time: where the motion stands, and its clock. Knows nothing of what is shown."""

from __future__ import annotations

import threading
import time as clock
from collections.abc import Callable

from rollgait.view.clip import FRAME_RATE


class Timeline:
    """A position in time that can play by itself, in a thread of its own.

    Attributes:
        horizon: end of the time, s.
        time: where it stands, s.
        speed: times real time.
        loop: whether it begins again at the end.
    """

    def __init__(self, horizon: float, on_change: Callable[[], None]) -> None:
        self.horizon, self.time, self.speed, self.loop = horizon, 0.0, 1.0, True
        self._on_change = on_change
        self._lock = threading.Lock()
        self._playing = threading.Event()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="timeline", daemon=True)
        self._thread.start()

    @property
    def playing(self) -> bool:
        """Whether it moves by itself."""
        return self._playing.is_set()

    def play(self) -> None:
        """Begins to move; from the start, if it stands at the end."""
        with self._lock:
            if self.time >= self.horizon - 1e-9:
                self.time = 0.0
            self._playing.set()

    def pause(self) -> None:
        """Stops moving."""
        with self._lock:
            self._playing.clear()

    def go(self, time: float) -> None:
        """Goes to a time (s) within the horizon."""
        with self._lock:
            self.time = min(max(time, 0.0), self.horizon)
        self._on_change()

    def step(self, frames: int) -> None:
        """Stops and goes some frames ahead (or back)."""
        self.pause()
        self.go(self.time + frames / FRAME_RATE)

    def restart(self, horizon: float) -> None:
        """Another motion: its time begins at 0."""
        with self._lock:
            self.horizon, self.time = horizon, 0.0
        self._on_change()

    def close(self) -> None:
        """Ends its thread."""
        self._closed.set()
        self._playing.set()
        self._thread.join()

    def _run(self) -> None:
        while True:
            self._playing.wait()
            if self._closed.is_set():
                return
            due = last = clock.perf_counter()
            while self._playing.is_set() and not self._closed.is_set():
                due = max(due + 1.0 / FRAME_RATE, last)  # too slow: frames are left out, the time is kept
                clock.sleep(max(0.0, due - clock.perf_counter()))
                now = clock.perf_counter()
                self._advance(now - last)
                last = now

    def _advance(self, seconds: float) -> None:
        with self._lock:
            if not self.playing:
                return  # paused in between: its time stays
            self.time += self.speed * seconds
            if self.time >= self.horizon:
                self.time = 0.0 if self.loop else self.horizon
                if not self.loop:
                    self._playing.clear()
        self._on_change()
