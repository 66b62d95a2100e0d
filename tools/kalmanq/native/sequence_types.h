/* A sequence and what is asked of it, in one arithmetic, which has its names */

typedef struct {
    K(filter) *filter;
    const K(process) *process;
    const K(sensor) *sensor;
    const K(process) *const *processes; /* steps: of the predict before each row; NULL: process */
    const K(sensor) *const *sensors;    /* steps: of each row; NULL: sensor */
    size_t steps;
    const num *z; /* steps x m; missing: NaN, in q31 not a word */
    const num *u; /* steps x l: row t is of the predict before row t; NULL: no control */
    int is_upper;            /* A has nothing below its diagonal */
    int begins;              /* the filter stands at row 0: no predict before it */
    K(loss) *losses;       /* of every update: one or, of gates, one for each sensor; NULL: none */
    const uint32_t *measured; /* by each of these: bits of z */
    size_t losses_count;
    const score *limits;   /* of gates, for 1 .. m components of a sensor; NULL: of another loss */
    K(process) *target;    /* of the weights */
    const number *weights; /* steps: the predict before row t has weights[t] Q, by the target; NULL: Q */
    int32_t *root;         /* q31: of the target's noise */
    K(lag) *lag;           /* attached as soon as the filter is ready, or NULL */
    int lag_follows;       /* read and written: is it attached? */
    size_t age;            /* of what is asked of it */
    K(instant) *instant;      /* attached after row `instant_row` of this call, or NULL */
    size_t instant_row;
    int instant_follows;     /* read and written */
    K(freeze) *settling; /* attached as soon as the filter is ready, or NULL */
    int is_settling;       /* read and written: is it attached? */
    K(consistency) *watch; /* of every update, or NULL */
    K(adaptation) *adaptation; /* attached to the filter, or NULL: its scales are wanted */
    /* Results, a row a step; each may be NULL.  What is not to be had is NaN, in q31 not a word. */
    num *mean, *mean_low, *sigma; /* n, after the update */
    number *variance;             /* n, as sigma; what a sigma's word cannot say */
    number *covariance;           /* n x n */
    num *innovation;              /* m, before it */
    number *innovation_variance;  /* m */
    score *nis, *log_likelihood;  /* of this step; where nothing was taken none, and 0 */
    int32_t *taken;
    num *lagged, *lagged_low, *lagged_sigma;   /* n, of `age` rows before */
    number *lagged_variance;                   /* n */
    num *instant_mean, *instant_low, *instant_sigma; /* n, of the point's row */
    number *instant_variance;                    /* n */
    number *instant_covariance;                  /* n x n */
    number *scales;                            /* 2: of Q and R */
    uint8_t *settled;                          /* did the step move the mean alone? */
    double *widest; /* n, read and written: of each state the largest variance before an update */
    size_t done, rested; /* written: rows that were done, and how many of them moved the mean alone in a cycle of roots */
} K(sequence);

/* Predict and update for every row.  Answers the first status that is not KQ_OK, of the row `done`. */
kq_status K(sequence_run)(K(sequence) *q);

/* The state at so many rows of a smoothed history, from `first` on: n numbers a row each, and n x n; each may be NULL. */
kq_status K(history_read)(const K(history) *h, size_t first, size_t steps, num *mean, num *mean_low, num *sigma,
                          number *variance, number *covariance);

/* The same of a start whose history has been smoothed by kq_diffuse_smooth. */
kq_status K(diffuse_read)(const K(diffuse) *s, size_t first, size_t steps, num *mean, num *mean_low, num *sigma,
                        number *variance, number *covariance);

/* Predict and update of a filter of constant gain; what is not present has to be all of a row. */
kq_status K(steady_run)(K(steady) *filter, size_t steps, const num *z, const uint32_t *present,
                        const num *u, int begins, num *mean, num *innovation, size_t *done);

/* A row of least squares after another: H is steps x n, z and r are steps.  Results may be NULL. */
kq_status K(least_squares_run)(K(least_squares) *fit, size_t steps, const number *H, const num *z,
                               const number *r, num *mean, num *mean_low, num *sigma, number *variance,
                               score *nis, score *log_likelihood, int32_t *taken, size_t *done);
