/*
 * kalmanq for MicroPython, in f32: Process(A, Q, B=None), Sensor(H, R), Filter(x0, P0).  README.md has their calls.
 *
 * Vectors are lists or tuples of numbers, matrices lists of rows.  A refused call raises ValueError and changes nothing.
 */
#include <string.h>

#include "py/obj.h"
#include "py/runtime.h"

#include "kalmanq/filter.h"

#ifndef MP_ERROR_TEXT /* before MicroPython 1.13 */
#define MP_ERROR_TEXT(text) (text)
#endif

/* The collector keeps a block that something points to the beginning of: A, B, H, R and memory are blocks of their own,
   and the C objects have these pointers; `kept` has them where C moves into the block. */
typedef struct { mp_obj_base_t base; kq_process_f32 process; float *kept; } process_object;
typedef struct { mp_obj_base_t base; kq_sensor_f32 sensor; float *kept; } sensor_object;
typedef struct { mp_obj_base_t base; kq_filter_f32 filter; float *kept; } filter_object;

extern const mp_obj_type_t kalmanq_process_type, kalmanq_sensor_type, kalmanq_filter_type;

static void require(kq_status status)
{
    if (status < KQ_OK)
        nlr_raise(mp_obj_new_exception_msg_varg(&mp_type_ValueError, MP_ERROR_TEXT("%s"), kq_status_text(status)));
}

static void *object_of(mp_obj_t o, const mp_obj_type_t *type, const char *name)
{
    if (mp_obj_get_type(o) != type)
        nlr_raise(mp_obj_new_exception_msg_varg(&mp_type_TypeError, MP_ERROR_TEXT("a kalmanq.%s is needed"), name));
    return MP_OBJ_TO_PTR(o);
}

static int length_of(mp_obj_t o)
{
    return mp_obj_get_int(mp_obj_len(o));
}

/* 1 to 16 elements: no size is so large that memory for it could wrap */
static int size_of(mp_obj_t o)
{
    const int length = length_of(o);
    if (length < 1 || length > KQ_SIZE_MAX) require(KQ_ERR_SIZE);
    return length;
}

static void read_vector(mp_obj_t o, int length, float *to)
{
    mp_obj_t *items;
    size_t found;
    mp_obj_get_array(o, &found, &items);
    if (found != (size_t)length)
        nlr_raise(mp_obj_new_exception_msg_varg(&mp_type_ValueError, MP_ERROR_TEXT("%d numbers where %d are needed"),
            (int)found, length));
    for (int i = 0; i < length; i++) to[i] = (float)mp_obj_get_float(items[i]);
}

static float *read_matrix(mp_obj_t o, int rows, int columns)
{
    float *matrix = m_new(float, (size_t)rows * (size_t)columns);
    mp_obj_t *items;
    size_t found;
    mp_obj_get_array(o, &found, &items);
    if (found != (size_t)rows)
        nlr_raise(mp_obj_new_exception_msg_varg(&mp_type_ValueError, MP_ERROR_TEXT("%d rows where %d are needed"),
            (int)found, rows));
    for (int i = 0; i < rows; i++) read_vector(items[i], columns, matrix + i * columns);
    return matrix;
}

static int columns_of(mp_obj_t matrix)
{
    mp_obj_t *rows;
    size_t count;
    mp_obj_get_array(matrix, &count, &rows);
    if (count == 0) require(KQ_ERR_SIZE);
    return size_of(rows[0]);
}

static mp_obj_t vector(int n, const float *from)
{
    mp_obj_t items[KQ_SIZE_MAX];
    for (int i = 0; i < n; i++) items[i] = mp_obj_new_float((mp_float_t)from[i]);
    return mp_obj_new_tuple((size_t)n, items);
}

static mp_obj_t process_make_new(const mp_obj_type_t *type, size_t n_args, size_t n_kw, const mp_obj_t *args)
{
    mp_arg_check_num(n_args, n_kw, 2, 3, false);
    const int has_control = n_args > 2 && args[2] != mp_const_none;
    const int n = size_of(args[0]), l = has_control ? columns_of(args[2]) : 0;
    const size_t length = KQ_PROCESS_LEN((size_t)n);
    const float *A = read_matrix(args[0], n, n), *Q = read_matrix(args[1], n, n);
    const float *B = has_control ? read_matrix(args[2], n, l) : NULL;
    process_object *self = m_new_obj(process_object);
    memset(self, 0, sizeof *self);
    self->base.type = type;
    self->kept = m_new(float, length);
    require(kq_process_assign_f32(&self->process, n, l, self->kept, length));
    require(kq_process_init_f32(&self->process, A, B, Q));
    return MP_OBJ_FROM_PTR(self);
}

static mp_obj_t sensor_make_new(const mp_obj_type_t *type, size_t n_args, size_t n_kw, const mp_obj_t *args)
{
    mp_arg_check_num(n_args, n_kw, 2, 2, false);
    const int m = size_of(args[0]), n = columns_of(args[0]);
    const size_t length = KQ_SENSOR_LEN((size_t)m);
    const float *H = read_matrix(args[0], m, n), *R = read_matrix(args[1], m, m);
    sensor_object *self = m_new_obj(sensor_object);
    memset(self, 0, sizeof *self);
    self->base.type = type;
    self->kept = m_new(float, length);
    require(kq_sensor_assign_f32(&self->sensor, n, m, self->kept, length));
    require(kq_sensor_init_f32(&self->sensor, H, R));
    return MP_OBJ_FROM_PTR(self);
}

static mp_obj_t filter_make_new(const mp_obj_type_t *type, size_t n_args, size_t n_kw, const mp_obj_t *args)
{
    mp_arg_check_num(n_args, n_kw, 2, 2, false);
    const int n = size_of(args[0]);
    const size_t length = KQ_FILTER_LEN_F32((size_t)n);
    float x0[KQ_SIZE_MAX];
    read_vector(args[0], n, x0);
    const float *P0 = read_matrix(args[1], n, n);
    filter_object *self = m_new_obj(filter_object);
    memset(self, 0, sizeof *self);
    self->base.type = type;
    self->kept = m_new(float, length);
    require(kq_filter_assign_f32(&self->filter, n, self->kept, length));
    require(kq_filter_init_f32(&self->filter, x0, P0));
    return MP_OBJ_FROM_PTR(self);
}

static kq_filter_f32 *filter_of(mp_obj_t self)
{
    return &((filter_object *)MP_OBJ_TO_PTR(self))->filter;
}

static const kq_process_f32 *process_of(mp_obj_t o)
{
    return &((process_object *)object_of(o, &kalmanq_process_type, "Process"))->process;
}

static const kq_sensor_f32 *sensor_of(mp_obj_t o)
{
    return &((sensor_object *)object_of(o, &kalmanq_sensor_type, "Sensor"))->sensor;
}

/* The controls of a process, or NULL for None */
static const float *controls(const kq_process_f32 *p, mp_obj_t o, float *u)
{
    if (o == mp_const_none) return NULL;
    read_vector(o, p->controls, u);
    return u;
}

/* predict(process, u=None) */
static mp_obj_t filter_predict(size_t n_args, const mp_obj_t *args)
{
    float u[KQ_SIZE_MAX];
    const kq_process_f32 *p = process_of(args[1]);
    require(kq_predict_f32(filter_of(args[0]), p, controls(p, n_args > 2 ? args[2] : mp_const_none, u)));
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_VAR_BETWEEN(filter_predict_obj, 2, 3, filter_predict);

/* update(sensor, z): None in z is a component that is missing */
static mp_obj_t filter_update(mp_obj_t self, mp_obj_t sensor, mp_obj_t measured)
{
    const kq_sensor_f32 *s = sensor_of(sensor);
    float z[KQ_SIZE_MAX] = {0};
    uint32_t present = 0;
    mp_obj_t *items;
    size_t found;
    mp_obj_get_array(measured, &found, &items);
    if (found != s->components) require(KQ_ERR_MISMATCH);
    for (size_t c = 0; c < found; c++) {
        if (items[c] == mp_const_none) continue;
        z[c] = (float)mp_obj_get_float(items[c]);
        present |= UINT32_C(1) << c;
    }
    require(kq_update_subset_f32(filter_of(self), s, z, present));
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_3(filter_update_obj, filter_update);

/* step(process, sensor, z, u=None): predict, then update; if one is refused, neither is done */
static mp_obj_t filter_step(size_t n_args, const mp_obj_t *args)
{
    float u[KQ_SIZE_MAX], z[KQ_SIZE_MAX];
    const kq_process_f32 *p = process_of(args[1]);
    const kq_sensor_f32 *s = sensor_of(args[2]);
    read_vector(args[3], s->components, z);
    require(kq_step_f32(filter_of(args[0]), p, controls(p, n_args > 4 ? args[4] : mp_const_none, u), s, z));
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_VAR_BETWEEN(filter_step_obj, 4, 5, filter_step);

static mp_obj_t filter_mean(mp_obj_t self)
{
    float mean[KQ_SIZE_MAX];
    const int n = filter_of(self)->states;
    for (int i = 0; i < n; i++) mean[i] = kq_mean_f32(filter_of(self), i);
    return vector(n, mean);
}
static MP_DEFINE_CONST_FUN_OBJ_1(filter_mean_obj, filter_mean);

static mp_obj_t filter_sigma(mp_obj_t self)
{
    float sigma[KQ_SIZE_MAX];
    const int n = filter_of(self)->states;
    for (int i = 0; i < n; i++) sigma[i] = kq_sigma_f32(filter_of(self), i);
    return vector(n, sigma);
}
static MP_DEFINE_CONST_FUN_OBJ_1(filter_sigma_obj, filter_sigma);

static mp_obj_t filter_covariance(mp_obj_t self)
{
    const int n = filter_of(self)->states;
    float *P = m_new(float, (size_t)n * (size_t)n);
    mp_obj_t rows[KQ_SIZE_MAX];
    require(kq_covariance_f32(filter_of(self), P));
    for (int i = 0; i < n; i++) rows[i] = vector(n, P + i * n);
    return mp_obj_new_tuple((size_t)n, rows);
}
static MP_DEFINE_CONST_FUN_OBJ_1(filter_covariance_obj, filter_covariance);

/* events(): the bits since the last call, which clears them */
static mp_obj_t filter_events(mp_obj_t self)
{
    const unsigned events = kq_events_f32(filter_of(self));
    kq_events_clear_f32(filter_of(self));
    return mp_obj_new_int_from_uint(events);
}
static MP_DEFINE_CONST_FUN_OBJ_1(filter_events_obj, filter_events);

static const mp_rom_map_elem_t filter_table[] = {
    {MP_ROM_QSTR(MP_QSTR_predict), MP_ROM_PTR(&filter_predict_obj)},
    {MP_ROM_QSTR(MP_QSTR_update), MP_ROM_PTR(&filter_update_obj)},
    {MP_ROM_QSTR(MP_QSTR_step), MP_ROM_PTR(&filter_step_obj)},
    {MP_ROM_QSTR(MP_QSTR_mean), MP_ROM_PTR(&filter_mean_obj)},
    {MP_ROM_QSTR(MP_QSTR_sigma), MP_ROM_PTR(&filter_sigma_obj)},
    {MP_ROM_QSTR(MP_QSTR_covariance), MP_ROM_PTR(&filter_covariance_obj)},
    {MP_ROM_QSTR(MP_QSTR_events), MP_ROM_PTR(&filter_events_obj)},
};
static MP_DEFINE_CONST_DICT(filter_dict, filter_table);

#ifdef MP_DEFINE_CONST_OBJ_TYPE /* from MicroPython 1.20 on */
MP_DEFINE_CONST_OBJ_TYPE(kalmanq_process_type, MP_QSTR_Process, MP_TYPE_FLAG_NONE, make_new, process_make_new);
MP_DEFINE_CONST_OBJ_TYPE(kalmanq_sensor_type, MP_QSTR_Sensor, MP_TYPE_FLAG_NONE, make_new, sensor_make_new);
MP_DEFINE_CONST_OBJ_TYPE(kalmanq_filter_type, MP_QSTR_Filter, MP_TYPE_FLAG_NONE, make_new, filter_make_new,
    locals_dict, &filter_dict);
#else
const mp_obj_type_t kalmanq_process_type = {
    .base = {&mp_type_type}, .name = MP_QSTR_Process, .make_new = process_make_new};
const mp_obj_type_t kalmanq_sensor_type = {
    .base = {&mp_type_type}, .name = MP_QSTR_Sensor, .make_new = sensor_make_new};
const mp_obj_type_t kalmanq_filter_type = {
    .base = {&mp_type_type}, .name = MP_QSTR_Filter, .make_new = filter_make_new,
    .locals_dict = (mp_obj_dict_t *)&filter_dict};
#endif

static const mp_rom_map_elem_t kalmanq_table[] = {
    {MP_ROM_QSTR(MP_QSTR___name__), MP_ROM_QSTR(MP_QSTR_kalmanq)},
    {MP_ROM_QSTR(MP_QSTR_Process), MP_ROM_PTR(&kalmanq_process_type)},
    {MP_ROM_QSTR(MP_QSTR_Sensor), MP_ROM_PTR(&kalmanq_sensor_type)},
    {MP_ROM_QSTR(MP_QSTR_Filter), MP_ROM_PTR(&kalmanq_filter_type)},
};
static MP_DEFINE_CONST_DICT(kalmanq_dict, kalmanq_table);

extern const mp_obj_module_t kalmanq_module;
const mp_obj_module_t kalmanq_module = {.base = {&mp_type_module}, .globals = (mp_obj_dict_t *)&kalmanq_dict};

#ifdef MP_REGISTER_MODULE
MP_REGISTER_MODULE(MP_QSTR_kalmanq, kalmanq_module);
#endif
