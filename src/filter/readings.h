/* What is checked before a step, and what can be read of a filter. */
#ifndef KQ_SRC_FILTER_READINGS_H
#define KQ_SRC_FILTER_READINGS_H

#include "checks.h"
#include "twins.h"

num T(kq_mean)(const filter *f, int i)
{
    return index_is_valid(f, i) ? mean_get(f->memory, f->states, i) : num_nan();
}

num T(kq_mean_low)(const filter *f, int i)
{
    return index_is_valid(f, i) ? mean_low(f->memory, f->states, i) : num_nan();
}

KQ_COLD num T(kq_sigma)(const filter *f, int i)
{
    if (!index_is_valid(f, i) || !has_root(f)) return num_nan();
    return word_of(scaled_root(root_product(filter_root(f), f->states, i, i)));
}

score T(kq_nis)(const filter *f)
{
    return has_state(f) ? likelihood_nis(&f->last) : not_a_score();
}

int T(kq_taken)(const filter *f) { return has_state(f) ? (int)f->last.count : -1; }

static score filter_log_likelihood(const filter *f, int whole_run)
{
    if (!has_state(f)) return not_a_score();
    return whole_run ? likelihood_run_log(&f->run) : likelihood_log(&f->last);
}

KQ_COLD kq_status T(kq_covariance)(const filter *f, scaled *P)
{
    const kq_status status = state_check_known(f);
    if (status) return status;
    if (!P) return KQ_ERR_NULL;
    root_square(P, filter_root(f), f->states);
    return KQ_OK;
}

/* S_cj = h_j'P h_c + R_cj for j <= c */
KQ_COLD static void innovation_covariance(scaled *out, const filter *f, const sensor *s)
{
    num F[ROW_LEN(KQ_SIZE_MAX)], other[ROW_LEN(KQ_SIZE_MAX)];
    const int n = f->states, m = s->components;
    for (int c = 0; c < m; c++) {
        project(F, filter_root(f), s->measurement + c * n, n);
        for (int j = 0; j <= c; j++) {
            project(other, filter_root(f), s->measurement + j * n, n);
            out[c * m + j] = out[j * m + c] =
                scaled_plus(row_product(F, other, n), noise_entry(s, j, c));
        }
    }
}

/* h_c'x */
KQ_COLD static num measured(const filter *f, const sensor *s, int c)
{
    const int n = f->states;
    const scaled below = mean_residual(0, s->measurement + c * n, f->memory, n, 0, n);
    return word_of(scaled_negative(below));
}

KQ_COLD kq_status T(kq_measurement)(const filter *f, const sensor *s, num *z, scaled *S)
{
    const kq_status status = sensor_check_reading(f, s);
    if (status) return status;
    for (int c = 0; z && c < s->components; c++) z[c] = measured(f, s, c);
    if (S) innovation_covariance(S, f, s);
    return KQ_OK;
}

KQ_COLD kq_status T(kq_innovation)(const filter *f, const sensor *s, const num *z, num *e)
{
    kq_status status = sensor_check_reading(f, s);
    if (status) return status;
    if (!z || !e) return KQ_ERR_NULL;
    status = sensor_check_values(s, z, s->components, UINT32_MAX);
    if (status) return status;
    num found[KQ_SIZE_MAX];
    const int n = f->states, m = s->components;
    for (int c = 0; c < m; c++) {
        found[c] = word_of(mean_residual(z[c], s->measurement + c * n, f->memory, n, 0, n));
        if (!scaled_is_finite(scaled_of_word(found[c]))) return KQ_ERR_NOT_FINITE;
    }
    for (int c = 0; c < m; c++) e[c] = found[c];
    return KQ_OK;
}

score T(kq_log_likelihood_last)(const filter *f) { return filter_log_likelihood(f, 0); }

score T(kq_log_likelihood)(const filter *f) { return filter_log_likelihood(f, 1); }

unsigned T(kq_events)(const filter *f) { return f ? f->events : 0; }

void T(kq_events_clear)(filter *f)
{
    if (f) f->events = 0;
}

#endif
