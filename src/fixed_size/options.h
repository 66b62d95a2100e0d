/*
 * kalmanq: sizes that the compiler knows.
 *
 * A source file of the user's own fixes n, m and what is known of A, and gets the steps compiled
 * for them: the same text, the same results, in about half of the instructions, for some kB of code.
 * Bit for bit where neither fuses products and sums (-ffp-contract=off); fused, last bits differ and
 * the low parts of means.
 *
 *     #include "kq_fixed_f32.h"    // in src/fixed_size of the source tree; installed:
                                 // <kalmanq/kernels/fixed_size/...>
 *
 *     kq_status track_step(const float z[2])
 *     {
 *         return kq_fixed_step_f32(&track, &motion, NULL, &radar, z, 4, 2, 0, KQ_FIXED_UPPER);
 *     }
 *
 * track, motion and radar are the ordinary objects, initialised and read as ever; the functions of
 * this file and those of the library may take turns.  n, m, the number l of controls (here none) and
 * the options must be constants.  Where u is NULL l is not looked at; 0 then leaves the least code.
 * Best one function a size: each use compiles the kernels anew; one arithmetic a file.  Options,
 * or-ed:
 *     KQ_FIXED_UPPER   A is upper triangular (kinematic models in the order position, velocity, ...)
 *     KQ_FIXED_BARE    no likelihood is kept: kq_nis, kq_taken and the log-likelihoods stay as they were;
 *                where the step is not left to the library (below) KQ_EVENT_PRECISION is not looked
 *                for
 * Errors, a history that records, a correlated or noise-free R, an A or a number of controls that is
 * not what was said: the linked library's function takes the step, at its own cost, and answers.  So
 * does it in floating point up to n = 3 where a sigma is to be held or a measurement is unusual (the
 * noise below 2^-15 of S or of the innovation's square, 2^-47 in f64, or nearly all of S), whose bits
 * are then the library's; from n = 4 on, and in q31, it takes the unusual component and those after it:
 * last bits of likelihoods, and of how f32 splits a mean, may be others then.
 * Stack: what does not fit in registers, for the smoother at most its workspace
 * (KQ_PRIVATE_HISTORY_WORKSPACE_LEN of n rounded up to 4, 6, 9 or 16).  For gcc at -O2 or -O3; another
 * compiler may unroll less.
 */
#ifndef KQ_SRC_FIXED_SIZE_OPTIONS_H
#define KQ_SRC_FIXED_SIZE_OPTIONS_H

enum { KQ_FIXED_UPPER = 1, KQ_FIXED_BARE = 2 };

#endif
