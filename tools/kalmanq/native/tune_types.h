/* What a run has in one arithmetic: tune.c has its names. */

typedef struct {
    kq_tune *of;
    K(process) *processes;
    K(sensor) sensor;
    K(filter) filter;
    K(diffuse) start;
    K(history) history;
    K(lag) lag;
    K(sequence) q;
    const num *late_z; /* rows as they are measured, where some come late */
    kq_format_q31 formats[3 * KQ_SIZE_MAX]; /* q31: of states, measurements and controls, one after the other */
} K(tuned);
