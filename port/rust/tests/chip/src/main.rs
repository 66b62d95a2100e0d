//! The same program on the host and on a chip: bits of means and sigmas, for the script to compare.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[path = "../../cart/mod.rs"]
mod cart;

use core::ffi::{c_int, c_void};
use core::fmt::Write;
use kalmanq::{Error, Events, Filter, Process, Sensor, filter_len_f32, filter_len_f64, filter_len_q31, process_len, q31, sensor_len, sys};

unsafe extern "C" {
    fn write(file: c_int, text: *const c_void, length: usize) -> isize;
}

struct Output;

impl Write for Output {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        unsafe { write(1, text.as_ptr().cast(), text.len()) };
        Ok(())
    }
}

macro_rules! run {
    ($number:ident, $filter_len:ident) => {{
        let (mut a, mut b, mut c) = ([0.0; process_len(2)], [0.0; sensor_len(2)], [0.0; $filter_len(2)]);
        let process = Process::new(&[[1.0 as $number, 0.1], [0.0, 0.95]], &[[0.005], [0.1]], &[[0.02, 0.01], [0.01, 0.03]], &mut a)?;
        let sensor = Sensor::new(&[[1.0, 0.0], [0.5, 1.0]], &[[0.4, 0.1], [0.1, 0.3]], &mut b)?;
        let mut filter = Filter::new(&[1.0, -1.0], &[[2.0, 0.5], [0.5, 3.0]], &mut c)?;
        for k in 0..100 {
            let z = (k * 37 % 11) as $number / 8.0;
            if k % 5 == 3 {
                filter.predict(&process, &[0.25])?;
                filter.update_present(&sensor, &[None, Some(z)])?;
            } else {
                filter.step(&process, &[0.25], &sensor, &[z, -z])?;
            }
        }
        let (mean, sigma, nis) = (filter.mean(), filter.sigma(), filter.nis());
        let _ = writeln!(Output, "{} {:x} {:x} {:x} {:x} {:x} {}", stringify!($number), mean[0].to_bits(), mean[1].to_bits(),
            sigma[0].to_bits(), sigma[1].to_bits(), nis.to_bits(), filter.taken());
        let refused = filter.update(&sensor, &[$number::NAN, 0.0]);
        let _ = writeln!(Output, "{refused:?} {} {:?}", refused.unwrap_err(), filter.events() == Events(0));
    }};
}

/// Of structs: whether Rust's are as large as C's
fn sizes() -> bool {
    unsafe {
        size_of::<sys::kq_process_f32>() == sys::kq_object_size_f32(sys::KQ_OBJECT_PROCESS)
            && size_of::<sys::kq_sensor_f32>() == sys::kq_object_size_f32(sys::KQ_OBJECT_SENSOR)
            && size_of::<sys::kq_filter_f32>() == sys::kq_object_size_f32(sys::KQ_OBJECT_FILTER)
            && size_of::<sys::kq_filter_f64>() == sys::kq_object_size_f64(sys::KQ_OBJECT_FILTER)
            && size_of::<sys::kq_filter_q31>() == sys::kq_object_size_q31(sys::KQ_OBJECT_FILTER)
            && size_of::<sys::kq_lag_q31>() == sys::kq_object_size_q31(sys::KQ_OBJECT_LAG)
    }
}

fn filters() -> Result<(), Error> {
    run!(f32, filter_len_f32);
    run!(f64, filter_len_f64);
    let _ = writeln!(Output, "q31 {:?}", cart::readings()?);
    prepared()
}

/// Fixed point with tables that the chip makes
fn prepared() -> Result<(), Error> {
    let (states, measured) = ([q31::format(20.0, None)?; 2], [q31::format(8.0, None)?; 1]);
    let (a, h) = (q31::matrix(&[[1.0, 0.1], [0.0, 0.95]], &states, &states)?, q31::matrix(&[[0.5, 1.0]], &measured, &states)?);
    let (mut g, mut p0, mut c) = ([0; q31::root_len(2)], [0; q31::root_len(2)], [0; filter_len_q31(2)]);
    q31::root(&[[0.02, 0.01], [0.01, 0.03]], &states, &mut g)?;
    q31::root(&[[2.0, 0.5], [0.5, 3.0]], &states, &mut p0)?;
    let r = q31::noise_diagonal(&[0.3], &measured)?;
    let process = Process::from_tables(&states, &[], &a, &[[], []], &g)?;
    let sensor = Sensor::from_tables(&states, &measured, &h, &r)?;
    let mut filter = Filter::from_tables(&states, &q31::raw(&[1.0, -1.0], &states)?, &p0, &mut c)?;
    for k in 0..100 {
        filter.step(&process, &[], &sensor, &[(k * 37 % 11) << 26])?;
    }
    let _ = writeln!(Output, "q31 {:?} {:?} {} {:?}", filter.mean(), filter.sigma(), filter.nis(), filter.events() == Events(0));
    Ok(())
}

fn run() -> c_int {
    let done = filters();
    let _ = writeln!(Output, "sizes {} done {done:?}", sizes());
    done.is_err() as c_int
}

#[cfg(not(target_os = "none"))]
fn main() {
    std::process::exit(run());
}

#[cfg(target_os = "none")]
#[unsafe(no_mangle)]
extern "C" fn main() -> c_int {
    run()
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    unsafe extern "C" {
        fn _Exit(status: c_int) -> !;
    }
    unsafe { _Exit(98) }
}
