/* EM: the model and the recordings checked; process, sensor and start prepared. */
#ifndef KQ_SRC_EM_MODEL_H
#define KQ_SRC_EM_MODEL_H

#include "expect.h"

typedef T(kq_parameters) parameters;

/* ------------------------------------------------------------------ checks */

static kq_status em_check_pointers(const parameters *p)
{
    if (!p->A || !p->H || !p->Q || !p->R || !p->x0 || !p->P0) return KQ_ERR_NULL;
    return p->controls && !p->B ? KQ_ERR_NULL : KQ_OK;
}

KQ_NOINLINE static kq_status em_check_covariance(const num *P, int n)
{
    num S[KQ_TRIANGLE(KQ_SIZE_MAX)];
    const kq_status status = covariance_check(P, n);
    return status ? status : root_of(S, P, n);
}

static kq_status em_check_form(const num *P, int n, kq_em_form form)
{
    num total = 0;
    if (form == KQ_EM_DIAGONAL) return is_diagonal(P, n) ? KQ_OK : KQ_ERR_FORM;
    for (int i = 0; i < n; i++) total += P[i * n + i];
    return form == KQ_EM_MULTIPLE && total == 0 ? KQ_ERR_FORM : KQ_OK;
}

static kq_status em_check_covariances(const estimation *e, const parameters *p, int r,
                                      const kq_em_choice *choice)
{
    kq_status status = em_check_covariance(p->Q, r);
    if (!status) status = em_check_covariance(p->R, e->components);
    if (!status) status = em_check_covariance(p->P0, e->states);
    if (!status && choice->free & KQ_EM_Q) status = em_check_form(p->Q, r, choice->Q_form);
    if (!status && choice->free & KQ_EM_R) {
        status = em_check_form(p->R, e->components, choice->R_form);
    }
    return status;
}

/* Are F's columns independent? */
KQ_NOINLINE static kq_status em_check_factor(const num *F, int n, int r)
{
    num rows[KQ_SIZE_MAX * KQ_SIZE_MAX], root[KQ_TRIANGLE(KQ_SIZE_MAX)];
    for (int j = 0; j < r; j++) {
        for (int i = 0; i < n; i++) rows[j * n + i] = F[i * r + j];
    }
    root_of_factor(root, rows, r, n);
    for (int j = 0; j < r; j++) {
        if (root[column(j) + j] == 0) return KQ_ERR_FORM;
    }
    return KQ_OK;
}

/* Sizes and numbers of the model */
static kq_status em_check_model(const estimation *e, const parameters *p,
                                const kq_em_choice *choice)
{
    const int n = e->states, m = e->components;
    if (em_check_pointers(p)) return KQ_ERR_NULL;
    if (p->controls < 0 || p->controls > KQ_SIZE_MAX) return KQ_ERR_SIZE;
    if (p->F ? p->noises < 1 || p->noises > n : p->noises != 0) return KQ_ERR_SIZE;
    const int r = p->F ? (int)p->noises : n, l = (int)p->controls;
    if (!all_finite(p->A, n * n) || !all_finite(p->H, m * n) || !all_finite(p->x0, n)) {
        return KQ_ERR_NOT_FINITE;
    }
    if ((l && !all_finite(p->B, n * l)) || (p->F && !all_finite(p->F, n * r))) {
        return KQ_ERR_NOT_FINITE;
    }
    const kq_status status = em_check_covariances(e, p, r, choice);
    return !status && p->F ? em_check_factor(p->F, n, r) : status;
}

static kq_status em_check_choice(const kq_em_choice *choice)
{
    if (choice->free > KQ_EM_ALL) return KQ_ERR_SIZE;
    if (choice->Q_form > KQ_EM_MULTIPLE || choice->R_form > KQ_EM_MULTIPLE) return KQ_ERR_SIZE;
    return KQ_OK;
}

/* Steps that the memory has a history for; kq_length, as a recording may have more than a size_t of
   16 bits */
static kq_length em_most_steps(const estimation *e)
{
    const size_t n = e->states, m = e->components;
    return (e->length - (size_t)EM_LEN(n, m, 0)) / (size_t)HISTORY_STEP_LEN(n, m);
}

/* `measurements` gets those of the recording. */
static kq_status recording_check(const estimation *e, const recording *r, int controls,
                                 uint32_t *measurements)
{
    if (!r->z) return KQ_ERR_NULL;
    if (r->steps < 1 || r->steps > KQ_COUNT_MAX) return KQ_ERR_SIZE;
    if (r->steps > em_most_steps(e)) return KQ_ERR_MEMORY;
    const num *z = r->z;
    for (size_t t = 0; t < r->steps; t++) {
        const uint32_t present = present_at(e, r, t);
        for (int c = 0; c < e->components; c++, z++) {
            if (present >> c & 1 && !num_is_finite(*z)) return KQ_ERR_NOT_FINITE;
        }
        *measurements += (uint32_t)count_of(present);
    }
    const num *u = r->u;
    for (size_t t = 1; controls && u && t < r->steps; t++, u += controls) {
        if (!all_finite(u, controls)) return KQ_ERR_NOT_FINITE;
    }
    return KQ_OK;
}

static int entries_free(const uint8_t *held, int count)
{
    int number = 0;
    for (int k = 0; k < count; k++) number += !held || !held[k];
    return number;
}

/* A mask that holds something, or NULL */
static const uint8_t *held_of(const uint8_t *held, int count)
{
    return entries_free(held, count) < count ? held : 0;
}

static int covariance_entries(int n, kq_em_form form)
{
    if (form == KQ_EM_MULTIPLE) return 1;
    return form == KQ_EM_DIAGONAL ? n : KQ_TRIANGLE(n);
}

static uint32_t em_count_free(const estimation *e, const kq_em_choice *choice, int r)
{
    const int n = e->states, m = e->components;
    int count = 0;
    if (choice->free & KQ_EM_A) count += entries_free(choice->A_held, n * n);
    if (choice->free & KQ_EM_H) count += entries_free(choice->H_held, m * n);
    if (choice->free & KQ_EM_Q) count += covariance_entries(r, choice->Q_form);
    if (choice->free & KQ_EM_R) count += covariance_entries(m, choice->R_form);
    if (choice->free & KQ_EM_X0) count += n;
    if (choice->free & KQ_EM_P0) count += KQ_TRIANGLE(n);
    return (uint32_t)count;
}

/* Is the unit of the state nobody's?  H, Q and it may all be multiplied. */
static int em_has_no_unit(const estimation *e, const parameters *p, const kq_em_choice *choice)
{
    if (!(choice->free & KQ_EM_Q) || !(choice->free & KQ_EM_H)) return 0;
    for (int k = 0; choice->H_held && k < e->components * e->states; k++) {
        if (choice->H_held[k] && p->H[k] != 0) return 0;
    }
    return 1;
}

/* ------------------------------------------------------------------ the model exchanged */

KQ_NOINLINE static void exchange(num *a, num *b, int count)
{
    for (int k = 0; k < count; k++) {
        const num entry = a[k];
        a[k] = b[k];
        b[k] = entry;
    }
}

/* Parameters KQ_EM_...: the caller's for those in memory, and these for the caller's */
static void em_exchange(const estimation *e, unsigned which)
{
    const em_places w = em_at(e);
    const parameters *p = e->model;
    const int n = e->states, m = e->components, r = em_noises(e);
    if (which & KQ_EM_A) exchange(p->A, w.A, n * n);
    if (which & KQ_EM_H) exchange(p->H, w.H, m * n);
    if (which & KQ_EM_Q) exchange(p->Q, w.Q, r * r);
    if (which & KQ_EM_R) exchange(p->R, w.R, m * m);
    if (which & KQ_EM_X0) exchange(p->x0, w.x0, n);
    if (which & KQ_EM_P0) exchange(p->P0, w.P0, n * n);
}

/* ------------------------------------------------------------------ the model prepared */

/* F^+ G into the map, r x n: least squares of G's columns on F's */
static void em_map_noise(const em_places *w, const num *F, const num *G, int n, int r)
{
    num c[KQ_SIZE_MAX], *rows = w->work.rows;
    const sums s = {n, r, w->work.spare, 1};
    for (int j = 0; j < n; j++) {
        for (int i = 0; i < n; i++) rows[j * n + i] = i <= j ? G[column(j) + i] : 0;
    }
    for (int j = 0; j < r; j++) {
        for (int i = 0; i < n; i++) rows[(n + j) * n + i] = F[i * r + j];
    }
    sums_make(&s, &w->work, n);
    for (int k = 0; k < n; k++) {
        sums_coefficients(c, &s, k);
        for (int j = 0; j < r; j++) w->map[j * n + k] = c[j];
    }
}

/* The root of F Q F' into G, Q = L L' */
static void em_root_of_factor(const em_places *w, num *G, const num *F, int n, int r)
{
    num *factor = w->work.rows;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < r; j++) {
            factor[i * r + j] = dot(0, F + i * r, w->of_Q + column(j), j + 1);
        }
    }
    root_of_factor(G, factor, n, r);
    drop_pivots(G, n, (num)(8 * n) * num_epsilon);
}

static kq_status em_prepare_process(estimation *e, const em_places *w, const parameters *p)
{
    const int n = e->states;
    num *G = p->F ? w->work.spare : w->of_Q;
    const kq_status status = T(kq_process_assign)(&e->process, n, (int)p->controls, w->process,
                                            KQ_PROCESS_LEN((size_t)n));
    if (status) return status;
    root_of_covariance(w->of_Q, p->Q, em_noises(e), UINT32_MAX);
    if (p->F) em_root_of_factor(w, G, p->F, n, (int)p->noises);
    copy(w->process, G, KQ_TRIANGLE(n));
    process_set_model(&e->process, p->A, p->B);
    if (p->F) em_map_noise(w, p->F, e->process.noise_root, n, (int)p->noises);
    return KQ_OK;
}

static kq_status em_prepare_sensor(estimation *e, const em_places *w, const parameters *p)
{
    const int m = e->components;
    const kq_status status =
        T(kq_sensor_assign)(&e->sensor, e->states, m, w->sensor, KQ_SENSOR_LEN((size_t)m));
    if (status) return status;
    root_of_covariance(w->of_R, p->R, m, UINT32_MAX);
    if (is_diagonal(p->R, m)) {
        sensor_set_diagonal(&e->sensor, &T(kq_sensor_independent), p->H, p->R, m + 1);
        return KQ_OK;
    }
    copy(w->sensor, w->of_R, KQ_TRIANGLE(m));
    decorrelate_root(w->sensor, m);
    sensor_set_correlated(&e->sensor, p->H, p->R);
    return KQ_OK;
}

/* The model has passed the check. */
static kq_status em_prepare(estimation *e, const em_places *w, const parameters *p)
{
    const int n = e->states;
    kq_status status = em_prepare_process(e, w, p);
    if (!status) status = em_prepare_sensor(e, w, p);
    if (status) return status;
    root_of_covariance(w->of_P0, p->P0, n, UINT32_MAX);
    status = T(kq_filter_assign)(&e->filter, n, w->filter, FILTER_LEN((size_t)n));
    if (status) return status;
    return T(kq_history_assign)(&e->history, n, w->history,
                                (size_t)(e->memory + e->length - w->history));
}

#endif
