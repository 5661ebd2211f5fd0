"""How much the command line says: `-q` nothing but errors, `-v` all that is known."""

from __future__ import annotations

import contextlib
import logging
import os
import sys
from collections.abc import Iterator, Sequence
from enum import Enum
from typing import Final, TextIO

FLAGS: Final = ("-q", "--quiet", "-v", "--verbose")


class Verbosity(Enum):
    """What is said, and the level from which the log is shown."""

    QUIET = logging.ERROR
    NORMAL = logging.INFO
    VERBOSE = logging.DEBUG


_now = Verbosity.NORMAL
_data: TextIO | None = None


def verbosity() -> Verbosity:
    """How much the running command says."""
    return _now


def stdout_of_data() -> TextIO:
    """Where data go that were asked for: stdout, however quiet the command is."""
    return _data or sys.stdout


@contextlib.contextmanager
def speaking(wanted: Verbosity) -> Iterator[None]:
    """Within this block the command line says so much. Quiet, nothing is printed on stdout but JSON."""
    global _now, _data
    before, log = (_now, _data), logging.getLogger("rollgait")
    level = log.level
    with contextlib.ExitStack() as stack:
        if wanted is Verbosity.QUIET:
            _data = sys.stdout
            nowhere = stack.enter_context(open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123
            stack.enter_context(contextlib.redirect_stdout(nowhere))
        _now = wanted
        log.setLevel(wanted.value)
        try:
            yield
        finally:
            _now, _data = before
            log.setLevel(level)


def flags_first(arguments: Sequence[str]) -> list[str]:
    """The arguments, what says how much is said in front: the parser knows it before the command only."""
    end = arguments.index("--") if "--" in arguments else len(arguments)
    flags = [each for each in arguments[:end] if each in FLAGS]
    return [*flags, *(each for each in arguments[:end] if each not in FLAGS), *arguments[end:]]
