"""Fatrop on one problem: stage functions evaluated all at once and put in its matrices by index.

Fatrop numbers a stage's variables (u, x), minimises over stages k = 0 … N with x⁺ = F(x, u), and wants

    BAbt[k]      (∂F/∂(u, x) | F − x⁺)ᵀ                 of the rows that define the next state
    Ggt[k]       (∂g/∂(u, x) | g)ᵀ                      of the other equations
    Ggt_ineq[k]  (∂g/∂(u, x) | g)ᵀ                      of inequalities, bounds of variables among them
    RSQrqt[k]    (∂²L/∂(u, x)² | ∂L/∂(u, x))            L without the x⁺ of x⁺ = F

Rows of the NLP that define the next state read x⁺ − F, so their multipliers change sign on the way.
"""

from __future__ import annotations

import ctypes
import time
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.budget import Budget, Repair
from rollgait.solvers.fatrop_matrices import HessianFill, JacobianFill
from rollgait.solvers.fatrop_rows import Rows
from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.linear_algebra import call_here
from rollgait.solvers.solution import Iteration, Progress, Solution
from rollgait.solvers.stage_evaluation import StageEvaluation
from rollgait.solvers.watched import NoAnswerError, call_watched
from rollgait.solvers.watched_here import Watch
from rollgait.transcription.base import Structure
from rollgait.transcription.nlp import Nlp

Array = NDArray[np.float64]

Options = dict[str, float | int]

PATIENCE = 80
"""Iterations without a tenth less violation after which the constraints are taken for contradictory."""
SMALL_VIOLATION = 1e-4
"""Scaled violation below which a solver may take its time over the cost."""
EVALUATIONS_MAX = 500
"""Of functions in one iteration; a line search that goes well takes less than 20."""
SILENCE_MAX = 1.0
"""s of processor time between two evaluations after which it will not come back, and for each stage"""
SILENCE_MAX_PER_STAGE = 0.01
"""s: a factorisation takes some 0.2 ms of it, and a difficult iteration a dozen of them."""
SILENCE_MAX_IN_TIME = 0.1
"""s, the same where somebody waits who needs the answer sooner: a controller cannot do without for long."""
SHORT = 1.0
"""s: a solve that is to be over so soon runs in the thread of who waits, which other signals than Ctrl-C do
not interrupt for as long."""
DOUBLE = ctypes.sizeof(ctypes.c_double)


class _GaveUpError(Exception):
    """The solve cannot go on; says why in one word."""


class FatropEngine:
    """Fatrop's memory for one NLP with stages. If it is left behind in a solve, it is never used again.

    Raises:
        InterfaceError: the library is not the expected one.

    Attributes:
        is_running: whether fatrop is in a solve.
    """

    def __init__(self, nlp: Nlp, structure: Structure, options: Options, warm_options: Options) -> None:
        self.nlp, self._options, self._warm_options = nlp, options, warm_options
        self._library = c.library()
        self._rows = Rows(nlp, structure)
        self._stages = [StageEvaluation(nlp, block) for block in nlp.blocks]
        self._guess, self._no_gradient = np.zeros(nlp.size), np.zeros(nlp.size)
        self._known: tuple[bytes, float, Array] = (b"", 0.0, np.empty(0))
        self._known_for = b""
        self._progress: Progress | None = None
        self._stop: Callable[[], bool] = lambda: False
        self._error: BaseException | None = None
        self._iteration = self._judged = 0
        self._least, self._least_at = np.inf, 0
        self._budget = Budget()
        self._is_over = self._skips_last = False
        self._best: tuple[float, Array] = (np.inf, np.empty(0))
        self._multipliers: tuple[Array, Array] | None = None
        self.is_running = False
        self._watch, self._evaluations_before = Watch(), 0
        self._call_here = call_here()
        self._jacobians: dict[int, JacobianFill] = {}
        self._hessians: dict[int, HessianFill] = {}
        self._interface = self._make_interface()
        self._solver: ctypes.c_void_p | None = ctypes.c_void_p(
            self._library.fatrop_ocp_c_create(ctypes.byref(self._interface), None, None)
        )
        if not self._solver:
            raise c.InterfaceError("fatrop could not be set up")
        self._check_dimensions()

    def __del__(self) -> None:
        if getattr(self, "_solver", None):
            self._library.fatrop_ocp_c_destroy(self._solver)

    def solve(
        self,
        guess: Array,
        progress: Progress | None,
        warm: bool,
        until: float,
        iterations: int | None,
        repair: Repair | None,
    ) -> Solution:
        """See `DirectFatrop.solve`. Raises `NoAnswerError` if it does not come back."""
        self._guess[:] = guess
        self._progress, self._error = progress, None
        self._iteration = self._judged = 0
        self._is_over, self._skips_last, self._best = False, repair is not None, (np.inf, self._guess)
        self._least, self._least_at = np.inf, 0
        self._evaluations_before = self._watch.signs
        self._multipliers = None
        self._forget_if_other_numbers()
        self._rows.load_bounds()
        self._budget = Budget(until, iterations, repair)
        for name, value in (self._options | (self._warm_options if warm else {})).items():
            kind = "double" if isinstance(value, float) else "int"
            getattr(self._library, f"fatrop_ocp_c_set_option_{kind}")(self._solver, name.encode(), value)
        self._watch.estimates = repair is None
        if repair is not None:  # as nobody finds others
            multipliers = self._library.fatrop_ocp_c_get_dual(self._solver).contents
            ctypes.memset(multipliers.pa, 0, DOUBLE * multipliers.m)
        patience = SILENCE_MAX + SILENCE_MAX_PER_STAGE * len(self._rows.nx)
        left = until - time.perf_counter()
        patience = min(patience, max(SILENCE_MAX_IN_TIME, left))
        with deferred_interrupt(others=left < SHORT) as self._stop:
            flag = self._solve_here(patience) if left < SHORT else self._solve_beside(patience)
        if (error := self._reason_to_fail()) is not None:
            raise error
        primal = self._library.fatrop_ocp_c_get_primal(self._solver).contents
        w = self._from_primal(primal.pa)
        if repair is not None and self._largest_violation(w) > self._best[0]:
            w = self._best[1]
        f, g = self._values(w)
        stats = self._library.fatrop_ocp_c_get_stats(self._solver).contents
        solved = flag == 0 and not (self._is_over and self._skips_last) and bool(np.isfinite(w).all())
        return Solution(
            w=w,
            g=g,
            cost=f,
            solved=solved,
            status="Solve_Succeeded" if solved else self._why(flag),
            iterations=max(int(stats.iterations_count), self._iteration),
            multipliers=self._multipliers,
        )

    def _solve_here(self, patience: float) -> int:
        """In this thread, which a busy machine would wake late if it waited for another."""
        if self._call_here is None or self._solver is None:
            return self._solve_beside(patience)
        assert self._solver is not None, "a solver that gave no answer is not asked again"
        self._watch.patience = patience
        try:
            return self._call_here(self._library.fatrop_ocp_c_solve, self._solver, self._watch)
        except NoAnswerError:
            self._solver = None  # in the middle of anything: neither used again nor freed
            raise

    def _solve_beside(self, patience: float) -> int:
        """In another thread, so that this one can be interrupted."""
        return call_watched(self._run, lambda: self._watch.signs, patience)

    def _run(self) -> int:
        self.is_running = True
        flag = int(self._library.fatrop_ocp_c_solve(self._solver))
        self.is_running = False
        return flag

    def abandon(self) -> None:
        """Makes a solve that still runs give up as soon as it asks for anything."""
        self._error = _GaveUpError("Abandoned")

    def _reason_to_fail(self) -> BaseException | None:
        """What went wrong in a callback; but who handles Ctrl-C himself gets the last iterate."""
        if isinstance(self._error, KeyboardInterrupt) and self._stop():
            return None
        return None if isinstance(self._error, _GaveUpError) else self._error

    def values(self, w: Array) -> tuple[float, Array]:
        """Cost and constraints at the free variables, for the NLP as it is now."""
        self._forget_if_other_numbers()
        return self._values(w)

    def _forget_if_other_numbers(self) -> None:
        """Keeps the values at the last iterate only where fixed variables and parameters are as they were."""
        numbers = (self.nlp.fixed_values, *(block.stage.parameters for block in self.nlp.blocks))
        bits = b"".join(array.tobytes("A") for array in numbers)
        if bits != self._known_for:
            self._known, self._known_for = (b"", 0.0, np.empty(0)), bits

    def _why(self, flag: int) -> str:
        """Why there is no solution; fatrop itself does not tell."""
        if isinstance(self._error, _GaveUpError):
            return str(self._error)
        if self._stagnates():
            return "No_Progress_Towards_The_Constraints"
        limit = int(self._options.get("max_iter", 0))
        return "Maximum_Iterations_Exceeded" if 0 < limit <= self._iteration else f"Not_Converged ({flag})"

    # -- values -----------------------------------------------------------------------------------------

    def _values(self, w: Array) -> tuple[float, Array]:
        """Cost and constraints at the free variables; fatrop asks for both, and again with the Jacobian."""
        if (bits := w.tobytes()) != self._known[0]:
            cost, g = 0.0, np.empty(self.nlp.rows)
            for stage in self._stages:
                value, rows = stage.value(w)
                cost += float(value.sum())
                g[stage.row_number] = rows[stage.row_source]
            self._known = (bits, cost, g)
        return self._known[1:]

    def _gradient(self, w: Array) -> Array:
        total = np.zeros(self.nlp.size)
        for stage in self._stages:
            parts = stage.gradient(w)[stage.variable_source]
            total += np.bincount(stage.variable_number, parts, minlength=self.nlp.size)
        return total

    # -- callbacks --------------------------------------------------------------------------------------

    def _make_interface(self) -> c.Interface:
        rows, nlp = self._rows, self.nlp
        # the callbacks must not keep the solver alive: its memory is large and goes with its last user
        this = weakref.proxy(self)

        nothing = np.full(nlp.size, np.nan)
        # asked for stage by stage, in every solve: the quickest way counts
        guess, low_limits, high_limits = (a.ctypes.data for a in (self._guess, *rows.limits))

        def copy_part(target: Any, source: int, part: slice) -> int:
            ctypes.memmove(target, source + DOUBLE * part.start, DOUBLE * (part.stop - part.start))
            return 0

        def objective(scale: float, x: Any, _s: Any, _g: Any, result: Any, _d: Any, _u: Any) -> int:
            result[0] = scale * this._guarded(lambda: this._values(this._from_primal(x))[0], np.nan)
            return c.SKIP

        def gradient(scale: float, x: Any, _s: Any, _g: Any, result: Any, _d: Any, _u: Any) -> int:
            value = this._guarded(lambda: this._gradient_unless_over(this._from_primal(x)), nothing)
            _write(result, scale * value[rows.order])
            return c.SKIP

        def violation(x: Any, _s: Any, _g: Any, result: Any, dims: Any, _u: Any) -> int:
            nothing = np.full(rows.total, np.nan)
            _write(
                result, this._guarded(lambda: this._violation(this._from_primal(x), dims.contents), nothing)
            )
            return c.SKIP

        def jacobian(x: Any, _s: Any, _g: Any, BAbt: Any, Ggt: Any, Ggt_ineq: Any, dims: Any, _u: Any) -> int:
            matrices = (BAbt, Ggt, Ggt_ineq)
            done = this._guarded(lambda: this._put_jacobian(this._from_primal(x), matrices), False)
            if not done:
                this._jacobian_fill(matrices).put_nothing()
            return c.SKIP

        def hessian(scale: float, x: Any, lam: Any, _s: Any, _g: Any, out: Any, dims: Any, _u: Any) -> int:
            done = this._guarded(
                lambda: this._put_hessian(scale, this._from_primal(x), lam, out, dims.contents), False
            )
            if not done:
                this._hessian_fill(out).put_identity()
            return c.SKIP

        def bounds(low: Any, high: Any, k: int, _u: Any) -> int:
            part = rows.bounds(k)
            return copy_part(low, low_limits, part) or copy_part(high, high_limits, part)

        return c.Interface(
            get_nx=c.GetDimension(lambda k, _: rows.nx[k]),
            get_nu=c.GetDimension(lambda k, _: rows.nu[k]),
            get_ng=c.GetDimension(lambda k, _: rows.n_equal[k]),
            get_ng_ineq=c.GetDimension(lambda k, _: rows.n_unequal[k]),
            get_n_stage_params=c.GetDimension(lambda k, _: 0),
            get_n_global_params=c.GetNumber(lambda _: 0),
            get_default_stage_params=c.GetStageValues(lambda *_: 0),
            get_default_global_params=c.GetValues(lambda *_: 0),
            get_horizon_length=c.GetNumber(lambda _: len(rows.nx)),
            get_bounds=c.GetBounds(bounds),
            get_initial_xk=c.GetStageValues(lambda x, k, _: copy_part(x, guess, rows.states(k))),
            get_initial_uk=c.GetStageValues(lambda u, k, _: copy_part(u, guess, rows.inputs(k))),
            full_eval_lag_hess=c.FullHessian(hessian),
            full_eval_constr_jac=c.FullJacobian(jacobian),
            full_eval_contr_viol=c.FullViolation(violation),
            full_eval_obj_grad=c.FullObjective(gradient),
            full_eval_obj=c.FullObjective(objective),
        )

    def _guarded(self, evaluate: Callable[[], Any], otherwise: Any) -> Any:
        """An exception cannot pass through foreign code: it is kept, and the solver is made to give up."""
        try:
            if self._error is None:
                if self._stop():
                    raise KeyboardInterrupt
                self._watch.signs += 1
                if self._watch.signs - self._evaluations_before > EVALUATIONS_MAX:
                    raise _GaveUpError("Too_Many_Evaluations")
                return evaluate()
        except BaseException as error:
            self._error = error
            self._give_up()
        return otherwise

    def _from_primal(self, x: Any) -> Array:
        w = np.empty(self.nlp.size)
        w[self._rows.order] = _read(x, self.nlp.size)
        return w

    def _violation(self, w: Array, dims: c.Dims) -> Array:
        rows = self._rows
        _, g = self._values(w)
        result = np.zeros(rows.total)
        place = rows.places(dims)
        result[place.equal] = (g - self.nlp.g_lower)[rows.equal]
        result[place.unequal] = g[rows.unequal]
        result[place.bounded] = w[rows.bounded]
        result[place.defining] = (self.nlp.g_lower - g)[rows.defining]
        return result

    # what is left of a matrix, or no number, could keep fatrop from ever finding a factorisation

    def _put_jacobian(self, w: Array, matrices: Sequence[Any]) -> bool:
        if self._is_last(w):
            return True
        _, g = self._values(w)
        values = np.concatenate([stage.jacobian(w) for stage in self._stages])
        _check_finite(values)
        self._jacobian_fill(matrices).put(values, g, w)
        return True

    def _put_hessian(self, scale: float, w: Array, lam: Any, matrix: Any, dims: c.Dims) -> bool:
        rows, place = self._rows, self._rows.places(dims)
        given = _read(lam, rows.total)
        multipliers = np.zeros(self.nlp.rows + 1)
        multipliers[rows.equal] = given[place.equal]
        multipliers[rows.unequal] = given[place.unequal]
        multipliers[rows.defining] = -given[place.defining]
        parts = zip(*(stage.hessian(w, scale, multipliers) for stage in self._stages), strict=True)
        second, first = (np.concatenate(part) for part in parts)
        _check_finite(second)
        self._hessian_fill(matrix).put(second, first, given[place.bounded])
        of_bounds = np.zeros(self.nlp.size)
        of_bounds[rows.bounded] = given[place.bounded]
        if scale:  # a restoration of the constraints knows no cost
            self._multipliers = (multipliers[:-1] / scale, of_bounds / scale)
        self._report(w)
        return True

    # fatrop keeps more than one set of matrices and passes now one, now another

    def _jacobian_fill(self, matrices: Sequence[Any]) -> JacobianFill:
        key = matrices[0][0].pA
        if key not in self._jacobians:
            like = next(iter(self._jacobians.values()), None)
            self._jacobians[key] = JacobianFill(self.nlp, self._rows, matrices, like)
        return self._jacobians[key]

    def _hessian_fill(self, matrix: Any) -> HessianFill:
        key = matrix[0].pA
        if key not in self._hessians:
            like = next(iter(self._hessians.values()), None)
            self._hessians[key] = HessianFill(self.nlp, self._rows, matrix, like)
        return self._hessians[key]

    def _report(self, w: Array) -> None:
        self._iteration += 1
        self._evaluations_before = self._watch.signs
        worst = self._largest_violation(w)
        if worst < 0.9 * self._least or worst < SMALL_VIOLATION:
            self._least, self._least_at = worst, self._iteration
        if self._stagnates():
            self._give_up()
        if self._progress is not None:
            self._progress(Iteration(self._iteration, self._values(w)[0], worst))

    def _is_last(self, w: Array) -> bool:
        """Whether nobody needs the derivatives here: the solve ends with this iterate, whatever they are.

        Fatrop asks for them where a line search has ended, before it looks at its number of iterations.
        """
        if self._judged < self._iteration:
            self._judged = self._iteration
            worst = self._largest_violation(w)
            if worst < self._best[0]:
                self._best = (worst, w)
            if not self._budget.allows_another(self._iteration, worst):
                self._is_over = True
                self._give_up()
        return self._is_over and self._skips_last

    def _gradient_unless_over(self, w: Array) -> Array:
        return self._no_gradient if self._is_last(w) else self._gradient(w)

    def _largest_violation(self, w: Array) -> float:
        """Of a constraint at free variables, scaled as fatrop sees it; may be NaN."""
        _, g = self._values(w)
        return float(self.nlp.violations(g, w).max(initial=0.0))

    def _stagnates(self) -> bool:
        return self._iteration - self._least_at > PATIENCE

    def _give_up(self) -> None:
        self._library.fatrop_ocp_c_set_option_int(self._solver, b"max_iter", 0)

    def _check_dimensions(self) -> None:
        """The sizes that fatrop reports back must be ours, or its structures are not those described here."""
        dims, rows = self._library.fatrop_ocp_c_get_dims(self._solver).contents, self._rows
        stages = len(rows.nx)
        if stages != dims.K or any(
            [getattr(dims, name)[k] for k in range(stages)] != list(sizes)
            for name, sizes in (
                ("nx", rows.nx),
                ("nu", rows.nu),
                ("ng", rows.n_equal),
                ("ng_ineq", rows.n_unequal),
            )
        ):
            raise c.InterfaceError("fatrop's C interface is not the expected one: it reports other sizes")


def _check_finite(derivatives: Array) -> None:
    """Raises `_GaveUpError`."""
    if not np.isfinite(derivatives).all():
        raise _GaveUpError("Invalid_Number_Detected")


# NumPy's own view of a pointer would leave a cycle for the garbage collector, a dozen in each solve


def _read(pointer: Any, count: int) -> Array:
    values: Array = np.empty(count)
    ctypes.memmove(values.ctypes.data, pointer, DOUBLE * count)
    return values


def _write(pointer: Any, values: Array) -> None:
    ctypes.memmove(pointer, np.ascontiguousarray(values).ctypes.data, DOUBLE * values.size)
