//! Fixed point: models of the q31 arithmetic, in which a state, control or measurement is an `i32`, a raw value.
//!
//! A component has a [`Format`]: value = raw value * 2^-fraction, within the declared range.  The functions of this module
//! make the C library's tables from numbers of `f64`, on the chip or on the host; a chip may also have them as `static`.
//! `Process`, `Sensor` and `Filter` refer to the tables; their calls are those of floating point, in raw values.
//!
//! ```
//! use kalmanq::{Filter, Process, Sensor, filter_len_q31, q31};
//!
//! let metres = [q31::format(1000.0, Some(20))?]; // +-1000 m in Q11.20
//! let millimetres = [q31::format(1e6, Some(0))?];
//! let (a, h) = (q31::matrix(&[[1.0]], &metres, &metres)?, q31::matrix(&[[1000.0]], &millimetres, &metres)?);
//! let (mut g, mut p0, mut memory) = ([0; q31::root_len(1)], [0; q31::root_len(1)], [0; filter_len_q31(1)]);
//! q31::root(&[[1e-4]], &metres, &mut g)?;
//! q31::root(&[[100.0]], &metres, &mut p0)?;
//! let r = q31::noise_diagonal(&[40000.0], &millimetres)?; // (200 mm)^2
//! let drift = Process::from_tables(&metres, &[], &a, &[[]], &g)?;
//! let gauge = Sensor::from_tables(&metres, &millimetres, &h, &r)?;
//! let mut level = Filter::from_tables(&metres, &q31::raw(&[0.0], &metres)?, &p0, &mut memory)?;
//! for z in [5110, 5140, 5090] {
//!     level.step(&drift, &[], &gauge, &[z])?;
//! }
//! assert_eq!((level.mean(), level.sigma()), ([5360968], [121323])); // 5.1126 m +- 0.1157 m
//! # Ok::<(), kalmanq::Error>(())
//! ```

use crate::{Error, Filter, Process, RangeError, Sensor, checked, first, sensor_len, size, sys, unassigned};
use core::ffi::c_int;
use core::marker::PhantomData;

/// The format of a component: `range` in raw values, and `fraction`, n of Qm.n.
pub use sys::kq_format_q31 as Format;
/// A coefficient: mantissa * 2^exponent, in units of raw values.
pub use sys::kq_scaled_q31 as Scaled;

/// Words of a root of N states.
pub const fn root_len(n: usize) -> usize {
    n * (n + 1) / 2 + n
}

/// What a status says, with the format that does not fit, if it is one.
fn fits(status: c_int, error: sys::kq_range_error_q31) -> Result<(), Error> {
    let sys::kq_range_error_q31 { quantity, component, bits } = error;
    match checked(status) {
        Err(Error::Range) if quantity != sys::KQ_NO_RANGE_ERROR => {
            Err(Error::Format(RangeError { quantity, component, bits }))
        }
        other => other,
    }
}

const NONE: sys::kq_range_error_q31 =
    sys::kq_range_error_q31 { quantity: sys::KQ_NO_RANGE_ERROR, component: 0, bits: 0 };
const ZERO: Scaled = Scaled { mantissa: 0, exponent: 0 };

/// Whether a slice has what C reads or writes of it.
fn long_enough(length: usize, needed: usize) -> Result<(), Error> {
    if length < needed { Err(Error::Memory) } else { Ok(()) }
}

/// The format of +-`range`; `None`: the most fraction bits that hold it.
pub fn format(range: f64, fraction: Option<i32>) -> Result<Format, Error> {
    let mut format = Format { range: 0, fraction: 0 };
    // 1000: KQ_FRACTION_BEST_Q31; a fraction of that size is none
    let fraction = fraction.map_or(1000, |n| if n == 1000 { c_int::MAX } else { n });
    // SAFETY: one format is written
    checked(unsafe { sys::kq_format_prepare_q31(&mut format, fraction, range, core::ptr::null_mut()) })?;
    Ok(format)
}

/// A, B or H as a table.
pub fn matrix<const R: usize, const C: usize>(
    m: &[[f64; C]; R],
    rows: &[Format; R],
    columns: &[Format; C],
) -> Result<[[Scaled; C]; R], Error> {
    let mut table = [[ZERO; C]; R];
    let to = table.as_mut_ptr().cast();
    // SAFETY: the arrays have the sizes that C is told
    checked(unsafe { sys::kq_matrix_prepare_q31(to, first(m), size(R), size(C), first(rows), first(columns)) })?;
    Ok(table)
}

/// The root of a covariance of the states, Q or P0, in [`root_len`]`(N)` words.
pub fn root<const N: usize>(p: &[[f64; N]; N], states: &[Format; N], root: &mut [i32]) -> Result<(), Error> {
    long_enough(root.len(), root_len(N))?;
    // SAFETY: as in matrix; `root` is as long as C writes
    checked(unsafe { sys::kq_root_prepare_q31(root.as_mut_ptr(), first(p), size(N), first(states)) })
}

/// R of independent components: variances.
pub fn noise_diagonal<const M: usize>(r: &[f64; M], measurements: &[Format; M]) -> Result<[Scaled; M], Error> {
    let mut table = [ZERO; M];
    // SAFETY: as in matrix
    checked(unsafe { sys::kq_noise_prepare_diagonal_q31(table.as_mut_ptr(), first(r), size(M), first(measurements)) })?;
    Ok(table)
}

/// R of correlated components, in [`sensor_len`]`(M)` numbers.
pub fn noise<const M: usize>(r: &[[f64; M]; M], measurements: &[Format; M], table: &mut [Scaled]) -> Result<(), Error> {
    long_enough(table.len(), sensor_len(M))?;
    // SAFETY: as in root
    checked(unsafe { sys::kq_noise_prepare_q31(table.as_mut_ptr(), first(r), size(M), first(measurements)) })
}

/// Raw values, rounded to nearest.
pub fn raw<const N: usize>(x: &[f64; N], formats: &[Format; N]) -> Result<[i32; N], Error> {
    let (mut raw, mut error) = ([0; N], NONE);
    // SAFETY: as in matrix
    let status = unsafe { sys::kq_vector_prepare_q31(raw.as_mut_ptr(), first(x), size(N), first(formats), &mut error) };
    fits(status, error)?;
    Ok(raw)
}

impl<'a, const N: usize, const L: usize> Process<'a, i32, N, L> {
    /// All tables stay borrowed; `g` is the root of Q.  Refused if a sum of products could overflow: [`Error::Format`].
    pub fn from_tables(
        states: &'a [Format; N],
        controls: &'a [Format; L],
        a: &'a [[Scaled; N]; N],
        b: &'a [[Scaled; L]; N],
        g: &'a [i32],
    ) -> Result<Self, Error> {
        long_enough(g.len(), root_len(N))?;
        let (mut raw, mut error) = (unassigned(), NONE);
        let table = sys::kq_process_table_q31 {
            states: size(N),
            controls: size(L),
            state_format: first(states),
            control_format: first(controls),
            transition: first(a),
            control: first(b),
            noise_root: g.as_ptr(),
        };
        // SAFETY: the arrays have the sizes that C is told, and outlive `raw`
        fits(unsafe { sys::kq_process_init_q31(&mut raw, &table, &mut error) }, error)?;
        Ok(Self { raw, borrowed: PhantomData })
    }
}

impl<'a, const N: usize, const M: usize> Sensor<'a, i32, N, M> {
    /// Independent components.  All tables stay borrowed.
    pub fn from_tables(
        states: &'a [Format; N],
        measurements: &'a [Format; M],
        h: &'a [[Scaled; N]; M],
        r: &'a [Scaled; M],
    ) -> Result<Self, Error> {
        let (mut raw, mut error) = (unassigned(), NONE);
        let table = sensor_table(states, measurements, h, r, 0);
        // SAFETY: as in Process::from_tables
        fits(unsafe { sys::kq_sensor_init_diagonal_q31(&mut raw, &table, &mut error) }, error)?;
        Ok(Self { raw, borrowed: PhantomData })
    }

    /// Correlated components: `r` is what [`noise`] makes.
    pub fn from_tables_correlated(
        states: &'a [Format; N],
        measurements: &'a [Format; M],
        h: &'a [[Scaled; N]; M],
        r: &'a [Scaled],
    ) -> Result<Self, Error> {
        long_enough(r.len(), sensor_len(M))?;
        let (mut raw, mut error) = (unassigned(), NONE);
        let table = sensor_table(states, measurements, h, r, 1);
        // SAFETY: as in Process::from_tables; `r` is as long as C reads
        fits(unsafe { sys::kq_sensor_init_q31(&mut raw, &table, &mut error) }, error)?;
        Ok(Self { raw, borrowed: PhantomData })
    }
}

fn sensor_table<const N: usize, const M: usize>(
    states: &[Format; N],
    measurements: &[Format; M],
    h: &[[Scaled; N]; M],
    r: &[Scaled],
    correlated: i32,
) -> sys::kq_sensor_table_q31 {
    sys::kq_sensor_table_q31 {
        states: size(N),
        components: size(M),
        correlated,
        state_format: first(states),
        measurement_format: first(measurements),
        measurement: first(h),
        noise: r.as_ptr(),
    }
}

impl<'a, const N: usize> Filter<'a, i32, N> {
    /// Before the first measurement: raw values `x0`, and the root of P0; neither stays borrowed.  `memory` has
    /// [`filter_len_q31`](crate::filter_len_q31)`(N)` words.
    pub fn from_tables(
        states: &'a [Format; N],
        x0: &[i32; N],
        p0: &[i32],
        memory: &'a mut [i32],
    ) -> Result<Self, Error> {
        long_enough(p0.len(), root_len(N))?;
        let (mut raw, mut error) = (unassigned(), NONE);
        let prior = sys::kq_prior_table_q31 {
            states: size(N),
            state_format: first(states),
            mean: first(x0),
            root: p0.as_ptr(),
        };
        // SAFETY: as in Process::from_tables
        unsafe {
            checked(sys::kq_filter_assign_q31(&mut raw, size(N), memory.as_mut_ptr(), memory.len()))?;
            fits(sys::kq_filter_init_q31(&mut raw, &prior, &mut error), error)?;
        }
        Ok(Self { raw, borrowed: PhantomData })
    }
}
