/* MicroPython 1.9 as small as it gets, for a program that runs one script: the module of port/micropython in it. */
#include <alloca.h>
#include <stdint.h>

#define MICROPY_ALLOC_PATH_MAX (64)
#define MICROPY_ENABLE_COMPILER (1)
#define MICROPY_ENABLE_GC (1)
#define MICROPY_ERROR_REPORTING (MICROPY_ERROR_REPORTING_NORMAL)
#define MICROPY_FLOAT_IMPL (MICROPY_FLOAT_IMPL_FLOAT)
#define MICROPY_LONGINT_IMPL (MICROPY_LONGINT_IMPL_NONE)
#define MICROPY_NLR_SETJMP (1)
#define MICROPY_PY_GC (1)
#define MICROPY_PY_STRUCT (1)
#define MICROPY_PY_IO (0)
#define MICROPY_PY_SYS (0)
#define MICROPY_PY_BUILTINS_COMPLEX (0)
#define MICROPY_PY_ASYNC_AWAIT (0)
#define MP_STATE_PORT MP_STATE_VM

typedef intptr_t mp_int_t;
typedef uintptr_t mp_uint_t;
typedef long mp_off_t;
#define UINT_FMT "%lu"
#define INT_FMT "%ld"

#include <stdio.h>
#define MP_PLAT_PRINT_STRN(text, length) fwrite(text, 1, length, stdout)

extern const struct _mp_obj_module_t kalmanq_module;
#define MICROPY_PORT_BUILTIN_MODULES {MP_ROM_QSTR(MP_QSTR_kalmanq), MP_ROM_PTR(&kalmanq_module)},
