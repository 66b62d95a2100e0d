/*
 * One bit turned in an object or its memory, each bit in turn: turned [seeds [stride]], of the objects beside process, sensor and filter
 * each stride-th one.  After 40 steps, between two calls, a bit is turned, and the three checks are called.  What they do not find runs
 * on for 50 steps beside a run without it.  Of each part:
 *   found        by a check
 *   answered     by the status of a call, or by an event
 *   harmless     what is shown is within 0.1 sigma and its sigma within 1 %, at each step
 *   healed       not at each step, but after 50
 *   likelihood   the same, but the log-likelihood of the run is off by more than 0.1
 *   off          after 50 steps; of what shows the past, at any step of it
 *   misleads     by more than 3 sigma, or a sigma by more than a factor 2, and nothing says so
 *   crashes      or hangs
 * Compiled for an arithmetic by -DKQ_TURNED_F32, _F64 or _Q31, under the sanitizers, for the host alone.
 */
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "turned_objects.h"

const char *__asan_default_options(void); /* what is wrong is counted, not told */
const char *__asan_default_options(void) { return "symbolize=0:print_legend=0"; }

static int check(void)
{
    return T(kq_process_check)(&now.process) < 0 || T(kq_sensor_check)(&now.sensor) < 0 ||
           T(kq_filter_check)(&now.filter) < 0;
}

/* ------------------------------------------------------------------ the parts */

typedef struct {
    char name[40];
    size_t at, size;       /* in the world */
    int misleads, crashes; /* at most so many of a hundred bits; 0 of what is checked */
} part;

enum { PARTS = 10, ALL_PARTS = PARTS + 3 * SCENES };

static size_t place(const void *p) { return (size_t)((const char *)p - (const char *)&now); }

static int parts_of_filter(part *out, const model *p)
{
    const size_t n = (size_t)p->n, m = (size_t)p->m, word = sizeof(num);
    const size_t root = n * (n + 1) / 2 * word, all = (size_t)LENGTH(FILTER)(p->n) * word;
    const int is_correlated = p->R[1] != 0 && m > 1;
    const size_t noises = is_correlated ? (size_t)KQ_TRIANGLE(m) : m;
#if defined(KQ_TURNED_Q31)
    const size_t exponents = n * word;
#else
    const size_t exponents = 0;
#endif
    const size_t mean_size = all - root - exponents, likelihood_at = offsetof(T(kq_filter), last);
    const part list[PARTS] = {
        {"process", place(&now.process), sizeof now.process, 0, 0},
        {"process, G", place(now.G), root + exponents, 0, 0},
        {"process, A", place(now.A), n * n * sizeof *now.A, 0, 0},
        {"sensor", place(&now.sensor), sizeof now.sensor, 0, 0},
        {"sensor, noise", place(now.noise), noises * sizeof *now.noise, 0, 0},
        {"sensor, H", place(now.H), m * n * sizeof *now.H, 0, 0},
        {"filter", place(&now.filter), likelihood_at, 0, 0},
        {"filter, likelihood", place(&now.filter) + likelihood_at, sizeof now.filter - likelihood_at, 0, 0},
        {"filter, mean", place(now.filter_memory), mean_size, 5, 0},
        {"filter, root", place(now.filter_memory) + mean_size, root + exponents, 5, 0},
    };
    memcpy(out, list, sizeof list);
    return PARTS;
}

static int parts_of_scene(part *out, const scene *s)
{
    const struct { const char *of; size_t at, size; } list[] = {
        {"", place(&now.other), s->size}, {", memory", place(now.memory), s->words * sizeof(num)},
        {", numbers", place(now.numbers), s->numbers * sizeof(coefficient)}};
    int count = 0;
    for (int k = 0; k < 3; k++) {
        if (!list[k].size) continue;
        part *to = &out[count++];
        *to = (part){"", list[k].at, list[k].size, s->most[k > 0][0], s->most[k > 0][1]};
        snprintf(to->name, sizeof to->name, "%s%s", s->name, list[k].of);
    }
    return count;
}

/* ------------------------------------------------------------------ a bit and what comes of it */

enum { FOUND, ANSWERED, HARMLESS, HEALED, LIKELIHOOD, WRONG, MISLEADS, CRASHES, CLASSES };
static const char *const class_name[] = {"found", "answered", "harmless", "healed", "likelihood", "off", "misleads", "crashes"};

static double twin_likelihood;
static unsigned twin_seen;

/* Answers whether a call has answered an error, or an event is new. */
static int go_on(const scene *s, const model *p, int *ever)
{
    *ever = NEAR;
    for (int t = BEFORE; t < BEFORE + STEPS; t++) {
        how_far = NEAR;
        if (s->step(p, t) || (T(kq_events)(&now.filter) & ~twin_seen)) return 1;
        if (how_far > *ever) *ever = how_far;
    }
    if (s->end) how_far = NEAR;
    return (s->end && s->end(p)) || (seen & ~twin_seen) != 0;
}

static int class_of(const scene *s, const model *p)
{
    int ever;
    shown = 0, seen = 0;
    if (check()) return FOUND;
    if (go_on(s, p, &ever)) return ANSWERED;
    if (how_far) return how_far == FAR ? MISLEADS : WRONG;
    return ever ? HEALED : fabs(likelihood() - twin_likelihood) <= 0.1 ? HARMLESS : LIKELIHOOD;
}

/* A child takes each `stride`-th bit until one crashes it; the classes are in memory that both see. */
static void turn_all(const scene *s, const model *p, const part *of, size_t stride, unsigned char *classes)
{
    const size_t bits = 8 * of->size;
    const struct itimerval second = {{0, 0}, {1, 0}}; /* of its own time: it hangs */
    memset(classes, CLASSES, bits);
    for (size_t next = 0; next < bits; next += stride) {
        fflush(stdout);
        const pid_t child = fork();
        if (child < 0) need(KQ_ERR_SIZE, "fork");
        if (child == 0) {
            if (!freopen("/dev/null", "w", stderr) || mprotect(held, sizeof *held, PROT_READ)) _exit(1);
            for (size_t k = next; k < bits; k += stride) {
                memcpy(&now, &held->kept, sizeof now);
                ((unsigned char *)&now)[of->at + k / 8] ^= (unsigned char)(1u << k % 8);
                setitimer(ITIMER_VIRTUAL, &second, NULL);
                classes[k] = (unsigned char)class_of(s, p);
            }
            _exit(0);
        }
        if (waitpid(child, NULL, 0) != child) need(KQ_ERR_SIZE, "waitpid");
        while (next < bits && classes[next] != CLASSES) next += stride;
        if (next < bits) classes[next] = CRASHES;
    }
}

/* ------------------------------------------------------------------ the table */

static part rows[ALL_PARTS];
static long tally[ALL_PARTS][CLASSES];
static int row_count;

static void run_undisturbed(const scene *s, const model *p)
{
    int ever;
    make(p);
    for (int t = 0; t < BEFORE + STEPS; t++) {
        held->u[t][0] = driven(t);
        for (int c = 0; c < p->m; c++) held->z[t][c] = measured(t, c);
    }
    for (int t = 0; t < BEFORE; t++) {
        if (t == s->at) s->begin(p);
        shown = 0;
        need((t < s->at ? step_filter : s->step)(p, t) ? KQ_ERR_RANGE : KQ_OK, "a step");
    }
    if (s->at == BEFORE && s->begin) s->begin(p);
    need(check() ? KQ_ERR_TABLE : KQ_OK, "a check of what is right"); /* and it keeps its seals */
    memcpy(&held->kept, &now, sizeof now);
    twin_seen = UINT32_MAX, seen = 0, shown = 0;
    need(go_on(s, p, &ever) ? KQ_ERR_RANGE : KQ_OK, s->name);
    twin_seen = T(kq_events)(&now.filter) | seen;
    twin_likelihood = likelihood();
}

/* The parts of a scene are the rows from `at` on. */
static int run(const scene *s, const model *p, uint64_t seed, size_t stride, int at, unsigned char *classes)
{
    measure(p, seed);
    is_twin = 1;
    run_undisturbed(s, p);
    is_twin = 0;
    const int count = s->begin ? parts_of_scene(rows + at, s) : parts_of_filter(rows + at, p);
    for (int k = at; k < at + count; k++) {
        turn_all(s, p, &rows[k], stride, classes);
        for (size_t bit = 0; bit < 8 * rows[k].size; bit += stride) tally[k][classes[bit]]++;
    }
    return count;
}

/* Answers whether all that is checked is found where it does harm, and the others mislead as rarely as they did. */
static int report(void)
{
    int good = 1;
    printf("| of 100 bits of | bits |");
    for (int c = 0; c < CLASSES; c++) printf(" %s |", class_name[c]);
    printf("\n|---|%s\n", "---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for (int k = 0; k < row_count; k++) {
        long all = 0;
        for (int c = 0; c < CLASSES; c++) all += tally[k][c];
        printf("| %s | %ld |", rows[k].name, all);
        for (int c = 0; c < CLASSES; c++) printf(" %.1f |", 100 * (double)tally[k][c] / (double)all);
        printf("\n");
        const long wrong = tally[k][MISLEADS] + (rows[k].misleads ? 0 : tally[k][WRONG]);
        if (100 * wrong <= rows[k].misleads * all && 100 * tally[k][CRASHES] <= rows[k].crashes * all) continue;
        printf("FAILED  %s\n", rows[k].name);
        good = 0;
    }
    return good;
}

static void *shared(size_t size)
{
    void *at = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (at == MAP_FAILED) need(KQ_ERR_MEMORY, "mmap");
    return at;
}

int main(int count, char **arguments)
{
    const int seeds = count > 1 ? atoi(arguments[1]) : 1;
    const size_t stride = count > 2 ? (size_t)atoi(arguments[2]) : 1;
    unsigned char *classes = shared(8 * sizeof(world));
    held = shared(sizeof *held);
    for (int k = 0; k < MODELS; k++) {
        for (int seed = 1; seed <= seeds; seed++) row_count = run(&alone, &models[k], (uint64_t)seed, 1, 0, classes);
    }
    for (int k = 0; k < SCENES; k++) {
        int made = 0;
        for (int seed = 1; seed <= seeds; seed++) made = run(&scenes[k], &models[0], (uint64_t)seed, stride, row_count, classes);
        row_count += made;
    }
    return report() ? 0 : 1;
}
