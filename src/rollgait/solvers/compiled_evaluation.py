"""What fatrop asks of a problem, answered in C (`evaluation_code.py`): the same as `Evaluation`, sooner.

The stage functions are those of `StageEvaluation`, called by the same buffers of CasADi; only who gathers
arguments and puts numbers in place is another. It needs a compiler, and a CasADi whose buffers can be
evaluated from C; without, NumPy does it.
"""

from __future__ import annotations

import ctypes
import logging
from ctypes import POINTER, Structure, byref, c_double, c_int, c_ssize_t, c_void_p
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.evaluation_code import FLAGS, SOURCE
from rollgait.solvers.fatrop_evaluation import (
    DOUBLE,
    Array,
    Evaluation,
    NotFiniteError,
    StagewiseCalls,
    memory_of,
)
from rollgait.solvers.fatrop_matrices import HessianFill, JacobianFill
from rollgait.solvers.fatrop_rows import Rows
from rollgait.solvers.kernels import machine_code
from rollgait.solvers.stage_evaluation import StageEvaluation
from rollgait.transcription.nlp import Nlp

log = logging.getLogger("rollgait")

EVALUATE: Final = "_ZN6casadi21_function_buffer_evalEPv"
"""CasADi's evaluation of a buffer."""


def _fields(numbers: str, addresses: str) -> list[tuple[str, Any]]:
    return [
        *((name, c_ssize_t) for name in numbers.split()),
        *((name, c_void_p) for name in addresses.split()),
    ]


class _Block(Structure):
    _fields_: ClassVar = _fields(
        "repetitions inputs costs rows slopes jacobian lam second first",
        "position row_source row_number slope_source slope_place lam_index y lam_value lam_f "
        "cost_value row_value slope_value jacobian_value second_value first_value "
        "value gradient jacobian_buffer hessian",
    )


class _Problem(Structure):
    _fields_: ClassVar = [
        *_fields(
            "size rows blocks equal unequal bounded defining is_loaded is_valued",
            "order rows_equal rows_unequal variables_bounded rows_defining "
            "at_equal at_unequal at_bounded at_defining g_lower g_upper lower upper "
            "x all g jacobian second first multipliers block evaluate",
        ),
        ("cost", c_double),
    ]


class _Place(Structure):
    _fields_: ClassVar = _fields("count", "target source")


class _JacobianFill(Structure):
    _fields_: ClassVar = [
        ("data", c_void_p * 3),
        ("derivative", _Place * 3),
        ("below", _Place * 3),
        ("bound_entry", _Place),
        ("bound_row", _Place),
    ]


class _HessianFill(Structure):
    _fields_: ClassVar = [
        ("data", c_void_p),
        *((name, _Place) for name in ("upper", "lower", "last_rows", "below", "bound")),
    ]


class _Stages(Structure):
    _fields_: ClassVar = _fields("", "first_bound begin states low high guess")


@lru_cache(maxsize=1)
def library() -> ctypes.CDLL | None:
    """The compiled functions; None where they cannot be had, which is logged."""
    try:
        _evaluate()
    except (OSError, AttributeError) as error:
        log.info("CasADi's buffers cannot be evaluated from C: %s", error)
        return None
    return machine_code(lambda: SOURCE, SOURCE, FLAGS, _load)


def _load(file: Path) -> ctypes.CDLL:
    loaded = ctypes.CDLL(str(file))
    problem, double, address = POINTER(_Problem), c_double, c_void_p
    for name, result, arguments in (
        ("cost", double, [problem, address]),
        ("worst", double, [problem, address]),
        ("put_cost", None, [problem, double, address, address]),
        ("put_gradient", None, [problem, double, address, address]),
        ("put_violation", None, [problem, address, address]),
        ("put_jacobian", c_int, [problem, address, address]),
        ("put_hessian", c_int, [problem, double, address, address, address]),
    ):
        function = getattr(loaded, f"rollgait_{name}")
        function.restype, function.argtypes = result, arguments
    return loaded


@lru_cache(maxsize=1)
def _evaluate() -> int:
    """Address of CasADi's evaluation of a buffer. Raises `OSError` or `AttributeError`."""
    import casadi

    files = sorted(Path(casadi.__file__).parent.glob("libcasadi.so*"))
    if not files:
        raise OSError("CasADi has no library of this name")
    # (the one that is loaded already)
    return _address_of(getattr(ctypes.CDLL(str(files[-1])), EVALUATE))


def _address_of(function: Any) -> int:
    return int(ctypes.cast(function, c_void_p).value or 0)


class CompiledStagewiseCalls(StagewiseCalls):
    """`StagewiseCalls` in C.

    Args:
        rows, guess: as there.
        loaded: the compiled functions.
    """

    def __init__(self, rows: Rows, guess: Array, loaded: ctypes.CDLL) -> None:
        first_bound, begin = (np.array(first, dtype=np.intp) for first in rows.begins)
        self._kept = (first_bound, begin, np.array(rows.nx, dtype=np.intp), *rows.limits, guess)
        self._given = _Stages(*(array.ctypes.data for array in self._kept))
        self.user_data = ctypes.addressof(self._given)
        self.bounds = c.GetBounds(_address_of(loaded.rollgait_bounds))
        self.states = c.GetStageValues(_address_of(loaded.rollgait_initial_states))
        self.inputs = c.GetStageValues(_address_of(loaded.rollgait_initial_inputs))


class CompiledEvaluation(Evaluation):
    """`Evaluation` in C.

    Args:
        nlp, rows, dims: as there.
        loaded: the compiled functions.
    """

    def __init__(self, nlp: Nlp, rows: Rows, dims: c.Dims, loaded: ctypes.CDLL) -> None:
        super().__init__(nlp, rows, dims)
        self._library = loaded
        self._kept: list[NDArray[Any]] = []
        self._of_jacobians: dict[int, tuple[JacobianFill, _JacobianFill]] = {}
        self._of_hessians: dict[int, tuple[HessianFill, _HessianFill]] = {}
        self._problem = self._make_problem()
        self._at = byref(self._problem)
        self._limits: tuple[Array, ...] = ()

    def _address(self, array: NDArray[Any]) -> int:
        """Of an array that is kept as long as this."""
        self._kept.append(array)
        return int(array.ctypes.data)

    def _make_problem(self) -> _Problem:
        nlp, rows, places, of = self.nlp, self._rows, self._places, self._address
        blocks = [self._make_block(stage) for stage in self.stages]
        self._blocks = (_Block * len(blocks))(*blocks)
        self._all: Array = np.zeros(nlp.size + nlp.fixed_values.size)
        self._g: Array = np.zeros(nlp.rows)
        lengths = {name: sum(getattr(b, name) for b in blocks) for name in ("jacobian", "second", "first")}
        numbers: dict[str, int] = {
            "size": nlp.size,
            "rows": nlp.rows,
            "blocks": len(blocks),
            "evaluate": _evaluate(),
            "block": ctypes.addressof(self._blocks),
            "order": of(rows.order),
            "variables_bounded": of(rows.bounded),
            "x": of(np.zeros(nlp.size)),
            "all": of(self._all),
            "g": of(self._g),
            "multipliers": of(self._row_multipliers),
        }
        numbers |= {name: of(np.zeros(max(1, length))) for name, length in lengths.items()}
        for name in ("equal", "unequal", "bounded", "defining"):
            which = getattr(rows, name)
            numbers |= {name: which.size, f"at_{name}": of(getattr(places, name))}
            if name != "bounded":
                numbers[f"rows_{name}"] = of(which)
        return _Problem(**numbers)

    def _make_block(self, stage: StageEvaluation) -> _Block:
        of, place = self._address, np.empty(self.nlp.size, dtype=np.intp)
        place[self._rows.order] = np.arange(self.nlp.size)
        cost, row = stage.buffers["value"].outputs
        (slope,), (jacobian,) = stage.buffers["gradient"].outputs, stage.buffers["jacobian"].outputs
        second, first = stage.buffers["hessian"].outputs
        return _Block(
            repetitions=stage.lam_f.size,
            inputs=stage.y.size,
            costs=cost.size,
            rows=stage.row_source.size,
            slopes=stage.variable_source.size,
            jacobian=jacobian.size,
            lam=stage.lam.size,
            second=second.size,
            first=first.size,
            position=of(stage.position),
            row_source=of(stage.row_source),
            row_number=of(stage.row_number),
            slope_source=of(stage.variable_source),
            slope_place=of(place[stage.variable_number]),
            lam_index=of(stage.lam_index),
            y=of(stage.y),
            lam_value=of(stage.lam),
            lam_f=of(stage.lam_f),
            cost_value=of(cost),
            row_value=of(row),
            slope_value=of(slope),
            jacobian_value=of(jacobian),
            second_value=of(second),
            first_value=of(first),
            value=stage.buffers["value"].address,
            gradient=stage.buffers["gradient"].address,
            jacobian_buffer=stage.buffers["jacobian"].address,
            hessian=stage.buffers["hessian"].address,
        )

    def begin(self) -> None:
        nlp = self.nlp
        limits = (nlp.g_lower, nlp.g_upper, nlp.lower, nlp.upper)
        if len(self._limits) != len(limits) or any(
            a is not b for a, b in zip(limits, self._limits, strict=True)
        ):
            self._limits = limits
            for name, array in zip(("g_lower", "g_upper", "lower", "upper"), limits, strict=True):
                setattr(self._problem, name, array.ctypes.data)
        super().begin()

    def _forget(self) -> None:
        self._all[self.nlp.size :] = self.nlp.fixed_values
        self._problem.is_loaded = 0

    # -- values ------------------------------------------------------------------------------------------

    def _values(self, w: Array) -> tuple[float, Array]:
        x = np.ascontiguousarray(w[self._rows.order])
        return self.cost(x.ctypes.data), self._g.copy()

    def variables(self, x: int) -> Array:
        self._library.rollgait_cost(self._at, x)
        return self._all[: self.nlp.size].copy()

    def cost(self, x: int) -> float:
        return float(self._library.rollgait_cost(self._at, x))

    def worst(self, x: int) -> float:
        return float(self._library.rollgait_worst(self._at, x))

    # -- what fatrop asks for ----------------------------------------------------------------------------

    def put_cost(self, scale: float, x: int, result: int) -> None:
        self._library.rollgait_put_cost(self._at, scale, x, result)

    def put_gradient(self, scale: float, x: int, result: int) -> None:
        self._library.rollgait_put_gradient(self._at, scale, x, result)

    def put_violation(self, x: int, result: int) -> None:
        self._library.rollgait_put_violation(self._at, x, result)

    def put_jacobian(self, x: int, matrices: tuple[int, int, int]) -> None:
        if (key := memory_of(matrices[0])) not in self._of_jacobians:
            self._of_jacobians[key] = self._places_of_jacobian(self.jacobian_fill(matrices))
        fill, places = self._of_jacobians[key]
        fill.make_ready()
        if not self._library.rollgait_put_jacobian(self._at, x, ctypes.addressof(places)):
            raise NotFiniteError

    def put_hessian(self, scale: float, x: int, lam: int, matrix: int) -> None:
        if (key := memory_of(matrix)) not in self._of_hessians:
            self._of_hessians[key] = self._places_of_hessian(self.hessian_fill(matrix))
        fill, places = self._of_hessians[key]
        fill.make_ready()
        if not self._library.rollgait_put_hessian(self._at, scale, x, lam, ctypes.addressof(places)):
            raise NotFiniteError
        ctypes.memmove(self._given.ctypes.data, lam, DOUBLE * self._given.size)
        self._keep_multipliers(scale)

    # -- where it goes -----------------------------------------------------------------------------------

    def _place(self, target: NDArray[np.intp], source: NDArray[np.intp]) -> _Place:
        return _Place(target.size, self._address(target), self._address(source))

    def _places_of_jacobian(self, fill: JacobianFill) -> tuple[JacobianFill, _JacobianFill]:
        rows, result = self._rows, _JacobianFill()
        which = (rows.defining, rows.equal, rows.unequal)
        for part, (data, target, source, below) in enumerate(fill.parts):
            result.data[part] = self._address(data)
            result.derivative[part] = self._place(target, source)
            result.below[part] = self._place(below, which[part])
        entry, row = fill.of_bounds
        result.bound_entry, result.bound_row = (
            self._place(entry, rows.bounded),
            self._place(row, rows.bounded),
        )
        return fill, result

    def _places_of_hessian(self, fill: HessianFill) -> tuple[HessianFill, _HessianFill]:
        own, result = fill.places, _HessianFill(data=self._address(fill.data))
        result.upper = self._place(own.upper.place, own.pairs)
        result.lower = self._place(own.lower.place, own.pairs[own.beside])
        result.last_rows = self._place(own.last_rows.place, own.last_rows.place)
        result.below = self._place(own.below.place, own.slopes)
        result.bound = self._place(own.bound.place, self._places.bounded)
        return fill, result
