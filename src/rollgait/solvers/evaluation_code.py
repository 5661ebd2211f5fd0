"""The C text of what fatrop asks of a problem: the stage functions called, their numbers put in place.

It does what `fatrop_evaluation.Evaluation` says, on the same arrays and with the same functions; those are
called through CasADi's buffers, compiled or not. `compiled_evaluation.py` has the same structs for Python.
"""

from __future__ import annotations

from typing import Final

from rollgait.solvers.kernels import SPECIFIC

SOURCE: Final = r"""
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef ptrdiff_t number;

struct block { /* a stage function and all its repetitions */
    number repetitions, inputs, costs, rows, slopes, jacobian, lam, second, first;
    const number *position;                     /* of each input among all variables */
    const number *row_source, *row_number;      /* rows that are constraints */
    const number *slope_source, *slope_place;   /* of the gradient, in fatrop's order */
    const number *lam_index;
    double *y, *lam_value, *lam_f;
    const double *cost_value, *row_value, *slope_value, *jacobian_value, *second_value, *first_value;
    void *value, *gradient, *jacobian_buffer, *hessian; /* CasADi's buffers */
};

struct problem {
    number size, rows, blocks, equal, unequal, bounded, defining, is_loaded, is_valued;
    const number *order;                        /* of fatrop's variables among the NLP's */
    const number *rows_equal, *rows_unequal, *variables_bounded, *rows_defining;
    const number *at_equal, *at_unequal, *at_bounded, *at_defining; /* among fatrop's constraints */
    const double *g_lower, *g_upper, *lower, *upper;
    double *x, *all, *g, *jacobian, *second, *first, *multipliers;
    struct block *block;
    void (*evaluate)(void *);
    double cost;
};

struct place { /* of some numbers in the memory of fatrop's matrices */
    number count;
    const number *target, *source;
};

struct jacobian_fill {
    double *data[3];
    struct place derivative[3], below[3]; /* of defining rows, equations, inequalities */
    struct place bound_entry, bound_row;
};

struct hessian_fill {
    double *data;
    struct place upper, lower, last_rows, below, bound;
};

/* -- values ---------------------------------------------------------------------------------------------- */

static void load(struct problem *p, const double *x)
{
    if (p->is_loaded && memcmp(x, p->x, p->size * sizeof *x) == 0)
        return;
    memcpy(p->x, x, p->size * sizeof *x);
    for (number i = 0; i < p->size; i++)
        p->all[p->order[i]] = x[i];
    for (number k = 0; k < p->blocks; k++) {
        const struct block *b = p->block + k;
        for (number i = 0; i < b->inputs; i++)
            b->y[i] = p->all[b->position[i]];
    }
    p->is_loaded = 1;
    p->is_valued = 0;
}

static void values(struct problem *p, const double *x)
{
    load(p, x);
    if (p->is_valued)
        return;
    p->cost = 0.0;
    for (number k = 0; k < p->blocks; k++) {
        const struct block *b = p->block + k;
        p->evaluate(b->value);
        for (number i = 0; i < b->costs; i++)
            p->cost += b->cost_value[i];
        for (number i = 0; i < b->rows; i++)
            p->g[b->row_number[i]] = b->row_value[b->row_source[i]];
    }
    p->is_valued = 1;
}

double rollgait_cost(struct problem *p, const double *x)
{
    values(p, x);
    return p->cost;
}

static double larger(double value, double most)
{
    return value <= most || most != most ? most : value; /* NaN is larger than all */
}

double rollgait_worst(struct problem *p, const double *x)
{
    double worst = 0.0;
    values(p, x);
    for (number i = 0; i < p->rows; i++) {
        worst = larger(p->g_lower[i] - p->g[i], worst);
        worst = larger(p->g[i] - p->g_upper[i], worst);
    }
    for (number i = 0; i < p->size; i++) {
        worst = larger(p->lower[i] - p->all[i], worst);
        worst = larger(p->all[i] - p->upper[i], worst);
    }
    return worst;
}

/* -- what fatrop asks for -------------------------------------------------------------------------------- */

void rollgait_put_cost(struct problem *p, double scale, const double *x, double *result)
{
    *result = scale * rollgait_cost(p, x);
}

void rollgait_put_gradient(struct problem *p, double scale, const double *x, double *result)
{
    load(p, x);
    memset(result, 0, p->size * sizeof *result);
    for (number k = 0; k < p->blocks; k++) {
        const struct block *b = p->block + k;
        p->evaluate(b->gradient);
        for (number i = 0; i < b->slopes; i++)
            result[b->slope_place[i]] += b->slope_value[b->slope_source[i]];
    }
    for (number i = 0; i < p->size; i++)
        result[i] *= scale;
}

void rollgait_put_violation(struct problem *p, const double *x, double *result)
{
    values(p, x);
    for (number i = 0; i < p->equal; i++)
        result[p->at_equal[i]] = p->g[p->rows_equal[i]] - p->g_lower[p->rows_equal[i]];
    for (number i = 0; i < p->unequal; i++)
        result[p->at_unequal[i]] = p->g[p->rows_unequal[i]];
    for (number i = 0; i < p->bounded; i++)
        result[p->at_bounded[i]] = p->all[p->variables_bounded[i]];
    for (number i = 0; i < p->defining; i++)
        result[p->at_defining[i]] = p->g_lower[p->rows_defining[i]] - p->g[p->rows_defining[i]];
}

/* copies, and says whether all of it are numbers */
static int finite_copy(double *to, const double *from, number count)
{
    const uint64_t mask = UINT64_C(0x7ff0000000000000);
    uint64_t bad = 0;
    for (number i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, from + i, sizeof bits);
        bad |= (bits & mask) == mask;
        to[i] = from[i];
    }
    return !bad;
}

int rollgait_put_jacobian(struct problem *p, const double *x, const struct jacobian_fill *fill)
{
    double *end = p->jacobian;
    int is_finite = 1;
    values(p, x);
    for (number k = 0; k < p->blocks; k++) {
        const struct block *b = p->block + k;
        p->evaluate(b->jacobian_buffer);
        is_finite &= finite_copy(end, b->jacobian_value, b->jacobian);
        end += b->jacobian;
    }
    if (!is_finite)
        return 0;
    for (int part = 0; part < 3; part++) {
        const struct place *d = fill->derivative + part, *r = fill->below + part;
        double *data = fill->data[part], sign = part == 0 ? -1.0 : 1.0;
        for (number i = 0; i < d->count; i++)
            data[d->target[i]] = sign * p->jacobian[d->source[i]];
        for (number i = 0; i < r->count; i++) {
            number row = r->source[i];
            data[r->target[i]] = part == 2 ? p->g[row] : sign * (p->g[row] - p->g_lower[row]);
        }
    }
    for (number i = 0; i < fill->bound_entry.count; i++) {
        fill->data[2][fill->bound_entry.target[i]] = 1.0;
        fill->data[2][fill->bound_row.target[i]] = p->all[fill->bound_row.source[i]];
    }
    return 1;
}

int rollgait_put_hessian(struct problem *p, double scale, const double *x, const double *lam,
                         const struct hessian_fill *fill)
{
    double *second = p->second, *first = p->first, *data = fill->data;
    int is_finite = 1;
    load(p, x);
    for (number i = 0; i < p->equal; i++)
        p->multipliers[p->rows_equal[i]] = lam[p->at_equal[i]];
    for (number i = 0; i < p->unequal; i++)
        p->multipliers[p->rows_unequal[i]] = lam[p->at_unequal[i]];
    for (number i = 0; i < p->defining; i++)
        p->multipliers[p->rows_defining[i]] = -lam[p->at_defining[i]];
    for (number k = 0; k < p->blocks; k++) {
        const struct block *b = p->block + k;
        for (number i = 0; i < b->repetitions; i++)
            b->lam_f[i] = scale;
        for (number i = 0; i < b->lam; i++)
            b->lam_value[i] = p->multipliers[b->lam_index[i]];
        p->evaluate(b->hessian);
        is_finite &= finite_copy(second, b->second_value, b->second);
        memcpy(first, b->first_value, b->first * sizeof *first);
        second += b->second;
        first += b->first;
    }
    if (!is_finite)
        return 0;
    for (number i = 0; i < fill->upper.count; i++)
        data[fill->upper.target[i]] = p->second[fill->upper.source[i]];
    for (number i = 0; i < fill->lower.count; i++)
        data[fill->lower.target[i]] = p->second[fill->lower.source[i]];
    for (number i = 0; i < fill->last_rows.count; i++)
        data[fill->last_rows.target[i]] = 0.0;
    for (number i = 0; i < fill->below.count; i++)
        data[fill->below.target[i]] = p->first[fill->below.source[i]];
    for (number i = 0; i < fill->bound.count; i++)
        data[fill->bound.target[i]] += lam[fill->bound.source[i]];
    return 1;
}

/* -- what it asks for stage by stage, in every solve ---------------------------------------------------- */

struct stages {
    const number *first_bound, *begin, *states; /* limits before a stage, variables before it, its states */
    const double *low, *high, *guess;
};

int rollgait_bounds(double *low, double *high, int k, void *given)
{
    const struct stages *s = given;
    number begin = s->first_bound[k], size = s->first_bound[k + 1] - begin;
    memcpy(low, s->low + begin, size * sizeof *low);
    memcpy(high, s->high + begin, size * sizeof *high);
    return 0;
}

int rollgait_initial_states(double *x, int k, void *given)
{
    const struct stages *s = given;
    memcpy(x, s->guess + s->begin[k], s->states[k] * sizeof *x);
    return 0;
}

int rollgait_initial_inputs(double *u, int k, void *given)
{
    const struct stages *s = given;
    number begin = s->begin[k] + s->states[k];
    memcpy(u, s->guess + begin, (s->begin[k + 1] - begin) * sizeof *u);
    return 0;
}
"""
FLAGS: Final = ("-O2", *SPECIFIC, "-ffp-contract=off", "-fPIC", "-shared")
