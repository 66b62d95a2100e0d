/* The slopes of P and x with log q (adaptation.h): what a predict makes of them, and what the scalar measurements of an
   update say of the scales, and make of them. */
#ifndef KQ_SRC_ADAPTATION_SLOPES_H
#define KQ_SRC_ADAPTATION_SLOPES_H

#include "models.h"

/* ------------------------------------------------------------------ predict */

/* (A v)_i; v: `stride` apart */
static scaled transition_times(const process *p, int i, const scaled *v, int stride)
{
    const scaled *row = p->transition + i * p->states;
    scaled total = {0};
    for (int k = p->first[i]; k < p->states; k++) {
        if (scaled_is_zero(row[k])) continue;
        total = scaled_plus(total, scaled_times(row[k], v[k * stride]));
    }
    return total;
}

/* v <- A v */
static void advance(scaled *v, int stride, const process *p)
{
    scaled moved[KQ_SIZE_MAX];
    const int n = p->states;
    for (int i = 0; i < n; i++) moved[i] = scaled_saturated(transition_times(p, i, v, stride));
    for (int i = 0; i < n; i++) v[i * stride] = moved[i];
}

/* The lower triangle as the upper one */
static void mirror_triangle(scaled *D, int n)
{
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < i; j++) D[i * n + j] = D[j * n + i];
    }
}

/* D <- A D A' + G G': columns, then what is needed of the rows */
static void advance_covariance(scaled *D, const process *p)
{
    scaled moved[KQ_SIZE_MAX];
    const int n = p->states;
    for (int j = 0; j < n; j++) advance(D + j, n, p);
    for (int i = 0; i < n; i++) {
        for (int j = i; j < n; j++) {
            const scaled noise = root_product(p->noise_root, n, i, j);
            moved[j] = scaled_plus(transition_times(p, j, D + i * n, 1), noise);
        }
        for (int j = i; j < n; j++) D[i * n + j] = scaled_saturated(moved[j]);
    }
    mirror_triangle(D, n);
}

/* ------------------------------------------------------------------ what an update says */

/* Scores and information of an update */
typedef struct {
    scaled process, sensor;
    scaled information[3];
    int count; /* scalar measurements */
} lesson;

/* One scalar measurement */
typedef struct {
    const scaled *h;
    scaled r, whole; /* its noise; its variance without the others of the update */
    scaled *k;       /* P h, then P h / sqrt(s) */
    scaled *unit;    /* its innovation, then nu */
} scalar;

static scaled inner(const scaled *h, const scaled *v, int n)
{
    scaled total = {0};
    for (int i = 0; i < n; i++) {
        if (scaled_is_zero(h[i])) continue;
        total = scaled_plus(total, scaled_times(h[i], v[i]));
    }
    return total;
}

/* v <- v - c w */
static void subtract(scaled *v, scaled c, const scaled *w, int n)
{
    for (int i = 0; i < n; i++) v[i] = scaled_minus(v[i], scaled_times(c, w[i]));
}

static scaled half(scaled a) { return scaled_shift(a, -1); }

static scaled squared(scaled a) { return scaled_times(a, a); }

/* Within -most .. most */
static scaled within(scaled a, scaled most)
{
    if (!scaled_is_less(most, scaled_magnitude(a))) return a;
    return scaled_is_negative(a) ? scaled_negative(most) : most;
}

/* P h = S (S'h), and h'P h + r */
static void begin_scalar(scalar *one, const filter *f)
{
    num F[ROW_LEN(KQ_SIZE_MAX)];
    const num *S = filter_root(f);
    const int n = f->states;
    project(F, S, one->h, n);
    root_times_row(one->k, S, F, n);
    one->whole = scaled_plus(row_product(F, F, n), one->r);
}

/* P h and e as they are after the `count` scalar measurements before it */
static void follow(scalar *one, const adaptation *a, int count)
{
    const int n = a->states;
    for (int j = 0; j < count; j++) {
        const scaled *before = scalar_gains(a) + j * n;
        const scaled along = inner(one->h, before, n);
        *one->unit = scaled_minus(*one->unit, scaled_times(along, scalar_units(a)[j]));
        subtract(one->k, along, before, n);
    }
}

/* Divides by sqrt(s); answers 1 / sqrt(s), or 0 where the others explain s up to rounding. */
static scaled normalise(scalar *one, int n)
{
    const scaled none = {0};
    const scaled s = scaled_plus(inner(one->h, one->k, n), one->r);
    if (scaled_is_negative(s) || !scaled_is_less(num_zero_variance, s)) return none;
    if (!scaled_is_less(scaled_times(one->whole, scaled_rounding()), s)) return none;
    const scaled over_sigma = scaled_over(scaled_one, scaled_root(s));
    for (int i = 0; i < n; i++) one->k[i] = scaled_times(one->k[i], over_sigma);
    *one->unit = scaled_times(*one->unit, over_sigma);
    return scaled_is_finite(over_sigma) && scaled_is_finite(*one->unit) ? over_sigma : none;
}

/* nu; a; y */
static void add_scores(lesson *l, scaled unit, scaled share, scaled slope)
{
    const scaled rest = scaled_minus(scaled_one, share), steep = squared(slope);
    const scaled excess = half(scaled_minus(squared(unit), scaled_one));
    const scaled along = scaled_times(unit, slope);
    scaled *J = l->information;
    l->process = scaled_plus(l->process, scaled_plus(scaled_times(share, excess), along));
    l->sensor = scaled_plus(l->sensor, scaled_minus(scaled_times(rest, excess), along));
    J[0] = scaled_plus(J[0], scaled_plus(half(squared(share)), steep));
    J[1] = scaled_plus(J[1], scaled_minus(half(scaled_times(share, rest)), steep));
    J[2] = scaled_plus(J[2], scaled_plus(half(squared(rest)), steep));
    l->count++;
}

/* D <- (I - K h') D (I - K h')'; v = D h / sqrt(s), a = h'v / sqrt(s) */
static void correct_covariance(scaled *D, const scaled *k, const scaled *v, scaled share, int n)
{
    for (int i = 0; i < n; i++) {
        const scaled w = scaled_minus(v[i], scaled_times(share, k[i]));
        for (int j = i; j < n; j++) {
            const scaled part = scaled_plus(scaled_times(w, k[j]), scaled_times(k[i], v[j]));
            D[i * n + j] = scaled_minus(D[i * n + j], part);
        }
    }
    mirror_triangle(D, n);
}

/* What a scalar measurement, normalised, says; then D and d as they are after it. */
static void study(adaptation *a, const scalar *one, scaled over_sigma, lesson *l)
{
    scaled v[KQ_SIZE_MAX];
    const int n = a->states;
    scaled *D = covariance_slope(a), *d = mean_slope(a);
    for (int i = 0; i < n; i++) v[i] = scaled_times(inner(one->h, D + i * n, n), over_sigma);
    const scaled most = scaled_of_count(MOST), unit = within(*one->unit, most);
    const scaled slope = scaled_times(inner(one->h, d, n), over_sigma);
    scaled share = scaled_times(inner(one->h, v, n), over_sigma);
    if (scaled_is_negative(share)) share = (scaled){0}; /* but for rounding it is in 0 .. 1 */
    if (scaled_is_less(scaled_one, share)) share = scaled_one;
    add_scores(l, unit, share, within(slope, most));
    const scaled back = scaled_plus(slope, scaled_times(share, unit));
    for (int i = 0; i < n; i++) {
        const scaled part = scaled_minus(scaled_times(v[i], unit), scaled_times(one->k[i], back));
        d[i] = scaled_plus(d[i], part);
    }
    correct_covariance(D, one->k, v, share, n);
}

static void study_scalars(adaptation *a, const filter *f, const reading *z, lesson *l)
{
    scaled buffer[KQ_SIZE_MAX];
    for (int c = 0; c < a->components; c++) {
        if (!(z->present >> c & 1)) continue;
        scalar one = {.h = scalar_row(z, c, buffer),
                      .r = scalar_noise(z, c),
                      .k = scalar_gains(a) + l->count * a->states,
                      .unit = scalar_units(a) + l->count};
        *one.unit = scalar_innovation(f, z, c);
        begin_scalar(&one, f);
        follow(&one, a, l->count);
        const scaled over_sigma = normalise(&one, a->states);
        if (!scaled_is_zero(over_sigma)) study(a, &one, over_sigma, l);
    }
}

/* Correlated, with components missing: as in filter/step.h */
KQ_NOINLINE static void study_present(adaptation *a, const filter *f, const reading *z, lesson *l)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    noise_of_present(noise, z->sensor, z->present);
    const reading some = {z->sensor, noise, z->z, z->present};
    study_scalars(a, f, &some, l);
}

#endif
