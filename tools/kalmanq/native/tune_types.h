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
    kq_format_q31 formats[3 * KQ_SIZE_MAX]; /* q31: of states, measurements and controls, one after the other */
} K(tuned);
