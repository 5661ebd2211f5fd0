"""The command line: a thin shell over the public names. Entry point: `main`."""

from rollgait.cli.app import main

__all__ = ["main"]
