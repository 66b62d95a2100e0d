//! The arithmetics, and which C functions each has.

use crate::sys;
use core::ffi::{c_int, c_uint};

/// `f32`, `f64`, or `i32`: a raw value of the q31 arithmetic.
pub trait Number: Calls {}
impl Number for f32 {}
impl Number for f64 {}
impl Number for i32 {}

/// `f32` or `f64`.
pub trait Float: Number + FloatCalls {}
impl Float for f32 {}
impl Float for f64 {}

/// A row a call: its name here, its arguments, its name in C by arithmetic.
macro_rules! calls {
    ($($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?, $f32:ident, $f64:ident, $q31:ident;)*) => {
        pub trait Calls: Copy + 'static {
            const ZERO: Self;
            const ZERO_ENTRY: Self::Entry;
            /// An entry of a covariance.
            type Entry: Copy;
            /// NIS and log-likelihoods.
            type Score;
            type Process;
            type Sensor;
            type Filter;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)?;)*
        }

        impl Calls for f32 {
            const ZERO: Self = 0.0;
            const ZERO_ENTRY: Self = 0.0;
            type Entry = Self;
            type Score = Self;
            type Process = sys::kq_process_f32;
            type Sensor = sys::kq_sensor_f32;
            type Filter = sys::kq_filter_f32;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)? { unsafe { sys::$f32($($argument),*) } })*
        }

        impl Calls for f64 {
            const ZERO: Self = 0.0;
            const ZERO_ENTRY: Self = 0.0;
            type Entry = Self;
            type Score = Self;
            type Process = sys::kq_process_f64;
            type Sensor = sys::kq_sensor_f64;
            type Filter = sys::kq_filter_f64;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)? { unsafe { sys::$f64($($argument),*) } })*
        }

        impl Calls for i32 {
            const ZERO: Self = 0;
            const ZERO_ENTRY: sys::kq_scaled_q31 = sys::kq_scaled_q31 { mantissa: 0, exponent: 0 };
            type Entry = sys::kq_scaled_q31;
            type Score = i64;
            type Process = sys::kq_process_q31;
            type Sensor = sys::kq_sensor_q31;
            type Filter = sys::kq_filter_q31;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)? { unsafe { sys::$q31($($argument),*) } })*
        }
    };
}

/// The same of calls that floating point alone has.
macro_rules! float_calls {
    ($($name:ident($($argument:ident: $type:ty),*), $f32:ident, $f64:ident;)*) => {
        pub trait FloatCalls: Calls {
            $(unsafe fn $name($($argument: $type),*) -> c_int;)*
        }

        impl FloatCalls for f32 {
            $(unsafe fn $name($($argument: $type),*) -> c_int { unsafe { sys::$f32($($argument),*) } })*
        }

        impl FloatCalls for f64 {
            $(unsafe fn $name($($argument: $type),*) -> c_int { unsafe { sys::$f64($($argument),*) } })*
        }
    };
}

calls! {
    filter_assign(f: &mut Self::Filter, n: c_int, memory: *mut Self, length: usize) -> c_int,
        kq_filter_assign_f32, kq_filter_assign_f64, kq_filter_assign_q31;
    predict(f: &mut Self::Filter, p: &Self::Process, u: *const Self) -> c_int,
        kq_predict_f32, kq_predict_f64, kq_predict_q31;
    update(f: &mut Self::Filter, s: &Self::Sensor, z: *const Self) -> c_int,
        kq_update_f32, kq_update_f64, kq_update_q31;
    update_subset(f: &mut Self::Filter, s: &Self::Sensor, z: *const Self, present: u32) -> c_int,
        kq_update_subset_f32, kq_update_subset_f64, kq_update_subset_q31;
    step(f: &mut Self::Filter, p: &Self::Process, u: *const Self, s: &Self::Sensor, z: *const Self) -> c_int,
        kq_step_f32, kq_step_f64, kq_step_q31;
    mean(f: &Self::Filter, i: c_int) -> Self, kq_mean_f32, kq_mean_f64, kq_mean_q31;
    sigma(f: &Self::Filter, i: c_int) -> Self, kq_sigma_f32, kq_sigma_f64, kq_sigma_q31;
    covariance(f: &Self::Filter, p: *mut Self::Entry) -> c_int,
        kq_covariance_f32, kq_covariance_f64, kq_covariance_q31;
    innovation(f: &Self::Filter, s: &Self::Sensor, z: *const Self, e: *mut Self) -> c_int,
        kq_innovation_f32, kq_innovation_f64, kq_innovation_q31;
    nis(f: &Self::Filter) -> Self::Score, kq_nis_f32, kq_nis_f64, kq_nis_q31;
    taken(f: &Self::Filter) -> c_int, kq_taken_f32, kq_taken_f64, kq_taken_q31;
    log_likelihood(f: &Self::Filter) -> Self::Score,
        kq_log_likelihood_f32, kq_log_likelihood_f64, kq_log_likelihood_q31;
    events(f: &Self::Filter) -> c_uint, kq_events_f32, kq_events_f64, kq_events_q31;
    events_clear(f: &mut Self::Filter), kq_events_clear_f32, kq_events_clear_f64, kq_events_clear_q31;
}

float_calls! {
    process_assign(p: &mut Self::Process, n: c_int, l: c_int, memory: *mut Self, length: usize),
        kq_process_assign_f32, kq_process_assign_f64;
    process_init(p: &mut Self::Process, a: *const Self, b: *const Self, q: *const Self),
        kq_process_init_f32, kq_process_init_f64;
    sensor_assign(s: &mut Self::Sensor, n: c_int, m: c_int, memory: *mut Self, length: usize),
        kq_sensor_assign_f32, kq_sensor_assign_f64;
    sensor_init(s: &mut Self::Sensor, h: *const Self, r: *const Self), kq_sensor_init_f32, kq_sensor_init_f64;
    filter_init(f: &mut Self::Filter, x0: *const Self, p0: *const Self), kq_filter_init_f32, kq_filter_init_f64;
}
