/* The library's own predict and update, and steps of the mean alone for any sizes: a page is a tenth as long as with
   functions of compile-time sizes.  kernels_<T>.c has the names. */
T(kq_kernels) T(kq_kernels_for)(int n, int m, int is_upper)
{
    (void)n, (void)m, (void)is_upper;
    return (T(kq_kernels)){T(kq_predict), T(kq_update), T(kq_calm_any)};
}
