/*
 * kalmanq in double: EM, and its public names.  A file of its own: who does not call it has nothing
 * of it.
 */
#include "has_double.h"

#if KQ_HAS_DOUBLE
/* Of these files a part is used. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif

#include "types_f64.h"

#include "triangle.inc"

#include "process.inc"
#include "predict.inc"
#include "update.inc"

#include "fit_float.inc"
#include "sensor.inc"
#include "likelihood.inc"
#include "filter.inc"

#include "root.inc"
#include "model.inc"

#include "history.inc"

/* Predict and update are the library's. */
static kq_status filter_predict(filter *f, const process *p, const num *u)
{
    return kq_predict_f64(f, p, u);
}

static kq_status filter_update_subset(filter *f, const sensor *s, const num *z, uint32_t present)
{
    return kq_update_subset_f64(f, s, z, present);
}

#include "smooth_kernels.inc"
#include "smoother.inc"

#include "em_sums.inc"
#include "em_expect.inc"
#include "em_filter.inc"
#include "em_model.inc"
#include "em_maximise.inc"
#include "em.inc"

kq_status kq_em_assign_f64(kq_em_f64 *em, int n, int m, double *memory, size_t length)
{
    return em_assign(em, n, m, memory, length);
}

kq_status kq_em_init_f64(kq_em_f64 *em, const kq_parameters_f64 *model, const kq_em_choice *choice,
                         const kq_recording_f64 *recordings, int count)
{
    return em_init(em, model, choice, recordings, count);
}

kq_status kq_em_iterate_f64(kq_em_f64 *em) { return em_iterate(em); }

kq_status kq_em_advance_f64(kq_em_f64 *em) { return em_advance(em); }

uint32_t kq_em_remaining_f64(const kq_em_f64 *em) { return em ? em->remaining : 0; }

double kq_em_log_likelihood_f64(const kq_em_f64 *em) { return em_log_likelihood(em); }

kq_status kq_em_maximise_f64(kq_em_f64 *em) { return em_maximise(em); }

double kq_em_change_f64(const kq_em_f64 *em) { return em_change(em); }

double kq_em_distance_f64(const kq_em_f64 *em) { return em_distance(em); }

int kq_em_is_settled_f64(const kq_em_f64 *em, double tolerance)
{
    return em_is_settled(em, tolerance);
}

kq_status kq_em_gradient_f64(const kq_em_f64 *em, const kq_gradient_f64 *gradient)
{
    return em_gradient(em, gradient);
}

#endif
