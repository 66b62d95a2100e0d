#include "digest.h"

#include <stdio.h>
#include <string.h>

enum { PARTS = sizeof(num) / sizeof(uint32_t) };

static const uint32_t expected[] = {
#ifdef KQ_BITS_WRITE
    0
#else
#include EXPECTED
#endif
};

enum { EXPECTATIONS = sizeof expected / sizeof expected[0] };

enum { MOST_CHECKS = 80, MOST_BLOCKS = 40 };

static const uint32_t EMPTY = UINT32_C(2166136261);
static const char *name; /* of the case */
static uint32_t digest;  /* FNV-1a, word by word, since the last check */
static const char *block_names[MOST_BLOCKS];
static struct {
    uint8_t block;
    int8_t step;
    uint32_t digest;
} checks[MOST_CHECKS]; /* of the case */
static int blocks, check_count;
static int cases, compared, differences, differences_before, bad;

static uint32_t add_word(uint32_t to, uint32_t word) { return (to ^ word) * UINT32_C(16777619); }

void put_word(uint32_t word)
{
    digest = add_word(digest, word);
#ifdef KQ_BITS_WORDS
    printf("%08lx\n", (unsigned long)word);
#endif
}

void put(num value)
{
    uint32_t parts[PARTS];
    memcpy(parts, &value, sizeof value);
    for (int k = 0; k < PARTS; k++) put_word(parts[k]);
}

void put_all(const num *values, int count)
{
    for (int k = 0; k < count; k++) put(values[k]);
}

void put_readings(const K(filter) * view, int n)
{
    for (int i = 0; i < n; i++) {
        put(K(mean)(view, i));
        put(K(mean_low)(view, i));
        put(K(sigma)(view, i));
    }
}

void put_covariance(const K(filter) * view, int n, num *P)
{
    put_status(K(covariance)(view, P));
    put_all(P, n * n);
}

void put_filter(const K(filter) * f, int n, num *P)
{
    put_readings(f, n);
    put_covariance(f, n, P);
    put_word(K(events)(f));
    put_word((uint32_t)K(taken)(f));
    put(K(nis)(f));
    put(K(log_likelihood)(f));
}

void put_status(kq_status status) { put_word((uint32_t)(int32_t)status); }

/* ------------------------------------------------------------------ blocks of a case */

static int block_of(const char *quantity)
{
    int block = 0;
    while (block < blocks && strcmp(block_names[block], quantity) != 0) block++;
    if (block == blocks && blocks < MOST_BLOCKS) block_names[blocks++] = quantity;
    return block;
}

void check(const char *quantity, int step)
{
#ifdef KQ_BITS_WORDS
    printf("%s, %s, %d: %08lx\n", name, quantity, step, (unsigned long)digest);
#endif
    const int block = block_of(quantity);
    if (check_count == MOST_CHECKS || block == MOST_BLOCKS) {
        printf("%s: too many digests\n", name);
        bad = 1;
        return;
    }
    checks[check_count].block = (uint8_t)block;
    checks[check_count].step = (int8_t)step;
    checks[check_count++].digest = digest;
    digest = EMPTY;
}

#if !defined(KQ_BITS_WRITE) && !defined(KQ_BITS_WORDS)
static void print_block(int block)
{
    for (int k = 0; k < check_count; k++) {
        if (checks[k].block == block) printf("  step %d: %08lx\n", checks[k].step, (unsigned long)checks[k].digest);
    }
}
#endif

/* A block's digest is compared, or written. */
static void report(int block, uint32_t found, uint32_t want)
{
#if defined(KQ_BITS_WRITE)
    (void)want;
    printf("0x%08lx, /* %s, %s */\n", (unsigned long)found, name, block_names[block]);
#elif defined(KQ_BITS_WORDS)
    (void)block;
    (void)found;
    (void)want;
#else
    if (found == want) return;
    differences++;
    if (FALSIFIED) return;
    printf("%s: %s: %08lx expected, not %08lx, which is of\n", name, block_names[block], (unsigned long)want,
           (unsigned long)found);
    print_block(block);
#endif
}

static void report_blocks(void)
{
    for (int block = 0; block < blocks; block++) {
        uint32_t found = EMPTY;
        for (int k = 0; k < check_count; k++) {
            if (checks[k].block == block) found = add_word(found, checks[k].digest);
        }
        report(block, found, compared < EXPECTATIONS ? expected[compared] : 0);
        compared++;
    }
}

void digest_begin(const char *of)
{
    name = of;
    digest = EMPTY;
    blocks = check_count = 0;
    differences_before = differences;
    cases++;
}

void digest_end(void)
{
    report_blocks();
    if ((differences != differences_before) == FALSIFIED) return;
    bad = 1;
    if (FALSIFIED) printf("%s: a wrong model is not found\n", name);
}

int digest_report(int is_all)
{
    (void)is_all;
#if !defined(KQ_BITS_WRITE) && !defined(KQ_BITS_WORDS)
    bad |= is_all ? compared != EXPECTATIONS : compared == 0;
    printf("%d cases, %d of %d digests compared, %d differ\n%s\n", cases, compared, (int)EXPECTATIONS, differences,
           bad ? "FAIL" : "OK");
#endif
    return bad;
}

num digest_falsify(num value)
{
    return FALSIFIED ? value + value * (sizeof(num) == 4 ? (num)0x1p-22 : (num)0x1p-50) : value;
}
