"""Fatrop's C interface by ctypes, and a check that the library is the one that is described here.

The library comes inside CasADi's wheel, whose own adapter spends 0.4 to 1.1 s on setting up each solver.
The layout below is that of fatrop 1.1 and BLASFEO 0.1.4 in panel-major format.
"""

from __future__ import annotations

import ctypes
from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_double, c_int, c_void_p
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

Pointer = Any
"""What ctypes calls a pointer instance."""


class InterfaceError(RuntimeError):
    """The library is missing or its interface is not the expected one."""


class Dims(Structure):
    """Sizes and offsets of the stages, as fatrop numbers them."""

    _fields_: ClassVar = [
        *((name, POINTER(c_int)) for name in ("ux_offs", "g_offs", "dyn_offs", "dyn_eq_offs")),
        *((name, POINTER(c_int)) for name in ("g_ineq_offs", "ineq_offs")),
        *((name, c_int) for name in ("max_nu", "max_nx", "max_ng", "max_ngineq", "n_ineqs", "K")),
        *((name, POINTER(c_int)) for name in ("nu", "nx", "ng", "ng_ineq")),
    ]


class Matrix(Structure):
    """A BLASFEO matrix: panels of `PANEL` rows, each column-major, `cn` columns wide."""

    _fields_: ClassVar = [
        ("mem", c_void_p),
        ("pA", c_void_p),
        ("dA", c_void_p),
        *((name, c_int) for name in ("m", "n", "pm", "cn", "use_dA", "memsize")),
    ]


class Vector(Structure):
    """A BLASFEO vector."""

    _fields_: ClassVar = [
        ("mem", c_void_p),
        ("pa", POINTER(c_double)),
        ("m", c_int),
        ("pm", c_int),
        ("memsize", c_int),
    ]


class Stats(Structure):
    """What fatrop reports at the end."""

    _fields_: ClassVar = [
        *(
            (f"{name}_time", c_double)
            for name in ("compute_sd", "duinf", "eval_hess", "eval_jac", "eval_cv", "eval_grad", "eval_obj")
        ),
        ("initialization_time", c_double),
        ("time_total", c_double),
        *((f"eval_{name}_count", c_int) for name in ("hess", "jac", "cv", "grad", "obj")),
        ("iterations_count", c_int),
        ("return_flag", c_int),
    ]


PANEL = 4
"""Rows of a panel, D_PS of the BLASFEO target in the wheel."""

GetDimension = CFUNCTYPE(c_int, c_int, c_void_p)
GetNumber = CFUNCTYPE(c_int, c_void_p)
# (numbers are handed on as addresses: ctypes makes no object for those)
GetStageValues = CFUNCTYPE(c_int, c_void_p, c_int, c_void_p)
GetValues = CFUNCTYPE(c_int, c_void_p, c_void_p)
GetBounds = CFUNCTYPE(c_int, c_void_p, c_void_p, c_int, c_void_p)
FullHessian = CFUNCTYPE(c_int, c_double, *[c_void_p] * 7)
FullJacobian = CFUNCTYPE(c_int, *[c_void_p] * 8)
FullViolation = CFUNCTYPE(c_int, *[c_void_p] * 6)
FullObjective = CFUNCTYPE(c_int, c_double, *[c_void_p] * 6)

SKIP = 1
"""What a full evaluation returns to say that the functions of single stages need not be called."""


class Interface(Structure):
    """The callbacks by which fatrop asks for the problem. Those of single stages stay empty."""

    _fields_: ClassVar = [
        ("get_nx", GetDimension),
        ("get_nu", GetDimension),
        ("get_ng", GetDimension),
        ("get_n_stage_params", GetDimension),
        ("get_n_global_params", GetNumber),
        ("get_default_stage_params", GetStageValues),
        ("get_default_global_params", GetValues),
        ("get_ng_ineq", GetDimension),
        ("get_horizon_length", GetNumber),
        *(
            (f"eval_{name}", c_void_p)
            for name in ("BAbt", "RSQrqt", "Ggt", "Ggt_ineq", "b", "g", "gineq", "rq", "L")
        ),
        ("get_bounds", GetBounds),
        ("get_initial_xk", GetStageValues),
        ("get_initial_uk", GetStageValues),
        ("full_eval_lag_hess", FullHessian),
        ("full_eval_constr_jac", FullJacobian),
        ("full_eval_contr_viol", FullViolation),
        ("full_eval_obj_grad", FullObjective),
        ("full_eval_obj", FullObjective),
        ("user_data", c_void_p),
    ]


@lru_cache
def library_files() -> tuple[Path, Path]:
    """Fatrop and BLASFEO in CasADi's wheel. Raises `InterfaceError` if they have not these versions."""
    import casadi

    folder = Path(casadi.__file__).parent
    found = []
    for name, version in (("fatrop", "1.1"), ("blasfeo", "0.1.4")):
        files = sorted(folder.glob(f"lib{name}.so.{version}*"))
        if not files:
            raise InterfaceError(f"{name} {version} is not in CasADi's wheel")
        found.append(files[0])
    return found[0], found[1]


@lru_cache
def library() -> ctypes.CDLL:
    """The library, with the signatures of its functions. Raises `InterfaceError`."""
    file, _ = library_files()
    try:
        loaded = ctypes.CDLL(str(file))
        _declare(loaded)
        kinds = {name: loaded.fatrop_ocp_c_option_type(name.encode()) for name in ("tol", "max_iter")}
    except (OSError, AttributeError) as error:
        raise InterfaceError(f"fatrop's C interface cannot be used: {error}") from None
    if kinds != {"tol": 0, "max_iter": 1}:
        raise InterfaceError(f"fatrop's C interface is not the expected one: option types {kinds}")
    return loaded


def _declare(loaded: ctypes.CDLL) -> None:
    for name, result, arguments in (
        ("create", c_void_p, [POINTER(Interface), c_void_p, c_void_p]),
        ("destroy", None, [c_void_p]),
        ("solve", c_int, [c_void_p]),
        ("option_type", c_int, [c_char_p]),
        ("set_option_double", c_int, [c_void_p, c_char_p, c_double]),
        ("set_option_int", c_int, [c_void_p, c_char_p, c_int]),
        ("get_primal", POINTER(Vector), [c_void_p]),
        ("get_dual", POINTER(Vector), [c_void_p]),
        ("get_dims", POINTER(Dims), [c_void_p]),
        ("get_stats", POINTER(Stats), [c_void_p]),
    ):
        function = getattr(loaded, f"fatrop_ocp_c_{name}")
        function.restype, function.argtypes = result, arguments
