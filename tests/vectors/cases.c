#include "cases.h"

static const int32_t level[] = {
#include "cases/level.inc"
};
static const int32_t velocity[] = {
#include "cases/velocity.inc"
};
static const int32_t acceleration[] = {
#include "cases/acceleration.inc"
};
static const int32_t plane[] = {
#include "cases/plane.inc"
};
static const int32_t dense[] = {
#include "cases/dense.inc"
};
static const int32_t imu[] = {
#include "cases/imu.inc"
};
static const int32_t sixteen[] = {
#include "cases/sixteen.inc"
};
static const int32_t sharp[] = {
#include "cases/sharp.inc"
};
static const int32_t singular[] = {
#include "cases/singular.inc"
};
static const int32_t saturated[] = {
#include "cases/saturated.inc"
};
static const int32_t changing[] = {
#include "cases/changing.inc"
};

#define CASE(name)                                                                                 \
    {                                                                                              \
#name, name, sizeof name / sizeof name[0]                                                  \
    }

const vector_case vector_cases[] = {
    CASE(level),   CASE(velocity), CASE(acceleration), CASE(plane),     CASE(dense),    CASE(imu),
    CASE(sixteen), CASE(sharp),    CASE(singular),     CASE(saturated), CASE(changing),
};

const int vector_case_count = sizeof vector_cases / sizeof vector_cases[0];
