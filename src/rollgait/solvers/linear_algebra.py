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
from ctypes import CFUNCTYPE, POINTER, byref, c_double, c_int, c_long, c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.kernels import FOR_THIS_PROCESSOR, machine_code
from rollgait.solvers.two_stages import error_of_two_stages

log = logging.getLogger("rollgait")

SWITCH = "ROLLGAIT_PRODUCT"
"""Environment variable that leaves BLASFEO its own product where it is `off`."""
BLASFEO = "BLASFEO"
BLASFEO_WITH_PRODUCT = "BLASFEO, product compiled for this processor"
"""What is in use, as statistics name it."""
TOLERANCE = 1e-9
"""Largest difference of two solutions of the problem of two stages, whose numbers are about 1."""

FUNCTION = "kernel_dgemm_nt_4x4_lib4"
"""D = α A Bᵀ + β C with A, B panels of 4 rows and kmax columns, C and D of 4 × 4, all column-major."""

SOURCE = f"""
typedef double column __attribute__((vector_size(32), aligned(8)));
typedef void product(int, double *, double *, double *, double *, double *, double *);

static product *instead; /* is called in place of this one, and counted, if there is one */
static long calls;

void rollgait_use_instead(product *other) {{ instead = other; calls = 0; }}
long rollgait_calls_instead(void) {{ return calls; }}

void {FUNCTION}(int kmax, double *alpha, double *A, double *B, double *beta, double *C, double *D)
{{
    if (instead) {{
        calls++;
        instead(kmax, alpha, A, B, beta, C, D);
        return;
    }}
    /* two sums for each column: one would wait for its own last addition */
    column even[4] = {{{{0}}}}, odd[4] = {{{{0}}}};
    int k = 0;
    for (; k + 1 < kmax; k += 2) {{
        column a = *(column *)(A + 4 * k), b = *(column *)(A + 4 * k + 4);
        for (int j = 0; j < 4; j++) {{
            even[j] += a * B[4 * k + j];
            odd[j] += b * B[4 * k + 4 + j];
        }}
    }}
    if (k < kmax) {{
        column a = *(column *)(A + 4 * k);
        for (int j = 0; j < 4; j++)
            even[j] += a * B[4 * k + j];
    }}
    for (int j = 0; j < 4; j++) {{
        column sum = *alpha * (even[j] + odd[j]);
        if (*beta != 0.0)
            sum += *beta * *(column *)(C + 4 * j);
        *(column *)(D + 4 * j) = sum;
    }}
}}
"""
FLAGS = ("-O3", FOR_THIS_PROCESSOR, "-fPIC", "-shared")

_Array = POINTER(c_double)
_Product = CFUNCTYPE(None, c_int, _Array, _Array, _Array, _Array, _Array, _Array)

_first_use = threading.Lock()
_in_front: list[bool] = []
"""Whether the product is in use: empty as long as nobody asked for it."""


def use_fast_products() -> bool:
    """Puts the compiled product in front of BLASFEO's, if that can be done; whether it is there."""
    with _first_use:
        if not _in_front:
            _in_front.append(_put_in_front())
    return _in_front[0]


def linear_algebra() -> str:
    """What fatrop's matrices are factorised by, in this process, as things are now."""
    return BLASFEO_WITH_PRODUCT if _in_front == [True] else BLASFEO


def _put_in_front() -> bool:
    if os.environ.get(SWITCH, "").lower() == "off" or not sys.platform.startswith("linux"):
        return False
    try:
        _, blasfeo = c.library_files()
    except c.InterfaceError as error:
        log.info("%s: planning without a product of our own", error)
        return False
    ours = machine_code(lambda: SOURCE, SOURCE, FLAGS, _load)
    return ours is not None and _is_of_use(ours, blasfeo)


def _load(library: Path) -> ctypes.CDLL:
    """The compiled product, in front of all that is loaded later."""
    loaded = ctypes.CDLL(str(library), mode=ctypes.RTLD_LOCAL)
    loaded.rollgait_use_instead.argtypes = [c_void_p]
    loaded.rollgait_calls_instead.restype = c_long
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
