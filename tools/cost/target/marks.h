/* What a program on the target tells the emulator, which watches for these calls. */
#ifndef KALMANQ_COST_MARKS_H
#define KALMANQ_COST_MARKS_H

/** What is measured; also the order of the columns that ask for it. */
enum {
    COST_PREDICT,
    COST_UPDATE,
    COST_STEP,
    COST_LEAN,
    COST_SMOOTH,
    COST_STEADY,
    COST_SWITCH,
    COST_GATED,
    COST_HUBER,
    COST_STUDENT,
    COST_JUMP,
    COST_LAG,
    COST_LAG_STATES,
    COST_POINT,
    COST_ADAPTED,
    COST_EM,
    COST_EM_STATE,
    COST_HARD_UPDATE,
    COST_HARD_STEP,
    COST_HARD_SMOOTH,
    COST_FILTER_CALLS,
    COST_ROOT_CALLS,
    COST_LEAN_CALLS,
    COST_SMOOTHER_CALLS,
    COST_KINDS
};

/** The next call of the function for this region is to be measured, or for ..._CALLS all that
 *  follows until the next mark; of several, the most counts.
 *    region   COST_KINDS * (number of the size in the program) + COST_... */
void cost_region(unsigned region);

/** A call answered an error: nothing of this program counts. */
void cost_failed(int status);

/** All regions are done. */
void cost_end(void);

#endif
