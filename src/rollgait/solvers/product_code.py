"""The C text of the product, and of the watch that it keeps over who calls it.

A thread that waits for another one is woken late on a busy machine, by more than a whole step of the
controller takes. So a solve that somebody waits for runs in the caller's own thread. What fatrop does without
end are factorisations, these are made of products, and the product is ours: it looks now and then whether
there was a sign of life lately, and leaves by `longjmp` if there was none. What it leaves is in no order, and
never used again.

The same library stands in front of one function of fatrop's own, which finds multipliers of equations before
the first iteration, by a factorisation as long as that of an iteration. Where Hessians do not depend on
multipliers (Gauss-Newton) the step of an iteration does not either, so who makes one or two leaves it out.
"""

from __future__ import annotations

from rollgait.solvers.kernels import FOR_THIS_PROCESSOR

FUNCTION = "kernel_dgemm_nt_4x4_lib4"
"""D = α A Bᵀ + β C with A, B panels of 4 rows and kmax columns, C and D of 4 × 4, all column-major."""

ESTIMATE = "_ZN6fatrop19IpEqMultInitializerINS_7OcpTypeEE18initialize_eq_multEb"
"""Fatrop's estimate of the multipliers of equations; after a restoration its argument is true."""

LOOK_EVERY = 10_000
"""Products between two looks at the clock: a few tenths of a millisecond."""

SOURCE = f"""
#include <setjmp.h>
#include <time.h>

/* -- the watch: one for each thread, and for each call within a call ------------------------------------- */

struct watch {{ /* shared with the caller */
    volatile long signs; /* of life, so far */
    double patience; /* longest silence, s of this thread's processor time */
    long estimates; /* whether multipliers are found before the first iteration */
}};

struct guard {{
    struct watch *watch;
    struct guard *outer;
    long left, seen;
    double since;
    jmp_buf back;
}};

static __thread struct guard *guard __attribute__((tls_model("initial-exec")));

static double seconds(void)
{{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}}

static void look(void)
{{
    struct guard *own = guard;
    double now = seconds();
    own->left = {LOOK_EVERY};
    if (own->watch->signs != own->seen) {{
        own->seen = own->watch->signs;
        own->since = now;
    }} else if (now - own->since > own->watch->patience) {{
        guard = own->outer;
        longjmp(own->back, 1);
    }}
}}

/* whether the call came back; what it returned goes to `result` */
int rollgait_call_watched(int (*call)(void *), void *argument, struct watch *watch, int *result)
{{
    struct guard own = {{watch, guard, {LOOK_EVERY}, watch->signs, seconds()}};
    if (setjmp(own.back))
        return 0;
    guard = &own;
    *result = call(argument);
    guard = own.outer;
    return 1;
}}

/* -- the estimate of multipliers ------------------------------------------------------------------------- */

typedef void estimate(void *, _Bool);

static estimate *own_estimate;

void rollgait_own_estimate(estimate *own) {{ own_estimate = own; }}

void {ESTIMATE}(void *of, _Bool restored)
{{
    if (own_estimate && (restored || !guard || guard->watch->estimates))
        own_estimate(of, restored);
}}

/* -- the product ----------------------------------------------------------------------------------------- */

typedef double column __attribute__((vector_size(32), aligned(8)));
typedef void product(int, double *, double *, double *, double *, double *, double *);

static product *instead; /* is called in place of this one, and counted, if there is one */
static long calls;

void rollgait_use_instead(product *other) {{ instead = other; calls = 0; }}
long rollgait_calls_instead(void) {{ return calls; }}

void {FUNCTION}(int kmax, double *alpha, double *A, double *B, double *beta, double *C, double *D)
{{
    if (guard && --guard->left < 0)
        look();
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

/* to try the watch on: makes a product; makes products without end */
int rollgait_ends(void *unused)
{{
    double one = 1.0, zero = 0.0, panel[16] = {{0}}, result[16];
    {FUNCTION}(4, &one, panel, panel, &zero, panel, result);
    return 1;
}}

int rollgait_never_ends(void *unused)
{{
    double one = 1.0, zero = 0.0, panel[16] = {{0}}, result[16];
    for (;;)
        {FUNCTION}(4, &one, panel, panel, &zero, panel, result);
    return 0;
}}
"""
FLAGS = ("-O3", FOR_THIS_PROCESSOR, "-fPIC", "-shared")
"""(-O3, as the product is one loop.)"""
