/* Runs the script that script.h has, on the host or on a chip. */
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include "py/compile.h"
#include "py/gc.h"
#include "py/lexer.h"
#include "py/runtime.h"

static const char script[] = {
#include "script.h"
};

static char heap[48 * 1024] __attribute__((aligned(16)));
static void *stack_top;

/* Roots are on the stack; registers go there first. */
void gc_collect(void)
{
    jmp_buf registers;
    (void)setjmp(registers);
    gc_collect_start();
    gc_collect_root((void **)(void *)&registers, (size_t)((char *)stack_top - (char *)&registers) / sizeof(void *));
    gc_collect_end();
}

void nlr_jump_fail(void *value)
{
    (void)value;
    exit(97);
}

mp_import_stat_t mp_import_stat(const char *path)
{
    (void)path;
    return MP_IMPORT_STAT_NO_EXIST;
}

mp_lexer_t *mp_lexer_new_from_file(const char *path)
{
    (void)path;
    exit(96);
}

static int run(void)
{
    nlr_buf_t nlr;
    if (nlr_push(&nlr)) {
        mp_obj_print_exception(&mp_plat_print, MP_OBJ_FROM_PTR(nlr.ret_val));
        return 1;
    }
    mp_lexer_t *lexer = mp_lexer_new_from_str_len(MP_QSTR__lt_stdin_gt_, script, sizeof script, 0);
    mp_parse_tree_t tree = mp_parse(lexer, MP_PARSE_FILE_INPUT);
    mp_call_function_0(mp_compile(&tree, MP_QSTR__lt_stdin_gt_, MP_EMIT_OPT_NONE, false));
    nlr_pop();
    return 0;
}

int main(void)
{
    int here;
    stack_top = (void *)(((uintptr_t)&here + sizeof(void *) - 1) / sizeof(void *) * sizeof(void *));
    gc_init(heap, heap + sizeof heap);
    mp_init();
    return run();
}
