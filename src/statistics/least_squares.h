/* Fading memory, and least squares by the filter. */
#ifndef KQ_SRC_STATISTICS_LEAST_SQUARES_H
#define KQ_SRC_STATISTICS_LEAST_SQUARES_H

#include "twins.h"

static kq_status lambda_check(scaled lambda)
{
    const scaled zero = scaled_zero();
    const kq_status status = number_check(lambda);
    if (status) return status;
    if (!scaled_is_less(zero, lambda) || scaled_is_less(scaled_one, lambda)) return KQ_ERR_RANGE;
    return KQ_OK;
}

static int fades(scaled lambda) { return scaled_is_less(lambda, scaled_one); }

static kq_status forget_check(const filter *f, scaled lambda)
{
    const kq_status status = filter_check(f);
    if (status) return status;
    return is_recorded(f) && fades(lambda) ? KQ_ERR_RECORDING : KQ_OK;
}

/* Is a variance so large that divided by lambda it would pass the limit? */
static int is_wound_up(const num *S, scaled lambda, int n)
{
    const scaled most = scaled_times(num_most_variance, lambda);
    for (int i = 0; i < n; i++) {
        if (scaled_is_less(most, root_product(S, n, i, i))) return 1;
    }
    return 0;
}

/* S <- S / sqrt(lambda) = S + g S, where g = (1 - lambda) / (sqrt(lambda) + lambda) */
static void forget_now(filter *f, scaled lambda)
{
    num *S = filter_root(f);
    const int n = f->states;
    if (is_wound_up(S, lambda, n)) {
        f->events |= KQ_EVENT_OVERFLOW;
        return;
    }
    const scaled base = scaled_plus(scaled_root(lambda), lambda);
    root_grow(S, scaled_over(scaled_minus(scaled_one, lambda), base), n);
    renormalise(S, n);
}

kq_status T(kq_forget)(filter *f, scaled lambda)
{
    kq_status status = filter_check(f);
    if (status) return status;
    status = lambda_check(lambda);
    if (status) return status;
    status = forget_check(f, lambda);
    if (status) return status;
    if (fades(lambda)) forget_now(f, lambda);
    return KQ_OK;
}

/* ------------------------------------------------------------------ least squares */

static kq_status least_squares_begin(least_squares *q, filter *f, scaled lambda)
{
    if (!q || !f) return KQ_ERR_NULL;
    const kq_status status = lambda_check(lambda);
    if (status) return status;
    q->filter = f;
    q->lambda = lambda;
    compensated_clear(&q->residual);
    compensated_clear(&q->weight);
    return KQ_OK;
}

static kq_status least_squares_check(const least_squares *q)
{
    if (!q) return KQ_ERR_NULL;
    return q->filter ? forget_check(q->filter, q->lambda) : KQ_ERR_NOT_READY;
}

/* A row of H as a sensor, which is good for as long as `row`, `memory` and h are */
static kq_status row_check(const least_squares *q, sensor *row, scaled *memory, const scaled *h,
                           num z, scaled r)
{
    const kq_status status = row_sensor(row, memory, q, h, r);
    return status ? status : update_check(q->filter, row, &z, 1);
}

static kq_status least_squares_take(least_squares *q, const sensor *row, num z)
{
    filter *f = q->filter;
    if (fades(q->lambda)) {
        forget_now(f, q->lambda);
        compensated_forget(&q->residual, q->lambda);
        compensated_forget(&q->weight, q->lambda);
    }
    const kq_status status = T(kq_update)(f, row, &z);
    if (status) return status;
    compensated_add(&q->residual, likelihood_nis(&f->last));
    compensated_add(&q->weight, score_of(scaled_of_count((int32_t)f->last.count)));
    return KQ_OK;
}

kq_status T(kq_least_squares_add)(least_squares *q, const scaled *H, const num *z, const scaled *r,
                                  size_t count)
{
    sensor row;
    scaled memory[KQ_SENSOR_DIAGONAL_LEN(1)];
    kq_status status = least_squares_check(q);
    if (status) return status;
    if (!H || !z || !r) return KQ_ERR_NULL;
    if (count > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    const size_t n = q->filter->states;
    for (size_t k = 0; k < count && !status; k++) {
        status = row_check(q, &row, memory, H + k * n, z[k], r[k]);
    }
    for (size_t k = 0; k < count && !status; k++) {
        status = row_sensor(&row, memory, q, H + k * n, r[k]);
        if (!status) status = least_squares_take(q, &row, z[k]);
    }
    return status;
}

static score least_squares_score(const least_squares *q, const compensated *sum)
{
    return q && q->filter ? compensated_score(sum) : not_a_score();
}

score T(kq_least_squares_residual)(const least_squares *q)
{
    return least_squares_score(q, q ? &q->residual : 0);
}

score T(kq_least_squares_weight)(const least_squares *q)
{
    return least_squares_score(q, q ? &q->weight : 0);
}

#endif
