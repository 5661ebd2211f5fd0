"""The command line: a thin shell over the public names. Entry point: `main`."""

from __future__ import annotations

import sys
from typing import NoReturn

from rollgait.cli.exit_status import INTERRUPTED, INTERRUPTED_WORDS


def main() -> NoReturn:
    """Entry point of the command line; Ctrl-C ends it in one line also while the commands are loaded."""
    try:
        from rollgait.cli.app import run

        status = run()
    except KeyboardInterrupt:
        print(f"error: {INTERRUPTED_WORDS}", file=sys.stderr)
        status = INTERRUPTED
    sys.exit(status)


__all__ = ["main"]
