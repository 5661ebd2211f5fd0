"""What every transport does: it carries bytes under a topic, and hands them on when it is asked."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Protocol

from rollgait.ros.topics import Topic

Receive = Callable[[bytes], None]
"""Takes a message as CDR."""


class Transport(Protocol):
    """Publishes and subscribes. Subscribers are called only within `receive`, in its thread."""

    def publish(self, topic: Topic, data: bytes) -> None:
        """Sends a message, as CDR. Never waits for who reads it."""

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From now on hands messages of a topic to `receive`."""

    def receive(self, seconds: float) -> None:
        """Hands on what has come; if nothing has, waits for the first to come, so long at most."""

    def close(self) -> None:
        """Ends it. What is published later goes nowhere."""


class Slowed:
    """A transport in slow motion, for machines that cannot keep up: a second of it takes `factor` seconds.

    Args:
        inner: the transport.
        factor: seconds on the wall in a second of all who talk over it; all must have the same.
    """

    def __init__(self, inner: Transport, factor: float) -> None:
        self._inner, self._factor = inner, factor

    def clock(self) -> float:
        """Its time, s."""
        return time.perf_counter() / self._factor

    def publish(self, topic: Topic, data: bytes) -> None:
        """Sends a message, as CDR."""
        self._inner.publish(topic, data)

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From now on hands messages of a topic to `receive`."""
        self._inner.subscribe(topic, receive)

    def receive(self, seconds: float) -> None:
        """Hands on what has come; waits for the first, so many of its own seconds at most."""
        self._inner.receive(self._factor * seconds)

    def close(self) -> None:
        """Ends it."""
        self._inner.close()


class Several:
    """One transport that is asked, and others that only get what is published as well.

    Args:
        main: the one that is waited for.
        others: they are looked at whenever the main one is.
    """

    def __init__(self, main: Transport, others: Sequence[Transport]) -> None:
        self._main, self._others = main, tuple(others)

    def publish(self, topic: Topic, data: bytes) -> None:
        """To all of them."""
        for each in (self._main, *self._others):
            each.publish(topic, data)

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From all of them."""
        for each in (self._main, *self._others):
            each.subscribe(topic, receive)

    def receive(self, seconds: float) -> None:
        """Waits for the main one only."""
        for each in self._others:
            each.receive(0.0)
        self._main.receive(seconds)

    def close(self) -> None:
        """Ends all of them."""
        for each in (self._main, *self._others):
            each.close()
