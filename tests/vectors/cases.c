#include "cases.h"
#include "flash.h"

#if defined(VECTOR_F32)
static const int32_t filter_f32[] FLASH = {
#include "cases/filter_f32.inc"
};
static const int32_t beyond_f32[] FLASH = {
#include "cases/beyond_f32.inc"
};
static const int32_t nonlinear_f32[] FLASH = {
#include "cases/nonlinear_f32.inc"
};
#elif defined(VECTOR_F64)
static const int32_t filter_f64[] FLASH = {
#include "cases/filter_f64.inc"
};
static const int32_t beyond_f64[] FLASH = {
#include "cases/beyond_f64.inc"
};
static const int32_t nonlinear_f64[] FLASH = {
#include "cases/nonlinear_f64.inc"
};
#else
static const int32_t level[] FLASH = {
#include "cases/level.inc"
};
static const int32_t extended[] FLASH = {
#include "cases/extended.inc"
};
static const int32_t velocity[] FLASH = {
#include "cases/velocity.inc"
};
static const int32_t acceleration[] FLASH = {
#include "cases/acceleration.inc"
};
static const int32_t plane[] FLASH = {
#include "cases/plane.inc"
};
static const int32_t dense[] FLASH = {
#include "cases/dense.inc"
};
static const int32_t imu[] FLASH = {
#include "cases/imu.inc"
};
static const int32_t sixteen[] FLASH = {
#include "cases/sixteen.inc"
};
static const int32_t sharp[] FLASH = {
#include "cases/sharp.inc"
};
static const int32_t singular[] FLASH = {
#include "cases/singular.inc"
};
static const int32_t saturated[] FLASH = {
#include "cases/saturated.inc"
};
static const int32_t changing[] FLASH = {
#include "cases/changing.inc"
};
static const int32_t adaptation[] FLASH = {
#include "cases/adaptation.inc"
};
static const int32_t on_line[] FLASH = {
#include "cases/on_line.inc"
};
static const int32_t robust[] FLASH = {
#include "cases/robust.inc"
};
static const int32_t start[] FLASH = {
#include "cases/start.inc"
};
static const int32_t statistics[] FLASH = {
#include "cases/statistics.inc"
};
static const int32_t steady[] FLASH = {
#include "cases/steady.inc"
};
#endif

#define CASE(name)                                                                                 \
    {                                                                                              \
#name, name, sizeof name / sizeof name[0]                                                  \
    }

const vector_case vector_cases[] = {
#if defined(VECTOR_F32)
    CASE(filter_f32), CASE(beyond_f32), CASE(nonlinear_f32),
#elif defined(VECTOR_F64)
    CASE(filter_f64), CASE(beyond_f64), CASE(nonlinear_f64),
#else
    CASE(level),      CASE(velocity),   CASE(acceleration), CASE(plane),    CASE(dense),
    CASE(imu),        CASE(sixteen),    CASE(sharp),        CASE(singular), CASE(saturated),
    CASE(changing),   CASE(adaptation), CASE(on_line),      CASE(robust),   CASE(start),
    CASE(statistics), CASE(steady),     CASE(extended),
#endif
};

const int vector_case_count = sizeof vector_cases / sizeof vector_cases[0];
