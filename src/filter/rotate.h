#ifndef KQ_SRC_FILTER_ROTATE_H
#define KQ_SRC_FILTER_ROTATE_H

#include "../arithmetic/arithmetic.h"
#include "../arithmetic/compiler.h"
#include "../arithmetic/rotor.h"
#include "../arithmetic/scaled.h"

/*
 * The measurement update of the root by one scalar measurement, Carlson's form.
 *     f = S'h,   a_j = r + f_0^2 + ... + f_j^2,   s = a_{n-1} the innovation variance
 *     c_j = sqrt(a_{j-1} / a_j),   S_j <- c_j S_j - (c_j f_j / a_{j-1}) b,   b += f_j S_j
 * At the end b = S f is s times the gain.  It is n Givens rotations of (r, f) that the
 * smoother will undo.  r > 0, so no a_j is 0; each c_j <= 1 and rows only shrink.
 *
 * b takes the place of f: entry j is read before the first of b's that comes there.  The
 * arithmetic may carry b in a unit of its own (rotor_unit).
 */
KQ_KERNEL rotor rotate_root(num *restrict S, num *restrict f, scaled r, scaled s, int n)
{
    rotor state = rotor_begin(r, s, f, n);
    KQ_UNROLL
    for (int j = 0; j < n; j++) {
        if (is_no_turn(f[j])) {
            f[j] = 0;
        } else {
            const rotation turn = rotor_turn(&state, f[j]);
            rotate(S, f, turn, j);
        }
        S += j + 1;
    }
    return state;
}

#endif
