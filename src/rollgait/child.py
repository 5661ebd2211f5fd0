"""Processes of this package, each told what to do, and saying what came of it, through pipes of its own.

What is said is pickled: both ends are this package, and nobody else has the pipes. No two processes share
one: a process that dies in the middle of a sentence spoils it for nobody else, and its parent learns of it.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import IO, Any, Final

from rollgait.errors import RollgaitError

_BEGIN: Final = b"\0rollgait\0"
"""Comes before the first sentence: what begins with the process, and prints, is passed over."""
_LENGTH: Final = struct.Struct("<Q")
_LOOK: Final = 1.0
"""Between two looks whether the parent is there, s: a process that it forked may hold its pipes open."""
_OWN_GROUP: Final = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
"""Ctrl-C in a terminal is for the parent; so it is on Windows."""


@dataclass(frozen=True)
class Unreadable:
    """In place of something that was said and cannot be read: why."""

    reason: str


class Child:
    """A process that runs `main` of a module of the package, which speaks as a `Parent` has it.

    It ends with its parent, does not hear Ctrl-C, has nothing on stdin, and prints to stderr.

    Args:
        module: its name.
        heard: is called with what it says, in a thread of its own; `Unreadable` if that cannot be read.
        ended: is called, in that thread, when it will say no more.
        silent: whether what it writes to stderr is thrown away.
        environment: variables that are others there.
    """

    def __init__(
        self,
        module: str,
        heard: Callable[[Any], None],
        ended: Callable[[], None],
        *,
        silent: bool = False,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        path = [str(place) for place in sys.path]
        begin = f"import sys; sys.path[:] = {path!r}; sys.argv[:] = {sys.argv!r}; "
        self._process = subprocess.Popen(
            [sys.executable, "-c", f"{begin}from {module} import main; main()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL if silent else None,
            env={**os.environ, **(environment or {})},
            start_new_session=True,  # Ctrl-C in a terminal is for its parent
            creationflags=_OWN_GROUP,
        )
        self._heard, self._ended, self._has_ended = heard, ended, False
        self._to_tell: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        try:
            for work in (self._listen, self._speak):
                threading.Thread(target=work, daemon=True).start()
        except BaseException:  # Ctrl-C: nobody has it yet, and could end it
            self._process.kill()
            raise

    def tell(self, what: object) -> bool:
        """Says something to the process, without waiting for it; False if it is known to have ended.

        Raises:
            RollgaitError: it cannot be pickled.
        """
        self._to_tell.put(pickled(what))
        return not self._has_ended

    def kill(self) -> None:
        """Ends the process, without waiting for its end."""
        self._process.kill()

    def close(self) -> None:
        """Ends the process."""
        self._process.kill()
        self._process.wait()
        self._to_tell.put(None)

    def _speak(self) -> None:
        assert self._process.stdin is not None
        if hasattr(signal, "pthread_sigmask"):  # where it was not ignored, a dead child would kill its parent
            signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
        with contextlib.suppress(OSError), self._process.stdin as stream:
            while (text := self._to_tell.get()) is not None:
                _write(stream, text)

    def _listen(self) -> None:
        assert self._process.stdout is not None
        try:
            with self._process.stdout as stream:
                if _found(stream, _BEGIN):
                    while (text := _read(stream)) is not None:
                        self._heard(unpickled(text))
        finally:
            self._has_ended = True
            self._to_tell.put(None)
            self._ended()


class Parent:
    """In the process: what its parent says, and what is said to it.

    The process ends when its parent has, as soon as Python has its turn.
    """

    def __init__(self) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        # what is done here, and the programs that it starts, have neither of the pipes
        self._orders = os.fdopen(os.dup(0), "rb", buffering=0)  # no lock that somebody holds at the very end
        self._answers = os.fdopen(os.dup(1), "wb")
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)
        if sys.stdout is not None:
            sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
        self._answers.write(_BEGIN)
        self._told: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        for work in (self._listen, self._watch):
            threading.Thread(target=work, daemon=True).start()

    def asks(self) -> Any:
        """The next that it says; `Unreadable` if that cannot be read here."""
        return unpickled(self._told.get())

    def tell(self, what: object) -> None:
        """Says something to the parent. Raises `RollgaitError` if it cannot be pickled."""
        text = pickled(what)
        try:
            _write(self._answers, text)
        except OSError:  # it has ended, or does not listen any more
            os._exit(0)

    def _listen(self) -> None:
        try:
            while (text := _read(self._orders)) is not None:
                self._told.put(text)
        finally:
            os._exit(0)

    def _watch(self) -> None:
        parent = os.getppid()
        while os.getppid() == parent:
            time.sleep(_LOOK)
        os._exit(0)


def pickled(what: object) -> bytes:
    """Something, classes of a notebook or script among it, as bytes. Raises `RollgaitError`."""
    import cloudpickle

    try:
        return bytes(cloudpickle.dumps(what))
    except Exception as error:
        raise RollgaitError(f"cannot be sent to another process: {_words(error)}") from error


def unpickled(text: bytes) -> Any:
    """What was pickled; `Unreadable` if that cannot be read here."""
    try:
        return pickle.loads(text)
    except BaseException as error:  # whatever reading calls: it must not end a thread
        return Unreadable(_words(error))


def _words(error: BaseException) -> str:
    """An error that is not ours, in a sentence."""
    return f"{type(error).__name__}: {error}"


def _write(stream: IO[bytes], text: bytes) -> None:
    stream.write(_LENGTH.pack(len(text)))
    stream.write(text)
    stream.flush()


def _read(stream: IO[bytes]) -> bytes | None:
    """The next that was written as a whole; None if nothing more comes."""
    head = _exactly(stream, _LENGTH.size)
    return None if head is None else _exactly(stream, _LENGTH.unpack(head)[0])


def _exactly(stream: IO[bytes], count: int) -> bytes | None:
    """So many bytes; None if there are no more so many."""
    parts = []
    while count > 0:
        try:
            part = stream.read(count)
        except (OSError, ValueError):  # ended, or closed
            return None
        if not part:
            return None
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


def _found(stream: IO[bytes], mark: bytes) -> bool:
    """Reads to the end of a mark; False if it does not come."""
    seen = b""
    while seen != mark:
        if (byte := _exactly(stream, 1)) is None:
            return False
        seen = (seen + byte)[-len(mark) :]
    return True
