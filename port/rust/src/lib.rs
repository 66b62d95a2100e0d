//! Kalman filters for microcontrollers: the C library kalmanq, with sizes that the compiler checks.
//!
//! A process, a sensor and a filter borrow their matrices and their memory; nothing is allocated.  `T` is `f32` or
//! `f64`, or `i32` in the fixed point of [`q31`].  `N`, `L` and `M` are the states, the controls and the measured components, 1 to 16 (`L` may be 0).
//!
//! ```
//! use kalmanq::{Filter, Process, Sensor, filter_len_f32, process_len, sensor_len};
//!
//! let (mut drift_memory, mut gauge_memory) = ([0.0; process_len(1)], [0.0; sensor_len(1)]);
//! let mut level_memory = [0.0; filter_len_f32(1)];
//! let drift = Process::new(&[[1.0f32]], &[[]], &[[0.01]], &mut drift_memory)?;
//! let gauge = Sensor::new(&[[1.0]], &[[4.0]], &mut gauge_memory)?;
//! let mut level = Filter::new(&[0.0], &[[1e6]], &mut level_memory)?;
//! for z in [511.0, 514.0, 509.0, 512.0, 510.0] {
//!     level.step(&drift, &[], &gauge, &[z])?;
//! }
//! assert_eq!(format!("{:.2} +- {:.2}", level.mean()[0], level.sigma()[0]), "511.19 +- 0.90");
//! # Ok::<(), kalmanq::Error>(())
//! ```
//!
//! A matrix of another size is an error of the compiler:
//!
//! ```compile_fail
//! use kalmanq::{Filter, Sensor, filter_len_f32, sensor_len};
//! let (mut sensor_memory, mut memory) = ([0.0; sensor_len(1)], [0.0; filter_len_f32(2)]);
//! let sensor = Sensor::new(&[[1.0f32]], &[[4.0]], &mut sensor_memory).unwrap(); // of one state
//! let mut filter = Filter::new(&[0.0f32; 2], &[[1.0, 0.0], [0.0, 1.0]], &mut memory).unwrap();
//! filter.update(&sensor, &[1.0]).unwrap();
//! ```
//!
//! [`sys`] has every function of the C library, smoothers too; they are unsafe.

#![no_std]

mod number;
pub mod q31;
#[rustfmt::skip]
pub mod sys;

use core::ffi::{CStr, c_int, c_uint};
use core::fmt;
use core::marker::PhantomData;
use core::mem::MaybeUninit;
use core::ptr;

pub use number::{Float, Number};

/// Numbers of memory of a process with `n` states.
pub const fn process_len(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Numbers of memory of a sensor with `m` components.
pub const fn sensor_len(m: usize) -> usize {
    m * (m + 1) / 2
}

/// Numbers of memory of a filter with `n` states in `f32`.
pub const fn filter_len_f32(n: usize) -> usize {
    2 * n + n * (n + 1) / 2
}

/// Numbers of memory of a filter with `n` states in `f64`.
pub const fn filter_len_f64(n: usize) -> usize {
    n + n * (n + 1) / 2
}

/// Words of memory of a filter with `n` states in [`q31`].
pub const fn filter_len_q31(n: usize) -> usize {
    2 * n + q31::root_len(n)
}

/// Why a call was refused.  It has changed nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Error {
    /// N or M is 0, or a size is above 16.
    Size,
    /// The memory is shorter than `process_len`, `sensor_len` or `filter_len` says.
    Memory,
    /// A matrix, vector or measurement holds NaN or infinity.
    NotFinite,
    /// A covariance differs from its transpose by more than rounding.
    NotSymmetric,
    /// A negative variance, or an eigenvalue negative beyond rounding.
    NotSemidefinite,
    /// A value is outside its range.
    Range,
    /// A format of [`q31`] does not fit the model.
    Format(RangeError),
    /// Another status of the C library.
    Other(c_int),
}

/// The component whose format does not fit, and how many more integer bits it needs.  0 bits: a value is outside the
/// declared range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RangeError {
    /// `sys::KQ_STATE`, `KQ_CONTROL` or `KQ_MEASUREMENT`.
    pub quantity: c_int,
    pub component: i32,
    pub bits: i32,
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = sys::kq_range_error_q31 { quantity: self.quantity, component: self.component, bits: self.bits };
        let mut text = [0u8; 80];
        // SAFETY: C writes no more than the length, and a 0
        unsafe { sys::kq_range_error_text_q31(&error, text.as_mut_ptr().cast(), text.len()) };
        f.write_str(CStr::from_bytes_until_nul(&text).ok().and_then(|one| one.to_str().ok()).unwrap_or(""))
    }
}

const ERRORS: [(c_int, Error); 6] = [
    (sys::KQ_ERR_SIZE, Error::Size),
    (sys::KQ_ERR_MEMORY, Error::Memory),
    (sys::KQ_ERR_NOT_FINITE, Error::NotFinite),
    (sys::KQ_ERR_NOT_SYMMETRIC, Error::NotSymmetric),
    (sys::KQ_ERR_NOT_SEMIDEFINITE, Error::NotSemidefinite),
    (sys::KQ_ERR_RANGE, Error::Range),
];

impl Error {
    /// The `kq_status`.
    pub fn status(self) -> c_int {
        match self {
            Error::Other(status) => status,
            Error::Format(_) => sys::KQ_ERR_RANGE,
            known => ERRORS.iter().find(|one| one.1 == known).map_or(0, |one| one.0),
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Error::Format(error) = self {
            return error.fmt(f);
        }
        // SAFETY: a static text, never NULL
        let text = unsafe { CStr::from_ptr(sys::kq_status_text(self.status())) };
        f.write_str(text.to_str().unwrap_or("an unknown status"))
    }
}

impl core::error::Error for Error {}

/// What a status says.  A positive one is a remark of a call that is done.
fn checked(status: c_int) -> Result<(), Error> {
    if status >= 0 {
        return Ok(());
    }
    Err(ERRORS.iter().find(|one| one.0 == status).map_or(Error::Other(status), |one| one.1))
}

/// What numbers made a filter do; a bit stays until [`Filter::clear_events`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Events(pub c_uint);

impl Events {
    /// A measurement was redundant and not taken: its innovation variance was rounding.
    pub const REDUNDANT: Events = Events(sys::KQ_EVENT_REDUNDANT);
    /// A variance or a mean was not representable.
    pub const OVERFLOW: Events = Events(sys::KQ_EVENT_OVERFLOW);
    /// In q31: a state was saturated at +-2^31 raw values.
    pub const SATURATED: Events = Events(sys::KQ_EVENT_SATURATED);
    /// Precision lost: a sigma may be wrong by more than 5 %.
    pub const PRECISION: Events = Events(sys::KQ_EVENT_PRECISION);
    /// A low-noise measurement contradicts what was known.
    pub const CONTRADICTION: Events = Events(sys::KQ_EVENT_CONTRADICTION);

    /// Whether nothing unusual has happened.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether all of `other` has happened.
    pub const fn contains(self, other: Events) -> bool {
        self.0 & other.0 == other.0
    }
}

impl core::ops::BitOr for Events {
    type Output = Events;
    fn bitor(self, other: Events) -> Events {
        Events(self.0 | other.0)
    }
}

/// Sizes go to C as `int`; one that is too large there is refused as too large, whatever it is.
fn size(n: usize) -> c_int {
    c_int::try_from(n).unwrap_or(c_int::MAX)
}

/// The first number of a vector or matrix; C wants NULL for one without any.
fn first<T, V>(of: &V) -> *const T {
    if size_of::<V>() == 0 { ptr::null() } else { (of as *const V).cast() }
}

/// An object of the C library before its assign.
fn unassigned<S>() -> S {
    // SAFETY: only called for the C structs of `sys`: numbers and pointers, for which zeros are a value
    unsafe { MaybeUninit::zeroed().assume_init() }
}

/// How the state moves: x <- A x + B u + w, w with covariance Q.
pub struct Process<'a, T: Number, const N: usize, const L: usize> {
    raw: T::Process,
    borrowed: PhantomData<(&'a [T], &'a mut [T])>,
}

impl<'a, T: Float, const N: usize, const L: usize> Process<'a, T, N, L> {
    /// `a` and `b` stay borrowed; `q` is symmetric and positive semi-definite, may be singular.  `memory` has
    /// [`process_len`]`(N)` numbers.
    pub fn new(a: &'a [[T; N]; N], b: &'a [[T; L]; N], q: &[[T; N]; N], memory: &'a mut [T]) -> Result<Self, Error> {
        let mut raw = unassigned();
        // SAFETY: the arrays have the sizes that C is told, and outlive `raw`
        unsafe {
            checked(T::process_assign(&mut raw, size(N), size(L), memory.as_mut_ptr(), memory.len()))?;
            checked(T::process_init(&mut raw, first(a), first(b), first(q)))?;
        }
        Ok(Self { raw, borrowed: PhantomData })
    }
}

/// What is measured: z = H x + v, v with covariance R.
pub struct Sensor<'a, T: Number, const N: usize, const M: usize> {
    raw: T::Sensor,
    borrowed: PhantomData<(&'a [T], &'a mut [T])>,
}

impl<'a, T: Float, const N: usize, const M: usize> Sensor<'a, T, N, M> {
    /// `h` and `r` stay borrowed; `r` is symmetric and positive semi-definite, may be 0.  `memory` has
    /// [`sensor_len`]`(M)` numbers.
    pub fn new(h: &'a [[T; N]; M], r: &'a [[T; M]; M], memory: &'a mut [T]) -> Result<Self, Error> {
        let mut raw = unassigned();
        // SAFETY: as in Process::new
        unsafe {
            checked(T::sensor_assign(&mut raw, size(N), size(M), memory.as_mut_ptr(), memory.len()))?;
            checked(T::sensor_init(&mut raw, first(h), first(r)))?;
        }
        Ok(Self { raw, borrowed: PhantomData })
    }
}

/// The estimate: a mean and a covariance.
pub struct Filter<'a, T: Number, const N: usize> {
    raw: T::Filter,
    borrowed: PhantomData<&'a mut [T]>,
}

// SAFETY: each is the only one that has its memory, and has no state elsewhere; by `&` the C library only reads it
unsafe impl<T: Number, const N: usize, const L: usize> Send for Process<'_, T, N, L> {}
unsafe impl<T: Number, const N: usize, const L: usize> Sync for Process<'_, T, N, L> {}
unsafe impl<T: Number, const N: usize, const M: usize> Send for Sensor<'_, T, N, M> {}
unsafe impl<T: Number, const N: usize, const M: usize> Sync for Sensor<'_, T, N, M> {}
unsafe impl<T: Number, const N: usize> Send for Filter<'_, T, N> {}
unsafe impl<T: Number, const N: usize> Sync for Filter<'_, T, N> {}

// SAFETY, of all calls below: every object was initialised by its `new` for the sizes of its type, what it borrows is
// still borrowed, and every array has the size that C reads or writes.
impl<'a, T: Float, const N: usize> Filter<'a, T, N> {
    /// The state before the first measurement: mean `x0`, covariance `p0`; neither stays borrowed.  `memory` has
    /// [`filter_len_f32`]`(N)` or [`filter_len_f64`]`(N)` numbers.
    pub fn new(x0: &[T; N], p0: &[[T; N]; N], memory: &'a mut [T]) -> Result<Self, Error> {
        let mut raw = unassigned();
        unsafe {
            checked(T::filter_assign(&mut raw, size(N), memory.as_mut_ptr(), memory.len()))?;
            checked(T::filter_init(&mut raw, first(x0), first(p0)))?;
        }
        Ok(Self { raw, borrowed: PhantomData })
    }
}

// SAFETY: as above
impl<T: Number, const N: usize> Filter<'_, T, N> {
    /// x <- A x + B u,  P <- A P A' + Q.
    pub fn predict<const L: usize>(&mut self, process: &Process<'_, T, N, L>, u: &[T; L]) -> Result<(), Error> {
        checked(unsafe { T::predict(&mut self.raw, &process.raw, first(u)) })
    }

    /// Takes the measurement `z`.
    pub fn update<const M: usize>(&mut self, sensor: &Sensor<'_, T, N, M>, z: &[T; M]) -> Result<(), Error> {
        checked(unsafe { T::update(&mut self.raw, &sensor.raw, first(z)) })
    }

    /// Takes those components of a measurement that are there.
    pub fn update_present<const M: usize>(
        &mut self,
        sensor: &Sensor<'_, T, N, M>,
        z: &[Option<T>; M],
    ) -> Result<(), Error> {
        let present = (0..M.min(32)).filter(|&c| z[c].is_some()).fold(0, |bits, c| bits | 1 << c);
        let values = z.map(|one| one.unwrap_or(T::ZERO));
        checked(unsafe { T::update_subset(&mut self.raw, &sensor.raw, first(&values), present) })
    }

    /// [`Filter::predict`], then [`Filter::update`]; if one of them is refused, neither is done.
    pub fn step<const L: usize, const M: usize>(
        &mut self,
        process: &Process<'_, T, N, L>,
        u: &[T; L],
        sensor: &Sensor<'_, T, N, M>,
        z: &[T; M],
    ) -> Result<(), Error> {
        checked(unsafe { T::step(&mut self.raw, &process.raw, first(u), &sensor.raw, first(z)) })
    }

    /// The mean of each state.
    pub fn mean(&self) -> [T; N] {
        core::array::from_fn(|i| unsafe { T::mean(&self.raw, size(i)) })
    }

    /// The standard deviation of each state; the 95 % interval is mean +- 1.96 sigma.
    pub fn sigma(&self) -> [T; N] {
        core::array::from_fn(|i| unsafe { T::sigma(&self.raw, size(i)) })
    }

    /// The covariance P.
    pub fn covariance(&self) -> Result<[[T::Entry; N]; N], Error> {
        let mut p = [[T::ZERO_ENTRY; N]; N];
        checked(unsafe { T::covariance(&self.raw, p.as_mut_ptr().cast()) })?;
        Ok(p)
    }

    /// z - H x, before the update.
    pub fn innovation<const M: usize>(&self, sensor: &Sensor<'_, T, N, M>, z: &[T; M]) -> Result<[T; M], Error> {
        let mut e = [T::ZERO; M];
        checked(unsafe { T::innovation(&self.raw, &sensor.raw, first(z), e.as_mut_ptr()) })?;
        Ok(e)
    }

    /// e' S^-1 e of the last update: chi-square with [`Filter::taken`] degrees of freedom if the model is right.
    pub fn nis(&self) -> T::Score {
        unsafe { T::nis(&self.raw) }
    }

    /// How many components the last update took.
    pub fn taken(&self) -> c_int {
        unsafe { T::taken(&self.raw) }
    }

    /// The log-likelihood of all measurements so far.
    pub fn log_likelihood(&self) -> T::Score {
        unsafe { T::log_likelihood(&self.raw) }
    }

    /// What has happened since [`Filter::new`] or [`Filter::clear_events`].
    pub fn events(&self) -> Events {
        Events(unsafe { T::events(&self.raw) })
    }

    /// Forgets the events.
    pub fn clear_events(&mut self) {
        unsafe { T::events_clear(&mut self.raw) }
    }
}
