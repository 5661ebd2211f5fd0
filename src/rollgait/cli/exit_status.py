"""Exit statuses of commands beside 0 done, 1 not solved or not passed, 2 wrong input."""

from typing import Final

INTERRUPTED: Final = 130
"""After Ctrl-C, as shells count it: 128 + SIGINT."""

INTERRUPTED_WORDS: Final = "stopped by Ctrl-C; no file is left half-written"
"""What is said then."""
