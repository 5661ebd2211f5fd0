"""A transport in a process of its own, so that who publishes waits for nobody.

A writer of DDS waits up to 0.1 s for a reader that does not keep up, and Python may hold its lock meanwhile:
a thread would not do where a controller has 10 ms. Messages are encoded by who publishes them, which takes a
fraction of a millisecond, and cross a pipe as bytes.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import queue
import signal
import threading
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Final

from rollgait.errors import RollgaitError
from rollgait.hardware.topics import SHOWN
from rollgait.hardware.transports.reach import Reach, opened
from rollgait.hardware.transports.transport import Receive, Transport
from rollgait.ros.topics import Topic
from rollgait.signals import deaf_to_ctrl_c

OPEN_WITHIN: Final = 60.0
"""Transports that are not open by then will not be, s."""
END_WITHIN: Final = 3.0
"""The process ends by itself in this time, s; otherwise it is ended."""
WAITING_MAX: Final = 100
"""Messages on their way to the process, 0.3 s of a run; what comes while there are so many is dropped."""
LOOK_EVERY: Final = 0.005
"""Between two looks at what others have published, s."""

Word = tuple[Topic, bytes]
"""What crosses: a message and where it belongs; of no bytes, to there, that the topic is subscribed to."""


@dataclass(frozen=True)
class Line:
    """Ends of the pipes to a `TransportProcess`; they can be handed to another process as it is started."""

    words: Connection
    answers: Connection

    def close(self) -> None:
        """Hangs up."""
        self.words.close()
        self.answers.close()


class TransportProcess:
    """A process that holds transports open, until it is closed or nobody holds its line any more.

    Args:
        reach: which transports.

    Attributes:
        line: to speak over, by one `Elsewhere`.
        said: what a person wants to know of it.

    Raises:
        RollgaitError: as the opening of the transports raised it.
    """

    def __init__(self, reach: Reach) -> None:
        context = multiprocessing.get_context("spawn")
        words, to_publish = context.Pipe(duplex=False)
        published, answers = context.Pipe(duplex=False)
        self.line = Line(to_publish, published)
        self._process = context.Process(
            target=_run, args=(words, answers, reach), name="transports", daemon=True
        )
        with deaf_to_ctrl_c():
            self._process.start()
        words.close()
        answers.close()
        try:
            came = published.poll(OPEN_WITHIN)
            answer = published.recv() if came else RollgaitError("the transports do not open")
        except EOFError:
            answer = RollgaitError("the process of the transports has ended")
        except BaseException:
            self.close()
            raise
        if isinstance(answer, BaseException):
            self.close()
            raise answer
        self.said: tuple[str, ...] = answer

    def close(self) -> None:
        """Ends it."""
        self.line.close()
        self._process.join(END_WITHIN)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


class Elsewhere:
    """A transport whose work a `TransportProcess` does.

    Args:
        line: to that process; of this one alone.

    Attributes:
        dropped: messages that could not be handed over at once.
        broken: whether there is nobody at the other end any more; what is published then goes nowhere.
    """

    def __init__(self, line: Line) -> None:
        self._line = line
        self._readers: dict[Topic, list[Receive]] = {}
        self._waiting: queue.SimpleQueue[Word | None] = queue.SimpleQueue()
        self.dropped = 0
        self.broken = False
        # a pipe that is full makes who writes wait: that is for this thread
        self._thread = threading.Thread(target=self._hand_over, name="transports", daemon=True)
        self._thread.start()

    def publish(self, topic: Topic, data: bytes) -> None:
        """Hands over a message, as CDR."""
        if self.broken or self._waiting.qsize() >= WAITING_MAX:
            self.dropped += 1
        else:
            self._waiting.put((topic, data))

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """From now on hands messages of a topic to `receive`."""
        if topic not in self._readers:
            self._waiting.put((topic, b""))
        self._readers.setdefault(topic, []).append(receive)

    def receive(self, seconds: float) -> None:
        """Hands on what has come; waits for the first, so long at most."""
        if not self._readers or self.broken:
            return
        try:
            while self._line.answers.poll(seconds):
                topic, data = self._line.answers.recv()
                for receive in self._readers.get(topic, ()):
                    receive(data)
                seconds = 0.0
        except (EOFError, OSError):
            self.broken = True

    def close(self) -> None:
        """Hangs up, once what waits has been handed over."""
        self._waiting.put(None)
        self._thread.join(END_WITHIN)
        self._line.close()

    def _hand_over(self) -> None:
        """The thread: words to the process, until there are no more or nobody is there."""
        try:
            while (word := self._waiting.get()) is not None:
                self._line.words.send(word)
        except OSError:
            self.broken = True


def _run(words: Connection, answers: Connection, reach: Reach) -> None:
    """The other process, until nobody holds the other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started it, who hangs up
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    with contextlib.suppress(OSError):  # nobody is there any more who started it
        try:
            transport, said = opened(reach, SHOWN)
        except RollgaitError as error:
            answers.send(error)
            return
        answers.send(said)
        _carry(transport, words, answers)
        transport.close()


def _carry(transport: Transport, words: Connection, answers: Connection) -> None:
    """Publishes what comes over the pipe, and answers with what others publish, until the pipe is closed."""

    def take(word: Any) -> None:
        topic, data = word
        if data:
            transport.publish(topic, data)
        else:
            transport.subscribe(topic, lambda heard: answers.send((topic, heard)))

    with contextlib.suppress(EOFError, OSError):
        while True:
            if words.poll(LOOK_EVERY):
                take(words.recv())
            transport.receive(0.0)
