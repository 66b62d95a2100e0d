//! The arithmetics of floating point, and which C functions each has.

use crate::sys;
use core::ffi::{c_int, c_uint};

/// `f32` or `f64`.
pub trait Number: Calls {}
impl Number for f32 {}
impl Number for f64 {}

/// A row a call: its name here, its arguments, its name in C by arithmetic.
macro_rules! calls {
    ($($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?, $f32:ident, $f64:ident;)*) => {
        pub trait Calls: Copy + 'static {
            const ZERO: Self;
            type Process;
            type Sensor;
            type Filter;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)?;)*
        }

        impl Calls for f32 {
            const ZERO: Self = 0.0;
            type Process = sys::kq_process_f32;
            type Sensor = sys::kq_sensor_f32;
            type Filter = sys::kq_filter_f32;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)? { unsafe { sys::$f32($($argument),*) } })*
        }

        impl Calls for f64 {
            const ZERO: Self = 0.0;
            type Process = sys::kq_process_f64;
            type Sensor = sys::kq_sensor_f64;
            type Filter = sys::kq_filter_f64;
            $(unsafe fn $name($($argument: $type),*) $(-> $result)? { unsafe { sys::$f64($($argument),*) } })*
        }
    };
}

calls! {
    process_assign(p: &mut Self::Process, n: c_int, l: c_int, memory: *mut Self, length: usize) -> c_int,
        kq_process_assign_f32, kq_process_assign_f64;
    process_init(p: &mut Self::Process, a: *const Self, b: *const Self, q: *const Self) -> c_int,
        kq_process_init_f32, kq_process_init_f64;
    sensor_assign(s: &mut Self::Sensor, n: c_int, m: c_int, memory: *mut Self, length: usize) -> c_int,
        kq_sensor_assign_f32, kq_sensor_assign_f64;
    sensor_init(s: &mut Self::Sensor, h: *const Self, r: *const Self) -> c_int, kq_sensor_init_f32, kq_sensor_init_f64;
    filter_assign(f: &mut Self::Filter, n: c_int, memory: *mut Self, length: usize) -> c_int,
        kq_filter_assign_f32, kq_filter_assign_f64;
    filter_init(f: &mut Self::Filter, x0: *const Self, p0: *const Self) -> c_int, kq_filter_init_f32, kq_filter_init_f64;
    predict(f: &mut Self::Filter, p: &Self::Process, u: *const Self) -> c_int, kq_predict_f32, kq_predict_f64;
    update(f: &mut Self::Filter, s: &Self::Sensor, z: *const Self) -> c_int, kq_update_f32, kq_update_f64;
    update_subset(f: &mut Self::Filter, s: &Self::Sensor, z: *const Self, present: u32) -> c_int,
        kq_update_subset_f32, kq_update_subset_f64;
    step(f: &mut Self::Filter, p: &Self::Process, u: *const Self, s: &Self::Sensor, z: *const Self) -> c_int,
        kq_step_f32, kq_step_f64;
    mean(f: &Self::Filter, i: c_int) -> Self, kq_mean_f32, kq_mean_f64;
    sigma(f: &Self::Filter, i: c_int) -> Self, kq_sigma_f32, kq_sigma_f64;
    covariance(f: &Self::Filter, p: *mut Self) -> c_int, kq_covariance_f32, kq_covariance_f64;
    innovation(f: &Self::Filter, s: &Self::Sensor, z: *const Self, e: *mut Self) -> c_int,
        kq_innovation_f32, kq_innovation_f64;
    nis(f: &Self::Filter) -> Self, kq_nis_f32, kq_nis_f64;
    taken(f: &Self::Filter) -> c_int, kq_taken_f32, kq_taken_f64;
    log_likelihood(f: &Self::Filter) -> Self, kq_log_likelihood_f32, kq_log_likelihood_f64;
    events(f: &Self::Filter) -> c_uint, kq_events_f32, kq_events_f64;
    events_clear(f: &mut Self::Filter), kq_events_clear_f32, kq_events_clear_f64;
}
