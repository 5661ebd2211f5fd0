"""`rollgait cache`: the compiled kernels on disk."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from rollgait.cli.arguments import AsJson
from rollgait.cli.output import print_json, print_table


def cache(
    clear: Annotated[bool, typer.Option("--clear", help="Remove all kernels.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show or remove the compiled kernels.

    They are made once and speed up every later plan. The environment variable ROLLGAIT_CACHE names
    another folder for them, or switches them off with 'off'.
    """
    from rollgait.solvers.cache_folder import cache_folder
    from rollgait.solvers.kernels import cached_kernels, clear_cache  # loads CasADi

    folder = cache_folder()
    removed = clear_cache() if clear else 0
    kernels, now = cached_kernels(), time.time()
    if as_json:
        files = [{"file": k.path.name, "bytes": k.size, "age": now - k.built} for k in kernels]
        where = None if folder is None else str(folder)
        print_json({"folder": where, "kernels": files} | ({"removed": removed} if clear else {}))
        return
    print(f"folder:  {'off (ROLLGAIT_CACHE)' if folder is None else folder}")
    if clear:
        print(f"removed: {removed}")
        return
    print(f"kernels: {len(kernels)}, {_size(sum(kernel.size for kernel in kernels))}")
    if kernels:
        rows = [(kernel.path.name, _size(kernel.size), _age(now - kernel.built)) for kernel in kernels]
        print_table([("file", "size", "age"), *rows], right=[1, 2])


def _size(count: int) -> str:
    return f"{count / 1024:.0f} KiB" if count < 1024**2 else f"{count / 1024**2:.1f} MiB"


def _age(seconds: float) -> str:
    """In the largest unit of which there are two or more."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{max(0.0, seconds):.0f} s"
