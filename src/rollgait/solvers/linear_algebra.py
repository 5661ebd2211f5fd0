"""Fatrop's innermost loop, compiled for this processor.

Half of fatrop's time goes into one function of BLASFEO, the product of 4-row panels, and the BLASFEO in
CasADi's wheel is built for any x86-64 processor. The same product compiled for the processor at hand, loaded
first so that the dynamic linker prefers it, makes a whole solve nearly twice as fast. Where it cannot be had,
nothing changes.
"""

from __future__ import annotations

import ctypes
import logging
import sys
from functools import lru_cache
from pathlib import Path

import numpy as np

from rollgait.solvers.kernels import FOR_THIS_PROCESSOR, machine_code

log = logging.getLogger("rollgait")

FUNCTION = "kernel_dgemm_nt_4x4_lib4"
"""D = α A Bᵀ + β C with A, B panels of 4 rows and kmax columns, C and D of 4 × 4, all column-major."""

SOURCE = f"""
typedef double column __attribute__((vector_size(32), aligned(8)));

void {FUNCTION}(int kmax, double *alpha, double *A, double *B, double *beta, double *C, double *D)
{{
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


@lru_cache
def use_fast_products() -> bool:
    """Puts the compiled product in front of BLASFEO's, which must not be loaded yet; whether it is there."""
    if not sys.platform.startswith("linux"):
        return False
    library = machine_code(SOURCE, FLAGS)
    if library is None or not _is_right(library):
        return False
    ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    return True


def _is_right(library: Path) -> bool:
    """Whether the compiled product multiplies: nobody else would notice if it did not."""
    product = getattr(ctypes.CDLL(str(library), mode=ctypes.RTLD_LOCAL), FUNCTION)
    generator = np.random.default_rng(0)
    for columns in (0, 1, 2, 5):
        A, B, C = (generator.normal(size=(size, 4)) for size in (columns, columns, 4))
        D = np.empty((4, 4))
        alpha, beta = ctypes.c_double(1.5), ctypes.c_double(-0.5)
        arrays = [a.ctypes.data_as(ctypes.c_void_p) for a in (A, B, C, D)]
        product(columns, ctypes.byref(alpha), arrays[0], arrays[1], ctypes.byref(beta), arrays[2], arrays[3])
        # the arrays hold columns as rows: the transposed of the product is B Aᵀ
        if not np.allclose(D, 1.5 * B.T @ A - 0.5 * C, atol=1e-12):
            log.info("the compiled matrix product is wrong on this machine: planning without")
            return False
    return True
