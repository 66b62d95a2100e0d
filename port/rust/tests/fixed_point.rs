//! Fixed point: the C program's words, the filter of f64, and what is refused.

mod cart;

use kalmanq::q31::{self, Format};
use kalmanq::{Error, Events, Filter, Process, RangeError, Sensor, filter_len_f64, filter_len_q31};
use kalmanq::{process_len, sensor_len, sys};

const A: [[f64; 2]; 2] = [[1.0, 0.1], [0.0, 0.95]];
const B: [[f64; 1]; 2] = [[0.005], [0.1]];
const Q: [[f64; 2]; 2] = [[0.02, 0.01], [0.01, 0.03]];
const H: [[f64; 2]; 2] = [[1.0, 0.0], [0.5, 1.0]];
const R: [[f64; 2]; 2] = [[0.4, 0.1], [0.1, 0.3]];

fn formats<const N: usize>(ranges: [f64; N]) -> [Format; N] {
    ranges.map(|range| q31::format(range, None).unwrap())
}

#[test]
fn words_are_those_of_the_program_in_c() {
    let words = [
        [1194899, 209673],
        [1099040, 183392],
        [1332578, 180719],
        [1581025, 170847],
        [1742276, 248441],
        [1884499, 177452],
        [1992271, 153624],
        [2265697, 140628],
    ];
    assert_eq!(cart::readings(), Ok(words)); // include/README.md prints them
}

#[test]
fn is_the_filter_of_f64() {
    let (states, controls, measured) = (formats([20.0, 20.0]), formats([2.0]), formats([8.0, 8.0]));
    let (a, b) = (q31::matrix(&A, &states, &states).unwrap(), q31::matrix(&B, &states, &controls).unwrap());
    let h = q31::matrix(&H, &measured, &states).unwrap();
    let (mut g, mut p0, mut r) =
        ([0; q31::root_len(2)], [0; q31::root_len(2)], [q31::Scaled { mantissa: 0, exponent: 0 }; 3]);
    q31::root(&Q, &states, &mut g).unwrap();
    q31::root(&Q, &states, &mut p0).unwrap();
    q31::noise(&R, &measured, &mut r).unwrap();
    let (mut memory, mut of_process, mut of_sensor, mut of_filter) =
        ([0; filter_len_q31(2)], [0.0; process_len(2)], [0.0; sensor_len(2)], [0.0; filter_len_f64(2)]);
    let process = Process::from_tables(&states, &controls, &a, &b, &g).unwrap();
    let sensor = Sensor::from_tables_correlated(&states, &measured, &h, &r).unwrap();
    let mut filter = Filter::from_tables(&states, &[0, 0], &p0, &mut memory).unwrap();
    let process64 = Process::new(&A, &B, &Q, &mut of_process).unwrap();
    let sensor64 = Sensor::new(&H, &R, &mut of_sensor).unwrap();
    let mut filter64 = Filter::new(&[0.0, 0.0], &Q, &mut of_filter).unwrap();
    let value = |raw: i32, format: Format| f64::from(raw) * 2f64.powi(-format.fraction);
    for k in 0..200 {
        let (u, z) = ((k as f64 * 0.3).sin(), [(k as f64 * 0.7).cos() * 2.0, (k as f64 * 1.1).sin()]);
        let (raw_u, raw_z) = (q31::raw(&[u], &controls).unwrap(), q31::raw(&z, &measured).unwrap());
        if k % 3 == 0 {
            filter.predict(&process, &raw_u).unwrap();
            filter.update_present(&sensor, &[None, Some(raw_z[1])]).unwrap();
            filter64.predict(&process64, &[u]).unwrap();
            filter64.update_present(&sensor64, &[None, Some(z[1])]).unwrap();
        } else {
            filter.step(&process, &raw_u, &sensor, &raw_z).unwrap();
            filter64.step(&process64, &[u], &sensor64, &z).unwrap();
        }
        let last = filter.covariance().unwrap()[0][1];
        let unit = 2f64.powi(last.exponent - states[0].fraction - states[1].fraction);
        assert!((f64::from(last.mantissa) * unit - filter64.covariance().unwrap()[0][1]).abs() < 1e-6, "step {k}");
        for i in 0..2 {
            assert!((value(filter.mean()[i], states[i]) - filter64.mean()[i]).abs() < 1e-6, "step {k}");
            assert!((value(filter.sigma()[i], states[i]) - filter64.sigma()[i]).abs() < 1e-6, "step {k}");
        }
    }
    assert_eq!((filter.events(), filter.taken()), (Events(0), 2));
    assert!((filter.nis() as f64 / 2f64.powi(24) - filter64.nis()).abs() < 1e-4);
    assert!((filter.log_likelihood() as f64 / 2f64.powi(24) - filter64.log_likelihood()).abs() < 1e-2);
}

#[test]
fn what_does_not_fit_is_refused_with_its_component() {
    let (wide, narrow) = (formats([1000.0, 1000.0]), formats([1000.0, 1.0]));
    let growing = [[1.0, 0.0], [0.2, 1.0]]; // a thousand of state 0 are 200 of state 1
    let a = q31::matrix(&growing, &narrow, &narrow).unwrap();
    let g = [0; q31::root_len(2)];
    let refused = Process::from_tables(&narrow, &[], &a, &[[], []], &g).err().unwrap();
    assert_eq!(refused, Error::Format(RangeError { quantity: sys::KQ_STATE, component: 1, bits: 3 }));
    assert_eq!(
        (refused.to_string().as_str(), refused.status()),
        ("state 1 needs 3 more integer bits", sys::KQ_ERR_RANGE)
    );
    let a = q31::matrix(&growing, &wide, &wide).unwrap();
    assert!(Process::from_tables(&wide, &[], &a, &[[], []], &g).is_ok());
    assert_eq!(Process::from_tables(&wide, &[], &a, &[[], []], &g[..4]).err(), Some(Error::Memory));
    assert!(matches!(q31::raw(&[1001.0, 0.0], &wide), Err(Error::Format(RangeError { component: 0, .. }))));
    assert_eq!(q31::format(1000.0, Some(31)).err(), Some(Error::Range));
    assert_eq!(q31::format(1000.0, Some(1000)).err(), Some(Error::Size));
    assert_eq!(q31::matrix(&[[f64::NAN]], &formats([1.0]), &formats([1.0])).err(), Some(Error::NotFinite));
    let mut memory = [0; filter_len_q31(2)];
    let short = memory.len() - 1;
    assert_eq!(Filter::from_tables(&wide, &[0, 0], &g, &mut memory[..short]).err(), Some(Error::Memory));
}

#[test]
fn a_filter_of_other_formats_is_refused_and_unchanged() {
    let (wide, narrow) = (formats([1000.0]), formats([1.0]));
    let (h, r) = (q31::matrix(&[[1.0]], &wide, &wide).unwrap(), q31::noise_diagonal(&[1.0], &wide).unwrap());
    let sensor = Sensor::from_tables(&wide, &wide, &h, &r).unwrap();
    let mut memory = [0; filter_len_q31(1)];
    let mut p0 = [0; q31::root_len(1)];
    q31::root(&[[1e-4]], &narrow, &mut p0).unwrap();
    let mut filter = Filter::from_tables(&narrow, &[7], &p0, &mut memory).unwrap();
    let before = (filter.mean(), filter.sigma());
    assert_eq!(filter.update(&sensor, &[1]), Err(Error::Other(sys::KQ_ERR_MISMATCH)));
    assert_eq!((filter.mean(), filter.sigma()), before);
}

#[test]
fn lengths_are_cs() {
    for n in 1..=16usize {
        let c = unsafe { sys::kq_length_q31(sys::KQ_OBJECT_FILTER, n as i32, 0, 0, 0) };
        assert_eq!(filter_len_q31(n) as u64, c);
    }
}
