/*
 * Steps of a filter whose roots go round in a cycle, word for word, most often of one: what is done to the mean is then
 * the same, too, at every turn.  It is kept once, by the library's own functions; a step is left with the mean,
 * by the operations of the full step and in their order: the same bits.  Compiled for sizes that the compiler knows;
 * calm_find.h is for all sizes.
 */
#ifndef KQ_NATIVE_CALM_H
#define KQ_NATIVE_CALM_H

/* The innovations of the measurement as a whole, in e; then the update by one component after the other, whose own are in
   `left` */
KQ_KERNEL int calm_update(const T(kq_calm) *k, num *x, const sensor *s, const num *z, num *e, num *left, num *nis, int n, int m)
{
    KQ_UNROLL
    for (int c = 0; c < m; c++) e[c] = mean_residual(z[c], s->measurement + c * n, x, n, 0, n);
    *nis = 0;
    KQ_UNROLL
    for (int c = 0; c < m; c++) {
        const num *b = k->directions + c * n, variance = k->variances[c];
        const num residual = mean_residual(z[c], s->measurement + c * n, x, n, 0, n);
        if (!is_certainly_blunt(s->noise[c], variance, residual) || is_weak(s->noise[c], variance)) return 0;
        const num w = residual / variance;
        left[c] = residual;
        KQ_UNROLL
        for (int i = 0; i < n; i++) mean_correct(x, n, i, b[i], w);
        *nis += weight_nis(w, residual);
    }
    mean_settle(x, n);
    return 1;
}

/* Where it answers 0 there is something unusual, and the filter is as it was. */
KQ_KERNEL int calm_step(const T(kq_calm) *k, filter *f, const process *p, const num *u, const sensor *s,
                        const num *z, num *e, int n, int m)
{
    num x[MEAN_PLANES * KQ_SIZE_MAX], t[KQ_SIZE_MAX], left[KQ_SIZE_MAX], nis;
    if (u && controls_check(p, u, p->controls)) return 0;
    KQ_UNROLL
    for (int i = 0; i < MEAN_PLANES * n; i++) x[i] = f->memory[i];
    mean_copy(t, x, n);
    if (mean_rounds && (p->plain & PROCESS_ROUNDED)) mean_take_rests(x, p->transition, t, n);
    predict_mean_of(x, p, u, p->controls, t, n, SHAPE_AS_FOUND);
    if (!calm_update(k, x, s, z, e, left, &nis, n, m)) return 0;
    if (f->attached) T(kq_calm_record)(k, f, p, left, m);
    KQ_UNROLL
    for (int i = 0; i < MEAN_PLANES * n; i++) f->memory[i] = x[i];
    f->last = k->last;
    f->last.nis = nis;
    likelihood_run_add(&f->run, &f->last);
    return 1;
}

#endif
