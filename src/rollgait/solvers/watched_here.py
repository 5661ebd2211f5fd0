"""Fatrop called in the thread of who waits for it, and left if it does not come back.

See `product_code.py` for how. It needs the product in front of BLASFEO; where that is missing, another thread
waits (`watched.py`), which a busy machine wakes late.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import CFUNCTYPE, POINTER, byref, c_double, c_int, c_long, c_void_p
from typing import Any, ClassVar, Final

from rollgait.solvers.watched import NoAnswerError

TRIAL_PATIENCE: Final = 1e-3
"""s of silence in the trial of the watch."""

Task = CFUNCTYPE(c_int, c_void_p)


class Watch(ctypes.Structure):
    """Signs of life so far, the longest silence, s of the thread's processor time, and whether fatrop finds
    multipliers of equations before its first iteration."""

    _fields_: ClassVar = [("signs", c_long), ("patience", c_double), ("estimates", c_long)]


CallHere = Callable[[Any, c_void_p, Watch], int]
"""Calls a C function of one pointer in this thread; raises `NoAnswerError` if it was left."""


def caller(product: ctypes.CDLL) -> CallHere:
    """How to call what makes products, with a library of `product_code.py` in front of BLASFEO."""
    watched = product.rollgait_call_watched
    watched.argtypes, watched.restype = [c_void_p, c_void_p, POINTER(Watch), POINTER(c_int)], c_int

    def call_here(function: Any, argument: c_void_p, watch: Watch) -> int:
        result = c_int()
        if not watched(ctypes.cast(function, c_void_p), argument, byref(watch), byref(result)):
            raise NoAnswerError(f"no sign of life for {watch.patience:g} s")
        return int(result.value)

    return call_here


def comes_back(product: ctypes.CDLL) -> bool:
    """Whether the watch leaves what makes products without end, and lets be what ends."""
    call_here, watch = caller(product), Watch(0, TRIAL_PATIENCE)
    if call_here(product.rollgait_ends, c_void_p(), watch) != 1:
        return False
    try:
        call_here(product.rollgait_never_ends, c_void_p(), watch)
    except NoAnswerError:
        return True
    return False
