//! The cart of the C library's README in fixed point, with the same tables; its C program is one of the library's tests.

use kalmanq::q31::{Format, Scaled};
use kalmanq::{Error, Filter, Process, Sensor, filter_len_q31};

const fn scaled(mantissa: f64, exponent: i32) -> Scaled {
    Scaled { mantissa: mantissa as i32, exponent }
}

const fn power(n: u32) -> f64 {
    (1u64 << n) as f64
}

static STATE: [Format; 2] = [Format { range: 1000 << 20, fraction: 20 }, Format { range: 50 << 20, fraction: 20 }];
static MILLIMETRES: [Format; 1] = [Format { range: 1000000, fraction: 0 }];
static A: [[Scaled; 2]; 2] =
    [[scaled(power(30), -30), scaled(0.1 * power(34) + 0.5, -34)], [scaled(0.0, 0), scaled(power(30), -30)]];
static H: [[Scaled; 2]; 1] = [[scaled(1000.0 * power(21), -41), scaled(0.0, 0)]];
static R: [Scaled; 1] = [scaled(40000.0 * power(15), -15)];
static G: [i32; 5] = [0, (0.005 * power(36) + 0.5) as i32, (0.1 * power(33) + 0.5) as i32, -16, -13];
static SIGMA0: [i32; 5] = [10 << 26, 0, 3 << 28, -6, -8];

/// Mean and sigma of the position after each of 8 measurements, of which one is lost.
pub fn readings() -> Result<[[i32; 2]; 8], Error> {
    let mut memory = [0; filter_len_q31(2)];
    let motion = Process::from_tables(&STATE, &[], &A, &[[], []], &G)?;
    let ranger = Sensor::from_tables(&STATE, &MILLIMETRES, &H, &R)?;
    let mut cart = Filter::from_tables(&STATE, &[0, 0], &SIGMA0, &mut memory)?;
    let mut readings = [[0; 2]; 8];
    for (t, z) in [1140, 1020, 1370, 1580, 0, 1790, 1860, 2310].into_iter().enumerate() {
        if t > 0 {
            cart.predict(&motion, &[])?;
        }
        if t != 4 {
            cart.update(&ranger, &[z])?;
        }
        readings[t] = [cart.mean()[0], cart.sigma()[0]];
    }
    Ok(readings)
}
