/* A process and a sensor as the macros of constant ones have them (KQ_PROCESS_TABLE, KQ_SENSOR_TABLE_<T>): their arrays
   stay; what only init finds out is left out. */
#ifndef KALMANQ_NATIVE_TABLES_H
#define KALMANQ_NATIVE_TABLES_H

#include "kalmanq/kalmanq.h"

void kq_process_as_table_f32(kq_process_f32 *p);
void kq_process_as_table_f64(kq_process_f64 *p);
void kq_process_as_table_q31(kq_process_q31 *p);
void kq_sensor_as_table_f32(kq_sensor_f32 *s, int is_lean);
void kq_sensor_as_table_f64(kq_sensor_f64 *s, int is_lean);
void kq_sensor_as_table_q31(kq_sensor_q31 *s, int is_lean);

#endif
