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
from collections.abc import Callable
from typing import IO, Any, Final

_LENGTH: Final = struct.Struct("<Q")


class Child:
    """A process that runs `main` of a module of the package, which speaks as a `Parent` has it.

    It ends with its parent, does not hear Ctrl-C, and writes to stderr whatever it prints.

    Args:
        module: its name.
        heard: is called with what it says, in a thread of its own; with the error, if that cannot be read.
        ended: is called, in that thread, when it will say no more.
        silent: whether what it writes to stderr is thrown away.
    """

    def __init__(
        self,
        module: str,
        heard: Callable[[Any], None],
        ended: Callable[[], None],
        *,
        silent: bool = False,
    ) -> None:
        begin = f"import sys; sys.path[:] = {sys.path!r}; from {module} import main; main()"
        self._process = subprocess.Popen(
            [sys.executable, "-c", begin],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL if silent else None,
            start_new_session=True,  # Ctrl-C in a terminal is for its parent
        )
        self._heard, self._ended = heard, ended
        threading.Thread(target=self._listen, daemon=True).start()

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def tell(self, what: object) -> bool:
        """Says something to the process; False if it has ended. What cannot be pickled raises its error."""
        text = _pickled(what)
        assert self._process.stdin is not None
        try:
            _write(self._process.stdin, text)
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Ends the process."""
        self._process.kill()
        self._process.wait()
        if self._process.stdin is not None:
            with contextlib.suppress(OSError):  # something may be left that nobody reads
                self._process.stdin.close()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stream:
            while (text := _read(stream)) is not None:
                self._heard(_said(text))
        self._ended()


class Parent:
    """In the process: what its parent says, and what is said to it.

    The process ends as soon as its parent has, whatever it does.
    """

    def __init__(self) -> None:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        self._answers = os.fdopen(os.dup(1), "wb")
        os.dup2(2, 1)  # what a solver prints must not get between the answers
        self._told: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()

    def asks(self) -> Any:
        """The next that it says; an error, if that cannot be read here."""
        return _said(self._told.get())

    def tell(self, what: object) -> None:
        """Says something to the parent."""
        _write(self._answers, _pickled(what))

    def _listen(self) -> None:
        while (text := _read(sys.stdin.buffer)) is not None:
            self._told.put(text)
        os._exit(0)


def _pickled(what: object) -> bytes:
    import cloudpickle

    return bytes(cloudpickle.dumps(what))


def _said(text: bytes) -> Any:
    """What was said; the error of reading it is said, too."""
    try:
        return pickle.loads(text)
    except Exception as error:
        return error


def _write(stream: IO[bytes], text: bytes) -> None:
    stream.write(_LENGTH.pack(len(text)))
    stream.write(text)
    stream.flush()


def _read(stream: IO[bytes]) -> bytes | None:
    """The next that was written as a whole; None if nothing more comes."""
    try:
        head = stream.read(_LENGTH.size)
        if len(head) < _LENGTH.size:
            return None
        (length,) = _LENGTH.unpack(head)
        text = stream.read(length)
    except (OSError, ValueError):  # ended, or closed
        return None
    return text if len(text) == length else None
