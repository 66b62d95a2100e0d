//! The C library's declarations, made by bindings.py from its headers.

#![allow(non_camel_case_types, non_snake_case, missing_docs)]

use core::ffi::{c_char, c_int, c_uint, c_void};

#[repr(C)]
pub struct kq_hooks_f32 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_hooks_f64 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_hooks_q31 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_loss_kind_f32 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_loss_kind_f64 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_loss_kind_q31 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_sensor_kind_f32 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_sensor_kind_f64 {
    _private: [u8; 0],
}
#[repr(C)]
pub struct kq_sensor_kind_q31 {
    _private: [u8; 0],
}
pub const KQ_SATURATED: c_int = 2;
pub const KQ_NOT_IDENTIFIED: c_int = 1;
pub const KQ_OK: c_int = 0;
pub const KQ_ERR_NULL: c_int = -1;
pub const KQ_ERR_SIZE: c_int = -2;
pub const KQ_ERR_MEMORY: c_int = -3;
pub const KQ_ERR_NOT_FINITE: c_int = -4;
pub const KQ_ERR_NOT_SYMMETRIC: c_int = -5;
pub const KQ_ERR_NOT_SEMIDEFINITE: c_int = -6;
pub const KQ_ERR_NOT_READY: c_int = -7;
pub const KQ_ERR_MISMATCH: c_int = -8;
pub const KQ_ERR_HISTORY_EMPTY: c_int = -9;
pub const KQ_ERR_HISTORY_FULL: c_int = -10;
pub const KQ_ERR_RANGE: c_int = -11;
pub const KQ_ERR_COEFFICIENT: c_int = -12;
pub const KQ_ERR_TABLE: c_int = -13;
pub const KQ_ERR_RECORDING: c_int = -14;
pub const KQ_ERR_NOT_DETECTABLE: c_int = -15;
pub const KQ_ERR_NOT_STABILISABLE: c_int = -16;
pub const KQ_ERR_NO_CONVERGENCE: c_int = -17;
pub const KQ_ERR_NO_DATA: c_int = -18;
pub const KQ_ERR_FEW_DATA: c_int = -19;
pub const KQ_ERR_LIKELIHOOD: c_int = -20;
pub const KQ_ERR_FORM: c_int = -21;
pub const KQ_ERR_CHANGED: c_int = -22;
pub const KQ_ERR_ARITHMETIC: c_int = -23;
pub type kq_status = c_int;
pub const KQ_EVENT_REDUNDANT: c_uint = 1;
pub const KQ_EVENT_OVERFLOW: c_uint = 2;
pub const KQ_EVENT_HISTORY_FULL: c_uint = 4;
pub const KQ_EVENT_SATURATED: c_uint = 8;
pub const KQ_EVENT_GATED: c_uint = 16;
pub const KQ_EVENT_REJECTIONS: c_uint = 32;
pub const KQ_EVENT_JUMP: c_uint = 64;
pub const KQ_EVENT_PRECISION: c_uint = 128;
pub const KQ_EVENT_LOW_NOISE: c_uint = 256;
pub const KQ_EVENT_CONTRADICTION: c_uint = 512;
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_scaled_q31 {
    pub mantissa: i32,
    pub exponent: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_format_q31 {
    pub range: i32,
    pub fraction: i32,
}
pub const KQ_STATE: c_int = 0;
pub const KQ_CONTROL: c_int = 1;
pub const KQ_MEASUREMENT: c_int = 2;
pub const KQ_NO_RANGE_ERROR: c_int = 3;
pub type kq_quantity = c_int;
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_range_error_q31 {
    pub quantity: kq_quantity,
    pub component: i32,
    pub bits: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_sensor_f32 {
    pub states: u8,
    pub components: u8,
    pub length: u8,
    pub measurement_seal: u8,
    pub memory: *mut f32,
    pub noise: *const f32,
    pub measurement: *const f32,
    pub covariance: *const f32,
    pub selects: [u8; 16],
    pub plain: u16,
    pub seal: u8,
    pub noise_seal: u8,
    pub kind: *const kq_sensor_kind_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_sensor_f64 {
    pub states: u8,
    pub components: u8,
    pub length: u8,
    pub measurement_seal: u8,
    pub memory: *mut f64,
    pub noise: *const f64,
    pub measurement: *const f64,
    pub covariance: *const f64,
    pub selects: [u8; 16],
    pub plain: u16,
    pub seal: u8,
    pub noise_seal: u8,
    pub kind: *const kq_sensor_kind_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_sensor_table_q31 {
    pub states: i32,
    pub components: i32,
    pub correlated: i32,
    pub state_format: *const kq_format_q31,
    pub measurement_format: *const kq_format_q31,
    pub measurement: *const kq_scaled_q31,
    pub noise: *const kq_scaled_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_sensor_q31 {
    pub states: u8,
    pub components: u8,
    pub correlated: u8,
    pub measurement_seal: u8,
    pub state_format: *const kq_format_q31,
    pub measurement_format: *const kq_format_q31,
    pub measurement: *const kq_scaled_q31,
    pub noise: *const kq_scaled_q31,
    pub selects: [u8; 16],
    pub plain: u16,
    pub seal: u8,
    pub noise_seal: u8,
    pub kind: *const kq_sensor_kind_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_process_f32 {
    pub states: u8,
    pub controls: u8,
    pub length: u16,
    pub memory: *mut f32,
    pub noise_root: *const f32,
    pub transition: *const f32,
    pub control: *const f32,
    pub first: [u8; 16],
    pub plain: u8,
    pub seal: u8,
    pub fingerprint: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_process_f64 {
    pub states: u8,
    pub controls: u8,
    pub length: u16,
    pub memory: *mut f64,
    pub noise_root: *const f64,
    pub transition: *const f64,
    pub control: *const f64,
    pub first: [u8; 16],
    pub plain: u8,
    pub seal: u8,
    pub fingerprint: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_process_table_q31 {
    pub states: i32,
    pub controls: i32,
    pub state_format: *const kq_format_q31,
    pub control_format: *const kq_format_q31,
    pub transition: *const kq_scaled_q31,
    pub control: *const kq_scaled_q31,
    pub noise_root: *const i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_process_q31 {
    pub states: u8,
    pub controls: u8,
    pub first: [u8; 16],
    pub plain: u8,
    pub seal: u8,
    pub fingerprint: u32,
    pub state_format: *const kq_format_q31,
    pub control_format: *const kq_format_q31,
    pub transition: *const kq_scaled_q31,
    pub control: *const kq_scaled_q31,
    pub noise_root: *const i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_attached_f32 {
    pub hooks: *const kq_hooks_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_attached_f64 {
    pub hooks: *const kq_hooks_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_compensated_f32 {
    pub high: f32,
    pub sum: f32,
    pub low: f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_compensated_f64 {
    pub high: f64,
    pub sum: f64,
    pub low: f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_likelihood_f32 {
    pub nis: f32,
    pub determinant: f32,
    pub exponent: i32,
    pub count: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_likelihood_f64 {
    pub nis: f64,
    pub determinant: f64,
    pub exponent: i32,
    pub count: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_likelihood_run_f32 {
    pub sum: kq_compensated_f32,
    pub determinant: f32,
    pub exponent: i32,
    pub count: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_likelihood_run_f64 {
    pub sum: kq_compensated_f64,
    pub determinant: f64,
    pub exponent: i32,
    pub count: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_filter_f32 {
    pub states: u8,
    pub ready: u8,
    pub events: u16,
    pub plain: u8,
    pub seal: u8,
    pub known: u16,
    pub memory: *mut f32,
    pub attached: *mut kq_attached_f32,
    pub weak: u32,
    pub last: kq_likelihood_f32,
    pub run: kq_likelihood_run_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_filter_f64 {
    pub states: u8,
    pub ready: u8,
    pub events: u16,
    pub plain: u8,
    pub seal: u8,
    pub known: u16,
    pub memory: *mut f64,
    pub attached: *mut kq_attached_f64,
    pub weak: u32,
    pub last: kq_likelihood_f64,
    pub run: kq_likelihood_run_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_attached_q31 {
    pub hooks: *const kq_hooks_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_prior_table_q31 {
    pub states: i32,
    pub state_format: *const kq_format_q31,
    pub mean: *const i32,
    pub root: *const i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_likelihood_q31 {
    pub nis: i64,
    pub determinant: kq_scaled_q31,
    pub count: i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_likelihood_run_q31 {
    pub sum: i64,
    pub carried: i32,
    pub count: i32,
    pub determinant: kq_scaled_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_filter_q31 {
    pub states: u8,
    pub ready: u8,
    pub events: u16,
    pub plain: u8,
    pub seal: u8,
    pub known: u16,
    pub memory: *mut i32,
    pub attached: *mut kq_attached_q31,
    pub state_format: *const kq_format_q31,
    pub weak: u32,
    pub last: kq_likelihood_q31,
    pub run: kq_likelihood_run_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_history_f32 {
    pub attached: kq_attached_f32,
    pub states: u8,
    pub phase: u8,
    pub records: u16,
    pub steps: u32,
    pub step: u32,
    pub fingerprint: u32,
    pub length: usize,
    pub used: usize,
    pub memory: *mut f32,
    pub process: *const kq_process_f32,
    pub filter: *mut kq_filter_f32,
    pub events: u8,
    pub rounding: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_history_f64 {
    pub attached: kq_attached_f64,
    pub states: u8,
    pub phase: u8,
    pub records: u16,
    pub steps: u32,
    pub step: u32,
    pub fingerprint: u32,
    pub length: usize,
    pub used: usize,
    pub memory: *mut f64,
    pub process: *const kq_process_f64,
    pub filter: *mut kq_filter_f64,
    pub events: u8,
    pub rounding: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_smooth_extras_f32 {
    pub lag_one: *mut f32,
    pub noise_mean: *mut f32,
    pub noise_covariance: *mut f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_smooth_extras_f64 {
    pub lag_one: *mut f64,
    pub noise_mean: *mut f64,
    pub noise_covariance: *mut f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_history_q31 {
    pub attached: kq_attached_q31,
    pub states: u8,
    pub phase: u8,
    pub records: u16,
    pub steps: u32,
    pub step: u32,
    pub fingerprint: u32,
    pub length: usize,
    pub used: usize,
    pub memory: *mut i32,
    pub process: *const kq_process_q31,
    pub filter: *mut kq_filter_q31,
    pub events: u8,
    pub rounding: u32,
    pub state_format: *const kq_format_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_smooth_extras_q31 {
    pub lag_one: *mut kq_scaled_q31,
    pub noise_mean: *mut kq_scaled_q31,
    pub noise_covariance: *mut kq_scaled_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub union kq_lag_f32_nameless_0 {
    pub tape: kq_history_f32,
    pub attached: kq_attached_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_lag_f32 {
    pub nameless_0: kq_lag_f32_nameless_0,
    pub most: u32,
    pub block: u32,
    pub steps: u32,
    pub next: u32,
    pub head: u32,
    pub joined: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub union kq_lag_f64_nameless_0 {
    pub tape: kq_history_f64,
    pub attached: kq_attached_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_lag_f64 {
    pub nameless_0: kq_lag_f64_nameless_0,
    pub most: u32,
    pub block: u32,
    pub steps: u32,
    pub next: u32,
    pub head: u32,
    pub joined: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub union kq_lag_q31_nameless_0 {
    pub tape: kq_history_q31,
    pub attached: kq_attached_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_lag_q31 {
    pub nameless_0: kq_lag_q31_nameless_0,
    pub most: u32,
    pub block: u32,
    pub steps: u32,
    pub next: u32,
    pub head: u32,
    pub joined: u32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub union kq_instant_f32_nameless_0 {
    pub tape: kq_history_f32,
    pub attached: kq_attached_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_instant_f32 {
    pub nameless_0: kq_instant_f32_nameless_0,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub union kq_instant_f64_nameless_0 {
    pub tape: kq_history_f64,
    pub attached: kq_attached_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_instant_f64 {
    pub nameless_0: kq_instant_f64_nameless_0,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub union kq_instant_q31_nameless_0 {
    pub tape: kq_history_q31,
    pub attached: kq_attached_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_instant_q31 {
    pub nameless_0: kq_instant_q31_nameless_0,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_diffuse_f32 {
    pub attached: kq_attached_f32,
    pub states: u8,
    pub unknowns: u8,
    pub ready: u8,
    pub phase: u8,
    pub early: u16,
    pub next: u16,
    pub steps: u32,
    pub memory: *mut f32,
    pub filter: *mut kq_filter_f32,
    pub tape: *mut kq_history_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_diffuse_f64 {
    pub attached: kq_attached_f64,
    pub states: u8,
    pub unknowns: u8,
    pub ready: u8,
    pub phase: u8,
    pub early: u16,
    pub next: u16,
    pub steps: u32,
    pub memory: *mut f64,
    pub filter: *mut kq_filter_f64,
    pub tape: *mut kq_history_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_diffuse_q31 {
    pub attached: kq_attached_q31,
    pub states: u8,
    pub unknowns: u8,
    pub ready: u8,
    pub phase: u8,
    pub early: u16,
    pub next: u16,
    pub steps: u32,
    pub memory: *mut i32,
    pub filter: *mut kq_filter_q31,
    pub tape: *mut kq_history_q31,
}
pub const KQ_ADAPT_BOTH: c_int = 0;
pub const KQ_ADAPT_PROCESS: c_int = 1;
pub const KQ_ADAPT_SENSOR: c_int = 2;
pub type kq_adapted = c_int;
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_adaptation_rule_f32 {
    pub scales: kq_adapted,
    pub memory: i32,
    pub step: f32,
    pub process_least: f32,
    pub process_most: f32,
    pub sensor_least: f32,
    pub sensor_most: f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_adaptation_rule_f64 {
    pub scales: kq_adapted,
    pub memory: i32,
    pub step: f64,
    pub process_least: f64,
    pub process_most: f64,
    pub sensor_least: f64,
    pub sensor_most: f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_adaptation_rule_q31 {
    pub scales: kq_adapted,
    pub memory: i32,
    pub step: kq_scaled_q31,
    pub process_least: kq_scaled_q31,
    pub process_most: kq_scaled_q31,
    pub sensor_least: kq_scaled_q31,
    pub sensor_most: kq_scaled_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_adaptation_f32 {
    pub attached: kq_attached_f32,
    pub states: u8,
    pub components: u8,
    pub waiting: u8,
    pub length: u16,
    pub memory: *mut f32,
    pub process: *const kq_process_f32,
    pub sensor: *const kq_sensor_f32,
    pub rule: kq_adaptation_rule_f32,
    pub process_scale: f32,
    pub sensor_scale: f32,
    pub information: [f32; 3],
    pub scaled_process: kq_process_f32,
    pub scaled_sensor: kq_sensor_f32,
    pub filter: *mut kq_filter_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_adaptation_f64 {
    pub attached: kq_attached_f64,
    pub states: u8,
    pub components: u8,
    pub waiting: u8,
    pub length: u16,
    pub memory: *mut f64,
    pub process: *const kq_process_f64,
    pub sensor: *const kq_sensor_f64,
    pub rule: kq_adaptation_rule_f64,
    pub process_scale: f64,
    pub sensor_scale: f64,
    pub information: [f64; 3],
    pub scaled_process: kq_process_f64,
    pub scaled_sensor: kq_sensor_f64,
    pub filter: *mut kq_filter_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_adaptation_q31 {
    pub attached: kq_attached_q31,
    pub states: u8,
    pub components: u8,
    pub waiting: u8,
    pub length: u16,
    pub memory: *mut kq_scaled_q31,
    pub root: *mut i32,
    pub process: *const kq_process_q31,
    pub sensor: *const kq_sensor_q31,
    pub rule: kq_adaptation_rule_q31,
    pub process_scale: kq_scaled_q31,
    pub sensor_scale: kq_scaled_q31,
    pub information: [kq_scaled_q31; 3],
    pub scaled_process: kq_process_q31,
    pub scaled_sensor: kq_sensor_q31,
    pub filter: *mut kq_filter_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_steady_solution_f32 {
    pub predicted: *mut f32,
    pub filtered: *mut f32,
    pub gain: *mut f32,
    pub smoother_gain: *mut f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_steady_solution_f64 {
    pub predicted: *mut f64,
    pub filtered: *mut f64,
    pub gain: *mut f64,
    pub smoother_gain: *mut f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_steady_f32 {
    pub states: u8,
    pub components: u8,
    pub events: u8,
    pub length: u8,
    pub plain: u16,
    pub memory: *mut f32,
    pub gain: *const f32,
    pub left: usize,
    pub process: *const kq_process_f32,
    pub sensor: *const kq_sensor_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_steady_f64 {
    pub states: u8,
    pub components: u8,
    pub events: u8,
    pub length: u8,
    pub plain: u16,
    pub memory: *mut f64,
    pub gain: *const f64,
    pub left: usize,
    pub process: *const kq_process_f64,
    pub sensor: *const kq_sensor_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_freeze_f32 {
    pub attached: kq_attached_f32,
    pub states: u8,
    pub components: u8,
    pub bits: u8,
    pub phase: u8,
    pub length: u16,
    pub memory: *mut f32,
    pub gain: *mut f32,
    pub process: *const kq_process_f32,
    pub fingerprint: u32,
    pub sensor: *const kq_sensor_f32,
    pub measurement: *const f32,
    pub filter: *mut kq_filter_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_freeze_f64 {
    pub attached: kq_attached_f64,
    pub states: u8,
    pub components: u8,
    pub bits: u8,
    pub phase: u8,
    pub length: u16,
    pub memory: *mut f64,
    pub gain: *mut f64,
    pub process: *const kq_process_f64,
    pub fingerprint: u32,
    pub sensor: *const kq_sensor_f64,
    pub measurement: *const f64,
    pub filter: *mut kq_filter_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_steady_q31 {
    pub states: u8,
    pub components: u8,
    pub events: u8,
    pub length: u8,
    pub plain: u16,
    pub memory: *mut i32,
    pub gain: *const kq_scaled_q31,
    pub left: usize,
    pub process: *const kq_process_q31,
    pub sensor: *const kq_sensor_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_freeze_q31 {
    pub attached: kq_attached_q31,
    pub states: u8,
    pub components: u8,
    pub bits: u8,
    pub phase: u8,
    pub length: u16,
    pub memory: *mut i32,
    pub gain: *mut kq_scaled_q31,
    pub process: *const kq_process_q31,
    pub fingerprint: u32,
    pub sensor: *const kq_sensor_q31,
    pub measurement: *const kq_scaled_q31,
    pub filter: *mut kq_filter_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_loss_f32 {
    pub kind: *const kq_loss_kind_f32,
    pub parameter: f32,
    pub weights: *mut f32,
    pub limit: f32,
    pub run: u16,
    pub rejected: u16,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_loss_f64 {
    pub kind: *const kq_loss_kind_f64,
    pub parameter: f64,
    pub weights: *mut f64,
    pub limit: f64,
    pub run: u16,
    pub rejected: u16,
}
pub const KQ_LEVEL_90: c_int = 0;
pub const KQ_LEVEL_95: c_int = 1;
pub const KQ_LEVEL_99: c_int = 2;
pub const KQ_LEVEL_999: c_int = 3;
pub const KQ_LEVEL_9999: c_int = 4;
pub type kq_level = c_int;
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_loss_q31 {
    pub kind: *const kq_loss_kind_q31,
    pub parameter: kq_scaled_q31,
    pub weights: *mut kq_scaled_q31,
    pub limit: i64,
    pub run: u16,
    pub rejected: u16,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_compensated_q31 {
    pub sum: i64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_least_squares_f32 {
    pub filter: *mut kq_filter_f32,
    pub lambda: f32,
    pub residual: kq_compensated_f32,
    pub weight: kq_compensated_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_least_squares_f64 {
    pub filter: *mut kq_filter_f64,
    pub lambda: f64,
    pub residual: kq_compensated_f64,
    pub weight: kq_compensated_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_least_squares_q31 {
    pub filter: *mut kq_filter_q31,
    pub measurement_format: *const kq_format_q31,
    pub lambda: kq_scaled_q31,
    pub residual: kq_compensated_q31,
    pub weight: kq_compensated_q31,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_jacobians_f32 {
    pub attached: kq_attached_f32,
    pub states: u8,
    pub predicts: usize,
    pub length: usize,
    pub processes: *mut kq_process_f32,
    pub memory: *mut f32,
    pub kept: usize,
    pub used: usize,
    pub noise: *const f32,
    pub history: *mut kq_history_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_jacobians_f64 {
    pub attached: kq_attached_f64,
    pub states: u8,
    pub predicts: usize,
    pub length: usize,
    pub processes: *mut kq_process_f64,
    pub memory: *mut f64,
    pub kept: usize,
    pub used: usize,
    pub noise: *const f64,
    pub history: *mut kq_history_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_jacobians_q31 {
    pub attached: kq_attached_q31,
    pub states: u8,
    pub predicts: usize,
    pub length: usize,
    pub processes: *mut kq_process_q31,
    pub memory: *mut i32,
    pub kept: usize,
    pub used: usize,
    pub noise: *const i32,
    pub history: *mut kq_history_q31,
}
pub type kq_function_f32 = Option<unsafe extern "C" fn(context: *mut c_void, x: *const f32, y: *mut f32)>;
pub type kq_function_f64 = Option<unsafe extern "C" fn(context: *mut c_void, x: *const f64, y: *mut f64)>;
pub const KQ_SIGMA_POINTS_CUBATURE: c_int = 0;
pub const KQ_SIGMA_POINTS_CENTRAL: c_int = 1;
pub type kq_sigma_points = c_int;
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_consistency_f32 {
    pub components: u8,
    pub watched: u8,
    pub window: i16,
    pub count: i16,
    pub next: i16,
    pub memory: *mut f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_consistency_f64 {
    pub components: u8,
    pub watched: u8,
    pub window: i16,
    pub count: i16,
    pub next: i16,
    pub memory: *mut f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_consistency_q31 {
    pub components: u8,
    pub watched: u8,
    pub window: i16,
    pub count: i16,
    pub next: i16,
    pub memory: *mut i32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_parameters_f32 {
    pub controls: i32,
    pub noises: i32,
    pub A: *mut f32,
    pub B: *const f32,
    pub F: *const f32,
    pub Q: *mut f32,
    pub H: *mut f32,
    pub R: *mut f32,
    pub x0: *mut f32,
    pub P0: *mut f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_parameters_f64 {
    pub controls: i32,
    pub noises: i32,
    pub A: *mut f64,
    pub B: *const f64,
    pub F: *const f64,
    pub Q: *mut f64,
    pub H: *mut f64,
    pub R: *mut f64,
    pub x0: *mut f64,
    pub P0: *mut f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_recording_f32 {
    pub steps: usize,
    pub z: *const f32,
    pub present: *const u16,
    pub u: *const f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_recording_f64 {
    pub steps: usize,
    pub z: *const f64,
    pub present: *const u16,
    pub u: *const f64,
}
pub const KQ_EM_A: c_int = 1;
pub const KQ_EM_H: c_int = 2;
pub const KQ_EM_Q: c_int = 4;
pub const KQ_EM_R: c_int = 8;
pub const KQ_EM_X0: c_int = 16;
pub const KQ_EM_P0: c_int = 32;
pub const KQ_EM_ALL: c_int = 63;
pub const KQ_EM_FULL: c_int = 0;
pub const KQ_EM_DIAGONAL: c_int = 1;
pub const KQ_EM_MULTIPLE: c_int = 2;
pub type kq_em_form = c_int;
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_em_choice {
    pub free: c_uint,
    pub Q_form: kq_em_form,
    pub R_form: kq_em_form,
    pub A_held: *const u8,
    pub H_held: *const u8,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_em_f32 {
    pub states: u8,
    pub components: u8,
    pub phase: u8,
    pub kept: u8,
    pub length: usize,
    pub memory: *mut f32,
    pub model: *const kq_parameters_f32,
    pub choice: *const kq_em_choice,
    pub recordings: *const kq_recording_f32,
    pub count: usize,
    pub recording: usize,
    pub step: usize,
    pub remaining: u32,
    pub log_likelihood: f32,
    pub before: f32,
    pub gain: f32,
    pub change: f32,
    pub rate: f32,
    pub process: kq_process_f32,
    pub sensor: kq_sensor_f32,
    pub filter: kq_filter_f32,
    pub history: kq_history_f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_em_f64 {
    pub states: u8,
    pub components: u8,
    pub phase: u8,
    pub kept: u8,
    pub length: usize,
    pub memory: *mut f64,
    pub model: *const kq_parameters_f64,
    pub choice: *const kq_em_choice,
    pub recordings: *const kq_recording_f64,
    pub count: usize,
    pub recording: usize,
    pub step: usize,
    pub remaining: u32,
    pub log_likelihood: f64,
    pub before: f64,
    pub gain: f64,
    pub change: f64,
    pub rate: f64,
    pub process: kq_process_f64,
    pub sensor: kq_sensor_f64,
    pub filter: kq_filter_f64,
    pub history: kq_history_f64,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_gradient_f32 {
    pub A: *mut f32,
    pub H: *mut f32,
    pub Q: *mut f32,
    pub R: *mut f32,
    pub x0: *mut f32,
    pub P0: *mut f32,
}
#[repr(C)]
#[derive(Clone, Copy)]
pub struct kq_gradient_f64 {
    pub A: *mut f64,
    pub H: *mut f64,
    pub Q: *mut f64,
    pub R: *mut f64,
    pub x0: *mut f64,
    pub P0: *mut f64,
}
pub const KQ_OBJECT_PROCESS: c_int = 0;
pub const KQ_OBJECT_SENSOR: c_int = 1;
pub const KQ_OBJECT_FILTER: c_int = 2;
pub const KQ_OBJECT_HISTORY: c_int = 3;
pub const KQ_OBJECT_LAG: c_int = 4;
pub const KQ_OBJECT_INSTANT: c_int = 5;
pub const KQ_OBJECT_DIFFUSE: c_int = 6;
pub const KQ_OBJECT_ADAPTATION: c_int = 7;
pub const KQ_OBJECT_CONSISTENCY: c_int = 8;
pub const KQ_OBJECT_LEAST_SQUARES: c_int = 9;
pub const KQ_OBJECT_STEADY: c_int = 10;
pub const KQ_OBJECT_FREEZE: c_int = 11;
pub const KQ_OBJECT_LOSS: c_int = 12;
pub const KQ_OBJECT_EM: c_int = 13;
pub const KQ_OBJECT_STEADY_SOLVE: c_int = 14;
pub const KQ_OBJECT_ROOT: c_int = 15;
pub const KQ_OBJECT_CONTINUOUS: c_int = 16;
pub const KQ_OBJECT_CORRELATED: c_int = 17;
pub type kq_object = c_int;

unsafe extern "C" {
    pub fn kq_status_text(status: kq_status) -> *const c_char;
    pub fn kq_range_error_text_q31(range_error: *const kq_range_error_q31, text: *mut c_char, length: usize) -> usize;
    pub static kq_sensor_independent_f32: kq_sensor_kind_f32;
    pub static kq_sensor_lean_f32: kq_sensor_kind_f32;
    pub static kq_sensor_independent_f64: kq_sensor_kind_f64;
    pub static kq_sensor_lean_f64: kq_sensor_kind_f64;
    pub fn kq_sensor_assign_f32(s: *mut kq_sensor_f32, n: c_int, m: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_sensor_assign_f64(s: *mut kq_sensor_f64, n: c_int, m: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_sensor_init_f32(s: *mut kq_sensor_f32, H: *const f32, R: *const f32) -> kq_status;
    pub fn kq_sensor_init_f64(s: *mut kq_sensor_f64, H: *const f64, R: *const f64) -> kq_status;
    pub fn kq_sensor_init_diagonal_f32(s: *mut kq_sensor_f32, H: *const f32, r: *const f32) -> kq_status;
    pub fn kq_sensor_init_diagonal_f64(s: *mut kq_sensor_f64, H: *const f64, r: *const f64) -> kq_status;
    pub fn kq_sensor_init_lean_f32(s: *mut kq_sensor_f32, H: *const f32, r: *const f32) -> kq_status;
    pub fn kq_sensor_init_lean_f64(s: *mut kq_sensor_f64, H: *const f64, r: *const f64) -> kq_status;
    pub fn kq_sensor_change_measurement_f32(s: *mut kq_sensor_f32, H: *const f32) -> kq_status;
    pub fn kq_sensor_change_measurement_f64(s: *mut kq_sensor_f64, H: *const f64) -> kq_status;
    pub fn kq_sensor_check_f32(s: *mut kq_sensor_f32) -> kq_status;
    pub fn kq_sensor_check_f64(s: *mut kq_sensor_f64) -> kq_status;
    pub fn kq_sensor_init_q31(s: *mut kq_sensor_q31, table: *const kq_sensor_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_sensor_init_diagonal_q31(s: *mut kq_sensor_q31, table: *const kq_sensor_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_sensor_init_lean_q31(s: *mut kq_sensor_q31, table: *const kq_sensor_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub static kq_sensor_independent_q31: kq_sensor_kind_q31;
    pub static kq_sensor_lean_q31: kq_sensor_kind_q31;
    pub fn kq_sensor_change_measurement_q31(s: *mut kq_sensor_q31, H: *const kq_scaled_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_sensor_check_q31(s: *mut kq_sensor_q31) -> kq_status;
    pub fn kq_process_assign_f32(p: *mut kq_process_f32, n: c_int, l: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_process_assign_f64(p: *mut kq_process_f64, n: c_int, l: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_process_init_f32(p: *mut kq_process_f32, A: *const f32, B: *const f32, Q: *const f32) -> kq_status;
    pub fn kq_process_init_f64(p: *mut kq_process_f64, A: *const f64, B: *const f64, Q: *const f64) -> kq_status;
    pub fn kq_process_init_factor_f32(p: *mut kq_process_f32, A: *const f32, B: *const f32, F: *const f32, r: c_int) -> kq_status;
    pub fn kq_process_init_factor_f64(p: *mut kq_process_f64, A: *const f64, B: *const f64, F: *const f64, r: c_int) -> kq_status;
    pub fn kq_process_init_root_f32(p: *mut kq_process_f32, A: *const f32, B: *const f32, G: *const f32) -> kq_status;
    pub fn kq_process_init_root_f64(p: *mut kq_process_f64, A: *const f64, B: *const f64, G: *const f64) -> kq_status;
    pub fn kq_process_init_continuous_f32(p: *mut kq_process_f32, F: *const f32, B: *const f32, Qc: *const f32, dt: f32, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_process_init_continuous_f64(p: *mut kq_process_f64, F: *const f64, B: *const f64, Qc: *const f64, dt: f64, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_process_init_correlated_f32(p: *mut kq_process_f32, A: *const f32, B: *const f32, Q: *const f32, s: *const kq_sensor_f32, S: *const f32, present: u32) -> kq_status;
    pub fn kq_process_init_correlated_f64(p: *mut kq_process_f64, A: *const f64, B: *const f64, Q: *const f64, s: *const kq_sensor_f64, S: *const f64, present: u32) -> kq_status;
    pub fn kq_process_change_transition_f32(p: *mut kq_process_f32, A: *const f32) -> kq_status;
    pub fn kq_process_change_transition_f64(p: *mut kq_process_f64, A: *const f64) -> kq_status;
    pub fn kq_process_check_f32(p: *mut kq_process_f32) -> kq_status;
    pub fn kq_process_check_f64(p: *mut kq_process_f64) -> kq_status;
    pub fn kq_process_init_q31(p: *mut kq_process_q31, table: *const kq_process_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_process_change_transition_q31(p: *mut kq_process_q31, A: *const kq_scaled_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_process_check_q31(p: *mut kq_process_q31) -> kq_status;
    pub fn kq_filter_assign_f32(f: *mut kq_filter_f32, n: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_filter_assign_f64(f: *mut kq_filter_f64, n: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_filter_init_f32(f: *mut kq_filter_f32, x0: *const f32, P0: *const f32) -> kq_status;
    pub fn kq_filter_init_f64(f: *mut kq_filter_f64, x0: *const f64, P0: *const f64) -> kq_status;
    pub fn kq_filter_init_root_f32(f: *mut kq_filter_f32, x0: *const f32, S: *const f32) -> kq_status;
    pub fn kq_filter_init_root_f64(f: *mut kq_filter_f64, x0: *const f64, S: *const f64) -> kq_status;
    pub fn kq_filter_copy_f32(to: *mut kq_filter_f32, from: *const kq_filter_f32) -> kq_status;
    pub fn kq_filter_copy_f64(to: *mut kq_filter_f64, from: *const kq_filter_f64) -> kq_status;
    pub fn kq_attach_f32(f: *mut kq_filter_f32, object: *mut kq_attached_f32) -> kq_status;
    pub fn kq_attach_f64(f: *mut kq_filter_f64, object: *mut kq_attached_f64) -> kq_status;
    pub fn kq_detach_f32(object: *mut kq_attached_f32) -> kq_status;
    pub fn kq_detach_f64(object: *mut kq_attached_f64) -> kq_status;
    pub fn kq_predict_f32(f: *mut kq_filter_f32, p: *const kq_process_f32, u: *const f32) -> kq_status;
    pub fn kq_predict_f64(f: *mut kq_filter_f64, p: *const kq_process_f64, u: *const f64) -> kq_status;
    pub fn kq_update_f32(f: *mut kq_filter_f32, s: *const kq_sensor_f32, z: *const f32) -> kq_status;
    pub fn kq_update_f64(f: *mut kq_filter_f64, s: *const kq_sensor_f64, z: *const f64) -> kq_status;
    pub fn kq_update_subset_f32(f: *mut kq_filter_f32, s: *const kq_sensor_f32, z: *const f32, present: u32) -> kq_status;
    pub fn kq_update_subset_f64(f: *mut kq_filter_f64, s: *const kq_sensor_f64, z: *const f64, present: u32) -> kq_status;
    pub fn kq_step_f32(f: *mut kq_filter_f32, p: *const kq_process_f32, u: *const f32, s: *const kq_sensor_f32, z: *const f32) -> kq_status;
    pub fn kq_step_f64(f: *mut kq_filter_f64, p: *const kq_process_f64, u: *const f64, s: *const kq_sensor_f64, z: *const f64) -> kq_status;
    pub fn kq_mean_f32(f: *const kq_filter_f32, i: c_int) -> f32;
    pub fn kq_mean_f64(f: *const kq_filter_f64, i: c_int) -> f64;
    pub fn kq_mean_low_f32(f: *const kq_filter_f32, i: c_int) -> f32;
    pub fn kq_mean_low_f64(f: *const kq_filter_f64, i: c_int) -> f64;
    pub fn kq_sigma_f32(f: *const kq_filter_f32, i: c_int) -> f32;
    pub fn kq_sigma_f64(f: *const kq_filter_f64, i: c_int) -> f64;
    pub fn kq_covariance_f32(f: *const kq_filter_f32, P: *mut f32) -> kq_status;
    pub fn kq_covariance_f64(f: *const kq_filter_f64, P: *mut f64) -> kq_status;
    pub fn kq_measurement_f32(f: *const kq_filter_f32, s: *const kq_sensor_f32, z: *mut f32, S: *mut f32) -> kq_status;
    pub fn kq_measurement_f64(f: *const kq_filter_f64, s: *const kq_sensor_f64, z: *mut f64, S: *mut f64) -> kq_status;
    pub fn kq_innovation_f32(f: *const kq_filter_f32, s: *const kq_sensor_f32, z: *const f32, e: *mut f32) -> kq_status;
    pub fn kq_innovation_f64(f: *const kq_filter_f64, s: *const kq_sensor_f64, z: *const f64, e: *mut f64) -> kq_status;
    pub fn kq_gain_f32(f: *const kq_filter_f32, s: *const kq_sensor_f32, K: *mut f32) -> kq_status;
    pub fn kq_gain_f64(f: *const kq_filter_f64, s: *const kq_sensor_f64, K: *mut f64) -> kq_status;
    pub fn kq_nis_f32(f: *const kq_filter_f32) -> f32;
    pub fn kq_nis_f64(f: *const kq_filter_f64) -> f64;
    pub fn kq_taken_f32(f: *const kq_filter_f32) -> c_int;
    pub fn kq_taken_f64(f: *const kq_filter_f64) -> c_int;
    pub fn kq_log_likelihood_last_f32(f: *const kq_filter_f32) -> f32;
    pub fn kq_log_likelihood_last_f64(f: *const kq_filter_f64) -> f64;
    pub fn kq_log_likelihood_f32(f: *const kq_filter_f32) -> f32;
    pub fn kq_log_likelihood_f64(f: *const kq_filter_f64) -> f64;
    pub fn kq_events_f32(f: *const kq_filter_f32) -> c_uint;
    pub fn kq_events_f64(f: *const kq_filter_f64) -> c_uint;
    pub fn kq_events_clear_f32(f: *mut kq_filter_f32);
    pub fn kq_events_clear_f64(f: *mut kq_filter_f64);
    pub fn kq_forecast_f32(f: *const kq_filter_f32, p: *const kq_process_f32, u: *const f32, steps: usize, ahead: *mut kq_filter_f32) -> kq_status;
    pub fn kq_forecast_f64(f: *const kq_filter_f64, p: *const kq_process_f64, u: *const f64, steps: usize, ahead: *mut kq_filter_f64) -> kq_status;
    pub fn kq_filter_check_f32(f: *mut kq_filter_f32) -> kq_status;
    pub fn kq_filter_check_f64(f: *mut kq_filter_f64) -> kq_status;
    pub fn kq_filter_assign_q31(f: *mut kq_filter_q31, n: c_int, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_filter_init_q31(f: *mut kq_filter_q31, prior: *const kq_prior_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_update_q31(f: *mut kq_filter_q31, s: *const kq_sensor_q31, z: *const i32) -> kq_status;
    pub fn kq_update_subset_q31(f: *mut kq_filter_q31, s: *const kq_sensor_q31, z: *const i32, present: u32) -> kq_status;
    pub fn kq_predict_q31(f: *mut kq_filter_q31, p: *const kq_process_q31, u: *const i32) -> kq_status;
    pub fn kq_step_q31(f: *mut kq_filter_q31, p: *const kq_process_q31, u: *const i32, s: *const kq_sensor_q31, z: *const i32) -> kq_status;
    pub fn kq_forecast_q31(f: *const kq_filter_q31, p: *const kq_process_q31, u: *const i32, steps: usize, ahead: *mut kq_filter_q31) -> kq_status;
    pub fn kq_filter_copy_q31(to: *mut kq_filter_q31, from: *const kq_filter_q31) -> kq_status;
    pub fn kq_attach_q31(f: *mut kq_filter_q31, object: *mut kq_attached_q31) -> kq_status;
    pub fn kq_detach_q31(object: *mut kq_attached_q31) -> kq_status;
    pub fn kq_mean_q31(f: *const kq_filter_q31, i: c_int) -> i32;
    pub fn kq_mean_low_q31(f: *const kq_filter_q31, i: c_int) -> i32;
    pub fn kq_sigma_q31(f: *const kq_filter_q31, i: c_int) -> i32;
    pub fn kq_covariance_q31(f: *const kq_filter_q31, P: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_measurement_q31(f: *const kq_filter_q31, s: *const kq_sensor_q31, z: *mut i32, S: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_innovation_q31(f: *const kq_filter_q31, s: *const kq_sensor_q31, z: *const i32, e: *mut i32) -> kq_status;
    pub fn kq_gain_q31(f: *const kq_filter_q31, s: *const kq_sensor_q31, K: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_nis_q31(f: *const kq_filter_q31) -> i64;
    pub fn kq_log_likelihood_last_q31(f: *const kq_filter_q31) -> i64;
    pub fn kq_log_likelihood_q31(f: *const kq_filter_q31) -> i64;
    pub fn kq_taken_q31(f: *const kq_filter_q31) -> c_int;
    pub fn kq_events_q31(f: *const kq_filter_q31) -> c_uint;
    pub fn kq_events_clear_q31(f: *mut kq_filter_q31);
    pub fn kq_filter_check_q31(f: *mut kq_filter_q31) -> kq_status;
    pub static kq_history_hooks_f32: kq_hooks_f32;
    pub static kq_history_hooks_f64: kq_hooks_f64;
    pub fn kq_history_assign_f32(h: *mut kq_history_f32, n: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_history_assign_f64(h: *mut kq_history_f64, n: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_history_steps_f32(h: *const kq_history_f32) -> usize;
    pub fn kq_history_steps_f64(h: *const kq_history_f64) -> usize;
    pub fn kq_smooth_f32(h: *mut kq_history_f32) -> kq_status;
    pub fn kq_smooth_f64(h: *mut kq_history_f64) -> kq_status;
    pub fn kq_smooth_states_f32(h: *mut kq_history_f32) -> kq_status;
    pub fn kq_smooth_states_f64(h: *mut kq_history_f64) -> kq_status;
    pub fn kq_smooth_step_f32(h: *mut kq_history_f32, p: *const kq_process_f32, extras: *const kq_smooth_extras_f32) -> kq_status;
    pub fn kq_smooth_step_f64(h: *mut kq_history_f64, p: *const kq_process_f64, extras: *const kq_smooth_extras_f64) -> kq_status;
    pub fn kq_smoothed_measurement_noise_f32(h: *const kq_history_f32, k: c_int, mean: *mut f32, variance: *mut f32) -> kq_status;
    pub fn kq_smoothed_measurement_noise_f64(h: *const kq_history_f64, k: c_int, mean: *mut f64, variance: *mut f64) -> kq_status;
    pub fn kq_smoothed_f32(h: *const kq_history_f32, t: usize, view: *mut kq_filter_f32) -> kq_status;
    pub fn kq_smoothed_f64(h: *const kq_history_f64, t: usize, view: *mut kq_filter_f64) -> kq_status;
    pub static kq_history_hooks_q31: kq_hooks_q31;
    pub fn kq_history_assign_q31(h: *mut kq_history_q31, n: c_int, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_history_steps_q31(h: *const kq_history_q31) -> usize;
    pub fn kq_smooth_q31(h: *mut kq_history_q31) -> kq_status;
    pub fn kq_smooth_states_q31(h: *mut kq_history_q31) -> kq_status;
    pub fn kq_smooth_step_q31(h: *mut kq_history_q31, p: *const kq_process_q31, extras: *const kq_smooth_extras_q31) -> kq_status;
    pub fn kq_smoothed_measurement_noise_q31(h: *const kq_history_q31, k: c_int, mean: *mut kq_scaled_q31, variance: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_smoothed_q31(h: *const kq_history_q31, t: usize, view: *mut kq_filter_q31) -> kq_status;
    pub fn kq_format_prepare_q31(format: *mut kq_format_q31, fraction: c_int, range: f64, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_matrix_prepare_q31(table: *mut kq_scaled_q31, M: *const f64, rows: c_int, columns: c_int, row_format: *const kq_format_q31, column_format: *const kq_format_q31) -> kq_status;
    pub fn kq_root_prepare_q31(root: *mut i32, P: *const f64, n: c_int, format: *const kq_format_q31) -> kq_status;
    pub fn kq_root_prepare_factor_q31(root: *mut i32, F: *const f64, n: c_int, r: c_int, format: *const kq_format_q31) -> kq_status;
    pub fn kq_noise_prepare_q31(table: *mut kq_scaled_q31, R: *const f64, m: c_int, format: *const kq_format_q31) -> kq_status;
    pub fn kq_noise_prepare_diagonal_q31(table: *mut kq_scaled_q31, r: *const f64, m: c_int, format: *const kq_format_q31) -> kq_status;
    pub fn kq_vector_prepare_q31(raw: *mut i32, x: *const f64, count: c_int, format: *const kq_format_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub static kq_lag_hooks_f32: kq_hooks_f32;
    pub static kq_delay_hooks_f32: kq_hooks_f32;
    pub static kq_lag_hooks_f64: kq_hooks_f64;
    pub static kq_delay_hooks_f64: kq_hooks_f64;
    pub fn kq_lag_assign_f32(lag: *mut kq_lag_f32, n: c_int, m: c_int, L: usize, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_lag_assign_f64(lag: *mut kq_lag_f64, n: c_int, m: c_int, L: usize, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_lag_steps_f32(lag: *const kq_lag_f32) -> usize;
    pub fn kq_lag_steps_f64(lag: *const kq_lag_f64) -> usize;
    pub fn kq_lagged_f32(lag: *mut kq_lag_f32, k: usize, view: *mut kq_filter_f32) -> kq_status;
    pub fn kq_lagged_f64(lag: *mut kq_lag_f64, k: usize, view: *mut kq_filter_f64) -> kq_status;
    pub fn kq_lagged_states_f32(lag: *mut kq_lag_f32, k: usize, view: *mut kq_filter_f32) -> kq_status;
    pub fn kq_lagged_states_f64(lag: *mut kq_lag_f64, k: usize, view: *mut kq_filter_f64) -> kq_status;
    pub fn kq_delay_assign_f32(lag: *mut kq_lag_f32, n: c_int, m: c_int, L: usize, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_delay_assign_f64(lag: *mut kq_lag_f64, n: c_int, m: c_int, L: usize, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_update_delayed_f32(lag: *mut kq_lag_f32, k: usize, s: *const kq_sensor_f32, z: *const f32, present: u32) -> kq_status;
    pub fn kq_update_delayed_f64(lag: *mut kq_lag_f64, k: usize, s: *const kq_sensor_f64, z: *const f64, present: u32) -> kq_status;
    pub static kq_lag_hooks_q31: kq_hooks_q31;
    pub static kq_delay_hooks_q31: kq_hooks_q31;
    pub fn kq_lag_assign_q31(lag: *mut kq_lag_q31, n: c_int, m: c_int, L: usize, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_delay_assign_q31(lag: *mut kq_lag_q31, n: c_int, m: c_int, L: usize, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_update_delayed_q31(lag: *mut kq_lag_q31, k: usize, s: *const kq_sensor_q31, z: *const i32, present: u32) -> kq_status;
    pub fn kq_lag_steps_q31(lag: *const kq_lag_q31) -> usize;
    pub fn kq_lagged_q31(lag: *mut kq_lag_q31, k: usize, view: *mut kq_filter_q31) -> kq_status;
    pub fn kq_lagged_states_q31(lag: *mut kq_lag_q31, k: usize, view: *mut kq_filter_q31) -> kq_status;
    pub static kq_instant_hooks_f32: kq_hooks_f32;
    pub static kq_instant_hooks_f64: kq_hooks_f64;
    pub fn kq_instant_assign_f32(instant: *mut kq_instant_f32, n: c_int, m: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_instant_assign_f64(instant: *mut kq_instant_f64, n: c_int, m: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_instant_smooth_f32(instant: *mut kq_instant_f32, view: *mut kq_filter_f32) -> kq_status;
    pub fn kq_instant_smooth_f64(instant: *mut kq_instant_f64, view: *mut kq_filter_f64) -> kq_status;
    pub static kq_instant_hooks_q31: kq_hooks_q31;
    pub fn kq_instant_assign_q31(instant: *mut kq_instant_q31, n: c_int, m: c_int, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_instant_smooth_q31(instant: *mut kq_instant_q31, view: *mut kq_filter_q31) -> kq_status;
    pub fn kq_diffuse_assign_f32(s: *mut kq_diffuse_f32, n: c_int, early: usize, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_diffuse_assign_f64(s: *mut kq_diffuse_f64, n: c_int, early: usize, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_diffuse_init_f32(s: *mut kq_diffuse_f32, f: *mut kq_filter_f32, x0: *const f32, P0: *const f32, unknown: u32) -> kq_status;
    pub fn kq_diffuse_init_f64(s: *mut kq_diffuse_f64, f: *mut kq_filter_f64, x0: *const f64, P0: *const f64, unknown: u32) -> kq_status;
    pub fn kq_diffuse_count_f32(s: *const kq_diffuse_f32) -> c_int;
    pub fn kq_diffuse_count_f64(s: *const kq_diffuse_f64) -> c_int;
    pub fn kq_diffuse_steps_f32(s: *const kq_diffuse_f32, first: *mut usize) -> usize;
    pub fn kq_diffuse_steps_f64(s: *const kq_diffuse_f64, first: *mut usize) -> usize;
    pub fn kq_diffuse_smooth_f32(s: *mut kq_diffuse_f32) -> kq_status;
    pub fn kq_diffuse_smooth_f64(s: *mut kq_diffuse_f64) -> kq_status;
    pub fn kq_diffuse_smoothed_f32(s: *const kq_diffuse_f32, t: usize, view: *mut kq_filter_f32) -> kq_status;
    pub fn kq_diffuse_smoothed_f64(s: *const kq_diffuse_f64, t: usize, view: *mut kq_filter_f64) -> kq_status;
    pub fn kq_diffuse_assign_q31(s: *mut kq_diffuse_q31, n: c_int, early: usize, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_diffuse_init_q31(s: *mut kq_diffuse_q31, f: *mut kq_filter_q31, prior: *const kq_prior_table_q31, unknown: u32, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_diffuse_count_q31(s: *const kq_diffuse_q31) -> c_int;
    pub fn kq_diffuse_steps_q31(s: *const kq_diffuse_q31, first: *mut usize) -> usize;
    pub fn kq_diffuse_smooth_q31(s: *mut kq_diffuse_q31) -> kq_status;
    pub fn kq_diffuse_smoothed_q31(s: *const kq_diffuse_q31, t: usize, view: *mut kq_filter_q31) -> kq_status;
    pub static kq_adaptation_hooks_f32: kq_hooks_f32;
    pub static kq_adaptation_hooks_f64: kq_hooks_f64;
    pub static kq_adaptation_hooks_q31: kq_hooks_q31;
    pub fn kq_adaptation_assign_f32(a: *mut kq_adaptation_f32, n: c_int, m: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_adaptation_assign_f64(a: *mut kq_adaptation_f64, n: c_int, m: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_adaptation_assign_q31(a: *mut kq_adaptation_q31, n: c_int, m: c_int, memory: *mut kq_scaled_q31, length: usize, root: *mut i32) -> kq_status;
    pub fn kq_adaptation_init_f32(a: *mut kq_adaptation_f32, p: *const kq_process_f32, s: *const kq_sensor_f32, rule: *const kq_adaptation_rule_f32) -> kq_status;
    pub fn kq_adaptation_init_f64(a: *mut kq_adaptation_f64, p: *const kq_process_f64, s: *const kq_sensor_f64, rule: *const kq_adaptation_rule_f64) -> kq_status;
    pub fn kq_adaptation_init_q31(a: *mut kq_adaptation_q31, p: *const kq_process_q31, s: *const kq_sensor_q31, rule: *const kq_adaptation_rule_q31) -> kq_status;
    pub fn kq_adaptation_scales_f32(a: *const kq_adaptation_f32, q: *mut f32, r: *mut f32) -> kq_status;
    pub fn kq_adaptation_scales_f64(a: *const kq_adaptation_f64, q: *mut f64, r: *mut f64) -> kq_status;
    pub fn kq_adaptation_scales_q31(a: *const kq_adaptation_q31, q: *mut kq_scaled_q31, r: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_adaptation_process_f32(a: *mut kq_adaptation_f32) -> *const kq_process_f32;
    pub fn kq_adaptation_process_f64(a: *mut kq_adaptation_f64) -> *const kq_process_f64;
    pub fn kq_adaptation_process_q31(a: *mut kq_adaptation_q31) -> *const kq_process_q31;
    pub fn kq_adaptation_sensor_f32(a: *mut kq_adaptation_f32) -> *const kq_sensor_f32;
    pub fn kq_adaptation_sensor_f64(a: *mut kq_adaptation_f64) -> *const kq_sensor_f64;
    pub fn kq_adaptation_sensor_q31(a: *mut kq_adaptation_q31) -> *const kq_sensor_q31;
    pub fn kq_steady_solve_f32(p: *const kq_process_f32, s: *const kq_sensor_f32, memory: *mut f32, length: usize, out: *const kq_steady_solution_f32) -> kq_status;
    pub fn kq_steady_solve_f64(p: *const kq_process_f64, s: *const kq_sensor_f64, memory: *mut f64, length: usize, out: *const kq_steady_solution_f64) -> kq_status;
    pub fn kq_steady_assign_f32(st: *mut kq_steady_f32, n: c_int, m: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_steady_assign_f64(st: *mut kq_steady_f64, n: c_int, m: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_steady_init_f32(st: *mut kq_steady_f32, p: *const kq_process_f32, s: *const kq_sensor_f32, x0: *const f32, gains: *const f32, count: usize) -> kq_status;
    pub fn kq_steady_init_f64(st: *mut kq_steady_f64, p: *const kq_process_f64, s: *const kq_sensor_f64, x0: *const f64, gains: *const f64, count: usize) -> kq_status;
    pub fn kq_steady_predict_f32(st: *mut kq_steady_f32, u: *const f32) -> kq_status;
    pub fn kq_steady_predict_f64(st: *mut kq_steady_f64, u: *const f64) -> kq_status;
    pub fn kq_steady_update_f32(st: *mut kq_steady_f32, z: *const f32) -> kq_status;
    pub fn kq_steady_update_f64(st: *mut kq_steady_f64, z: *const f64) -> kq_status;
    pub fn kq_steady_step_f32(st: *mut kq_steady_f32, u: *const f32, z: *const f32) -> kq_status;
    pub fn kq_steady_step_f64(st: *mut kq_steady_f64, u: *const f64, z: *const f64) -> kq_status;
    pub fn kq_steady_mean_f32(st: *const kq_steady_f32, i: c_int) -> f32;
    pub fn kq_steady_mean_f64(st: *const kq_steady_f64, i: c_int) -> f64;
    pub fn kq_steady_innovation_f32(st: *const kq_steady_f32, z: *const f32, e: *mut f32) -> kq_status;
    pub fn kq_steady_innovation_f64(st: *const kq_steady_f64, z: *const f64, e: *mut f64) -> kq_status;
    pub static kq_freeze_hooks_f32: kq_hooks_f32;
    pub static kq_freeze_hooks_f64: kq_hooks_f64;
    pub fn kq_freeze_assign_f32(w: *mut kq_freeze_f32, n: c_int, m: c_int, memory: *mut f32, length: usize, gain: *mut f32) -> kq_status;
    pub fn kq_freeze_assign_f64(w: *mut kq_freeze_f64, n: c_int, m: c_int, memory: *mut f64, length: usize, gain: *mut f64) -> kq_status;
    pub fn kq_freeze_init_f32(w: *mut kq_freeze_f32, bits: c_int) -> kq_status;
    pub fn kq_freeze_init_f64(w: *mut kq_freeze_f64, bits: c_int) -> kq_status;
    pub fn kq_freeze_is_active_f32(w: *const kq_freeze_f32) -> c_int;
    pub fn kq_freeze_is_active_f64(w: *const kq_freeze_f64) -> c_int;
    pub fn kq_freeze_release_f32(w: *mut kq_freeze_f32) -> kq_status;
    pub fn kq_freeze_release_f64(w: *mut kq_freeze_f64) -> kq_status;
    pub fn kq_steady_assign_q31(st: *mut kq_steady_q31, n: c_int, m: c_int, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_steady_init_q31(st: *mut kq_steady_q31, p: *const kq_process_q31, s: *const kq_sensor_q31, x0: *const i32, gains: *const kq_scaled_q31, count: usize) -> kq_status;
    pub fn kq_steady_predict_q31(st: *mut kq_steady_q31, u: *const i32) -> kq_status;
    pub fn kq_steady_update_q31(st: *mut kq_steady_q31, z: *const i32) -> kq_status;
    pub fn kq_steady_step_q31(st: *mut kq_steady_q31, u: *const i32, z: *const i32) -> kq_status;
    pub fn kq_steady_events_q31(st: *const kq_steady_q31) -> c_uint;
    pub fn kq_steady_events_clear_q31(st: *mut kq_steady_q31);
    pub fn kq_steady_mean_q31(st: *const kq_steady_q31, i: c_int) -> i32;
    pub fn kq_steady_mean_low_q31(st: *const kq_steady_q31, i: c_int) -> i32;
    pub fn kq_steady_innovation_q31(st: *const kq_steady_q31, z: *const i32, e: *mut i32) -> kq_status;
    pub static kq_freeze_hooks_q31: kq_hooks_q31;
    pub fn kq_freeze_assign_q31(w: *mut kq_freeze_q31, n: c_int, m: c_int, memory: *mut i32, length: usize, gain: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_freeze_init_q31(w: *mut kq_freeze_q31, bits: c_int) -> kq_status;
    pub fn kq_freeze_is_active_q31(w: *const kq_freeze_q31) -> c_int;
    pub fn kq_freeze_release_q31(w: *mut kq_freeze_q31) -> kq_status;
    pub static kq_loss_huber_f32: kq_loss_kind_f32;
    pub static kq_loss_student_f32: kq_loss_kind_f32;
    pub static kq_loss_jump_f32: kq_loss_kind_f32;
    pub static kq_loss_gate_f32: kq_loss_kind_f32;
    pub static kq_loss_huber_f64: kq_loss_kind_f64;
    pub static kq_loss_student_f64: kq_loss_kind_f64;
    pub static kq_loss_jump_f64: kq_loss_kind_f64;
    pub static kq_loss_gate_f64: kq_loss_kind_f64;
    pub fn kq_chi_square_limit_f32(m: c_int, level: kq_level) -> f32;
    pub fn kq_chi_square_limit_f64(m: c_int, level: kq_level) -> f64;
    pub fn kq_update_robust_f32(f: *mut kq_filter_f32, s: *const kq_sensor_f32, z: *const f32, present: u32, loss: *mut kq_loss_f32) -> kq_status;
    pub fn kq_update_robust_f64(f: *mut kq_filter_f64, s: *const kq_sensor_f64, z: *const f64, present: u32, loss: *mut kq_loss_f64) -> kq_status;
    pub fn kq_process_scale_noise_f32(target: *mut kq_process_f32, source: *const kq_process_f32, q: f32) -> kq_status;
    pub fn kq_process_scale_noise_f64(target: *mut kq_process_f64, source: *const kq_process_f64, q: f64) -> kq_status;
    pub fn kq_smooth_reweighted_f32(h: *mut kq_history_f32, target: *mut kq_process_f32, source: *const kq_process_f32, nu: f32, q: *mut f32) -> kq_status;
    pub fn kq_smooth_reweighted_f64(h: *mut kq_history_f64, target: *mut kq_process_f64, source: *const kq_process_f64, nu: f64, q: *mut f64) -> kq_status;
    pub static kq_loss_huber_q31: kq_loss_kind_q31;
    pub static kq_loss_student_q31: kq_loss_kind_q31;
    pub static kq_loss_jump_q31: kq_loss_kind_q31;
    pub static kq_loss_gate_q31: kq_loss_kind_q31;
    pub fn kq_chi_square_limit_q31(m: c_int, level: kq_level) -> i64;
    pub fn kq_update_robust_q31(f: *mut kq_filter_q31, s: *const kq_sensor_q31, z: *const i32, present: u32, loss: *mut kq_loss_q31) -> kq_status;
    pub fn kq_process_scale_noise_q31(target: *mut kq_process_q31, source: *const kq_process_q31, root: *mut i32, q: kq_scaled_q31) -> kq_status;
    pub fn kq_smooth_reweighted_q31(h: *mut kq_history_q31, target: *mut kq_process_q31, source: *const kq_process_q31, root: *mut i32, nu: kq_scaled_q31, q: *mut kq_scaled_q31) -> kq_status;
    pub fn kq_forget_f32(f: *mut kq_filter_f32, lambda: f32) -> kq_status;
    pub fn kq_forget_f64(f: *mut kq_filter_f64, lambda: f64) -> kq_status;
    pub fn kq_forget_q31(f: *mut kq_filter_q31, lambda: kq_scaled_q31) -> kq_status;
    pub fn kq_least_squares_init_f32(q: *mut kq_least_squares_f32, f: *mut kq_filter_f32, lambda: f32) -> kq_status;
    pub fn kq_least_squares_init_f64(q: *mut kq_least_squares_f64, f: *mut kq_filter_f64, lambda: f64) -> kq_status;
    pub fn kq_least_squares_init_q31(q: *mut kq_least_squares_q31, f: *mut kq_filter_q31, lambda: kq_scaled_q31, measurement_format: *const kq_format_q31) -> kq_status;
    pub fn kq_least_squares_add_f32(q: *mut kq_least_squares_f32, H: *const f32, z: *const f32, r: *const f32, count: usize) -> kq_status;
    pub fn kq_least_squares_add_f64(q: *mut kq_least_squares_f64, H: *const f64, z: *const f64, r: *const f64, count: usize) -> kq_status;
    pub fn kq_least_squares_add_q31(q: *mut kq_least_squares_q31, H: *const kq_scaled_q31, z: *const i32, r: *const kq_scaled_q31, count: usize) -> kq_status;
    pub fn kq_least_squares_residual_f32(q: *const kq_least_squares_f32) -> f32;
    pub fn kq_least_squares_residual_f64(q: *const kq_least_squares_f64) -> f64;
    pub fn kq_least_squares_residual_q31(q: *const kq_least_squares_q31) -> i64;
    pub fn kq_least_squares_weight_f32(q: *const kq_least_squares_f32) -> f32;
    pub fn kq_least_squares_weight_f64(q: *const kq_least_squares_f64) -> f64;
    pub fn kq_least_squares_weight_q31(q: *const kq_least_squares_q31) -> i64;
    pub fn kq_predict_extended_f32(f: *mut kq_filter_f32, p: *const kq_process_f32, d: *const f32) -> kq_status;
    pub fn kq_predict_extended_f64(f: *mut kq_filter_f64, p: *const kq_process_f64, d: *const f64) -> kq_status;
    pub fn kq_sensor_init_extended_f32(s: *mut kq_sensor_f32, H: *const f32, R: *const f32) -> kq_status;
    pub fn kq_sensor_init_extended_f64(s: *mut kq_sensor_f64, H: *const f64, R: *const f64) -> kq_status;
    pub fn kq_sensor_init_diagonal_extended_f32(s: *mut kq_sensor_f32, H: *const f32, r: *const f32) -> kq_status;
    pub fn kq_sensor_init_diagonal_extended_f64(s: *mut kq_sensor_f64, H: *const f64, r: *const f64) -> kq_status;
    pub fn kq_sensor_init_lean_extended_f32(s: *mut kq_sensor_f32, H: *const f32, r: *const f32) -> kq_status;
    pub fn kq_sensor_init_lean_extended_f64(s: *mut kq_sensor_f64, H: *const f64, r: *const f64) -> kq_status;
    pub fn kq_move_f32(f: *mut kq_filter_f32, d: *const f32) -> kq_status;
    pub fn kq_move_f64(f: *mut kq_filter_f64, d: *const f64) -> kq_status;
    pub static kq_jacobians_hooks_f32: kq_hooks_f32;
    pub static kq_jacobians_hooks_f64: kq_hooks_f64;
    pub fn kq_jacobians_assign_f32(j: *mut kq_jacobians_f32, h: *mut kq_history_f32, n: c_int, processes: *mut kq_process_f32, predicts: usize, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_jacobians_assign_f64(j: *mut kq_jacobians_f64, h: *mut kq_history_f64, n: c_int, processes: *mut kq_process_f64, predicts: usize, memory: *mut f64, length: usize) -> kq_status;
    pub static kq_jacobians_hooks_q31: kq_hooks_q31;
    pub fn kq_jacobians_assign_q31(j: *mut kq_jacobians_q31, h: *mut kq_history_q31, n: c_int, processes: *mut kq_process_q31, predicts: usize, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_process_change_jacobian_q31(p: *mut kq_process_q31, A: *const kq_scaled_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_sensor_init_extended_q31(s: *mut kq_sensor_q31, table: *const kq_sensor_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_sensor_init_diagonal_extended_q31(s: *mut kq_sensor_q31, table: *const kq_sensor_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_sensor_init_lean_extended_q31(s: *mut kq_sensor_q31, table: *const kq_sensor_table_q31, range_error: *mut kq_range_error_q31) -> kq_status;
    pub fn kq_predict_extended_q31(f: *mut kq_filter_q31, p: *const kq_process_q31, d: *const i32) -> kq_status;
    pub fn kq_move_q31(f: *mut kq_filter_q31, d: *const i32) -> kq_status;
    pub fn kq_linearise_f32(at: *const kq_filter_f32, g: kq_function_f32, context: *mut c_void, rows: c_int, rule: kq_sigma_points, y: *mut f32, J: *mut f32, E: *mut f32) -> kq_status;
    pub fn kq_linearise_f64(at: *const kq_filter_f64, g: kq_function_f64, context: *mut c_void, rows: c_int, rule: kq_sigma_points, y: *mut f64, J: *mut f64, E: *mut f64) -> kq_status;
    pub fn kq_process_linearise_f32(p: *mut kq_process_f32, base: *const kq_process_f32, A: *const f32, E: *mut f32) -> kq_status;
    pub fn kq_process_linearise_f64(p: *mut kq_process_f64, base: *const kq_process_f64, A: *const f64, E: *mut f64) -> kq_status;
    pub fn kq_sensor_linearise_f32(s: *mut kq_sensor_f32, base: *const kq_sensor_f32, H: *const f32, E: *const f32, R: *mut f32) -> kq_status;
    pub fn kq_sensor_linearise_f64(s: *mut kq_sensor_f64, base: *const kq_sensor_f64, H: *const f64, E: *const f64, R: *mut f64) -> kq_status;
    pub fn kq_predict_sigma_points_f32(f: *mut kq_filter_f32, p: *const kq_process_f32, increment: kq_function_f32, context: *mut c_void, rule: kq_sigma_points, work: *mut f32) -> kq_status;
    pub fn kq_predict_sigma_points_f64(f: *mut kq_filter_f64, p: *const kq_process_f64, increment: kq_function_f64, context: *mut c_void, rule: kq_sigma_points, work: *mut f64) -> kq_status;
    pub fn kq_update_sigma_points_f32(f: *mut kq_filter_f32, s: *const kq_sensor_f32, innovation: kq_function_f32, context: *mut c_void, rule: kq_sigma_points, work: *mut f32) -> kq_status;
    pub fn kq_update_sigma_points_f64(f: *mut kq_filter_f64, s: *const kq_sensor_f64, innovation: kq_function_f64, context: *mut c_void, rule: kq_sigma_points, work: *mut f64) -> kq_status;
    pub fn kq_consistency_assign_f32(c: *mut kq_consistency_f32, m: c_int, window: usize, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_consistency_assign_f64(c: *mut kq_consistency_f64, m: c_int, window: usize, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_consistency_assign_q31(c: *mut kq_consistency_q31, m: c_int, window: usize, memory: *mut i32, length: usize) -> kq_status;
    pub fn kq_consistency_clear_f32(c: *mut kq_consistency_f32) -> kq_status;
    pub fn kq_consistency_clear_f64(c: *mut kq_consistency_f64) -> kq_status;
    pub fn kq_consistency_clear_q31(c: *mut kq_consistency_q31) -> kq_status;
    pub fn kq_consistency_watch_f32(c: *mut kq_consistency_f32, f: *const kq_filter_f32, s: *const kq_sensor_f32, z: *const f32, present: u32) -> kq_status;
    pub fn kq_consistency_watch_f64(c: *mut kq_consistency_f64, f: *const kq_filter_f64, s: *const kq_sensor_f64, z: *const f64, present: u32) -> kq_status;
    pub fn kq_consistency_watch_q31(c: *mut kq_consistency_q31, f: *const kq_filter_q31, s: *const kq_sensor_q31, z: *const i32, present: u32) -> kq_status;
    pub fn kq_consistency_record_f32(c: *mut kq_consistency_f32, f: *const kq_filter_f32) -> kq_status;
    pub fn kq_consistency_record_f64(c: *mut kq_consistency_f64, f: *const kq_filter_f64) -> kq_status;
    pub fn kq_consistency_record_q31(c: *mut kq_consistency_q31, f: *const kq_filter_q31) -> kq_status;
    pub fn kq_consistency_count_f32(c: *const kq_consistency_f32) -> usize;
    pub fn kq_consistency_count_f64(c: *const kq_consistency_f64) -> usize;
    pub fn kq_consistency_count_q31(c: *const kq_consistency_q31) -> usize;
    pub fn kq_consistency_nis_f32(c: *const kq_consistency_f32, q: f32, nis: *mut f32, low: *mut f32, high: *mut f32) -> kq_status;
    pub fn kq_consistency_nis_f64(c: *const kq_consistency_f64, q: f64, nis: *mut f64, low: *mut f64, high: *mut f64) -> kq_status;
    pub fn kq_consistency_nis_q31(c: *const kq_consistency_q31, q: i64, nis: *mut i64, low: *mut i64, high: *mut i64) -> kq_status;
    pub fn kq_consistency_innovation_f32(c: *const kq_consistency_f32, component: c_int, q: f32, mean: *mut f32, mean_bound: *mut f32, correlation: *mut f32, correlation_bound: *mut f32) -> kq_status;
    pub fn kq_consistency_innovation_f64(c: *const kq_consistency_f64, component: c_int, q: f64, mean: *mut f64, mean_bound: *mut f64, correlation: *mut f64, correlation_bound: *mut f64) -> kq_status;
    pub fn kq_consistency_innovation_q31(c: *const kq_consistency_q31, component: c_int, q: i64, mean: *mut i64, mean_bound: *mut i64, correlation: *mut i64, correlation_bound: *mut i64) -> kq_status;
    pub fn kq_em_assign_f32(em: *mut kq_em_f32, n: c_int, m: c_int, memory: *mut f32, length: usize) -> kq_status;
    pub fn kq_em_assign_f64(em: *mut kq_em_f64, n: c_int, m: c_int, memory: *mut f64, length: usize) -> kq_status;
    pub fn kq_em_init_f32(em: *mut kq_em_f32, model: *const kq_parameters_f32, choice: *const kq_em_choice, recordings: *const kq_recording_f32, count: usize) -> kq_status;
    pub fn kq_em_init_f64(em: *mut kq_em_f64, model: *const kq_parameters_f64, choice: *const kq_em_choice, recordings: *const kq_recording_f64, count: usize) -> kq_status;
    pub fn kq_em_iterate_f32(em: *mut kq_em_f32) -> kq_status;
    pub fn kq_em_iterate_f64(em: *mut kq_em_f64) -> kq_status;
    pub fn kq_em_advance_f32(em: *mut kq_em_f32) -> kq_status;
    pub fn kq_em_advance_f64(em: *mut kq_em_f64) -> kq_status;
    pub fn kq_em_remaining_f32(em: *const kq_em_f32) -> u32;
    pub fn kq_em_remaining_f64(em: *const kq_em_f64) -> u32;
    pub fn kq_em_log_likelihood_f32(em: *const kq_em_f32) -> f32;
    pub fn kq_em_log_likelihood_f64(em: *const kq_em_f64) -> f64;
    pub fn kq_em_maximise_f32(em: *mut kq_em_f32) -> kq_status;
    pub fn kq_em_maximise_f64(em: *mut kq_em_f64) -> kq_status;
    pub fn kq_em_change_f32(em: *const kq_em_f32) -> f32;
    pub fn kq_em_change_f64(em: *const kq_em_f64) -> f64;
    pub fn kq_em_distance_f32(em: *const kq_em_f32) -> f32;
    pub fn kq_em_distance_f64(em: *const kq_em_f64) -> f64;
    pub fn kq_em_gradient_f32(em: *const kq_em_f32, gradient: *const kq_gradient_f32) -> kq_status;
    pub fn kq_em_gradient_f64(em: *const kq_em_f64, gradient: *const kq_gradient_f64) -> kq_status;
    pub fn kq_length_f32(object: kq_object, n: c_int, m: c_int, k: usize, l: usize) -> u64;
    pub fn kq_length_f64(object: kq_object, n: c_int, m: c_int, k: usize, l: usize) -> u64;
    pub fn kq_length_q31(object: kq_object, n: c_int, m: c_int, k: usize, l: usize) -> u64;
    pub fn kq_object_size_f32(object: kq_object) -> usize;
    pub fn kq_object_size_f64(object: kq_object) -> usize;
    pub fn kq_object_size_q31(object: kq_object) -> usize;
    pub fn kq_self_test_f32() -> kq_status;
    pub fn kq_self_test_f64() -> kq_status;
    pub fn kq_self_test_q31() -> kq_status;
}
