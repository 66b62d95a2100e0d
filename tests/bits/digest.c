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

static const uint32_t EMPTY = UINT32_C(2166136261);
static const char *name; /* of the case */
static uint32_t digest;  /* FNV-1a, word by word, since the last check */
static int cases, checked, differences, differences_before, bad;

void put_word(uint32_t word)
{
    digest = (digest ^ word) * UINT32_C(16777619);
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

void put_status(kq_status status) { put_word((uint32_t)(int32_t)status); }

/* What becomes of a digest: compared, or written */
static void report(const char *quantity, int step, uint32_t want)
{
#if defined(KQ_BITS_WRITE)
    (void)want;
    printf("0x%08lx, /* %s, %s, %d */\n", (unsigned long)digest, name, quantity, step);
#elif defined(KQ_BITS_WORDS)
    (void)want;
    printf("%s, %s, %d\n", name, quantity, step);
#else
    if (digest == want) return;
    differences++;
    if (FALSIFIED) return;
    printf("%s: %s at step %d: %08lx expected, not %08lx\n", name, quantity, step,
           (unsigned long)want, (unsigned long)digest);
#endif
}

void check(const char *quantity, int step)
{
    report(quantity, step, checked < EXPECTATIONS ? expected[checked] : 0);
    checked++;
    digest = EMPTY;
}

void digest_begin(const char *of)
{
    name = of;
    digest = EMPTY;
    differences_before = differences;
    cases++;
}

void digest_end(void)
{
    if ((differences != differences_before) == FALSIFIED) return;
    bad = 1;
    if (FALSIFIED) printf("%s: a wrong model is not found\n", name);
}

int digest_report(int is_all)
{
    (void)is_all;
#if !defined(KQ_BITS_WRITE) && !defined(KQ_BITS_WORDS)
    bad |= is_all ? checked != EXPECTATIONS : checked == 0;
    printf("%d cases, %d of %d digests compared, %d differ\n%s\n", cases, checked,
           (int)EXPECTATIONS, differences, bad ? "FAIL" : "OK");
#endif
    return bad;
}

num digest_falsify(num value)
{
    return FALSIFIED ? value + value * (sizeof(num) == 4 ? (num)0x1p-22 : (num)0x1p-50) : value;
}
