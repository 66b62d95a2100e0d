/*
 * The unknown start's calls in every order: after each call every reading is what a line of
 * distinct numbers says, or nothing where nothing has been measured or smoothed.
 *
 * x is a level and its slope.  Measurements are on the line 3 + 2 t, so that every mean is known.
 * The start's and the tape's memory begin as what nobody wrote: under a sanitizer that knows, it is
 * left so; otherwise it is filled with words that are no such mean.
 *
 * Before this: S(name) is kq_name_<T>; word, its number type; is_nothing(word) and is_no_score();
 * line(word), the number that a word stands for; begin(start, filter), take(filter, z) and
 * advance(filter), its init, update and predict; ORDER_<object>_LEN, the memory of each.
 */
#ifndef KALMANQ_TESTS_START_ORDERS_H
#define KALMANQ_TESTS_START_ORDERS_H

enum { ORDER_DEPTH = 7, ORDER_EARLY = 2, ORDER_STEPS = 9 };
enum { CALL_INIT, CALL_ATTACH, CALL_UPDATE, CALL_PREDICT, CALL_SMOOTH, CALLS };

/* What has to be known */
typedef struct {
    int now, seen, seen_at; /* steps since init; steps measured, 2 suffice; the first of them */
    int attached, origin;   /* the step of it */
    int early;              /* steps kept before the tape */
    int smoothed, last;     /* up to this step */
    int whole, level_at;    /* all of it, or the level of one step at most */
} expectation;

static int is_open(const expectation *e) { return e->seen < 2; }

static void expect_smooth(expectation *e)
{
    if (is_open(e)) e->early++;
    e->whole = !is_open(e);
    e->level_at = e->seen ? e->seen_at : -1;
    e->smoothed = 1;
    e->last = e->now - e->origin;
}

static void expect(expectation *e, int call)
{
    static const expectation none;
    const int keeps = e->attached && !e->smoothed && is_open(e);
    if (call == CALL_INIT) *e = none;
    if (call == CALL_ATTACH && !is_open(e)) { /* the history is no longer the start's */
        e->attached = 0;
        e->last = e->early - 1;
    }
    if (call == CALL_ATTACH && is_open(e)) {
        e->attached = 1;
        e->origin = e->now;
        e->early = e->smoothed = 0;
    }
    if (call == CALL_UPDATE) {
        if (e->seen == 0) e->seen_at = e->now;
        if (e->seen == 0 || (e->seen == 1 && e->now != e->seen_at)) e->seen++;
    }
    if (call == CALL_PREDICT) {
        e->early += keeps;
        e->now++;
    }
    if (call == CALL_SMOOTH && e->attached && !e->smoothed) expect_smooth(e);
}

static int is_expected(const expectation *e, int i)
{
    return !is_open(e) || (i == 0 && e->seen == 1 && e->now == e->seen_at);
}

static int is_expected_smoothed(const expectation *e, int t, int i)
{
    if (!e->smoothed || t > e->last) return 0;
    if (t >= e->early) return e->whole;
    if (t < e->early - ORDER_EARLY) return 0;
    return e->whole || (i == 0 && e->origin + t == e->level_at);
}

static void assert_word(int expected, double value, word high, word low, word sigma)
{
    TEST_ASSERT_EQUAL_INT(!expected, is_nothing(high));
    TEST_ASSERT_EQUAL_INT(!expected, is_nothing(low));
    TEST_ASSERT_EQUAL_INT(!expected, is_nothing(sigma));
    if (!expected) return;
    assert_within(1e-3, value, line(high), __LINE__);
    TEST_ASSERT_TRUE(line(sigma) >= 0 && line(sigma) < 100);
}

static double line_at(int t, int i) { return i ? 2 : 3 + 2 * t; }

static void assert_readings(const S(diffuse) * s, const S(filter) * f, const expectation *e)
{
    S(covariance_word) P[4];
    TEST_ASSERT_EQUAL_INT(2 - e->seen, S(diffuse_count)(s));
    for (int i = 0; i < 2; i++) {
        assert_word(is_expected(e, i), line_at(e->now, i), S(mean)(f, i),
                    S(mean_low)(f, i), S(sigma)(f, i));
    }
    TEST_ASSERT_EQUAL_INT(is_open(e) ? KQ_ERR_NOT_READY : KQ_OK, S(covariance)(f, P));
    TEST_ASSERT_FALSE(is_no_score(S(log_likelihood)(f)));
    TEST_ASSERT_FALSE(is_no_score(S(log_likelihood_last)(f)));
    for (int t = 0; t <= ORDER_STEPS; t++) {
        int whole = 1;
        S(filter) view;
        const kq_status status = S(diffuse_smoothed)(s, (size_t)t, &view); /* refused: it reads NaN */
        (void)status;
        for (int i = 0; i < 2; i++) {
            const int expected = is_expected_smoothed(e, t, i);
            whole &= expected;
            assert_word(expected, line_at(e->origin + t, i), S(mean)(&view, i), S(mean_low)(&view, i),
                        S(sigma)(&view, i));
        }
        const int answered = S(covariance)(&view, P) == KQ_OK;
        TEST_ASSERT_EQUAL_INT(whole, answered);
    }
}

static void make_call(S(diffuse) * s, S(filter) * f, S(history) * tape, int now, int call)
{
    if (call == CALL_INIT) begin(s, f);
    if (call == CALL_ATTACH) ASSERT_OK(S(attach)(f, &tape->attached));
    if (call == CALL_UPDATE) take(f, line_at(now, 0));
    if (call == CALL_PREDICT) advance(f);
    const kq_status status = call == CALL_SMOOTH ? S(diffuse_smooth)(s) : KQ_OK; /* may be refused */
    (void)status;
}

#if defined(__has_feature)
#if __has_feature(memory_sanitizer)
#define UNWRITTEN(memory) ((void)(memory))
#endif
#endif
#ifndef UNWRITTEN
#define UNWRITTEN(memory) memset(memory, 0x41, sizeof(memory))
#endif

/* The order's digits are its calls. */
static void run_order(int order, int depth)
{
    word start_memory[ORDER_START_LEN], filter_memory[ORDER_FILTER_LEN];
    word tape_memory[ORDER_TAPE_LEN];
    S(diffuse) s;
    S(filter) f;
    S(history) tape;
    expectation e = {0};
    UNWRITTEN(start_memory);
    UNWRITTEN(filter_memory);
    UNWRITTEN(tape_memory);
    ASSERT_OK(S(diffuse_assign)(&s, 2, ORDER_EARLY, start_memory, COUNT(start_memory)));
    ASSERT_OK(S(filter_assign)(&f, 2, filter_memory, COUNT(filter_memory)));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    begin(&s, &f);
    for (int k = 0; k < depth; k++, order /= CALLS) {
        const int call = order % CALLS;
        make_call(&s, &f, &tape, e.now, call);
        expect(&e, call);
    }
    assert_readings(&s, &f, &e);
}

static void calls_in_every_order(void)
{
    int orders = 1;
    for (int depth = 0; depth <= ORDER_DEPTH; depth++, orders *= CALLS) {
        for (int order = 0; order < orders; order++) run_order(order, depth);
    }
}

#endif
