/*
 * Cortex-M0 and M0+: the loops, in words of two halves.  include/kalmanq/port/vectors.h says what each
 * one is.
 *
 * In the sums of 64 bits a word is (signed high half, unsigned low half), and each of the two mixed
 * products, which fit a signed word, is added at bit 16.  Where one factor is the same for all, both low
 * halves are signed: then the two mixed products and what rounds into them fit one word, and
 *     a b 2^-k, rounded = a_high b_high 2^(32-k) + (mixed + (a_low b_low >> 16)) 2^(16-k), rounded,
 * of which the last shift leaves its half in the carry.
 */
#ifndef KALMANQ_PORT_VECTORS_H
#define KALMANQ_PORT_VECTORS_H

#include <stdint.h>

/* r1:r0 += the sum of products of r2.. and r3.. up to r2 = ip */
KQ_ASSEMBLY kq_dot(void)
{
    __asm(".syntax unified\n\t"
          "push {r4-r7, lr}\n\t"
          "cmp r2, ip\n\t"
          "beq 2f\n"
          "1:\n\t"
          "ldmia r2!, {r4}\n\t"
          "ldmia r3!, {r5}\n\t"
          "cmp r4, #0\n\t" /* transitions are mostly 0 */
          "beq 3f\n\t"
          "uxth r6, r4\n\t"
          "asrs r4, r4, #16\n\t"
          "uxth r7, r5\n\t"
          "asrs r5, r5, #16\n\t"
          "mov lr, r6\n\t"
          "muls r6, r7, r6\n\t"
          "adds r0, r0, r6\n\t"
          "muls r7, r4, r7\n\t" /* multiplications leave the carry */
          "muls r4, r5, r4\n\t"
          "adcs r1, r1, r4\n\t"
          "mov r6, lr\n\t"
          "muls r6, r5, r6\n\t"
          "lsls r4, r7, #16\n\t"
          "asrs r7, r7, #16\n\t"
          "adds r0, r0, r4\n\t"
          "adcs r1, r1, r7\n\t"
          "lsls r4, r6, #16\n\t"
          "asrs r6, r6, #16\n\t"
          "adds r0, r0, r4\n\t"
          "adcs r1, r1, r6\n"
          "3:\n\t"
          "cmp r2, ip\n\t"
          "bne 1b\n"
          "2:\n\t"
          "pop {r4-r7, pc}");
}

static inline int64_t dot(int64_t total, const int32_t *a, const int32_t *b, int count)
{
    register uint32_t low __asm("r0") = (uint32_t)total;
    register uint32_t high __asm("r1") = (uint32_t)((uint64_t)total >> 32);
    register const int32_t *x __asm("r2") = a;
    register const int32_t *y __asm("r3") = b;
    register const int32_t *end __asm("ip") = a + count;
    __asm("bl %c5"
          : "+r"(low), "+r"(high), "+r"(x), "+r"(y)
          : "r"(end), "i"(kq_dot)
          : "lr", "cc", "memory");
    return (int64_t)((uint64_t)high << 32 | low);
}

/* r1:r0 += the sum of squares of r3 words, the first at r2, each r4 bytes behind the one before and r4
   growing by ip each time; r2, r3 and r4 are lost */
KQ_ASSEMBLY kq_squares(void)
{
    __asm(".syntax unified\n\t"
          "push {r5-r7, lr}\n\t"
          "cmp r3, #0\n\t"
          "beq 2f\n"
          "1:\n\t"
          "ldr r5, [r2]\n\t"
          "add r2, r2, r4\n\t"
          "add r4, r4, ip\n\t"
          "uxth r6, r5\n\t"
          "asrs r5, r5, #16\n\t"
          "mov r7, r6\n\t"
          "muls r7, r5, r7\n\t"
          "muls r6, r6, r6\n\t"
          "muls r5, r5, r5\n\t"
          "adds r0, r0, r6\n\t"
          "adcs r1, r1, r5\n\t"
          "lsls r6, r7, #17\n\t"
          "asrs r7, r7, #15\n\t"
          "adds r0, r0, r6\n\t"
          "adcs r1, r1, r7\n\t"
          "subs r3, r3, #1\n\t"
          "bne 1b\n"
          "2:\n\t"
          "pop {r5-r7, pc}");
}

static inline int64_t strided_squares(int64_t total, const int32_t *a, int count, int step, int growth)
{
    register uint32_t low __asm("r0") = (uint32_t)total;
    register uint32_t high __asm("r1") = (uint32_t)((uint64_t)total >> 32);
    register const int32_t *x __asm("r2") = a;
    register int left __asm("r3") = count;
    register int bytes __asm("r4") = 4 * step;
    register int more __asm("ip") = 4 * growth;
    __asm("bl %c6"
          : "+r"(low), "+r"(high), "+r"(x), "+r"(left), "+r"(bytes)
          : "r"(more), "i"(kq_squares)
          : "lr", "cc", "memory");
    return (int64_t)((uint64_t)high << 32 | low);
}

static inline int64_t squares(int64_t total, const int32_t *a, int count)
{
    return strided_squares(total, a, count, 1, 0);
}

static inline int64_t row_squares(const int32_t *s, int i, int n)
{
    return strided_squares(0, s, n - i, i + 1, 1);
}

/* r0.. -= r1.. r2 2^-30 up to r1 = ip.  |mixed| <= 2^30 + 2^29, for halves of 2^15 at most and 2^14 of
   V's high ones */
KQ_ASSEMBLY kq_subtract_multiple(void)
{
    __asm(".syntax unified\n\t"
          "push {r4-r7, lr}\n\t"
          "sxth r5, r2\n\t"
          "asrs r6, r2, #16\n\t"
          "movs r3, #0\n\t"
          "adcs r6, r6, r3\n\t"
          "lsls r7, r6, #2\n\t"
          "cmp r1, ip\n\t"
          "beq 2f\n"
          "1:\n\t"
          "ldmia r1!, {r2}\n\t"
          "sxth r3, r2\n\t"
          "subs r2, r2, r3\n\t"
          "asrs r2, r2, #16\n\t"
          "mov r4, r3\n\t"
          "muls r4, r5, r4\n\t"
          "asrs r4, r4, #16\n\t"
          "muls r3, r6, r3\n\t"
          "adds r3, r3, r4\n\t"
          "mov r4, r2\n\t"
          "muls r4, r5, r4\n\t"
          "adds r3, r3, r4\n\t"
          "muls r2, r7, r2\n\t"
          "asrs r3, r3, #14\n\t"
          "adcs r3, r3, r2\n\t"
          "ldr r4, [r0]\n\t"
          "subs r4, r4, r3\n\t"
          "stmia r0!, {r4}\n\t"
          "cmp r1, ip\n\t"
          "bne 1b\n"
          "2:\n\t"
          "pop {r4-r7, pc}");
}

static inline void subtract_multiple(int32_t *restrict w, const int32_t *restrict V, int32_t d,
                                     int count)
{
    register int32_t *to __asm("r0") = w;
    register const int32_t *from __asm("r1") = V;
    register int32_t factor __asm("r2") = d;
    register const int32_t *end __asm("ip") = V + count;
    __asm volatile("bl %c4"
                   : "+r"(to), "+r"(from), "+r"(factor)
                   : "r"(end), "i"(kq_subtract_multiple)
                   : "r3", "lr", "cc", "memory");
}

/* r0.. <- (r0.. << r1) r2 2^-31 up to r0 = ip.  -2^31 <= mixed < 2^31 - 2^14: low halves are below
   2^15, and of a word whose high half is 2^15 negative */
KQ_ASSEMBLY kq_scale(void)
{
    __asm(".syntax unified\n\t"
          "push {r4-r7, lr}\n\t"
          "sxth r5, r2\n\t"
          "asrs r6, r2, #16\n\t"
          "movs r3, #0\n\t"
          "adcs r6, r6, r3\n\t"
          "lsls r7, r6, #1\n\t"
          "cmp r0, ip\n\t"
          "beq 2f\n"
          "1:\n\t"
          "ldr r2, [r0]\n\t"
          "lsls r2, r2, r1\n\t"
          "sxth r3, r2\n\t"
          "asrs r2, r2, #16\n\t" /* of a word up to 2^31: its bit 15 is in the carry */
          "movs r4, #0\n\t"
          "adcs r2, r2, r4\n\t"
          "mov r4, r3\n\t"
          "muls r4, r5, r4\n\t"
          "asrs r4, r4, #16\n\t"
          "muls r3, r6, r3\n\t"
          "adds r3, r3, r4\n\t"
          "mov r4, r2\n\t"
          "muls r4, r5, r4\n\t"
          "adds r3, r3, r4\n\t"
          "muls r2, r7, r2\n\t"
          "asrs r3, r3, #15\n\t"
          "adcs r3, r3, r2\n\t"
          "stmia r0!, {r3}\n\t"
          "cmp r0, ip\n\t"
          "bne 1b\n"
          "2:\n\t"
          "pop {r4-r7, pc}");
}

static inline void scale(int32_t *w, int up, int32_t factor, int count)
{
    register int32_t *to __asm("r0") = w;
    register int shift __asm("r1") = up;
    register int32_t by __asm("r2") = factor;
    register const int32_t *end __asm("ip") = w + count;
    __asm volatile("bl %c4"
                   : "+r"(to), "+r"(shift), "+r"(by)
                   : "r"(end), "i"(kq_scale)
                   : "r3", "lr", "cc", "memory");
}

/* One result of a rotation, into r6: FIRST by the word in L (low half) and H (high), SIGN the second by that
   in M and N.  r8, r9, lr: c's halves and twice the high one; r10, r11, ip: t's.  |mixed| may be up to
   2.2 2^30: the last of its sums may overflow, and is mended out of line.  All before it is below
   1.9 2^30. */
#define KQ_TURN(L, H, M, N, SIGN, LABEL)                                                           \
    "mov r6, r8\n\t"                                                                               \
    "muls r6, " L ", r6\n\t"                                                                       \
    "mov r7, r10\n\t"                                                                              \
    "muls r7, " M ", r7\n\t" SIGN " r6, r6, r7\n\t"                                                \
    "asrs r6, r6, #16\n\t"                                                                         \
    "mov r7, r8\n\t"                                                                               \
    "muls r7, " H ", r7\n\t"                                                                       \
    "adds r6, r6, r7\n\t"                                                                          \
    "mov r7, r10\n\t"                                                                              \
    "muls r7, " N ", r7\n\t" SIGN " r6, r6, r7\n\t"                                                \
    "mov r7, r9\n\t"                                                                               \
    "muls r7, " L ", r7\n\t"                                                                       \
    "adds r6, r6, r7\n\t"                                                                          \
    "mov r7, r11\n\t"                                                                              \
    "muls r7, " M ", r7\n\t" SIGN " r6, r6, r7\n\t"                                                \
    "bvs " LABEL "f\n\t"                                                                           \
    "asrs r6, r6, #15\n" LABEL "0:\n\t"                                                            \
    "mov r7, lr\n\t"                                                                               \
    "muls r7, " H ", r7\n\t"                                                                       \
    "adcs r6, r6, r7\n\t"                                                                          \
    "mov r7, ip\n\t"                                                                               \
    "muls r7, " N ", r7\n\t" SIGN " r6, r6, r7\n\t"

/* Bit 32 of the sum that overflowed is the opposite of bit 31, and weighs 2^17. */
#define KQ_MEND(LABEL)                                                                             \
    LABEL ":\n\t"                                                                                  \
    "movs r7, #1\n\t"                                                                              \
    "lsls r7, r7, #17\n\t"                                                                         \
    "cmp r6, #0\n\t"                                                                               \
    "blt " LABEL "1f\n\t"                                                                          \
    "rsbs r7, r7, #0\n" LABEL "1:\n\t"                                                             \
    "asrs r6, r6, #15\n\t"                                                                         \
    "adcs r6, r6, r7\n\t"                                                                          \
    "adds r6, r6, #0\n\t" /* no carry */                                                           \
    "b " LABEL "0b\n"

/* r0.. <- r2 r0.. - r3 r1..,  r1.. <- r2 r1.. + r3 r0.., 2^-31, up to r0 = ip.  c's low half is in
   (-2^15, 2^15], the others' in [-2^15, 2^15): so two products of low halves fit one word. */
KQ_ASSEMBLY kq_rotate(void)
{
    __asm(".syntax unified\n\t"
          "push {r4-r7, lr}\n\t"
          "mov r4, r8\n\t"
          "mov r5, r9\n\t"
          "mov r6, r10\n\t"
          "mov r7, r11\n\t"
          "push {r4-r7}\n\t"
          "mov r4, ip\n\t"
          "push {r4}\n\t" /* where it ends */
          "movs r6, #0\n\t"
          "subs r4, r2, #1\n\t"
          "asrs r4, r4, #16\n\t"
          "adcs r4, r4, r6\n\t"
          "mov r9, r4\n\t"
          "lsls r5, r4, #1\n\t"
          "mov lr, r5\n\t"
          "lsls r4, r4, #16\n\t"
          "subs r4, r2, r4\n\t"
          "mov r8, r4\n\t"
          "sxth r5, r3\n\t"
          "mov r10, r5\n\t"
          "asrs r5, r3, #16\n\t"
          "adcs r5, r5, r6\n\t"
          "mov r11, r5\n\t"
          "lsls r5, r5, #1\n\t"
          "mov ip, r5\n"
          "1:\n\t"
          "ldr r3, [r0]\n\t"
          "sxth r2, r3\n\t"
          "subs r3, r3, r2\n\t"
          "asrs r3, r3, #16\n\t"
          "ldr r5, [r1]\n\t"
          "sxth r4, r5\n\t"
          "subs r5, r5, r4\n\t"
          "asrs r5, r5, #16\n\t"
          KQ_TURN("r2", "r3", "r4", "r5", "subs", "3") "stmia r0!, {r6}\n\t"
          KQ_TURN("r4", "r5", "r2", "r3", "adds", "4") "stmia r1!, {r6}\n\t"
          "ldr r6, [sp]\n\t"
          "cmp r0, r6\n\t"
          "bne 1b\n\t"
          "add sp, #4\n\t"
          "pop {r4-r7}\n\t"
          "mov r8, r4\n\t"
          "mov r9, r5\n\t"
          "mov r10, r6\n\t"
          "mov r11, r7\n\t"
          "pop {r4-r7, pc}\n"
          KQ_MEND("3") KQ_MEND("4"));
}

static inline void rotate_words(int32_t *restrict s, int32_t *restrict b, int32_t c, int32_t t, int last)
{
    register int32_t *x __asm("r0") = s;
    register int32_t *y __asm("r1") = b;
    register int32_t cosine __asm("r2") = c;
    register int32_t sine __asm("r3") = t;
    register const int32_t *end __asm("ip") = s + last + 1;
    b[last] = 0;
    __asm volatile("bl %c5"
                   : "+r"(x), "+r"(y), "+r"(cosine), "+r"(sine), "+r"(end)
                   : "i"(kq_rotate)
                   : "lr", "cc", "memory");
}

#endif
