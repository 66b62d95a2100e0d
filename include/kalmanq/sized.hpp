// kalmanq in C++11 and later: objects whose sizes are template parameters, in float or double.  Optional.
//
//     kalmanq::Process<float, 2> motion;             // 2 states; Process<float, 2, 1>: and 1 control
//     kalmanq::Sensor<float, 2, 1> ranger;           // 2 states, 1 component
//     kalmanq::Filter<float, 2> cart;
//     status = motion.init(A, Q);                    // named arrays of 4 numbers, or it does not compile
//     status = cart.step(motion, ranger, z);         // float z[1], or of a row of measurements &z[t]
//
// An object is C's, with its memory: every function of C takes its address, kq_sigma(&cart, 0).  A member function is one
// call of C.  Static objects are initialised as those of KQ_FILTER_F32: by the linker, without a constructor that runs.
// The objects are not copied: kq_filter_copy_f32 does that.  The manual is the header of the function in C.
#ifndef KALMANQ_SIZED_HPP
#define KALMANQ_SIZED_HPP

#include "generic.h"

namespace kalmanq {

namespace c {
template <typename T> struct of;
template <> struct of<float> {
    typedef kq_process_f32 process;
    typedef kq_sensor_f32 sensor;
    typedef kq_filter_f32 filter;
    static constexpr int filter_length(int n) { return KQ_FILTER_LEN_F32(n); }
    static kq_status diagonal(sensor *s, const float *H, const float *r) { return kq_sensor_init_diagonal_f32(s, H, r); }
    static kq_status lean(sensor *s, const float *H, const float *r) { return kq_sensor_init_lean_f32(s, H, r); }
};
template <> struct of<double> {
    typedef kq_process_f64 process;
    typedef kq_sensor_f64 sensor;
    typedef kq_filter_f64 filter;
    static constexpr int filter_length(int n) { return KQ_FILTER_LEN_F64(n); }
    static kq_status diagonal(sensor *s, const double *H, const double *r) { return kq_sensor_init_diagonal_f64(s, H, r); }
    static kq_status lean(sensor *s, const double *H, const double *r) { return kq_sensor_init_lean_f64(s, H, r); }
};
constexpr bool is_size(int n) { return n >= 1 && n <= KQ_SIZE_MAX; }

/* What points at a number, as &z[t]; an array does not become one, so its length is checked */
template <typename T> struct number {
    const T *at;
    template <typename P> number(P *const &pointer) : at(pointer) {}
};
}

template <typename T, int N, int L = 0> struct Process : c::of<T>::process {
    static_assert(c::is_size(N) && (L == 0 || c::is_size(L)), "1 to 16 states, 0 to 16 controls");
    constexpr Process()
        : c::of<T>::process{N, L, KQ_PROCESS_LEN(N), memory_, nullptr, nullptr, nullptr, {0}, 0, 0, 0}, memory_{} {}
    Process(const Process &) = delete;
    Process &operator=(const Process &) = delete;

    /* A and B are kept by reference: no temporary arrays */
    kq_status init(const T (&&A)[N * N], const T (&Q)[N * N]) = delete;
    kq_status init(const T (&&A)[N * N], const T (&B)[L ? N * L : 1], const T (&Q)[N * N]) = delete;
    kq_status init(const T (&A)[N * N], const T (&&B)[L ? N * L : 1], const T (&Q)[N * N]) = delete;
    KQ_NODISCARD kq_status init(const T (&A)[N * N], const T (&Q)[N * N])
    {
        static_assert(L == 0, "a process with controls: init(A, B, Q)");
        return kq_process_init(this, A, nullptr, Q);
    }
    KQ_NODISCARD kq_status init(const T (&A)[N * N], const T (&B)[L ? N * L : 1], const T (&Q)[N * N])
    {
        static_assert(L > 0, "a process without controls: init(A, Q)");
        return kq_process_init(this, A, B, Q);
    }

  private:
    T memory_[KQ_PROCESS_LEN(N)];
};

template <typename T, int N, int M> struct Sensor : c::of<T>::sensor {
    static_assert(c::is_size(N) && c::is_size(M), "1 to 16 states, 1 to 16 components");
    constexpr Sensor()
        : c::of<T>::sensor{N, M, KQ_SENSOR_LEN(M), 0, memory_, nullptr, nullptr, nullptr, {0}, 0, 0, 0, nullptr}, memory_{} {}
    Sensor(const Sensor &) = delete;
    Sensor &operator=(const Sensor &) = delete;

    /* H is kept by reference: no temporary array */
    kq_status init(const T (&&H)[M * N], const T (&R)[M * M]) = delete;
    kq_status init_diagonal(const T (&&H)[M * N], const T (&r)[M]) = delete;
    kq_status init_lean(const T (&&H)[M * N], const T (&r)[M]) = delete;
    KQ_NODISCARD kq_status init(const T (&H)[M * N], const T (&R)[M * M]) { return kq_sensor_init(this, H, R); }
    KQ_NODISCARD kq_status init_diagonal(const T (&H)[M * N], const T (&r)[M]) { return c::of<T>::diagonal(this, H, r); }
    KQ_NODISCARD kq_status init_lean(const T (&H)[M * N], const T (&r)[M]) { return c::of<T>::lean(this, H, r); }

  private:
    T memory_[KQ_SENSOR_LEN(M)];
};

template <typename T, int N> struct Filter : c::of<T>::filter {
    static_assert(c::is_size(N), "1 to 16 states");
    constexpr Filter()
        : c::of<T>::filter{N, 0, 0, 0, 0, 0, memory_, nullptr, 0, 0, {0, 0, 0, 0}, {{0, 0, 0}, 0, 0, 0}}, memory_{} {}
    Filter(const Filter &) = delete;
    Filter &operator=(const Filter &) = delete;

    KQ_NODISCARD kq_status init(const T (&x0)[N], const T (&P0)[N * N]) { return kq_filter_init(this, x0, P0); }
    KQ_NODISCARD kq_status predict(const Process<T, N> &p) { return kq_predict(this, &p, nullptr); }
    template <int L> KQ_NODISCARD kq_status predict(const Process<T, N, L> &p, const T (&u)[L])
    {
        return kq_predict(this, &p, u);
    }
    template <int M> KQ_NODISCARD kq_status update(const Sensor<T, N, M> &s, const T (&z)[M]) { return kq_update(this, &s, z); }
    KQ_NODISCARD kq_status update(const Sensor<T, N, 1> &s, c::number<T> z) { return kq_update(this, &s, z.at); }
    template <int M> KQ_NODISCARD kq_status update_subset(const Sensor<T, N, M> &s, const T (&z)[M], uint32_t present)
    {
        return kq_update_subset(this, &s, z, present);
    }
    template <int M> KQ_NODISCARD kq_status step(const Process<T, N> &p, const Sensor<T, N, M> &s, const T (&z)[M])
    {
        return kq_step(this, &p, nullptr, &s, z);
    }
    KQ_NODISCARD kq_status step(const Process<T, N> &p, const Sensor<T, N, 1> &s, c::number<T> z)
    {
        return kq_step(this, &p, nullptr, &s, z.at);
    }
    template <int L, int M> KQ_NODISCARD kq_status step(const Process<T, N, L> &p, const T (&u)[L],
        const Sensor<T, N, M> &s, const T (&z)[M])
    {
        return kq_step(this, &p, u, &s, z);
    }
    template <int L> KQ_NODISCARD kq_status step(const Process<T, N, L> &p, const T (&u)[L], const Sensor<T, N, 1> &s, c::number<T> z)
    {
        return kq_step(this, &p, u, &s, z.at);
    }
    template <int M> KQ_NODISCARD kq_status innovation(const Sensor<T, N, M> &s, const T (&z)[M], T (&e)[M]) const
    {
        return kq_innovation(this, &s, z, e);
    }
    KQ_NODISCARD kq_status covariance(T (&P)[N * N]) const { return kq_covariance(this, P); }

  private:
    T memory_[c::of<T>::filter_length(N)];
};

}
#endif
