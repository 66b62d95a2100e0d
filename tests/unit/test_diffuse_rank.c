/*
 * The unknown start of models in integers, with measurements missing at random: at every step what
 * it says to be determined is what exact arithmetic says, and once it is ready its state and what
 * is smoothed are those of the library in double.
 */
#define MAX KQ_SIZE_MAX

#include "exact_rank.h"
#include "models.h"

enum { PATTERN_STATES = KQ_SIZE_MAX, PATTERNS = 30 };

static process_model process;
static sensor_model sensor;
static prior_model prior;
static num range[MAX];
S_FILTER(filter, MAX);
S_DIFFUSE(start, MAX, 0);

/* x' = A x + w, h x + v */
static void put_model(int n, const double *a, const double *h)
{
    static num A[MAX * MAX], Q[MAX * MAX], H[MAX];
    static const num R[] = {1};
    for (int k = 0; k < n * n; k++) A[k] = N(a[k]), Q[k] = k % (n + 1) ? 0 : N(0.0625);
    for (int k = 0; k < n; k++) H[k] = N(h[k]), range[k] = N(1e4);
    put_process(&process, n, 0, range, NULL, A, NULL, Q);
    put_sensor(&sensor, n, 1, range, range, H, R);
}

static void begin(int n)
{
    static const num x0[MAX], P0[MAX * MAX];
    put_prior(&prior, n, range, x0, P0);
    ASSERT_OK(S(filter_assign)(&filter, n, filter_memory, COUNT(filter_memory)));
    ASSERT_OK(S(diffuse_assign)(&start, n, 0, start_memory, COUNT(start_memory)));
    ASSERT_OK(init_start(&start, &filter, &prior, UINT32_MAX));
}

static void take(double z)
{
    const num seen = N(z);
    ASSERT_OK(S(update)(&filter, &sensor.sensor, measured(&sensor.sensor, &seen)));
}

static void advance(void) { ASSERT_OK(S(predict)(&filter, &process.process, NULL)); }

/* In integers, and as the library gets it: the same, or a similar one of which the first `same`
   components are */
typedef struct {
    int n, same, is_regular, grows;
    int a[PATTERN_STATES * PATTERN_STATES], h[PATTERN_STATES];
    double A[PATTERN_STATES * PATTERN_STATES], H[PATTERN_STATES];
} pattern_model;

static pattern_model model;

static uint32_t pattern_seed = 1;

/* 0 .. count-1 */
static int drawn(int count)
{
    pattern_seed = pattern_seed * UINT32_C(1664525) + UINT32_C(1013904223);
    return (int)((pattern_seed >> 8) % (uint32_t)count);
}

static void clear_model(int n)
{
    static const pattern_model none;
    model = none;
    model.n = model.same = n;
    model.is_regular = 1;
}

static void copy_model(void)
{
    for (int k = 0; k < model.n * model.n; k++) model.A[k] = model.a[k];
    for (int k = 0; k < model.n; k++) model.H[k] = model.h[k];
}

/* A level, with a slope where `trend`, and a season of `period` steps of sum 0 */
static void put_season(int trend, int period)
{
    const int first = trend ? 2 : 1, n = first + period - 1;
    clear_model(n);
    for (int i = 0; i < first; i++) model.a[i * n + i] = 1;
    if (trend) model.a[1] = 1;
    for (int k = first; k < n; k++) model.a[first * n + k] = -1;
    for (int k = first + 1; k < n; k++) model.a[k * n + k - 1] = 1;
    model.h[0] = model.h[first] = 1;
    copy_model();
}

/* The same model with its season in harmonics: the season's own components are others. */
static void put_harmonics(int trend, int period)
{
    put_season(trend, period);
    const int n = model.n;
    int k = model.same = trend ? 2 : 1;
    for (int i = 0; i < n * n; i++) model.A[i] = 0;
    for (int i = 0; i < n; i++) model.H[i] = 0;
    for (int i = 0; i < k; i++) model.A[i * n + i] = 1;
    if (trend) model.A[1] = 1;
    model.H[0] = 1;
    for (int j = 1; k < n; j++, k += 2) {
        const double angle = 2 * acos(-1.0) * j / period;
        model.H[k] = 1;
        model.A[k * n + k] = cos(angle);
        if (k + 1 == n) return; /* the one that changes its sign every step */
        model.A[k * n + k + 1] = sin(angle);
        model.A[(k + 1) * n + k] = -sin(angle);
        model.A[(k + 1) * n + k + 1] = cos(angle);
    }
}

/* A chain of sums, seen at its end */
static void put_chain(int n)
{
    clear_model(n);
    for (int i = 0; i < n; i++) model.a[i * n + i] = model.a[i * n + i + (i + 1 < n)] = 1;
    model.h[0] = 1;
    copy_model();
}

static int is_regular(void)
{
    static const row_space none;
    row_space rows = none;
    for (int i = 0; i < model.n; i++) {
        uint32_t row[RANK_MAX];
        for (int k = 0; k < model.n; k++) row[k] = residue(model.a[i * model.n + k]);
        (void)row_space_add(&rows, row, model.n);
    }
    return rows.rank == model.n;
}

/* Entries of -1, 0, 1, `share` of 8 of them not 0, nothing that physics has: the modes of A grow and
   shrink, in each step. */
static void put_random(int n, int share, int regular)
{
    do {
        clear_model(n);
        for (int k = 0; k < n * n; k++) model.a[k] = drawn(8) < share ? 2 * drawn(2) - 1 : 0;
        for (int k = 0; k < n; k++) model.h[k] = drawn(3) - 1;
        model.is_regular = is_regular();
        model.grows = 1;
    } while (model.is_regular != regular);
    copy_model();
}

/* A random order of the states, with signs, and one more term in each row: of determinant +-1 */
static void put_shuffle(int n)
{
    int to[PATTERN_STATES];
    clear_model(n);
    for (int i = 0; i < n; i++) to[i] = i;
    for (int i = n - 1; i > 0; i--) {
        const int j = drawn(i + 1), old = to[i];
        to[i] = to[j];
        to[j] = old;
    }
    for (int i = 0; i < n; i++) model.a[i * n + to[i]] = 2 * drawn(2) - 1;
    for (int k = 0; k < n; k++) model.h[k] = drawn(8) < 3;
    model.h[drawn(n)] = 1;
    copy_model();
}

/* ------------------------------------------------------------------ one run */

static exact_start exact;

enum { RIGHT, EARLY, EARLY_STATE, LATE, OUTCOMES };

/* Against exact arithmetic: a component, or the count, too early; either too late */
static int compare_rank(void)
{
    const int count = exact_count(&exact), is = S(diffuse_count)(&start);
    if (is < count) return EARLY;
    if (is > count && (model.is_regular || count == 0)) return LATE;
    for (int i = 0; count > 0 && i < model.same; i++) {
        const int known = exact_is_determined(&exact, i), says = !is_nothing(S(mean)(&filter, i));
        if (known != says) return says ? EARLY_STATE : LATE;
    }
    return RIGHT;
}

static int outcomes[OUTCOMES];

/* `missing` of 100 steps, until all is determined */
static void run_pattern(int missing)
{
    const int steps = model.grows ? 4 * model.n : 150;
    int outcome = RIGHT;
    put_model(model.n, model.A, model.H);
    begin(model.n);
    exact_begin(&exact, model.n);
    for (int t = 0; t < steps && outcome == RIGHT; t++) {
        if (drawn(100) >= missing) {
            take(drawn(64) - 32);
            exact_update(&exact, model.h);
        }
        outcome = compare_rank();
        if (exact_count(&exact) == 0) break;
        advance();
        exact_predict(&exact, model.a);
    }
    outcomes[outcome]++;
}

/* `count` patterns of one model at 10 to 80 % missing */
static void run_patterns(int count)
{
    static const int missing[] = {10, 30, 50, 80};
    for (int k = 0; k < OUTCOMES; k++) outcomes[k] = 0;
    for (int k = 0; k < 4 * count; k++) run_pattern(missing[k % 4]);
}

static void assert_all_right(void)
{
    TEST_ASSERT_EQUAL_INT(0, outcomes[EARLY]);
    TEST_ASSERT_EQUAL_INT(0, outcomes[EARLY_STATE]);
    TEST_ASSERT_EQUAL_INT(0, outcomes[LATE]);
}

/* ------------------------------------------------------------------ tests */

TEST(seasons)
{
    static const int period[] = {12, 7, 4, 15};
    for (int k = 0; k < COUNT(period); k++) {
        for (int trend = 0; trend < 2; trend++) {
            if (trend + period[k] > PATTERN_STATES - 1) continue;
            put_season(trend, period[k]);
            run_patterns(PATTERNS);
            assert_all_right();
        }
    }
}

TEST(seasons_in_harmonics)
{
    for (int trend = 0; trend < 2; trend++) {
        put_harmonics(trend, 12);
        run_patterns(PATTERNS);
        assert_all_right();
        put_harmonics(trend, 7);
        run_patterns(PATTERNS);
        assert_all_right();
    }
}

TEST(chains_and_permutations)
{
    for (int n = 1; n <= 4; n++) {
        put_chain(n);
        run_patterns(PATTERNS);
        assert_all_right();
    }
    for (int k = 0; k < PATTERNS; k++) {
        put_shuffle(2 + k % (PATTERN_STATES - 1));
        run_patterns(1);
        assert_all_right();
    }
}

/* Dense, of determinants that are not 0: what grows soon hides what does not. */
TEST(dense_models)
{
    for (int k = 0; k < PATTERNS; k++) {
        put_random(3, 8, 1);
        run_patterns(1);
        assert_all_right();
        put_random(2 + k % (PATTERN_STATES - 1), 3, 1);
        run_patterns(1);
        TEST_ASSERT_EQUAL_INT(0, outcomes[EARLY]);
    }
}

/* What has decayed below the rounding of the rest is waited for no longer. */
TEST(what_has_decayed)
{
    static const double A[] = {0.505, 0.495, 0.495, 0.505}, h[] = {1, 0.5};
    put_model(2, A, h);
    begin(2);
    for (int t = 0; t < 12; t++) advance();
    take(1);
    advance();
    take(2);
    TEST_ASSERT_EQUAL_INT(0, S(diffuse_count)(&start));
}

/* What others have grown away from is below their rounding, and unknown still. */
TEST(what_others_have_grown_away_from)
{
    static const double A[] = {16, 0, 1, 0.5}, h[] = {1, 0};
    put_model(2, A, h);
    for (int steps = 1; steps < 15; steps++) {
        begin(2);
        for (int t = 0; t < steps; t++) advance();
        take(1);
        TEST_ASSERT_EQUAL_INT(1, S(diffuse_count)(&start));
        TEST_ASSERT_TRUE(is_nothing(S(mean)(&filter, 1)) && !is_nothing(S(mean)(&filter, 0)));
        ASSERT_OK(S(filter_check)(&filter));
    }
}

/* Only the difference of two states is ever seen, and it doubles at each step: neither state becomes known by rounding. */
TEST(what_is_never_seen)
{
    static const double A[] = {1, 0, -1, 2}, h[] = {1, -1};
    put_model(2, A, h);
    begin(2);
    for (int t = 0; t < 300; t++) {
        if (t) advance();
        take(0);
        TEST_ASSERT_EQUAL_INT(1, S(diffuse_count)(&start));
        TEST_ASSERT_TRUE(is_nothing(S(mean)(&filter, 0)) && is_nothing(S(mean)(&filter, 1)));
    }
}

SUITE(diffuse_rank, NULL)
#include "diffuse_rank.tests"
