/*
 * The sums of a filter and of least squares after 100 years of 10 Hz, 3.2e10 measurements, against sums in double.  Not one by
 * one: so many measurements are added one by one (2^25), then blocks of 2^15, each as 32 additions of what 1024 measurements come
 * to, through the same functions, with the same carries.  -DKQ_SUMS_f32, _f64 or _q31
 */
#include <math.h>
#include <stdio.h>

#if defined(KQ_SUMS_f32)
#include "kq_statistics_f32.c"
#define NAME "f32"
static num number(double a) { return (num)a; }
static score in_score(double a) { return (score)a; }
static double of_score(score a) { return (double)a; }
#elif defined(KQ_SUMS_f64)
#include "kq_statistics_f64.c"
#define NAME "f64"
static num number(double a) { return a; }
static score in_score(double a) { return a; }
static double of_score(score a) { return a; }
#else
#include "kq_statistics_q31.c"
#define NAME "q31"
static scaled number(double a)
{
    int exponent;
    const double share = frexp(a, &exponent);
    return (scaled){(int32_t)(share * 0x1p31), exponent - 31};
}
static score in_score(double a) { return (score)(a * 0x1p24); }
static double of_score(score a) { return (double)a * 0x1p-24; }
#endif

enum { FOLD = 1 << 15, AT_ONCE = 1024 };

typedef struct {
    likelihood_run run;
    compensated residual;
    double nis, logarithms, count; /* what is right: of all NIS, log s and measurements */
} sums;

/* `times` measurements of innovation variance s and that NIS together */
static void add(sums *all, double nis, double s, int32_t times)
{
    likelihood last;
    likelihood_clear(&last);
    likelihood_add(&last, number(nis), number(s));
    last.count = times;
    likelihood_run_add(&all->run, &last);
    compensated_add(&all->residual, in_score(nis));
    all->nis += nis;
    all->logarithms += log(s) + times * log(2 * 3.14159265358979323846);
    all->count += times;
}

static int check(const sums *all, double most)
{
    const double right = -(all->nis + all->logarithms) / 2, found = of_score(likelihood_run_log(&all->run));
    const double error = fabs(found / right - 1), residual = fabs(of_score(compensated_score(&all->residual)) / all->nis - 1);
    printf("%s %.3g measurements: log-likelihood %.6g, off by %.1e; residual off by %.1e\n", NAME, all->count, found, error, residual);
    return error <= most && residual <= most && likelihood_run_is_possible(&all->run);
}

int main(void)
{
    sums all = {.nis = 0};
    int good;
    likelihood_run_clear(&all.run);
    compensated_clear(&all.residual);
    for (int32_t k = 0; k < INT32_C(1) << 25; k++) add(&all, (double)((uint32_t)k * 7919U & 1023) / 512, 0.75, 1);
    good = check(&all, 1e-5);
    while (all.count < 3.2e10) add(&all, AT_ONCE * (1 + ((int)(all.count / FOLD) & 255) / 256.0), 0.75, AT_ONCE);
    return good && check(&all, 1e-5) ? 0 : 1;
}
