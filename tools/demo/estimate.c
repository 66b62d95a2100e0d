/*
 * kq_estimate_f32, kq_estimate_f64: Q and R of one sequence by EM with kalmanq, from a guess.
 *
 *     kq_estimate_f64 < problem > iterations
 *
 * The problem is that of run.c, with the guess for Q and R; steps ahead and ranges play no part.
 * Q stays a multiple of what it is, R diagonal; all else is held.  The iterations are text, one a
 * line:
 *
 *     iteration K log_likelihood Q[n x n] R[m x m]      K = 0 (the guess) .. the last
 *     settled 0 or 1                                    by the stop rule; 0: at the most iterations
 *     distance D                                        of the last log-likelihood to its maximum,
 *                                                       extrapolated; nan: not known
 *     end
 *
 * Bad input, or too few measurements: one line on stderr, nothing on stdout, exit status 1.
 */
#include "demo.h"

#include <stdlib.h>
#include <string.h>

/* Fewer iterations of a long sequence, so that a host is done within half a minute. */
enum { ITERATIONS_MAX = 1000, STATES_MAX = 20000000 }; /* states of all steps of all iterations */
static const word TOLERANCE = (word)1e-6;

typedef T(kq_parameters) parameters;
typedef T(kq_recording) recording;
typedef T(kq_em) estimator;

static const kq_em_choice Q_AND_R = {KQ_EM_Q | KQ_EM_R, KQ_EM_MULTIPLE, KQ_EM_DIAGONAL, NULL, NULL};

/* What every iteration gave: its Q and R, and their log-likelihood. */
typedef struct {
    size_t q_size, r_size;
    size_t last;
    int settled;
    word distance;
    word *log_likelihood, *Q, *R; /* of iterations 0 .. last */
} course;

static uint16_t *masks(const uint32_t *present, size_t steps)
{
    uint16_t *made = allocate(steps, sizeof *made);
    for (size_t t = 0; t < steps; t++) {
        made[t] = (uint16_t)present[t];
    }
    return made;
}

static parameters guess_of(const problem *given)
{
    size_t n = (size_t)given->n, m = (size_t)given->m;
    parameters guess = {.A = words(given->A, n * n),
                        .Q = words(given->Q, n * n),
                        .H = words(given->H, m * n),
                        .R = words(given->R, m * m),
                        .x0 = words(given->x0, n),
                        .P0 = words(given->P0, n * n)};
    return guess;
}

static recording recording_of(const problem *given)
{
    recording made = {.steps = (size_t)given->steps,
                      .z = words(given->z, given->steps * (size_t)given->m),
                      .present = masks(given->present, given->steps)};
    return made;
}

static size_t most_iterations(const problem *given)
{
    size_t most = STATES_MAX / given->steps / (size_t)given->n;
    return most < ITERATIONS_MAX ? most : ITERATIONS_MAX;
}

static course course_of(const problem *given)
{
    size_t n = (size_t)given->n, m = (size_t)given->m, rows = most_iterations(given) + 1;
    course found = {.q_size = n * n, .r_size = m * m};
    found.log_likelihood = allocate(rows, sizeof(word));
    found.Q = allocate(rows * found.q_size, sizeof(word));
    found.R = allocate(rows * found.r_size, sizeof(word));
    return found;
}

/* ---- the library at work ----------------------------------------------------------------- */

static void note(course *found, size_t k, const estimator *em, const parameters *model)
{
    found->last = k;
    found->log_likelihood[k] = T(kq_em_log_likelihood)(em);
    found->distance = T(kq_em_distance)(em);
    memcpy(found->Q + k * found->q_size, model->Q, found->q_size * sizeof(word));
    memcpy(found->R + k * found->r_size, model->R, found->r_size * sizeof(word));
}

/* The E-step, which gives the log-likelihood of Q and R as they are. */
static void expect(estimator *em)
{
    do {
        check(T(kq_em_advance)(em), "EM");
    } while (T(kq_em_remaining)(em) > 0);
}

static void estimate(const problem *given, course *found)
{
    parameters model = guess_of(given);
    recording data = recording_of(given);
    size_t most = most_iterations(given);
    size_t length = LENGTH(KQ_EM_LEN)((size_t)given->n, (size_t)given->m, given->steps);
    estimator em;

    check(T(kq_em_assign)(&em, given->n, given->m, allocate(length, sizeof(word)), length), "EM");
    check(T(kq_em_init)(&em, &model, &Q_AND_R, &data, 1), "EM");
    expect(&em);
    note(found, 0, &em, &model);
    for (size_t k = 1; k <= most && !found->settled; k++) {
        check(T(kq_em_maximise)(&em), "EM");
        found->settled = T(kq_em_is_settled)(&em, TOLERANCE);
        expect(&em);
        note(found, k, &em, &model);
    }
}

/* ---- writing ----------------------------------------------------------------------------- */

static void write_row(const word *values, size_t row, size_t size)
{
    for (size_t k = 0; k < size; k++) {
        printf(" %.17g", (double)values[row * size + k]);
    }
}

static void write_course(const course *found)
{
    for (size_t k = 0; k <= found->last; k++) {
        printf("iteration %lu %.17g", (unsigned long)k, (double)found->log_likelihood[k]);
        write_row(found->Q, k, found->q_size);
        write_row(found->R, k, found->r_size);
        putchar('\n');
    }
    printf("settled %d\n", found->settled);
    printf("distance %.17g\n", (double)found->distance);
    finish_output();
}

/* All memory lives as long as the program: the system takes it back. */
int main(void)
{
    problem given = read_problem(stdin);
    course found = course_of(&given);
    estimate(&given, &found);
    write_course(&found);
    return EXIT_SUCCESS;
}
