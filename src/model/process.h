/* The process: A, B and the root of Q, prepared. */
#ifndef KQ_SRC_MODEL_PROCESS_H
#define KQ_SRC_MODEL_PROCESS_H

#include "twins.h"

KQ_INLINE kq_status process_check(const process *p)
{
    if (!p) return KQ_ERR_NULL;
    return p->noise_root ? KQ_OK : KQ_ERR_NOT_READY;
}

enum { PROCESS_UPPER = 128, PROCESS_ROUNDED = 64 };

/* A process that was not always the same: no fingerprint is that. */
static const uint32_t process_mixed = UINT32_C(1) << 31;

/* Turned, so that a word's high bits count in low ones; times 2^32 / 1.618, which is odd: each of
   the two can be undone, and no word is lost. */
static inline uint32_t fingerprint_join(uint32_t print, uint32_t word)
{
    return ((print << 5 | print >> 27) ^ word) * UINT32_C(0x9e3779b1);
}

/* Not for size: it is a part of every step whose A is another one. */
KQ_SHARED uint32_t fingerprint_of(uint32_t print, const num *words, int count)
{
    for (; count > 0; count--) print = fingerprint_join(print, num_bits(*words++));
    return print;
}

/* One whose noise has been scaled: its fingerprint is not the fingerprint of its G. */
static const uint32_t process_scaled = UINT32_C(1) << 30;

/* Of what the smoother reads, G and A, in 30 bits */
KQ_COLD static uint32_t process_fingerprint(const process *p)
{
    const int n = p->states;
    const uint32_t noise = fingerprint_of(0, p->noise_root, ROOT_LEN(n));
    const uint32_t print = fingerprint_of(noise, (const num *)p->transition, n * n * SCALED_WORDS);
    return (print ^ print >> 16) & ~(process_mixed | process_scaled);
}

KQ_COLD static void process_set_transition(process *p, const scaled *A)
{
    const int n = p->states;
    int first = n, upper = 1;
    for (int i = n - 1; i >= 0; i--) {
        int k = 0;
        while (k < first && scaled_is_zero(A[i * n + k])) k++;
        first = k;
        p->first[i] = (uint8_t)first;
        if (first < i) upper = 0;
    }
    const int rounded = transition_is_rounded(A, n) ? PROCESS_ROUNDED : 0;
    p->plain = (uint8_t)(n | rounded | (upper ? PROCESS_UPPER : 0));
    p->transition = A;
    p->fingerprint = process_fingerprint(p);
    p->seal = 0;
}

/* The fingerprint of a process of noise c G; of c = 1: the source's own */
static uint32_t scaled_fingerprint(const process *source, scaled c)
{
    if (scaled_bits(c) == scaled_bits(scaled_one)) return source->fingerprint;
    const uint32_t print = fingerprint_join(source->fingerprint, scaled_bits(c));
    return ((print ^ print >> 16) & ~process_mixed) | process_scaled;
}

/* n and what the steps of compile-time sizes are told of A: is it upper triangular? */
KQ_KERNEL int process_shape(const process *p) { return p->plain & ~PROCESS_ROUNDED; }

/* What is known of A beforehand.  FULL: there is no A and no noise, only dense rows. */
enum { SHAPE_AS_FOUND, SHAPE_DENSE, SHAPE_UPPER, SHAPE_FULL };

/* Rows l and below of A are 0 to the left of this column. */
KQ_KERNEL int first_column(const process *p, int l, int shape)
{
    if (shape == SHAPE_AS_FOUND) return p->first[l];
    return shape == SHAPE_UPPER ? l : 0;
}

#endif
