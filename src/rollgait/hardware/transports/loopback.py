"""A transport within a process, in a time of its own: for tests, and for who tries things out."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable

from rollgait.hardware.transports.transport import Receive
from rollgait.ros.topics import Topic

TICK = 1e-3
"""Time goes on in such steps, s."""


class Loopback:
    """Time and messages of all who are connected to it.

    Attributes:
        time: s; goes on only in `pass_time`.
    """

    def __init__(self) -> None:
        self.time = 0.0
        self._ticks = 0
        self._ends: list[End] = []
        self._each: list[Callable[[float], None]] = []

    def end(self, latency: float = 0.0) -> End:
        """Another end of it; what is published there arrives so much later, s."""
        end = End(self, latency)
        self._ends.append(end)
        return end

    def each_tick(self, do: Callable[[float], None]) -> None:
        """From now on lets something happen in each tick; it gets the time, s."""
        self._each.append(do)

    def carry(self, sender: End, topic: Topic, data: bytes, at: float) -> None:
        """Puts a message on its way to all other ends."""
        for end in self._ends:
            if end is not sender and end.connected:
                end.expect(at, topic, data)

    def pass_time(self) -> None:
        """A tick."""
        self._ticks += 1
        self.time = self._ticks * TICK
        for do in self._each:
            do(self.time)


class End:
    """A transport that begins and ends at a `Loopback`.

    Attributes:
        connected: while it is not, nothing comes and nothing goes: a cable that is pulled.
    """

    def __init__(self, loopback: Loopback, latency: float) -> None:
        self._loopback, self._latency = loopback, latency
        self._readers: dict[Topic, list[Receive]] = {}
        self._coming: list[tuple[float, int, Topic, bytes]] = []
        self._count = itertools.count()
        self.connected = True

    def publish(self, topic: Topic, data: bytes) -> None:
        """Sends a message, as CDR."""
        if self.connected:
            self._loopback.carry(self, topic, data, self._loopback.time + self._latency)

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From now on hands messages of a topic to `receive`."""
        self._readers.setdefault(topic, []).append(receive)

    def expect(self, at: float, topic: Topic, data: bytes) -> None:
        """A message that arrives at a time."""
        heapq.heappush(self._coming, (at, next(self._count), topic, data))

    def receive(self, seconds: float) -> None:
        """Hands on what has come by now; waits for it, which lets time pass."""
        until = self._loopback.time + seconds
        while not self._hand_on() and self._loopback.time < until - 0.5 * TICK:
            self._loopback.pass_time()

    def _hand_on(self) -> bool:
        came = False
        while self._coming and self._coming[0][0] <= self._loopback.time + 1e-9:
            _, _, topic, data = heapq.heappop(self._coming)
            for receive in self._readers.get(topic, ()):
                receive(data)
                came = True
        return came

    def close(self) -> None:
        """Takes it off."""
        self.connected = False
