/*
 * The operations of kalmanq/port, a core's own or the portable ones, against the same said plainly, on
 * words that are drawn at their bounds: halves of 2^15 and next to it, rotations by an eighth of a turn.
 *   KQ_FALSIFY   one word is wrong: that must be found
 */
#include "arithmetic/fixed.h"

#include "kalmanq/port/vectors.h"

#include <stdio.h>

#ifdef KQ_FALSIFY
enum { FALSIFIED = 1 };
#else
enum { FALSIFIED = 0 };
#endif

enum { LENGTH = 5, TRIANGLE = 15, ROUNDS = 500 };

static int differences;

static void check(const char *name, int64_t found, int64_t expected)
{
    if (found == expected) return;
    if (differences++ < 10) printf("%s is wrong\n", name);
}

static uint32_t draw(void)
{
    static uint32_t seed = 1;
    seed = seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return seed >> 16;
}

/* |word| < 2^bits; the low half is often extreme */
static int32_t draw_word(int bits)
{
    static const uint16_t extreme[] = {0x8000, 0x7fff, 0x8001, 0xffff, 0, 1};
    const uint32_t high = draw() & ((UINT32_C(1) << (bits - 16)) - 1);
    const uint32_t low = draw() & 1 ? extreme[draw() % 6] : draw();
    const int32_t word = (int32_t)(high << 16 | low);
    return draw() & 1 ? -word : word;
}

static uint32_t root_of(uint64_t square)
{
    uint32_t root = 0;
    for (uint32_t bit = UINT32_C(1) << 31; bit; bit >>= 1) {
        const uint32_t longer = root | bit;
        if ((uint64_t)longer * longer <= square) root = longer;
    }
    return root;
}

/* b for a, such that (a, b) is nearly `bits` long, and not more */
static int32_t draw_other(int32_t a, int bits)
{
    const uint32_t most = root_of((UINT64_C(1) << (2 * bits)) - (uint64_t)((int64_t)a * a));
    uint32_t b = (most & ~UINT32_C(0xffff)) | ((uint32_t)draw_word(31) & 0xffff);
    if (b > most) b = b < 0x10000 ? most : b - 0x10000;
    if (b > INT32_MAX) b = INT32_MAX;
    return draw() & 1 ? -(int32_t)b : (int32_t)b;
}

/* About a third: an eighth of a turn */
static int32_t draw_first(int bits)
{
    if (draw() % 3) return draw_word(bits);
    const int32_t diagonal = (int32_t)(UINT32_C(0x5a82799a) >> (31 - bits)) & ~INT32_C(0xffff);
    const int32_t word = diagonal + (draw_word(31) & 0xffff);
    return draw() & 1 ? -word : word;
}

/* floor(a 2^-shift + 1/2) */
static int64_t plainly(int64_t a, int shift)
{
    return ((a >> (shift - 1)) + 1) >> 1;
}

static void check_words(void)
{
    const int32_t a = draw_word(31), b = draw_word(31);
    const uint32_t u = (uint32_t)a << 1 | 1, v = (uint32_t)b << 1;
    const int64_t p = (int64_t)a * b;
    check("product", product(a, b), p + FALSIFIED);
    check("product_unsigned", (int64_t)product_unsigned(u, v), (int64_t)((uint64_t)u * v));
    check("product_high", product_high(u, v), (int64_t)((uint64_t)u * v >> 32));
    check("quotient", quotient(0x8000 | u >> 17), UINT32_MAX / (0x8000 | u >> 17));
    check("shift_rounded_wide 30", shift_rounded_wide(p >> 2, 30), plainly(p >> 2, 30));
    check("shift_rounded_wide 31", shift_rounded_wide(p, 31), (int32_t)plainly(p, 31));
    const int32_t c = draw_word(30), d = draw_word(30);
    check("narrow_product", round_product_to_word(a, b, 31, 31), (int32_t)plainly(p, 31));
    check("narrow_products", round_products_to_word(c, d, d, a, 31, 31),
          (int32_t)plainly((int64_t)c * d + (int64_t)d * a, 31));
    for (int shift = 1; shift < 32; shift++) {
        check("shift_rounded", shift_rounded(a, shift), plainly(a, shift));
        check("shift_rounded_long", shift_rounded_long(p, shift), plainly(p, shift));
    }
    check("shift_rounded_long of ones", shift_rounded_long(-1 - (p & 1), 1), -(p & 1));
}

static void check_sums(int count)
{
    int32_t a[TRIANGLE], b[LENGTH];
    const int64_t begin = (int64_t)draw_word(30) * draw_word(30);
    int64_t products = begin, square = begin, row = 0;
    for (int k = 0; k < TRIANGLE; k++) a[k] = draw_word(30);
    for (int k = 0; k < LENGTH; k++) b[k] = draw_word(30);
    for (int k = 0; k < count; k++) {
        products += (int64_t)a[k] * b[k];
        square += (int64_t)a[k] * a[k];
    }
    check("dot", dot(begin, a, b, count), products);
    check("squares", squares(begin, a, count), square);
    const int i = LENGTH - count, diagonal = i * (i + 1) / 2 + i;
    for (int j = i, at = diagonal; j < LENGTH; at += ++j) row += (int64_t)a[at] * a[at];
    check("row_squares", row_squares(a + diagonal, i, LENGTH), row);
}

static void check_maps(int count)
{
    int32_t w[LENGTH], V[LENGTH], old[LENGTH];
    const int up = (int)(draw() % 3);
    const int32_t d = draw_word(31), factor = (int32_t)magnitude(draw_word(31));
    for (int k = 0; k < LENGTH; k++) {
        V[k] = draw() % 4 ? draw_word(30) : (INT32_C(1) << 30) + 2;
        w[k] = old[k] = draw_word(30) / 2;
        if (draw() & 1) V[k] = -V[k];
    }
    subtract_multiple(w, V, d / 2, count);
    for (int k = 0; k < LENGTH; k++) {
        check("subtract_multiple", w[k],
              k < count ? old[k] - plainly((int64_t)V[k] * (d / 2), 30) : old[k]);
        w[k] = old[k] = draw_word(31 - up);
    }
    scale(w, up, factor, count);
    for (int k = 0; k < LENGTH; k++) {
        check("scale", w[k],
              k < count ? plainly((int64_t)old[k] * (1 << up) * factor, 31) : old[k]);
    }
}

static void check_turn(int32_t c, int32_t t, int32_t *s, int32_t *b, int last)
{
    int32_t old[LENGTH], own[LENGTH];
    b[last] = 0;
    for (int k = 0; k < LENGTH; k++) {
        old[k] = s[k];
        own[k] = b[k];
    }
    rotate_words(s, b, c, t, last);
    for (int k = 0; k < LENGTH; k++) {
        const int64_t x = (int64_t)c * old[k] - (int64_t)t * own[k];
        const int64_t y = (int64_t)c * own[k] + (int64_t)t * old[k];
        check("rotate_words, s", s[k], k <= last ? plainly(x, 31) : old[k]);
        check("rotate_words, b", b[k], k <= last ? plainly(y, 31) : own[k]);
    }
}

static void check_rotation(int last)
{
    int32_t s[LENGTH], b[LENGTH];
    const int32_t c = (int32_t)magnitude(draw_first(31)), t = draw_other(c, 31);
    for (int k = 0; k < LENGTH; k++) {
        s[k] = draw_first(30);
        b[k] = draw_other(s[k], 30);
    }
    check_turn(c, t, s, b, last);
}

/* Choice k of six next to an eighth of a turn, at the bounds of both halves */
static int32_t eighth(int32_t high, int k)
{
    const int32_t word = (high << 16) + 0x7fff + k % 3;
    return k < 3 ? word : -word;
}

static void check_eighths(void)
{
    for (int i = 0; i < 6 * 6 * 6 * 3; i++) {
        int32_t s[LENGTH] = {0}, b[LENGTH] = {0};
        s[0] = eighth(0x2d40, i % 6);
        b[0] = eighth(0x2d40, i / 6 % 6);
        check_turn(eighth(0x5a81, i / 216), eighth(0x5a81, i / 36 % 6), s, b, 1);
    }
}

int main(void)
{
    for (int round = 0; round < ROUNDS; round++) {
        const int count = round % LENGTH + 1;
        check_words();
        check_sums(round % (LENGTH + 1));
        check_maps(round % (LENGTH + 1));
        check_rotation(count - 1);
    }
    check_eighths();
    printf("%d differences\n", differences);
    if (differences) return 1;
    puts("OK");
    return 0;
}
