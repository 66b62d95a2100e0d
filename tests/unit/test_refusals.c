/*
 * A call that is given something wrong answers an error, and nothing has changed: one table over the calls of all
 * arithmetics.  A row names a call and its arguments; of an argument its kind says what it may be instead, and the
 * status that answers it.  The rows of steps are run with everything attached that changes what a step does.
 */
#define WATCHED_BYTES (1024 * sizeof(word))

#include "models.h"
#include "unchanged.h"

enum { MOST_ARGUMENTS = 7, STEPS = 4 };

static process_model motion, other, three, unmade, scaled;
static sensor_model radar, coupled, lean, gauge3, unmade_sensor;
static prior_model prior, prior3;
S_FILTER(track, 2);
S_FILTER(twin, 2);
S_FILTER(blank, 2);
S_FILTER(track3, 3);
static S(filter) bare, view;
static S(sensor) differs; /* takes innovations */
S_HISTORY(tape, 2, 2, STEPS, 0);
S_HISTORY(recorded, 2, 2, STEPS, 0);
S_HISTORY(unused, 2, 2, STEPS, 0);
S_HISTORY(tape3, 3, 1, STEPS, 0);
S_LAG(lag, 2, 2, 1);
S_INSTANT(instant, 2, 2);
S_DIFFUSE(start, 2, 0);
S_DIFFUSE(blank_start, 2, 0);
S_ADAPTATION(tuner, 2, 2);
S_ADAPTATION(blank_tuner, 2, 2);
S_FREEZE(calm, 2, 2);
S_FREEZE(blank_calm, 2, 2);
S_STEADY(steady, 2, 2);
S_STEADY(blank_steady, 2, 2);
S_CONSISTENCY(recent, 2, 2);
S_HISTORY(course, 2, 2, STEPS, STEPS);
S_JACOBIANS(kept, course, 2, 1, 1);
static S(consistency) blank_recent;
/* The losses, and what is wrong of each: 0, less, and what is no number */
enum { LOSSES = 4, GATE = LOSSES - 1, BAD = 7 };
static S(least_squares) fit, blank_fit, fit_of_nothing;
static entry row_of_fit[2], bad_rows[2][2];
static S(loss) losses[LOSSES], bad_losses[LOSSES][BAD], no_loss;
static entry factor, lambda, bad_factors[BAD], scales[STEPS], bad_scales[BAD][STEPS];
static S(adaptation_rule) rule;

static word z[2], bad_z[8][2], u[2], bad_u[4], mean[2];
static entry out[9], gains[4];
static score scores[4];
static int states = 2, bad_states[] = {0, -1, 17, 258, -254, INT_MAX, INT_MIN};
static size_t count = 1, no_count = 0, too_many = KQ_COUNT_MAX + 1, below_0 = SIZE_MAX;
static size_t filter_length = S_FILTER_LEN(2), short_filter = S_FILTER_LEN(2) - 1;
static size_t history_length = S_HISTORY_LEN(2, 1, 1, 0), short_history = S_HISTORY_LEN(2, 0, 1, 0) - 1;
static size_t early = 0, no_early = UINT16_MAX;
static size_t start_length = S_DIFFUSE_LEN(2, 0), short_start = S_DIFFUSE_LEN(2, 0) - 1;
static size_t short_memory = 0;
static size_t lag_length = S_LAG_LEN(2, 1, 1), short_lag = S_LAG_LEN(2, 1, 1) - 1;
static size_t instant_length = S_INSTANT_LEN(2, 1), short_instant = S_INSTANT_LEN(2, 1) - 1;
static size_t window = 2, no_window = KQ_WINDOW_MAX + 1;
static size_t recent_length = S_CONSISTENCY_LEN(2, 2), short_recent = S_CONSISTENCY_LEN(2, 2) - 1;
static size_t calm_length = S_FREEZE_LEN(2), short_calm = S_FREEZE_LEN(2) - 1;
static size_t steady_length = S_STEADY_LEN(2), short_steady = S_STEADY_LEN(2) - 1;
static size_t kept_length = S_JACOBIANS_LEN(2, 1, 1), short_kept = S_JACOBIANS_LEN(2, 1, 1) - 1;
static score quantile, bad_quantile;
static int component = 1, one = 1, many = INT_MAX, bits = 8, many_bits = 1000;
static num A[] = {1, 0.5, 0, 1}, B[] = {0.125, 0.5}, Q[] = {0.25, 0.125, 0.125, 0.5};
static num H[] = {1, 0, 0.5, 1}, R[] = {0.5, 0.25, 0.25, 1}, x0[] = {1, -2, 0}, P0[] = {2, 0.5, 0.5, 1};

static int calls_of_rates; /* of the function that nonlinear calls are given */

/* ------------------------------------------------------- what an argument may be instead */

typedef struct {
    void *value;
    kq_status status;
} way;

#define END {NULL, KQ_OK}

static const way of_output[] = {{NULL, KQ_ERR_NULL}, END}, of_nothing[] = {END};
static const way of_filter[] = {
    {NULL, KQ_ERR_NULL}, {&blank, KQ_ERR_NOT_READY}, {&track3, KQ_ERR_MISMATCH}, END};
static const way of_source[] = {{NULL, KQ_ERR_NULL}, {&blank, KQ_ERR_NOT_READY}, END};
static const way of_target[] = {{NULL, KQ_ERR_NULL}, {&bare, KQ_ERR_MEMORY}, {&track, KQ_ERR_MISMATCH},
                                {&track3, KQ_ERR_MISMATCH}, END};
static const way of_process[] = {{NULL, KQ_ERR_NULL}, {&unmade.process, KQ_ERR_NOT_READY},
                                 {&three.process, KQ_ERR_MISMATCH}, END};
static const way of_smoothing_process[] = {{&unmade.process, KQ_ERR_NOT_READY}, {&three.process, KQ_ERR_MISMATCH}, END};
static const way of_sensor[] = {{NULL, KQ_ERR_NULL}, {&unmade_sensor.sensor, KQ_ERR_NOT_READY},
                                {&gauge3.sensor, KQ_ERR_MISMATCH}, END};
static const way of_measurement[] = {
    {NULL, KQ_ERR_NULL},         {bad_z[0], NOT_A_NUMBER}, {bad_z[1], NOT_A_NUMBER}, {bad_z[2], NOT_A_NUMBER},
    {bad_z[3], NOT_A_NUMBER},    {bad_z[4], NOT_A_NUMBER}, {bad_z[5], NOT_A_NUMBER}, {bad_z[6], NOT_A_NUMBER},
    {bad_z[7], NOT_A_NUMBER},    END};
#ifdef KQ_TEST_Q31 /* An increment has no range: what is no word is refused. */
static const way of_increment[] = {{NULL, KQ_ERR_NULL}, {bad_z[6], NOT_A_NUMBER}, {bad_z[7], NOT_A_NUMBER}, END};
#else
#define of_increment of_measurement
#endif
static const way of_control[] = {{&bad_u[0], NOT_A_NUMBER}, {&bad_u[1], NOT_A_NUMBER}, {&bad_u[2], NOT_A_NUMBER},
                                 {&bad_u[3], NOT_A_NUMBER}, END};
static const way of_states[] = {{&bad_states[0], KQ_ERR_SIZE}, {&bad_states[1], KQ_ERR_SIZE},
                                {&bad_states[2], KQ_ERR_SIZE}, {&bad_states[3], KQ_ERR_SIZE},
                                {&bad_states[4], KQ_ERR_SIZE}, {&bad_states[5], KQ_ERR_SIZE},
                                {&bad_states[6], KQ_ERR_SIZE}, END};
static const way of_count[] = {{&too_many, KQ_ERR_SIZE}, {&below_0, KQ_ERR_SIZE}, END};
static const way of_gains[] = {{&no_count, KQ_ERR_SIZE}, {&too_many, KQ_ERR_SIZE}, {&below_0, KQ_ERR_SIZE}, END};
static const way of_early[] = {{&no_early, KQ_ERR_SIZE}, {&below_0, KQ_ERR_SIZE}, END};
static const way of_measurements[] = {{&bad_states[0], KQ_ERR_SIZE}, {&bad_states[1], KQ_ERR_SIZE}, {&many, KQ_ERR_MEMORY}, END};
static const way of_lag[] = {{&too_many, KQ_ERR_SIZE}, {&below_0, KQ_ERR_SIZE}, END};
static const way of_window[] = {{&no_count, KQ_ERR_SIZE}, {&no_window, KQ_ERR_SIZE}, {&below_0, KQ_ERR_SIZE}, END};
static const way of_bits[] = {{&bad_states[0], KQ_ERR_SIZE}, {&many_bits, KQ_ERR_SIZE}, END};
static const way of_lag_length[] = {{&short_lag, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_instant_length[] = {{&short_instant, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_recent_length[] = {{&short_recent, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_calm_length[] = {{&short_calm, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_steady_length[] = {{&short_steady, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_kept_length[] = {{&short_kept, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_component[] = {{&bad_states[1], KQ_ERR_SIZE}, {&states, KQ_ERR_SIZE}, END};
static const way of_quantile[] = {{&bad_quantile, KQ_ERR_RANGE}, END};
static const way of_recent[] = {{NULL, KQ_ERR_NULL}, {&blank_recent, KQ_ERR_NOT_READY}, END};
static const way of_filter_length[] = {{&short_filter, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_history_length[] = {{&short_history, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_other_filter[] = {{NULL, KQ_ERR_NULL}, {&track3, KQ_ERR_MISMATCH}, END};
static const way of_start_length[] = {{&short_start, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_history[] = {{NULL, KQ_ERR_NULL}, {&unused, KQ_ERR_HISTORY_EMPTY}, END};
static size_t recorded_steps = 2; /* steps 0 and 1 */
static const way of_step[] = {{&recorded_steps, KQ_ERR_SIZE}, {&too_many, KQ_ERR_SIZE}, {&below_0, KQ_ERR_SIZE}, END};
static const way of_recorder[] = {{NULL, KQ_ERR_NULL}, {&tape3.attached, KQ_ERR_MISMATCH}, END};
static const way of_attached[] = {{NULL, KQ_ERR_NULL}, {&blank_tuner.attached, KQ_ERR_NOT_READY},
                                  {&blank_calm.attached, KQ_ERR_NOT_READY}, END};
static const way of_start[] = {{NULL, KQ_ERR_NULL}, {&blank_start, KQ_ERR_NOT_READY}, END};
static const way of_steady[] = {{NULL, KQ_ERR_NULL}, {&blank_steady, KQ_ERR_NOT_READY}, END};
static const way of_settling[] = {{NULL, KQ_ERR_NULL}, {&blank_calm, KQ_ERR_NOT_READY}, END};

#define OF_LOSS(k)                                                                                 \
    {                                                                                              \
        {NULL, KQ_ERR_NULL}, {&no_loss, KQ_ERR_NULL}, {&bad_losses[k][0], KQ_ERR_RANGE},           \
        {&bad_losses[k][1], KQ_ERR_RANGE}, {&bad_losses[k][2], NOT_AN_ENTRY},                      \
        {&bad_losses[k][3], NOT_AN_ENTRY}, END                                                     \
    }
static const way of_losses[LOSSES][7] = {OF_LOSS(0), OF_LOSS(1), OF_LOSS(2), {
    {NULL, KQ_ERR_NULL}, {&bad_losses[GATE][0], KQ_ERR_RANGE}, {&bad_losses[GATE][1], KQ_ERR_RANGE}, END}};
static const way of_jump[] = {{&bad_losses[GATE][2], KQ_ERR_RANGE}, END};
/* More than 1, too, however little */
static const way of_lambda[] = {{&bad_factors[0], KQ_ERR_RANGE}, {&bad_factors[1], KQ_ERR_RANGE},
                                {&bad_factors[2], NOT_AN_ENTRY}, {&bad_factors[3], NOT_AN_ENTRY},
                                {&bad_factors[4], NOT_AN_ENTRY}, {&bad_factors[5], NOT_AN_ENTRY},
                                {&bad_factors[6], KQ_ERR_RANGE}, {&factor, KQ_ERR_RANGE}, END};
static const way of_factor[] = {{&bad_factors[1], KQ_ERR_NOT_SEMIDEFINITE}, {&bad_factors[2], NOT_AN_ENTRY},
                                {&bad_factors[3], NOT_AN_ENTRY}, END};
static const way of_freedom[] = {{&bad_factors[0], KQ_ERR_RANGE}, {&bad_factors[1], KQ_ERR_RANGE},
                                 {&bad_factors[2], NOT_AN_ENTRY}, {&bad_factors[3], NOT_AN_ENTRY}, END};
static const way of_scales[] = {{NULL, KQ_ERR_NULL}, {bad_scales[1], KQ_ERR_NOT_SEMIDEFINITE},
                                {bad_scales[2], NOT_AN_ENTRY}, {bad_scales[3], NOT_AN_ENTRY}, END};
static const way of_made_sensor[] = {{NULL, KQ_ERR_NULL}, {&unmade_sensor.sensor, KQ_ERR_NOT_READY}, END};
static const way of_source_process[] = {{NULL, KQ_ERR_NULL}, {&unmade.process, KQ_ERR_NOT_READY}, END};
static const way of_fit[] = {{NULL, KQ_ERR_NULL}, {&blank_fit, KQ_ERR_NOT_READY}, {&fit_of_nothing, KQ_ERR_NOT_READY},
                             END};
static const way of_first[] = {{NULL, KQ_ERR_NULL}, {bad_z[0], NOT_A_NUMBER}, {bad_z[2], NOT_A_NUMBER},
                               {bad_z[4], NOT_A_NUMBER}, {bad_z[6], NOT_A_NUMBER}, END};
static const way of_row[] = {{NULL, KQ_ERR_NULL}, {bad_rows[0], NOT_AN_ENTRY}, {bad_rows[1], NOT_AN_ENTRY}, END};
static const way of_variance[] = {{NULL, KQ_ERR_NULL}, {&bad_factors[1], NO_VARIANCE}, {&bad_factors[2], NOT_AN_ENTRY},
                                  {&bad_factors[3], NOT_AN_ENTRY}, END};
/* Numbers, two or four of them, of which the last is none; covariances that are none */
static num bad_numbers[3][4] = {{1, 0, 0, (num)NAN}, {1, 0, 0, (num)INFINITY}, {1, 0, 0, -(num)INFINITY}};
static num skew[] = {1, 0.5, 0, 1}, indefinite[] = {1, 2, 2, 1}, negative_variance[] = {1, N(-1e-9)};
#define NOT_FINITE_FROM(k)                                                                         \
    {bad_numbers[0] + k, KQ_ERR_NOT_FINITE}, {bad_numbers[1] + k, KQ_ERR_NOT_FINITE},              \
    {bad_numbers[2] + k, KQ_ERR_NOT_FINITE}
#define NO_COVARIANCE {skew, KQ_ERR_NOT_SYMMETRIC}, {indefinite, KQ_ERR_NOT_SEMIDEFINITE}
static const way of_vector[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(2), END};
static const way of_matrix[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(0), END};
static const way of_covariance[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(0), NO_COVARIANCE, END};
#ifdef KQ_TEST_Q31 /* the root has its own array, and of the target nothing is looked at */
static num tiny_variance[] = {1, 0x1p-1074};
static const way of_variances[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(2), {negative_variance, KQ_ERR_NOT_SEMIDEFINITE},
                                   {tiny_variance, KQ_ERR_COEFFICIENT}, END};
static kq_format_q31 no_formats[2][2] = {{{1, 0}, {1, KQ_FRACTION_MIN_Q31 - 1}}, {{1, 0}, {1, KQ_FRACTION_MAX_Q31 + 1}}};
static const way of_formats[] = {{NULL, KQ_ERR_NULL}, {no_formats[0], KQ_ERR_SIZE}, {no_formats[1], KQ_ERR_SIZE}, END};
static const way of_vector_formats[] = {{NULL, KQ_ERR_NULL}, END};
static int32_t root_words[S_ROOT_LEN(2)];
static sensor_model diagonal, negative;
static const way of_prior_table[] = {{NULL, KQ_ERR_NULL}, {&prior3.table, KQ_ERR_MISMATCH}, END};
static const way of_diagonal_table[] = {{NULL, KQ_ERR_NULL}, {&coupled.table, KQ_ERR_TABLE}, {&negative.table, KQ_ERR_TABLE}, END};
static size_t tuner_length = KQ_ADAPTATION_LEN_Q31(2, 2), short_tuner = KQ_ADAPTATION_LEN_Q31(2, 2) - 1;
static const way of_scaled[] = {{NULL, KQ_ERR_NULL}, {&motion.process, KQ_ERR_MISMATCH}, END};
static const way of_root[] = {{NULL, KQ_ERR_NULL}, {motion.noise_root, KQ_ERR_MISMATCH}, END};
#define A_ROOT {scaled.noise_root, of_root}
static const kq_format_q31 bad_formats[] = {{0, 0}, {1, 95}, {1, -65}};
static const way of_format[] = {{NULL, KQ_ERR_NULL}, {(void *)&bad_formats[0], KQ_ERR_TABLE},
                                {(void *)&bad_formats[1], KQ_ERR_TABLE}, {(void *)&bad_formats[2], KQ_ERR_TABLE}, END};
#define FORMAT radar.measurement_format
#define A_FORMAT {FORMAT, of_format}
#else
static const way of_scaled[] = {{NULL, KQ_ERR_NULL}, {&unmade.process, KQ_ERR_SIZE}, {&motion.process, KQ_ERR_MISMATCH},
                                {&three.process, KQ_ERR_MISMATCH}, END};
#define A_ROOT {NULL, of_nothing}
static size_t tuner_length = ADAPTATION_LEN(2, 2), short_tuner = ADAPTATION_LEN(2, 2) - 1;
static const way of_variances[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(2), {negative_variance, KQ_ERR_NOT_SEMIDEFINITE}, END};
/* What becomes of time, and of noise that has to do with a measurement's */
static num flow_memory[KQ_CONTINUOUS_LEN(2, 1)], second = 1, no_times[] = {0, -1, (num)NAN, (num)INFINITY};
static size_t flow_length = KQ_CONTINUOUS_LEN(2, 1), short_flow = KQ_CONTINUOUS_LEN(2, 1) - 1;
static const way of_flow_length[] = {{&short_flow, KQ_ERR_MEMORY}, END};
static const way of_time[] = {{&no_times[0], KQ_ERR_RANGE}, {&no_times[1], KQ_ERR_RANGE},
                              {&no_times[2], KQ_ERR_NOT_FINITE}, {&no_times[3], KQ_ERR_NOT_FINITE}, END};
#ifdef KQ_TEST_F32
KQ_EM_F32(em, 2, 2, 1);
KQ_EM_F32(blank_em, 2, 2, 1);
#else
KQ_EM_F64(em, 2, 2, 1);
KQ_EM_F64(blank_em, 2, 2, 1);
#endif
static size_t em_length = COUNT(em_memory), short_em = COUNT(em_memory) - 1;
static const way of_em_length[] = {{&short_em, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_em[] = {{NULL, KQ_ERR_NULL}, {&blank_em, KQ_ERR_NOT_READY}, END};
static num drift_words[KQ_CORRELATED_LEN(2, 1, 2)];
static K(process) drift, short_drift, drift_of_one;
static num shared[] = {0.125, -0.125, 0.25, 0.0625}, no_noise[4], too_much[] = {2, 0, 0, 0}, wide_shared[] = {NUM_MAX, 0, 0, 0};
static const way of_drift[] = {{NULL, KQ_ERR_NULL}, {&short_drift, KQ_ERR_MEMORY}, {&drift_of_one, KQ_ERR_SIZE}, END};
static const way of_shared_noise[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(0), NO_COVARIANCE, {no_noise, KQ_ERR_NOT_SEMIDEFINITE}, END};
static const way of_shared[] = {{NULL, KQ_ERR_NULL}, NOT_FINITE_FROM(0), {too_much, KQ_ERR_NOT_SEMIDEFINITE},
                                {wide_shared, KQ_ERR_NOT_SEMIDEFINITE}, END};
static size_t model_length = KQ_PROCESS_LEN(2), short_model = KQ_PROCESS_LEN(2) - 2; /* a diagonal sensor has a word less */
static num solved[SOLVE_LEN(2, 2)];
static K(steady_solution) solution = {out, NULL, NULL, NULL};
static size_t solve_length = SOLVE_LEN(2, 2), short_solve = SOLVE_LEN(2, 2) - 1;
static const way of_solve_length[] = {{&short_solve, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_model_length[] = {{&short_model, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};
static const way of_assigned_process[] = {{NULL, KQ_ERR_NULL}, {&unmade.process, KQ_ERR_SIZE}, END};
static const way of_assigned_sensor[] = {{NULL, KQ_ERR_NULL}, {&unmade_sensor.sensor, KQ_ERR_SIZE}, END};
/* Functions of a nonlinear model: one that is given something wrong is not called. */
static int first_rule = KQ_SIGMA_POINTS_CUBATURE, no_rules[] = {-1, 2};
static num work[KQ_SIGMA_POINTS_LEN(2, 2)], of_noise[4];
static process_model bent;
static sensor_model sharp, diagonal;
static void rates(void *context, const num *x, num *y)
{
    (void)context;
    calls_of_rates++;
    y[0] = x[0] + x[1], y[1] = x[1];
}
static const way of_rule[] = {{&no_rules[0], KQ_ERR_RANGE}, {&no_rules[1], KQ_ERR_RANGE}, END};
static const way of_bent[] = {{NULL, KQ_ERR_NULL}, {&unmade.process, KQ_ERR_SIZE}, {&motion.process, KQ_ERR_MISMATCH}, END};
static const way of_sharp[] = {{NULL, KQ_ERR_NULL}, {&diagonal.sensor, KQ_ERR_MEMORY}, {&radar.sensor, KQ_ERR_MISMATCH},
                               {&gauge3.sensor, KQ_ERR_MISMATCH}, END};
static const way of_assigned_filter[] = {{NULL, KQ_ERR_NULL}, {&bare, KQ_ERR_SIZE}, END};
#define FORMAT NULL
#define A_FORMAT {FORMAT, of_nothing}
#endif
static const way of_tuner_length[] = {{&short_tuner, KQ_ERR_MEMORY}, {&short_memory, KQ_ERR_MEMORY}, END};

/* ---------------------------------------------------------------------------------- calls */

#define CALL_OF(name, ...)                                                                         \
    static kq_status name##_of(void *const *a) { return S(name)(__VA_ARGS__); }

CALL_OF(predict, a[0], a[1], a[2])
CALL_OF(update, a[0], a[1], a[2])
CALL_OF(update_subset, a[0], a[1], a[2], 3)
CALL_OF(update_robust, a[0], a[1], a[2], 3, a[3])
CALL_OF(step, a[0], a[1], a[2], a[3], a[4])
CALL_OF(forecast, a[0], a[1], a[2], *(size_t *)a[3], a[4])
CALL_OF(filter_assign, a[0], *(int *)a[1], a[2], *(size_t *)a[3])
CALL_OF(filter_copy, a[0], a[1])
CALL_OF(filter_check, a[0])
CALL_OF(covariance, a[0], a[1])
CALL_OF(measurement, a[0], a[1], a[2], a[3])
CALL_OF(innovation, a[0], a[1], a[2], a[3])
CALL_OF(gain, a[0], a[1], a[2])
CALL_OF(move, a[0], a[1])
CALL_OF(predict_extended, a[0], a[1], a[2])
CALL_OF(lag_assign, a[0], *(int *)a[1], *(int *)a[2], *(size_t *)a[3], a[4], *(size_t *)a[5])
CALL_OF(instant_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4])
CALL_OF(steady_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4])
CALL_OF(freeze_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4], a[5])
CALL_OF(freeze_init, a[0], *(int *)a[1])
CALL_OF(consistency_assign, a[0], *(int *)a[1], *(size_t *)a[2], a[3], *(size_t *)a[4])
CALL_OF(consistency_clear, a[0])
CALL_OF(consistency_watch, a[0], a[1], a[2], a[3], UINT32_MAX)
CALL_OF(consistency_record, a[0], a[1])
CALL_OF(consistency_nis, a[0], *(score *)a[1], a[2], a[3], a[4])
CALL_OF(consistency_innovation, a[0], *(int *)a[1], *(score *)a[2], a[3], a[4], a[5], a[6])
CALL_OF(jacobians_assign, a[0], a[1], *(int *)a[2], a[3], *(size_t *)a[4], a[5], *(size_t *)a[6])
CALL_OF(attach, a[0], a[1])
CALL_OF(detach, a[0])
CALL_OF(history_assign, a[0], *(int *)a[1], a[2], *(size_t *)a[3])
CALL_OF(smooth, a[0])
CALL_OF(smooth_states, a[0])
CALL_OF(smooth_step, a[0], a[1], NULL)
CALL_OF(smoothed, a[0], *(size_t *)a[1], a[2])
CALL_OF(diffuse_assign, a[0], *(int *)a[1], *(size_t *)a[2], a[3], *(size_t *)a[4])
CALL_OF(diffuse_smooth, a[0])
CALL_OF(diffuse_smoothed, a[0], 0, a[1])
CALL_OF(adaptation_init, a[0], a[1], a[2], a[3])
CALL_OF(steady_init, a[0], a[1], a[2], a[5], a[3], *(size_t *)a[4])
CALL_OF(steady_predict, a[0], a[1])
CALL_OF(steady_update, a[0], a[1])
CALL_OF(steady_step, a[0], a[1], a[2])
CALL_OF(steady_innovation, a[0], a[1], a[2])
CALL_OF(freeze_release, a[0])
CALL_OF(forget, a[0], *(entry *)a[1])
CALL_OF(least_squares_add, a[0], a[1], a[2], a[3], *(size_t *)a[4])
#ifdef KQ_TEST_Q31
CALL_OF(least_squares_init, a[0], a[1], *(entry *)a[2], a[3])
CALL_OF(process_scale_noise, a[0], a[1], a[3], *(entry *)a[2])
CALL_OF(adaptation_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4], a[5])
CALL_OF(diffuse_init, a[0], a[1], a[2], 0, NULL)
CALL_OF(process_init, a[0], a[1], NULL)
CALL_OF(process_change_transition, a[0], a[1], NULL)
CALL_OF(sensor_init, a[0], a[1], NULL)
CALL_OF(sensor_init_diagonal, a[0], a[1], NULL)
CALL_OF(sensor_init_lean, a[0], a[1], NULL)
CALL_OF(sensor_change_measurement, a[0], a[1], NULL)
CALL_OF(filter_init, a[0], a[1], NULL)
CALL_OF(vector_prepare, a[0], a[1], *(int *)a[2], a[3], NULL)
CALL_OF(matrix_prepare, a[0], a[1], *(int *)a[2], *(int *)a[3], a[4], a[5])
CALL_OF(root_prepare, a[0], a[1], *(int *)a[2], a[3])
CALL_OF(root_prepare_factor, a[0], a[1], *(int *)a[2], *(int *)a[3], a[4])
CALL_OF(noise_prepare, a[0], a[1], *(int *)a[2], a[3])
CALL_OF(noise_prepare_diagonal, a[0], a[1], *(int *)a[2], a[3])
CALL_OF(smooth_reweighted, a[0], a[1], a[2], a[5], *(entry *)a[3], a[4])
#else
CALL_OF(least_squares_init, a[0], a[1], *(entry *)a[2])
CALL_OF(steady_solve, a[0], a[1], a[2], *(size_t *)a[3], a[4])
CALL_OF(adaptation_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4])
CALL_OF(em_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4])
CALL_OF(diffuse_init, a[0], a[1], a[2], a[3], 0)
CALL_OF(em_advance, a[0])
CALL_OF(em_maximise, a[0])
CALL_OF(em_iterate, a[0])
static kq_status linearise_of(void *const *a)
{
    return S(linearise)(a[0], a[1] ? rates : NULL, NULL, *(int *)a[2], (kq_sigma_points)first_rule, a[3], a[4], a[5]);
}
static kq_status linearise_by_of(void *const *a)
{
    return S(linearise)(&track, rates, NULL, 2, (kq_sigma_points)*(int *)a[0], mean, out, work);
}
static kq_status predict_sigma_points_of(void *const *a)
{
    return S(predict_sigma_points)(a[0], a[1], a[2] ? rates : NULL, NULL, (kq_sigma_points)*(int *)a[3], a[4]);
}
static kq_status update_sigma_points_of(void *const *a)
{
    return S(update_sigma_points)(a[0], a[1], a[2] ? rates : NULL, NULL, (kq_sigma_points)*(int *)a[3], a[4]);
}
CALL_OF(process_linearise, a[0], a[1], a[2], a[3])
CALL_OF(sensor_linearise, a[0], a[1], a[2], a[3], a[4])
CALL_OF(process_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4])
CALL_OF(process_init, a[0], a[1], a[2], a[3])
CALL_OF(process_init_root, a[0], a[1], a[2], a[3])
CALL_OF(process_init_factor, a[0], a[1], a[2], a[3], *(int *)a[4])
CALL_OF(process_init_continuous, a[0], a[1], a[2], a[3], *(num *)a[4], a[5], *(size_t *)a[6])
CALL_OF(process_init_correlated, a[0], a[1], a[2], a[3], a[4], a[5], UINT32_MAX)
CALL_OF(process_change_transition, a[0], a[1])
CALL_OF(sensor_assign, a[0], *(int *)a[1], *(int *)a[2], a[3], *(size_t *)a[4])
CALL_OF(sensor_init, a[0], a[1], a[2])
CALL_OF(sensor_init_diagonal, a[0], a[1], a[2])
CALL_OF(sensor_init_lean, a[0], a[1], a[2])
CALL_OF(sensor_change_measurement, a[0], a[1])
CALL_OF(filter_init, a[0], a[1], a[2])
CALL_OF(process_scale_noise, a[0], a[1], *(entry *)a[2])
CALL_OF(smooth_reweighted, a[0], a[1], a[2], *(entry *)a[3], a[4])
#endif

typedef struct {
    const char *name;
    kq_status (*call)(void *const *);
    struct {
        void *good;
        const way *ways;
    } argument[MOST_ARGUMENTS];
} row;

#define ROW(name, ...) {#name, name##_of, {__VA_ARGS__}}
#define A_FILTER {&track, of_filter}
#define A_PROCESS {&motion.process, of_process}
#define A_SENSOR {&radar.sensor, of_sensor}
#define A_MEASUREMENT {z, of_measurement}
#define A_CONTROL {u, of_control}
#define AN_OUTPUT(array) {array, of_output}
#define A_COUNT {&states, of_states + 1} /* of controls, of columns: 0 may be */

/* What moves a filter, whatever is attached */
static const row steps[] = {
    ROW(predict, A_FILTER, A_PROCESS, A_CONTROL),
    ROW(update, A_FILTER, A_SENSOR, A_MEASUREMENT),
    ROW(update_subset, A_FILTER, A_SENSOR, A_MEASUREMENT),
    ROW(step, A_FILTER, A_PROCESS, A_CONTROL, A_SENSOR, A_MEASUREMENT),
};

/* By models that nothing is learnt of */
static const row steps_of_others[] = {
    ROW(predict, A_FILTER, {&other.process, of_process}, A_CONTROL),
    ROW(update_subset, A_FILTER, {&coupled.sensor, of_sensor}, A_MEASUREMENT),
    ROW(step, A_FILTER, {&other.process, of_process}, A_CONTROL, {&coupled.sensor, of_sensor}, A_MEASUREMENT),
};

static const row calls[] = {
    ROW(update_robust, A_FILTER, A_SENSOR, A_MEASUREMENT, {&losses[0], of_losses[0]}),
    ROW(update_robust, A_FILTER, A_SENSOR, A_MEASUREMENT, {&losses[1], of_losses[1]}),
    ROW(update_robust, A_FILTER, A_SENSOR, A_MEASUREMENT, {&losses[2], of_losses[2]}),
    ROW(update_robust, A_FILTER, A_SENSOR, A_MEASUREMENT, {&losses[2], of_jump}),
    ROW(update_robust, A_FILTER, A_SENSOR, A_MEASUREMENT, {&losses[GATE], of_losses[GATE]}),
    ROW(process_scale_noise, {&scaled.process, of_scaled}, {&motion.process, of_source_process}, {&factor, of_factor}, A_ROOT),
    ROW(forecast, {&track, of_filter}, A_PROCESS, A_CONTROL, {&count, of_count}, {&twin, of_target}),
    ROW(filter_assign, AN_OUTPUT(&twin), {&states, of_states}, AN_OUTPUT(twin_memory),
        {&filter_length, of_filter_length}),
    ROW(filter_copy, {&twin, of_target}, {&track, of_source}),
    ROW(filter_check, {&track, of_source}),
    ROW(covariance, {&track, of_source}, AN_OUTPUT(out)),
    ROW(measurement, A_FILTER, A_SENSOR, {mean, of_nothing}, {out, of_nothing}),
    ROW(innovation, A_FILTER, A_SENSOR, A_MEASUREMENT, AN_OUTPUT(mean)),
    ROW(gain, A_FILTER, A_SENSOR, AN_OUTPUT(out)),
    ROW(move, {&track, of_source}, {z, of_increment}),
    ROW(predict_extended, A_FILTER, {&other.process, of_process}, {z, of_increment}),
    ROW(update, A_FILTER, {&differs, of_sensor}, {z, of_increment}),
    ROW(update_robust, A_FILTER, {&differs, of_sensor}, {z, of_increment}, {&losses[0], of_losses[0]}),
    ROW(update_robust, A_FILTER, {&differs, of_sensor}, {z, of_increment}, {&losses[1], of_losses[1]}),
    ROW(update_robust, A_FILTER, {&differs, of_sensor}, {z, of_increment}, {&losses[2], of_losses[2]}),
    ROW(update, A_FILTER, {&lean.sensor, of_sensor}, A_MEASUREMENT),
    ROW(lag_assign, AN_OUTPUT(&lag), {&states, of_states}, {&one, of_measurements}, {&count, of_lag}, AN_OUTPUT(lag_memory),
        {&lag_length, of_lag_length}),
    ROW(instant_assign, AN_OUTPUT(&instant), {&states, of_states}, {&one, of_measurements}, AN_OUTPUT(instant_memory),
        {&instant_length, of_instant_length}),
    ROW(steady_assign, AN_OUTPUT(&steady), {&states, of_states}, {&states, of_states}, AN_OUTPUT(steady_memory),
        {&steady_length, of_steady_length}),
    ROW(freeze_assign, AN_OUTPUT(&calm), {&states, of_states}, {&states, of_states}, AN_OUTPUT(calm_memory),
        {&calm_length, of_calm_length}, AN_OUTPUT(calm_gain)),
    ROW(freeze_init, AN_OUTPUT(&calm), {&bits, of_bits}),
    ROW(consistency_assign, AN_OUTPUT(&recent), {&states, of_states}, {&window, of_window}, AN_OUTPUT(recent_memory),
        {&recent_length, of_recent_length}),
    ROW(consistency_clear, {&recent, of_recent}),
    ROW(consistency_watch, {&recent, of_recent}, A_FILTER, A_SENSOR, A_MEASUREMENT),
    ROW(attach, {&track, of_source}, {&tape.attached, of_recorder}),
    ROW(detach, {&tape.attached, of_attached}),
    ROW(history_assign, AN_OUTPUT(&tape), {&states, of_states}, AN_OUTPUT(tape_memory),
        {&history_length, of_history_length}),
    ROW(smooth, {&recorded, of_history}),
    ROW(smooth_states, {&recorded, of_history}),
    ROW(smooth_reweighted, {&recorded, of_history}, {&scaled.process, of_scaled}, A_PROCESS, {&factor, of_freedom},
        {scales, of_scales}, A_ROOT),
    ROW(smooth_step, {&recorded, of_history}, {NULL, of_nothing}),
    ROW(diffuse_assign, AN_OUTPUT(&start), {&states, of_states}, {&early, of_early}, AN_OUTPUT(start_memory),
        {&start_length, of_start_length}),
    ROW(jacobians_assign, AN_OUTPUT(&kept), AN_OUTPUT(&course), {&states, of_states}, AN_OUTPUT(kept_processes),
        {&count, of_gains}, AN_OUTPUT(kept_memory), {&kept_length, of_kept_length}),
    ROW(adaptation_init, AN_OUTPUT(&tuner), A_PROCESS, A_SENSOR, AN_OUTPUT(&rule)),
    ROW(steady_init, AN_OUTPUT(&steady), A_PROCESS, A_SENSOR, AN_OUTPUT(gains), {&count, of_gains}, AN_OUTPUT(mean)),
    ROW(steady_predict, {&steady, of_steady}, A_CONTROL),
    ROW(steady_update, {&steady, of_steady}, A_MEASUREMENT),
    ROW(steady_step, {&steady, of_steady}, A_CONTROL, A_MEASUREMENT),
    ROW(steady_innovation, {&steady, of_steady}, A_MEASUREMENT, AN_OUTPUT(mean)),
    ROW(freeze_release, {&calm, of_settling}),
    ROW(forget, {&track, of_source}, {&lambda, of_lambda}),
    ROW(least_squares_init, AN_OUTPUT(&fit), AN_OUTPUT(&track), {&lambda, of_lambda}, A_FORMAT),
    ROW(least_squares_add, {&fit, of_fit}, {row_of_fit, of_row}, {z, of_first}, {&factor, of_variance}, {&count, of_count}),
#ifdef KQ_TEST_Q31
    ROW(adaptation_assign, AN_OUTPUT(&tuner), {&states, of_states}, {&states, of_states}, AN_OUTPUT(tuner_memory),
        {&tuner_length, of_tuner_length}, AN_OUTPUT(tuner_root)),
    ROW(diffuse_init, AN_OUTPUT(&start), {&twin, of_other_filter}, {&prior.table, of_prior_table}),
    ROW(process_init, AN_OUTPUT(&other.process), AN_OUTPUT(&other.table)),
    ROW(process_change_transition, {&other.process, of_source_process}, AN_OUTPUT(other.transition)),
    ROW(sensor_init, AN_OUTPUT(&coupled.sensor), AN_OUTPUT(&coupled.table)),
    ROW(sensor_init_diagonal, AN_OUTPUT(&diagonal.sensor), {&diagonal.table, of_diagonal_table}),
    ROW(sensor_init_lean, AN_OUTPUT(&diagonal.sensor), {&diagonal.table, of_diagonal_table}),
    ROW(sensor_change_measurement, {&coupled.sensor, of_made_sensor}, AN_OUTPUT(coupled.measurement)),
    ROW(filter_init, AN_OUTPUT(&twin), AN_OUTPUT(&prior.table)),
    ROW(vector_prepare, AN_OUTPUT(mean), {x0, of_vector}, {&states, of_states}, {motion.state_format, of_vector_formats}),
    ROW(matrix_prepare, AN_OUTPUT(out), {A, of_matrix}, {&states, of_states}, {&states, of_states},
        {motion.state_format, of_formats}, {motion.state_format, of_formats}),
    ROW(root_prepare, AN_OUTPUT(root_words), {P0, of_covariance}, {&states, of_states}, {motion.state_format, of_formats}),
    ROW(root_prepare_factor, AN_OUTPUT(root_words), {A, of_matrix}, {&states, of_states}, A_COUNT,
        {motion.state_format, of_formats}),
    ROW(noise_prepare, AN_OUTPUT(out), {R, of_covariance}, {&states, of_states}, {radar.measurement_format, of_formats}),
    ROW(noise_prepare_diagonal, AN_OUTPUT(out), {B, of_variances}, {&states, of_states},
        {radar.measurement_format, of_formats}),
#else
    ROW(steady_solve, A_PROCESS, A_SENSOR, AN_OUTPUT(solved), {&solve_length, of_solve_length}, AN_OUTPUT(&solution)),
    ROW(adaptation_assign, AN_OUTPUT(&tuner), {&states, of_states}, {&states, of_states}, AN_OUTPUT(tuner_memory),
        {&tuner_length, of_tuner_length}),
    ROW(diffuse_init, AN_OUTPUT(&start), {&twin, of_other_filter}, {x0, of_vector}, {P0, of_covariance}),
    ROW(em_assign, AN_OUTPUT(&em), {&states, of_states}, {&states, of_states}, AN_OUTPUT(em_memory), {&em_length, of_em_length}),
    ROW(process_assign, AN_OUTPUT(&other.process), {&states, of_states}, A_COUNT, AN_OUTPUT(other.words),
        {&model_length, of_model_length}),
    ROW(process_init, {&other.process, of_assigned_process}, AN_OUTPUT(A), AN_OUTPUT(B), AN_OUTPUT(Q)),
    ROW(process_init_root, {&other.process, of_assigned_process}, AN_OUTPUT(A), AN_OUTPUT(B), AN_OUTPUT(Q)),
    ROW(process_init_factor, {&other.process, of_assigned_process}, AN_OUTPUT(A), AN_OUTPUT(B), AN_OUTPUT(Q),
        A_COUNT),
    ROW(process_init_continuous, AN_OUTPUT(&other.process), {A, of_matrix}, AN_OUTPUT(B), {Q, of_covariance}, {&second, of_time},
        AN_OUTPUT(flow_memory), {&flow_length, of_flow_length}),
    ROW(process_init_correlated, {&drift, of_drift}, {A, of_matrix}, AN_OUTPUT(B), {Q, of_shared_noise}, A_SENSOR,
        {shared, of_shared}),
    ROW(process_change_transition, {&other.process, of_source_process}, AN_OUTPUT(A)),
    ROW(sensor_assign, AN_OUTPUT(&coupled.sensor), {&states, of_states}, {&states, of_states}, AN_OUTPUT(coupled.words),
        {&model_length, of_model_length}),
    ROW(sensor_init, {&coupled.sensor, of_assigned_sensor}, AN_OUTPUT(H), AN_OUTPUT(R)),
    ROW(sensor_init_diagonal, {&coupled.sensor, of_assigned_sensor}, AN_OUTPUT(H), {B, of_variances}),
    ROW(sensor_init_lean, {&coupled.sensor, of_assigned_sensor}, AN_OUTPUT(H), {B, of_variances}),
    ROW(sensor_change_measurement, {&coupled.sensor, of_made_sensor}, AN_OUTPUT(H)),
    ROW(filter_init, {&twin, of_assigned_filter}, AN_OUTPUT(x0), AN_OUTPUT(P0)),
    ROW(linearise, {&track, of_source}, AN_OUTPUT(&first_rule), {&states, of_states}, AN_OUTPUT(mean), AN_OUTPUT(out),
        AN_OUTPUT(work)),
    ROW(linearise_by, {&first_rule, of_rule}),
    ROW(predict_sigma_points, A_FILTER, A_PROCESS, AN_OUTPUT(&first_rule), {&first_rule, of_rule}, AN_OUTPUT(work)),
    ROW(update_sigma_points, A_FILTER, A_SENSOR, AN_OUTPUT(&first_rule), {&first_rule, of_rule}, AN_OUTPUT(work)),
    ROW(process_linearise, {&bent.process, of_bent}, A_PROCESS, AN_OUTPUT(A), AN_OUTPUT(out)),
    ROW(sensor_linearise, {&sharp.sensor, of_sharp}, A_SENSOR, AN_OUTPUT(H), AN_OUTPUT(out), AN_OUTPUT(of_noise)),
#endif
};

#ifndef KQ_TEST_Q31
static const row calls_of_em[] = {ROW(em_advance, {&blank_em, of_em}), ROW(em_maximise, {&blank_em, of_em}),
                                  ROW(em_iterate, {&blank_em, of_em})};
#endif

/* Of a tape that has been smoothed, or of which a step has */
static const row records[] = {ROW(consistency_record, {&recent, of_recent}, {&track, of_source})};
static const row readings_of_records[] = {
    ROW(consistency_nis, {&recent, of_recent}, {&quantile, of_quantile}, AN_OUTPUT(&scores[0]), AN_OUTPUT(&scores[1]),
        AN_OUTPUT(&scores[2])),
    ROW(consistency_innovation, {&recent, of_recent}, {&component, of_component}, {&quantile, of_quantile},
        AN_OUTPUT(&scores[0]), AN_OUTPUT(&scores[1]), AN_OUTPUT(&scores[2]), AN_OUTPUT(&scores[3])),
};
static const row showings[] = {ROW(smoothed, AN_OUTPUT(&recorded), {&no_count, of_step}, AN_OUTPUT(&view))};
static const row smoothings[] = {ROW(smooth_step, {&recorded, of_history}, {&motion.process, of_smoothing_process})};

/* Smoothing of a start that has not been recorded is empty, not refused for its arguments. */
static const row of_starts[] = {
    ROW(diffuse_smooth, {&start, of_start}),
    ROW(diffuse_smoothed, {&start, of_start}, {&view, of_nothing}),
    ROW(attach, {&track, of_source}, {&tape.attached, of_recorder}),
};

/* --------------------------------------------------------------------------------- driver */

static void set_up(void)
{
    static const num I3[] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, range[] = {100, 10, 10}, drive_range[] = {5};
    static const num seen[] = {3, 1}, push[] = {2};
    put_process(&motion, 2, 1, range, drive_range, A, B, Q);
    put_process(&other, 2, 1, range, drive_range, A, B, P0);
    put_process(&three, 3, 0, range, drive_range, I3, NULL, I3);
    put_process(&scaled, 2, 1, range, drive_range, A, B, Q);
    put_sensor(&radar, 2, 2, range, range, H, R);
    put_sensor(&coupled, 2, 2, range, range, H, R);
    put_sensor(&gauge3, 3, 2, range, range, I3, R);
    put_independent(&lean, 2, 2, range, range, H, B);
    ASSERT_OK(init_lean(&lean, B));
    differs = *of_innovations(&radar);
    put_prior(&prior, 2, range, x0, P0);
    put_prior(&prior3, 3, range, x0, I3);
    memcpy(z, measured(&radar.sensor, seen), sizeof z);
    memcpy(u, driven(&motion.process, push, 1), sizeof(word));
    for (int k = 0; k < 4; k++) {
        const word bad = bad_word(&radar.sensor, k);
        bad_u[k] = bad;
        memcpy(bad_z[2 * k], z, sizeof z), memcpy(bad_z[2 * k + 1], z, sizeof z);
        bad_z[2 * k][0] = bad_z[2 * k + 1][1] = bad;
    }
    losses[0] = (S(loss)){.kind = &S(loss_huber), .parameter = number(9)};
    losses[1] = (S(loss)){.kind = &S(loss_student), .parameter = number(9)};
    losses[2] = (S(loss)){.kind = &S(loss_jump), .parameter = number(9)};
    losses[GATE] = (S(loss)){.kind = &S(loss_gate), .limit = score_of(9)};
    no_loss = losses[0], no_loss.kind = NULL;
    factor = number(2), lambda = number(0.5);
    quantile = score_of(2), bad_quantile = score_of(-1);
    for (int k = 0; k < 2; k++) {
        row_of_fit[k] = number(1);
        for (int i = 0; i < 2; i++) bad_rows[k][i] = i == k ? bad_entry(k) : number(1);
    }
    for (int t = 0; t < STEPS; t++) scales[t] = number(1);
    for (int k = 0; k < BAD; k++) {
        bad_factors[k] = k < 2 ? number(-2 * k) : k < BAD - 1 ? bad_entry(k - 2) : just_above_1();
        for (int t = 0; t < STEPS; t++) bad_scales[k][t] = t ? number(1) : bad_factors[k];
        for (int l = 0; l < LOSSES; l++) {
            bad_losses[l][k] = losses[k == 2 && l == GATE ? 2 : l];
            bad_losses[l][k].parameter = l < GATE ? bad_factors[k] : number(0.5);
            bad_losses[l][k].limit = score_of(-k);
        }
    }
    rule = usual_rule();
    ASSERT_OK(S(filter_assign)(&twin, 2, twin_memory, COUNT(twin_memory)));
    ASSERT_OK(init_filter(&track, &prior));
    ASSERT_OK(init_filter(&twin, &prior));
    ASSERT_OK(init_filter(&track3, &prior3));
    ASSERT_OK(S(history_assign)(&tape, 2, tape_memory, COUNT(tape_memory)));
    ASSERT_OK(S(history_assign)(&recorded, 2, recorded_memory, COUNT(recorded_memory)));
    ASSERT_OK(S(attach)(&twin, &recorded.attached));
    ASSERT_OK(S(predict)(&twin, &motion.process, u));
    ASSERT_OK(S(gain)(&track, &radar.sensor, gains));
    ASSERT_OK(S(steady_init)(&steady, &motion.process, &radar.sensor, mean, gains, 1));
    ASSERT_OK(S(adaptation_init)(&tuner, &motion.process, &radar.sensor, &rule));
    ASSERT_OK(S(freeze_init)(&calm, 8));
    ASSERT_OK(S(consistency_clear)(&recent));
#ifdef KQ_TEST_Q31
    put_independent(&diagonal, 2, 2, range, range, H, B);
    put_independent(&negative, 2, 2, range, range, H, B);
    negative.noise[0].mantissa = -negative.noise[0].mantissa;
#else
    ASSERT_OK(S(process_assign)(&drift, 2, 3, drift_words, COUNT(drift_words)));
    ASSERT_OK(S(process_assign)(&short_drift, 2, 3, drift_words, COUNT(drift_words) - 1));
    ASSERT_OK(S(process_assign)(&drift_of_one, 2, 1, drift_words, COUNT(drift_words)));
    ASSERT_OK(S(process_assign)(&bent.process, 2, 0, bent.words, COUNT(bent.words)));
    ASSERT_OK(S(sensor_assign)(&sharp.sensor, 2, 2, sharp.words, COUNT(sharp.words)));
    ASSERT_OK(S(sensor_assign)(&diagonal.sensor, 2, 2, diagonal.words, KQ_SENSOR_DIAGONAL_LEN(2)));
#endif
    ASSERT_OK(least_squares_init_of((void *[]){&fit, &track, &lambda, FORMAT}));
    ASSERT_OK(least_squares_init_of((void *[]){&fit_of_nothing, &blank, &lambda, FORMAT}));
    calls_of_rates = 0;
    watch_nothing();
    WATCH(track), WATCH(track_memory), WATCH(twin), WATCH(twin_memory), WATCH(track3), WATCH(bare), WATCH(blank);
    WATCH(z), WATCH(u), WATCH(mean), WATCH(out), WATCH(recorded), WATCH(recorded_memory), WATCH(tape);
    WATCH(steady), WATCH(steady_memory), WATCH(motion.process), WATCH(radar.sensor), WATCH(scaled.process);
    WATCH(other.process), WATCH(coupled.sensor);
    WATCH(scales);
#ifdef KQ_TEST_Q31
    WATCH(root_words), WATCH(diagonal.sensor);
#else
    WATCH(drift);
#endif
}

static void assert_row(const row *r)
{
    void *a[MOST_ARGUMENTS];
    for (int k = 0; k < MOST_ARGUMENTS; k++) a[k] = r->argument[k].good;
    for (int k = 0; k < MOST_ARGUMENTS; k++) {
        for (const way *w = r->argument[k].ways; w && w->status; w++) {
            describe(r->name, "argument", k + 1, "spoiled by", (int)(w - r->argument[k].ways) + 1);
            a[k] = w->value;
            ASSERT_REFUSED(w->status, r->call(a));
        }
        a[k] = r->argument[k].good;
    }
    describe(r->name, "argument", 0, "spoiled by", 0);
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, calls_of_rates, description());
}

static void assert_rows(const row *rows, int count_of_rows, int are_good)
{
    void *a[MOST_ARGUMENTS];
    for (int r = 0; r < count_of_rows; r++) {
        assert_row(&rows[r]);
        for (int k = 0; k < MOST_ARGUMENTS; k++) a[k] = rows[r].argument[k].good;
        if (are_good) ASSERT_OK(rows[r].call(a)); /* the row's own arguments are good */
    }
}

#define ASSERT_ROWS(rows, are_good) assert_rows(rows, COUNT(rows), are_good)

TEST(steps_refuse) { ASSERT_ROWS(steps, 1); }

TEST(every_call_refuses)
{
    for (int r = 0; r < COUNT(calls); r++) {
        set_up();
        WATCH(start), WATCH(start_memory), WATCH(tuner), WATCH(tuner_memory);
#ifndef KQ_TEST_Q31
        WATCH(em), watch(flow_memory, 6 * sizeof(num)); /* A and B; the rest is scratch */
        watch(drift_words, (KQ_PROCESS_LEN(2) + 2 * (2 + 3)) * sizeof(num));
#endif
        assert_rows(&calls[r], 1, 1);
    }
}

#ifndef KQ_TEST_Q31
TEST_FLOAT(em_refuses)
{
    WATCH(blank_em);
    ASSERT_ROWS(calls_of_em, 0);
}
#endif

TEST(recording_refuses)
{
    ASSERT_REFUSED(KQ_ERR_NOT_READY, S(consistency_record)(&recent, &track));
    ASSERT_OK(S(consistency_watch)(&recent, &track, &radar.sensor, z, UINT32_MAX));
    ASSERT_OK(S(update)(&track, &radar.sensor, z));
    ASSERT_ROWS(records, 1);
    ASSERT_ROWS(readings_of_records, 1);
}

TEST(smoothing_refuses_a_process_that_does_not_fit)
{
    ASSERT_OK(S(smooth_step)(&recorded, NULL, NULL));
    ASSERT_ROWS(smoothings, 1);
}

TEST(showing_what_is_smoothed_refuses)
{
    ASSERT_OK(S(smooth)(&recorded));
    ASSERT_ROWS(showings, 1);
}

/* What fits no filter, and what no filter fits */
TEST(attaching_refuses)
{
    static S(history) no_tape;
    static S(lag) no_lag;
    static S(instant) no_instant;
    static S(jacobians) none_kept;
    struct S(attached) *const objects[] = {&tape.attached, &lag.attached, &instant.attached, &tuner.attached,
                                           &calm.attached, &kept.attached};
    struct S(attached) *const unready[] = {&no_tape.attached, &no_lag.attached, &no_instant.attached,
                                           &blank_tuner.attached, &blank_calm.attached, &none_kept.attached};
    WATCH(lag), WATCH(instant), WATCH(tuner), WATCH(calm), WATCH(kept);
    for (int k = 0; k < COUNT(objects); k++) {
        describe("object", "number", k, "", 0);
        ASSERT_REFUSED(KQ_ERR_NULL, S(attach)(NULL, objects[k]));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, S(attach)(&blank, objects[k]));
        ASSERT_REFUSED(KQ_ERR_MISMATCH, S(attach)(&track3, objects[k]));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, S(attach)(&track, unready[k]));
        ASSERT_REFUSED(KQ_ERR_NOT_READY, S(detach)(unready[k]));
        unready[k]->hooks = objects[k]->hooks; /* assigned, it seems; without sizes */
        const int is_tape = k < 3;
        watched_store();
        const kq_status status = S(attach)(&track, unready[k]);
        watched_assert_unchanged(__LINE__);
        TEST_ASSERT_TRUE(is_tape ? status == KQ_ERR_SIZE || status == KQ_ERR_MEMORY : status == KQ_ERR_NOT_READY);
        unready[k]->hooks = NULL;
    }
    ASSERT_REFUSED(KQ_ERR_NULL, S(attach)(&track, NULL));
    ASSERT_REFUSED(KQ_ERR_NULL, S(detach)(NULL));
}

/* What is attached watches the filter's steps, and has changed as little as the filter. */
TEST(steps_refuse_with_a_history_a_lag_or_an_instant)
{
    struct S(attached) *const objects[] = {&tape.attached, &lag.attached, &instant.attached};
    WATCH(tape_memory), WATCH(lag), WATCH(lag_memory), WATCH(instant), WATCH(instant_memory);
    for (int k = 0; k < COUNT(objects); k++) {
        ASSERT_OK(S(attach)(&track, objects[k]));
        ASSERT_ROWS(steps, 1);
        ASSERT_ROWS(steps, 1);
    }
}

TEST(steps_refuse_with_an_adaptation)
{
    WATCH(tuner), WATCH(tuner_memory);
    ASSERT_OK(S(attach)(&track, &tuner.attached));
    for (int k = 0; k < 4; k++) ASSERT_ROWS(steps, 1); /* waiting, and learning */
    ASSERT_ROWS(steps_of_others, 1);
}

/* A refused step does not end it. */
TEST(steps_refuse_with_a_settling)
{
    WATCH(calm), WATCH(calm_memory), WATCH(calm_gain);
    ASSERT_OK(S(attach)(&track, &calm.attached));
    ASSERT_ROWS(steps, 0);
    for (int k = 0; k < 100; k++) ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&calm));
    ASSERT_ROWS(steps, 0);
    ASSERT_OK(S(step)(&track, &motion.process, u, &radar.sensor, z));
    TEST_ASSERT_EQUAL_INT(1, S(freeze_is_active)(&calm));
}

/* All unknown, and nothing */
TEST(steps_and_smoothing_refuse_with_a_start)
{
    WATCH(start), WATCH(start_memory), WATCH(blank_start);
    for (uint32_t unknown = 0; unknown < 4; unknown += 3) {
        ASSERT_OK(S(diffuse_assign)(&start, 2, 0, start_memory, COUNT(start_memory)));
        ASSERT_OK(init_start(&start, &track, &prior, unknown));
        ASSERT_ROWS(of_starts, 0);
        ASSERT_ROWS(steps, 1);
    }
}

SUITE(refusals, set_up)
#include "refusals.tests"
