/* The gain of the next update. */
#ifndef KQ_SRC_FILTER_GAIN_H
#define KQ_SRC_FILTER_GAIN_H

#include "low_noise.h"

/*
 * The scalar gains k_c, each for the state as corrected by the ones before it, into the gain
 * for the whole innovation: K = [k_0 k_1 ...] (I + L)^-1 M with L_cl = h_c'k_l for l < c, and
 * M the decorrelation.  In place, columns from the last.
 */
KQ_COLD static void join_gains(scaled *K, const reading *z)
{
    const sensor *s = z->sensor;
    const int n = s->states, m = s->components;
    scaled k[KQ_SIZE_MAX] = {0}, buffer[KQ_SIZE_MAX];
    for (int l = m - 1; l >= 0; l--) {
        for (int i = 0; i < n; i++) k[i] = K[i * m + l];
        for (int c = l + 1; c < m; c++) {
            const scaled *h = scalar_row(z, c, buffer);
            scaled along = scaled_times(h[0], k[0]);
            for (int i = 1; i < n; i++) along = scaled_plus(along, scaled_times(h[i], k[i]));
            for (int i = 0; i < n; i++) {
                K[i * m + l] = scaled_minus(K[i * m + l], scaled_times(along, K[i * m + c]));
            }
        }
    }
    for (int j = m - 1; j > 0 && sensor_is_correlated(s); j--) {
        for (int c = 0; c < j; c++) {
            for (int i = 0; i < n; i++) {
                const scaled part = scaled_times(K[i * m + c], z->noise[column(j) + c]);
                K[i * m + j] = scaled_plus(K[i * m + j], part);
            }
        }
    }
}

/* The gain, or none if K is NULL; the root becomes that of the updated state. */
KQ_COLD static void gain_of_root(filter *f, const reading *z, scaled *K)
{
    const sensor *s = z->sensor;
    scaled buffer[KQ_SIZE_MAX], memory[LOW_NOISE_PARTS * KQ_SIZE_MAX];
    const low_noise_work w = low_noise_work_at(memory, f->states);
    low_noise_scalar one;
    const scaled zero = scaled_zero();
    const int n = f->states, m = s->components;
    one.z = z;
    for (int c = 0; c < m; c++) {
        one.component = c;
        one.h = scalar_row(z, c, buffer);
        one.r = scalar_noise(z, c);
        one.e = zero;
        const int taken = update_root(f, &one, &w);
        for (int i = 0; K && i < n; i++) {
            K[i * m + c] = taken ? scaled_over(w.b[i], one.s) : zero;
        }
    }
    if (K) join_gains(K, z);
}

KQ_COLD static void gain_with(const filter *f, const reading *z, scaled *K)
{
    num memory[FILTER_LEN(KQ_SIZE_MAX)];
    filter trial = *f;
    trial.memory = memory;
    filter_set_attached(&trial, 0);
    copy(memory, f->memory, FILTER_LEN(f->states));
    gain_of_root(&trial, z, K);
}

KQ_COLD KQ_NOINLINE static void gain_of_some(const filter *f, const sensor *s, scaled *K)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    noise_of_present(noise, s, UINT32_MAX);
    gain_with(f, &(reading){s, noise, 0, UINT32_MAX}, K);
}

/* The update of a root alone, in place, and its gain unless K is NULL.  f: a copy of a filter */
KQ_NOINLINE static void update_root_by(filter *f, const sensor *s, scaled *K)
{
    scaled noise[KQ_TRIANGLE(KQ_SIZE_MAX)];
    reading z = {s, s->noise, 0, UINT32_MAX};
    if (noise_is_of_others(s, UINT32_MAX)) {
        noise_of_present(noise, s, UINT32_MAX);
        z.noise = noise;
    }
    filter_set_ready(f, FILTER_READY);
    gain_of_root(f, &z, K);
}

#endif
