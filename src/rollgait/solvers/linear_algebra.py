"""Fatrop's innermost loop, compiled for this processor.

Half of fatrop's time goes into one function of BLASFEO, the product of 4-row panels, and the BLASFEO in
CasADi's wheel is built for any x86-64 processor. The same product compiled for the processor at hand, loaded
first so that the dynamic linker prefers it, makes a whole solve nearly twice as fast.

It is used only where all of this holds: fatrop and BLASFEO are those that are known here, with panels of 4
rows; the product multiplies as BLASFEO's own does; and a problem of two stages has the same solution with it,
with BLASFEO's own and by a dense factorisation. Otherwise it hands everything on to BLASFEO's own, and
nothing changes. Other packages with a BLASFEO of their own (piqp) may get it as well: by that
name it is the same function in each.
"""

from __future__ import annotations

import ctypes
import logging
import os
import sys
import threading
from contextlib import suppress
from ctypes import CFUNCTYPE, POINTER, byref, c_double, c_int, c_long, c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.kernels import machine_code
from rollgait.solvers.product_code import ESTIMATE, FLAGS, FUNCTION, SOURCE
from rollgait.solvers.two_stages import error_of_two_stages
from rollgait.solvers.watched_here import CallHere, caller, comes_back

log = logging.getLogger("rollgait")

SWITCH = "ROLLGAIT_PRODUCT"
"""Environment variable that leaves BLASFEO its own product where it is `off`."""
BLASFEO = "BLASFEO"
BLASFEO_WITH_PRODUCT = "BLASFEO, product compiled for this processor"
"""What is in use, as statistics name it."""
TOLERANCE = 1e-9
"""Largest difference of two solutions of the problem of two stages, whose numbers are about 1."""

_Array = POINTER(c_double)
_Product = CFUNCTYPE(None, c_int, _Array, _Array, _Array, _Array, _Array, _Array)

_first_use = threading.Lock()
_in_front: list[ctypes.CDLL | None] = []
"""The product, if it is in use: empty as long as nobody asked for it."""


def use_fast_products() -> bool:
    """Puts the compiled product in front of BLASFEO's, if that can be done; whether it is there."""
    with _first_use:
        if not _in_front:
            _in_front.append(_put_in_front())
    return _in_front[0] is not None


def linear_algebra() -> str:
    """What fatrop's matrices are factorised by, in this process, as things are now."""
    return BLASFEO_WITH_PRODUCT if _product() is not None else BLASFEO


def call_here() -> CallHere | None:
    """How to call fatrop in one's own thread and come back for sure; None where that cannot be had."""
    product = _product()
    return None if product is None or not comes_back(product) else caller(product)


def _product() -> ctypes.CDLL | None:
    return _in_front[0] if _in_front else None


def _put_in_front() -> ctypes.CDLL | None:
    if os.environ.get(SWITCH, "").lower() == "off" or not sys.platform.startswith("linux"):
        return None
    try:
        fatrop, blasfeo = c.library_files()
    except c.InterfaceError as error:
        log.info("%s: planning without a product of our own", error)
        return None
    ours = machine_code(lambda: SOURCE, SOURCE, FLAGS, _load)
    if ours is None:
        return None
    with suppress(OSError, AttributeError):  # who has no estimate by this name makes his own
        own_estimate = getattr(ctypes.CDLL(str(fatrop)), ESTIMATE)
        ours.rollgait_own_estimate(ctypes.cast(own_estimate, c_void_p))
    return ours if _is_of_use(ours, blasfeo) else None


def _load(library: Path) -> ctypes.CDLL:
    """The compiled product, in front of all that is loaded later."""
    loaded = ctypes.CDLL(str(library), mode=ctypes.RTLD_LOCAL)
    loaded.rollgait_use_instead.argtypes = [c_void_p]
    loaded.rollgait_calls_instead.restype = c_long
    loaded.rollgait_own_estimate.argtypes = [c_void_p]
    if not _multiplies(getattr(loaded, FUNCTION)):
        raise OSError("the compiled matrix product is wrong on this machine")
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    return loaded


def _is_of_use(ours: ctypes.CDLL, file: Path) -> bool:
    """Whether BLASFEO calls our product, and does with it what it does without; otherwise it has its own."""
    try:
        blasfeo = ctypes.CDLL(str(file))
        own = getattr(blasfeo, FUNCTION)
        ours.rollgait_use_instead(ctypes.cast(own, c_void_p))
        reason = _objection(ours, blasfeo, own)
    except (OSError, AttributeError) as error:  # then nobody calls it by this name
        reason = str(error)
    if reason:
        log.info("no product of our own in BLASFEO: %s", reason)
        return False
    return True


def _objection(ours: ctypes.CDLL, blasfeo: ctypes.CDLL, own: Any) -> str:
    """Why our product, which calls BLASFEO's own now, should not be used; "" if it is in use afterwards."""
    if (panel := _panel_size(blasfeo)) != c.PANEL:
        return f"its panels have {panel} rows, not {c.PANEL}"
    if not _multiplies(own):
        return "its own multiplies something else"
    if not error_of_two_stages() < TOLERANCE:
        return "a problem of two stages is not solved without it"
    if ours.rollgait_calls_instead() == 0:
        return "it was loaded before"
    ours.rollgait_use_instead(None)
    if not error_of_two_stages() < TOLERANCE:
        ours.rollgait_use_instead(ctypes.cast(own, c_void_p))
        return "a problem of two stages is not solved with it"
    return ""


def _panel_size(blasfeo: ctypes.CDLL) -> int:
    """Rows of a panel: what is allotted to a matrix of one row."""
    matrix = c.Matrix()
    blasfeo.blasfeo_allocate_dmat.argtypes = [c_int, c_int, POINTER(c.Matrix)]
    blasfeo.blasfeo_free_dmat.argtypes = [POINTER(c.Matrix)]
    blasfeo.blasfeo_allocate_dmat(1, 1, byref(matrix))
    rows = int(matrix.pm)
    blasfeo.blasfeo_free_dmat(byref(matrix))
    return rows


def _multiplies(function: Any) -> bool:
    """Whether a function computes the product: nobody else would notice if it did not."""
    product = ctypes.cast(function, _Product)
    generator = np.random.default_rng(0)
    for columns in (0, 1, 2, 5):
        A, B, C = (generator.normal(size=(size, 4)) for size in (columns, columns, 4))
        D = np.empty((4, 4))
        alpha, beta = c_double(1.5), c_double(-0.5)
        a, b, given, result = (array.ctypes.data_as(_Array) for array in (A, B, C, D))
        product(columns, byref(alpha), a, b, byref(beta), given, result)
        # the arrays hold columns as rows: the transposed of the product is B Aᵀ
        if not np.allclose(D, 1.5 * B.T @ A - 0.5 * C, atol=1e-12):
            return False
    return True
