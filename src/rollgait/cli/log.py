"""What the library logs, as plain lines on stderr."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from rollgait.cli.output import print_note


class _Lines(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        print_note(record.getMessage())


@contextmanager
def log_on_stderr() -> Iterator[None]:
    """Shows what is logged under `rollgait` while the block runs, from INFO on."""
    log, handler = logging.getLogger("rollgait"), _Lines()
    before = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(before)
