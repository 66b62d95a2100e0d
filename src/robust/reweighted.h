/* A process whose noise is scaled, and the smoother with one that is scaled step by step. */
#ifndef KQ_SRC_ROBUST_REWEIGHTED_H
#define KQ_SRC_ROBUST_REWEIGHTED_H

#include "robust.h"

static kq_status process_scale_check(const process *target, const process *source, scaled q,
                                     num *root)
{
    if (!target) return KQ_ERR_NULL;
    kq_status status = process_check(source);
    if (!status) status = noise_weight_check(q);
    if (status) return status;
    if (target == source) return KQ_ERR_MISMATCH;
    return scaled_noise_check(target, source, root, scaled_root(q));
}

static kq_status process_scale_noise(process *target, const process *source, num *root, scaled q)
{
    const kq_status status = process_scale_check(target, source, q, root);
    if (status) return status;
    set_scaled_noise(target, source, root, scaled_root(q));
    return KQ_OK;
}

/* Does coordinate k of the noise move the state? */
static int noise_is_live(const process *p, int k)
{
    for (int i = 0; i <= k; i++) {
        const scaled entry = root_number(p->noise_root, p->states, i, k);
        if (scaled_is_less(num_tiny, scaled_times(entry, entry))) return 1;
    }
    return 0;
}

/* E[eta'eta | T] of the step that is being undone, eta in units of m's G; `rank` gets the number of
   its coordinates that move the state, which alone are counted */
static scaled noise_square(const process *m, const process *source, const workspace *v, int *rank)
{
    const scaled zero = scaled_zero();
    const int n = m->states;
    scaled total = zero;
    *rank = 0;
    for (int k = 0; k < n; k++) {
        if (!noise_is_live(source, k)) continue;
        num *theta = v->M; /* one row after the other in the place of the first */
        theta_noise_row(theta, m, v, k);
        const scaled mean = coordinate_scaled(coordinate_dot(theta, v->a, n, n));
        row_times_root(theta, v->T, n, n);
        total = scaled_plus(total, scaled_times(mean, mean));
        total = scaled_plus(total, row_product(theta, theta, 2 * n));
        ++*rank;
    }
    return total;
}

/* smooth_back by m, the source scaled by q; answers the q that the smoothed noise asks for. */
static scaled smooth_back_reweighted(history *h, const process *m, const process *source, scaled nu,
                                     scaled q)
{
    const process *before;
    const int n = h->states;
    int rank;
    const workspace v = workspace_at(h->memory, n);
    num *state = history_pop_predict(h, &before, n);
    h->process = before;
    predict_root(v.predicted, state + MEAN_PLANES * n, m, v.W, v.pq);
    const scaled square = scaled_times(q, noise_square(m, source, &v, &rank));
    history_note(h, theta_times_root(m, &v, n));
    take_coordinates(&v, n);
    history_note(h, smoothed_state(state, v.a, v.T, n));
    keep_state(h, state, n);
    h->step--;
    undo_updates(h, n, 0);
    return scaled_over(scaled_plus(nu, square), scaled_plus(nu, scaled_of_count(rank)));
}

static kq_status smooth_reweighted_check(const history *h, const process *target,
                                         const process *source, num *root, scaled nu,
                                         const scaled *q)
{
    kq_status status = smooth_check(h, 0);
    if (!status) status = process_check(source);
    if (!status) status = parameter_check(nu);
    if (status) return status;
    if (!target || !q) return KQ_ERR_NULL;
    if (h->attached.hooks->is_recorder == RECORDS_PROCESSES) return KQ_ERR_RECORDING; /* each step has its own */
    if (source->states != h->states || !processes_agree(source, h->process)) {
        return KQ_ERR_MISMATCH;
    }
    for (uint32_t t = 0; t + 1 < h->steps && !status; t++) {
        status = process_scale_check(target, source, q[t], root);
    }
    return status;
}

/* q[t]: of the predict from step t to t + 1 */
static kq_status smooth_reweighted(history *h, process *target, const process *source, num *root,
                                   scaled nu, scaled *q)
{
    const kq_status status = smooth_reweighted_check(h, target, source, root, nu, q);
    if (status) return status;
    smooth_one(h, 0, undo_mean_and_root, 0, HISTORY_SMOOTHING);
    while (h->step > 0) {
        scaled *now = q + (h->step - 1);
        set_scaled_noise(target, source, root, scaled_root(*now)); /* has been checked */
        *now = smooth_back_reweighted(h, target, source, nu, *now);
    }
    return KQ_OK;
}

#endif
