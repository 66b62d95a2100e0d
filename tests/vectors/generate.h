/* What the three files of the generator share.  Host only. */
#ifndef KALMANQ_GENERATE_H
#define KALMANQ_GENERATE_H

#include "script.h"
#include "vector.h"

enum { ALL_COMPONENTS = -1 };

void begin_case(const char *name, const char *title);

/** `axes` times (position, velocity, ...) of `order` each, driven by white noise of density `noise`
    in the highest derivative */
void make_kinematic(model *M, int axes, int order, double dt, double noise);

/** Its states, process, sensor and prior; the first or another one of a case */
void put_model(const model *M);

/** What is built on the filter (generate_beyond.c, generate_extended.c) */
void case_adaptation(void);
void case_extended(void);
void case_on_line(void);
void case_robust(void);
void case_start(void);
void case_statistics(void);
void case_steady(void);

#endif
