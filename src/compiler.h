/* The one thing that C11 cannot say: keep a function's large scratch array off the stack of
   its caller.  Without it the library is as right, and its stack is deeper. */
#ifndef KALMANQ_COMPILER_H
#define KALMANQ_COMPILER_H

#if defined(__GNUC__)
#define KQ_NOINLINE __attribute__((noinline))
#else
#define KQ_NOINLINE
#endif

#endif
