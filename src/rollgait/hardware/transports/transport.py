"""What every transport does: it carries bytes under a topic, and hands them on when it is asked."""

from __future__ import annotations

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
