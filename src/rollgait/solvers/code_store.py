"""Stage codes on disk beside their kernels, so that a new process derives nothing.

A file holds what is needed to use a stage without CasADi's algebra: sparsities, index maps, names, and the
functions themselves, for where there is no compiler. It lies in the folder of the kernels, which nobody but
its user can write to.
"""

from __future__ import annotations

import json
import logging
import os
import tempfile
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from rollgait.errors import FileError
from rollgait.solvers.cache_folder import OWNER_ONLY, cache_folder, is_private_file, private_folder
from rollgait.solvers.kernels import CODE_SUFFIX, compiled
from rollgait.transcription.code import FUNCTION_NAMES, RowGroup, StageCode

log = logging.getLogger("rollgait")

INDEX_NAMES = ("jacobian_rows", "jacobian_cols", "hessian_rows", "hessian_cols", "linear")
"""Arrays of a stage code."""
UNREADABLE = (OSError, ValueError, KeyError, TypeError, RuntimeError, zipfile.BadZipFile)
"""What reading a damaged file raises; RuntimeError is CasADi's."""


class DiskStore:
    """Keeps stage codes in the folder of the cache; compiled ones beside them, where that is wanted."""

    def __init__(self, kernels: bool) -> None:
        self._kernels = kernels

    def load(self, key: str) -> StageCode | None:
        """What is kept under a key; None if nothing is, or nothing that can be read."""
        place = _place()
        if place is None:
            return None
        file = place / f"{key}{CODE_SUFFIX}"
        with suppress(*UNREADABLE):
            if is_private_file(file):
                # (a file of its own: NumPy leaves a damaged one open)
                with file.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
                    return self._read(key, data)
        return None

    def keep(self, key: str, code: StageCode, compile_it: bool) -> StageCode:
        """Writes a code, if there is a place for it; with kernels, it is compiled and returned so."""
        texts = {name: getattr(code, name).serialize() for name in FUNCTION_NAMES}
        place = _place()
        if place is not None:
            with suppress(OSError):  # a full disk is no reason not to plan
                _write(place / f"{key}{CODE_SUFFIX}", _as_arrays(code, texts, compile_it))
        return self._faster(key, code, texts) if self._kernels and compile_it else code

    def _read(self, key: str, data: Any) -> StageCode:
        about = json.loads(str(data["about"]))

        def functions() -> dict[str, ca.Function]:
            return {name: ca.Function.deserialize(str(data[name])) for name in FUNCTION_NAMES}

        fast = _kernel(key, functions) if self._kernels and about["compile_it"] else None
        parts: dict[str, Any] = {name: data[name] for name in INDEX_NAMES}
        parts |= functions() if fast is None else fast
        return StageCode(
            **parts,
            parameters=tuple((str(name), int(size)) for name, size in about["parameters"]),
            groups=tuple(RowGroup(**group) for group in about["groups"]),
            cost_names=tuple(about["cost_names"]),
        )

    def _faster(self, key: str, code: StageCode, texts: dict[str, str]) -> StageCode:
        def functions() -> dict[str, ca.Function]:
            return {name: ca.Function.deserialize(text) for name, text in texts.items()}

        fast = _kernel(key, functions)
        return code if fast is None else code.with_functions(fast)


@lru_cache(maxsize=2)
def store_for(kernels: bool) -> DiskStore:
    """The store of this process, with or without compiled kernels."""
    return DiskStore(kernels)


def _kernel(key: str, functions: Callable[[], dict[str, ca.Function]]) -> dict[str, ca.Function] | None:
    """The functions as machine code; only where they are not compiled yet are they made."""
    names = [f"stage_{name}" for name in FUNCTION_NAMES]
    fast = compiled(lambda: list(functions().values()), names, known_by=key)
    return None if fast is None else dict(zip(FUNCTION_NAMES, fast, strict=True))


def _place() -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    with suppress(FileError):  # the kernels say why
        return private_folder(folder, create=True)
    return None


def _as_arrays(code: StageCode, texts: dict[str, str], compile_it: bool) -> dict[str, Any]:
    about = {
        "parameters": code.parameters,
        "groups": [asdict(group) for group in code.groups],
        "cost_names": code.cost_names,
        "compile_it": compile_it,
    }
    return {name: getattr(code, name) for name in INDEX_NAMES} | texts | {"about": json.dumps(about)}


def _write(file: Path, arrays: dict[str, Any]) -> None:
    """All or nothing; two processes may do so at once."""
    handle, name = tempfile.mkstemp(dir=file.parent, prefix=".build-")
    try:
        with os.fdopen(handle, "wb") as stream:
            np.savez_compressed(stream, **arrays)
        Path(name).chmod(OWNER_ONLY)
        Path(name).replace(file)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
