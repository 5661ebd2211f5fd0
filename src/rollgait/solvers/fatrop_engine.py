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
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rollgait.solvers import fatrop_library as c
from rollgait.solvers.budget import Budget, Repair
from rollgait.solvers.compiled_evaluation import CompiledEvaluation, CompiledStagewiseCalls
from rollgait.solvers.fatrop_evaluation import DOUBLE, Evaluation, NotFiniteError, StagewiseCalls, write
from rollgait.solvers.fatrop_rows import Rows
from rollgait.solvers.interrupt import deferred_interrupt
from rollgait.solvers.linear_algebra import call_here
from rollgait.solvers.solution import Iteration, Progress, Solution
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


class _GaveUpError(Exception):
    """The solve cannot go on; says why in one word."""


class FatropEngine:
    """Fatrop's memory for one NLP with stages. If it is left behind in a solve, it is never used again.

    Raises:
        InterfaceError: the library is not the expected one.

    Args:
        nlp, structure: the problem.
        options, warm_options, repair_options: of fatrop; the second for a guess near the solution, the last
            where in addition there is a `repair`.
        compiled: functions in C that evaluate the problem, if there are any.

    Attributes:
        is_running: whether fatrop is in a solve.
        evaluation: what is evaluated for it.
    """

    def __init__(
        self,
        nlp: Nlp,
        structure: Structure,
        options: Options,
        warm_options: Options,
        repair_options: Options,
        compiled: ctypes.CDLL | None = None,
    ) -> None:
        self.nlp, self._options = nlp, options
        self._warm_options, self._repair_options = warm_options, repair_options
        self._library = c.library()
        self._rows = Rows(nlp, structure)
        self._guess: Array = np.zeros(nlp.size)
        self._progress: Progress | None = None
        self._stop: Callable[[], bool] = lambda: False
        self._error: BaseException | None = None
        self._iteration = self._judged = 0
        self._least, self._least_at = np.inf, 0
        self._budget = Budget()
        self._is_over = self._skips_last = False
        self._best: tuple[float, Array] = (np.inf, np.empty(0))
        self.is_running = False
        self._watch, self._evaluations_before = Watch(), 0
        self._told: Options = {}
        self._call_here = call_here()
        self._stagewise = (
            StagewiseCalls(self._rows, self._guess)
            if compiled is None
            else CompiledStagewiseCalls(self._rows, self._guess, compiled)
        )
        self._interface = self._make_interface()
        self._solver: ctypes.c_void_p | None = ctypes.c_void_p(
            self._library.fatrop_ocp_c_create(ctypes.byref(self._interface), None, None)
        )
        if not self._solver:
            raise c.InterfaceError("fatrop could not be set up")
        dims = self._library.fatrop_ocp_c_get_dims(self._solver).contents
        self._check_dimensions(dims)
        self.evaluation = (
            Evaluation(nlp, self._rows, dims)
            if compiled is None
            else CompiledEvaluation(nlp, self._rows, dims, compiled)
        )

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
        self.evaluation.begin()
        self._rows.load_bounds()
        self._budget = Budget(until, iterations, repair)
        near = self._warm_options if repair is None else self._repair_options
        self._set_options(self._options | (near if warm else {}))
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
        primal = ctypes.addressof(self._library.fatrop_ocp_c_get_primal(self._solver).contents.pa.contents)
        if repair is not None and self.evaluation.worst(primal) > self._best[0]:
            w = self._best[1]
        else:
            w = self.evaluation.variables(primal)
        f, g = self.evaluation.values(w)
        stats = self._library.fatrop_ocp_c_get_stats(self._solver).contents
        solved = flag == 0 and not (self._is_over and self._skips_last) and bool(np.isfinite(w).all())
        return Solution(
            w=w,
            g=g,
            cost=f,
            solved=solved,
            status="Solve_Succeeded" if solved else self._why(flag),
            iterations=max(int(stats.iterations_count), self._iteration),
            multipliers=self.evaluation.multipliers,
        )

    def _set_options(self, options: Options) -> None:
        """Tells fatrop what it has not been told yet."""
        for name, value in options.items():
            if self._told.get(name) != value:
                kind = "double" if isinstance(value, float) else "int"
                getattr(self._library, f"fatrop_ocp_c_set_option_{kind}")(self._solver, name.encode(), value)
                self._told[name] = value

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
        return self.evaluation.values(w)

    def _why(self, flag: int) -> str:
        """Why there is no solution; fatrop itself does not tell."""
        if isinstance(self._error, _GaveUpError):
            return str(self._error)
        if self._stagnates():
            return "No_Progress_Towards_The_Constraints"
        limit = int(self._options.get("max_iter", 0))
        return "Maximum_Iterations_Exceeded" if 0 < limit <= self._iteration else f"Not_Converged ({flag})"

    # -- callbacks --------------------------------------------------------------------------------------

    def _make_interface(self) -> c.Interface:
        rows, nlp = self._rows, self.nlp
        # the callbacks must not keep the solver alive: its memory is large and goes with its last user
        this = weakref.proxy(self)

        # what is left of a matrix, or no number, could keep fatrop from ever finding a factorisation
        no_cost, no_gradient, no_rows = (np.full(size, np.nan) for size in (1, nlp.size, rows.total))

        def objective(scale: float, x: int, _s: Any, _g: Any, result: int, _d: Any, _u: Any) -> int:
            if not this._guarded(lambda: this.evaluation.put_cost(scale, x, result)):
                write(result, no_cost)
            return c.SKIP

        def gradient(scale: float, x: int, _s: Any, _g: Any, result: int, _d: Any, _u: Any) -> int:
            if not this._guarded(lambda: this._put_gradient(scale, x, result)):
                write(result, no_gradient)
            return c.SKIP

        def violation(x: int, _s: Any, _g: Any, result: int, _d: Any, _u: Any) -> int:
            if not this._guarded(lambda: this.evaluation.put_violation(x, result)):
                write(result, no_rows)
            return c.SKIP

        def jacobian(x: int, _s: Any, _g: Any, BAbt: int, Ggt: int, Ggt_ineq: int, _d: Any, _u: Any) -> int:
            matrices = (BAbt, Ggt, Ggt_ineq)
            if not this._guarded(lambda: this._put_jacobian(x, matrices)):
                this.evaluation.jacobian_fill(matrices).put_nothing()
            return c.SKIP

        def hessian(scale: float, x: int, lam: int, _s: Any, _g: Any, out: int, _d: Any, _u: Any) -> int:
            if not this._guarded(lambda: this._put_hessian(scale, x, lam, out)):
                this.evaluation.hessian_fill(out).put_identity()
            return c.SKIP

        calls = self._stagewise
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
            get_bounds=calls.bounds,
            get_initial_xk=calls.states,
            get_initial_uk=calls.inputs,
            full_eval_lag_hess=c.FullHessian(hessian),
            full_eval_constr_jac=c.FullJacobian(jacobian),
            full_eval_contr_viol=c.FullViolation(violation),
            full_eval_obj_grad=c.FullObjective(gradient),
            full_eval_obj=c.FullObjective(objective),
            user_data=calls.user_data,
        )

    def _guarded(self, evaluate: Callable[[], None]) -> bool:
        """Whether something could be evaluated.

        An exception cannot pass through foreign code: it is kept, and the solver is made to give up.
        """
        try:
            if self._error is None:
                if self._stop():
                    raise KeyboardInterrupt
                self._watch.signs += 1
                if self._watch.signs - self._evaluations_before > EVALUATIONS_MAX:
                    raise _GaveUpError("Too_Many_Evaluations")
                evaluate()
                return True
        except NotFiniteError:
            self._error = _GaveUpError("Invalid_Number_Detected")
            self._give_up()
        except BaseException as error:
            self._error = error
            self._give_up()
        return False

    def _put_gradient(self, scale: float, x: int, result: int) -> None:
        if self._is_last(x):
            ctypes.memset(result, 0, DOUBLE * self.nlp.size)
        else:
            self.evaluation.put_gradient(scale, x, result)

    def _put_jacobian(self, x: int, matrices: tuple[int, int, int]) -> None:
        if not self._is_last(x):
            self.evaluation.put_jacobian(x, matrices)

    def _put_hessian(self, scale: float, x: int, lam: int, matrix: int) -> None:
        self.evaluation.put_hessian(scale, x, lam, matrix)
        self._report(x)

    def _report(self, x: int) -> None:
        self._iteration += 1
        self._evaluations_before = self._watch.signs
        worst = self.evaluation.worst(x)
        if worst < 0.9 * self._least or worst < SMALL_VIOLATION:
            self._least, self._least_at = worst, self._iteration
        if self._stagnates():
            self._give_up()
        if self._progress is not None:
            self._progress(Iteration(self._iteration, self.evaluation.cost(x), worst))

    def _is_last(self, x: int) -> bool:
        """Whether nobody needs the derivatives here: the solve ends with this iterate, whatever they are.

        Fatrop asks for them where a line search has ended, before it looks at its number of iterations.
        """
        if self._judged < self._iteration:
            self._judged = self._iteration
            worst = self.evaluation.worst(x)
            if worst < self._best[0]:
                self._best = (worst, self.evaluation.variables(x))
            if not self._budget.allows_another(self._iteration, worst):
                self._is_over = True
                self._give_up()
        return self._is_over and self._skips_last

    def _stagnates(self) -> bool:
        return self._iteration - self._least_at > PATIENCE

    def _give_up(self) -> None:
        self._set_options({"max_iter": 0})

    def _check_dimensions(self, dims: c.Dims) -> None:
        """The sizes that fatrop reports back must be ours, or its structures are not those described here."""
        rows = self._rows
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
