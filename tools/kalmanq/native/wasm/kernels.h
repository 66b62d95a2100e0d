/* The library's own predict and update, and steps of the mean alone for any sizes: a page is a tenth as long as with
   functions of compile-time sizes.  kernels_<T>.c has the names. */
static int calm_any(const T(kq_calm) *k, filter *f, const process *p, const num *u, const sensor *s, const num *z, num *e)
{
    return calm_step(k, f, p, u, s, z, e, f->states, s->components);
}

T(kq_kernels) T(kq_kernels_for)(int n, int m, int is_upper)
{
    (void)n, (void)m, (void)is_upper;
    return (T(kq_kernels)){T(kq_predict), T(kq_update), calm_any};
}
