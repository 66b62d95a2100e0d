//! The crate against the textbook's filter, what it refuses, what it remembers, and its structs against C's sizes.

use core::mem::size_of;
use kalmanq::{Error, Events, Filter, Process, Sensor, filter_len_f32, filter_len_f64, process_len, sensor_len, sys};

const A: [[f64; 2]; 2] = [[1.0, 0.1], [0.0, 0.95]];
const B: [[f64; 1]; 2] = [[0.005], [0.1]];
const Q: [[f64; 2]; 2] = [[0.02, 0.01], [0.01, 0.03]];
const H: [[f64; 2]; 2] = [[1.0, 0.0], [0.5, 1.0]];
const R: [[f64; 2]; 2] = [[0.4, 0.1], [0.1, 0.3]];

type Matrix = [[f64; 2]; 2];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn sum(a: &Matrix, b: &Matrix, sign: f64) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| a[i][j] + sign * b[i][j]))
}

fn transposed(a: &Matrix) -> Matrix {
    core::array::from_fn(|i| core::array::from_fn(|j| a[j][i]))
}

fn inverse(a: &Matrix) -> Matrix {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [[a[1][1] / determinant, -a[0][1] / determinant], [-a[1][0] / determinant, a[0][0] / determinant]]
}

fn applied(a: &Matrix, x: [f64; 2]) -> [f64; 2] {
    core::array::from_fn(|i| a[i][0] * x[0] + a[i][1] * x[1])
}

fn textbook_step(x: &mut [f64; 2], p: &mut Matrix, u: f64, z: [f64; 2]) {
    let moved = applied(&A, *x);
    *x = core::array::from_fn(|i| moved[i] + B[i][0] * u);
    *p = sum(&product(&product(&A, p), &transposed(&A)), &Q, 1.0);
    let gain =
        product(&product(p, &transposed(&H)), &inverse(&sum(&product(&product(&H, p), &transposed(&H)), &R, 1.0)));
    let seen = applied(&H, *x);
    let correction = applied(&gain, [z[0] - seen[0], z[1] - seen[1]]);
    *x = [x[0] + correction[0], x[1] + correction[1]];
    *p = sum(p, &product(&product(&gain, &H), p), -1.0);
}

#[test]
fn is_the_textbooks_filter() {
    let (mut process_memory, mut sensor_memory, mut memory) =
        ([0.0; process_len(2)], [0.0; sensor_len(2)], [0.0; filter_len_f64(2)]);
    let process = Process::new(&A, &B, &Q, &mut process_memory).unwrap();
    let sensor = Sensor::new(&H, &R, &mut sensor_memory).unwrap();
    let (mut x, mut p) = ([1.0, -1.0], [[2.0, 0.5], [0.5, 3.0]]);
    let mut filter = Filter::new(&x, &p, &mut memory).unwrap();
    for k in 0..200 {
        let (u, z) = ((k as f64 * 0.3).sin(), [(k as f64 * 0.7).cos() * 2.0, (k as f64 * 1.1).sin()]);
        textbook_step(&mut x, &mut p, u, z);
        filter.step(&process, &[u], &sensor, &z).unwrap();
        let covariance = filter.covariance().unwrap();
        for i in 0..2 {
            assert!((filter.mean()[i] - x[i]).abs() < 1e-12, "step {k}");
            assert!((filter.sigma()[i] - p[i][i].sqrt()).abs() < 1e-12, "step {k}");
            assert!((0..2).all(|j| (covariance[i][j] - p[i][j]).abs() < 1e-12), "step {k}");
        }
    }
    assert_eq!((filter.taken(), filter.events()), (2, Events(0)));
    assert!(filter.nis() > 0.0 && filter.log_likelihood() < 0.0);
}

#[test]
fn step_is_predict_and_update() {
    let run = |apart: bool| {
        let (mut a, mut b, mut c) = ([0.0; process_len(2)], [0.0; sensor_len(2)], [0.0; filter_len_f64(2)]);
        let process = Process::new(&A, &B, &Q, &mut a).unwrap();
        let sensor = Sensor::new(&H, &R, &mut b).unwrap();
        let mut filter = Filter::new(&[0.0; 2], &Q, &mut c).unwrap();
        if apart {
            filter.predict(&process, &[1.0]).unwrap();
            filter.update_present(&sensor, &[Some(1.0), Some(2.0)]).unwrap();
        } else {
            filter.step(&process, &[1.0], &sensor, &[1.0, 2.0]).unwrap();
        }
        (filter.mean(), filter.sigma())
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn missing_components_are_not_read() {
    let (mut b, mut c) = ([0.0; sensor_len(2)], [0.0; filter_len_f64(2)]);
    let sensor = Sensor::new(&H, &R, &mut b).unwrap();
    let mut filter = Filter::new(&[0.0; 2], &Q, &mut c).unwrap();
    let before = (filter.mean(), filter.sigma());
    filter.update_present(&sensor, &[None, None]).unwrap();
    assert_eq!((filter.mean(), filter.sigma(), filter.taken()), (before.0, before.1, 0));
    filter.update_present(&sensor, &[Some(1.0), None]).unwrap();
    assert_eq!(filter.taken(), 1);
    // of z[0] alone: K = Q[.][0] / (Q[0][0] + R[0][0])
    assert!((filter.mean()[1] - 0.01 / 0.42).abs() < 1e-12);
}

#[test]
fn refuses_and_changes_nothing() {
    let (mut b, mut c) = ([0.0; sensor_len(2)], [0.0; filter_len_f64(2)]);
    let sensor = Sensor::new(&H, &R, &mut b).unwrap();
    let mut filter = Filter::new(&[1.0; 2], &Q, &mut c).unwrap();
    let before = (filter.mean(), filter.covariance().unwrap());
    assert_eq!(filter.update(&sensor, &[f64::NAN, 1.0]), Err(Error::NotFinite));
    assert_eq!((filter.mean(), filter.covariance().unwrap()), before);
    assert_eq!(filter.innovation(&sensor, &[3.0, 1.5]), Ok([2.0, 0.0]));
    let mut memory = [0.0; 200];
    assert_eq!(Filter::new(&[0.0; 2], &Q, &mut memory[..filter_len_f64(2) - 1]).err(), Some(Error::Memory));
    assert_eq!(Filter::new(&[0.0; 17], &[[0.0; 17]; 17], &mut memory).err(), Some(Error::Size));
    assert_eq!(Filter::<f64, 0>::new(&[], &[], &mut memory).err(), Some(Error::Size));
    assert_eq!(Filter::new(&[0.0; 2], &[[1.0, 0.5], [0.0, 1.0]], &mut memory).err(), Some(Error::NotSymmetric));
    assert_eq!(Filter::new(&[0.0; 2], &[[1.0, 2.0], [2.0, 1.0]], &mut memory).err(), Some(Error::NotSemidefinite));
    assert_eq!(Process::new(&[[f32::INFINITY]], &[[]], &[[1.0]], &mut [0.0; 1]).err(), Some(Error::NotFinite));
    assert!(
        Error::NotFinite.to_string().contains("NaN")
            && Error::Other(sys::KQ_ERR_NO_DATA).status() == sys::KQ_ERR_NO_DATA
    );
}

#[test]
fn events_are_flags() {
    let (mut b, mut c) = ([0.0; sensor_len(1)], [0.0; filter_len_f32(1)]);
    let exact = Sensor::new(&[[1.0f32]], &[[0.0]], &mut b).unwrap();
    let mut filter = Filter::new(&[0.0], &[[1.0]], &mut c).unwrap();
    filter.update(&exact, &[0.5]).unwrap();
    assert!(filter.events().is_empty());
    filter.update(&exact, &[0.5]).unwrap(); // sigma is 0: it says nothing new
    assert!(
        filter.events().contains(Events::REDUNDANT) && !filter.events().contains(Events::REDUNDANT | Events::OVERFLOW)
    );
    filter.clear_events();
    assert!(filter.events().is_empty());
}

#[test]
fn a_filter_moves_and_crosses_threads() {
    let mut c = [0.0; filter_len_f64(2)];
    let filter = Filter::new(&[1.0, 2.0], &Q, &mut c).unwrap();
    let moved = std::thread::scope(|scope| scope.spawn(move || filter.mean()).join().unwrap());
    assert_eq!(moved, [1.0, 2.0]);
}

#[test]
fn lengths_are_cs() {
    for n in 1..=16usize {
        let m = n as i32;
        unsafe {
            assert_eq!(process_len(n) as u64, sys::kq_length_f32(sys::KQ_OBJECT_PROCESS, m, 0, 0, 0));
            assert_eq!(sensor_len(n) as u64, sys::kq_length_f32(sys::KQ_OBJECT_SENSOR, 0, m, 0, 0));
            assert_eq!(filter_len_f32(n) as u64, sys::kq_length_f32(sys::KQ_OBJECT_FILTER, m, 0, 0, 0));
            assert_eq!(filter_len_f64(n) as u64, sys::kq_length_f64(sys::KQ_OBJECT_FILTER, m, 0, 0, 0));
        }
    }
}

macro_rules! sizes {
    ($($object:ident: $f32:ident $f64:ident $q31:ident;)*) => {
        $(unsafe {
            assert_eq!(size_of::<sys::$f32>(), sys::kq_object_size_f32(sys::$object), stringify!($f32));
            assert_eq!(size_of::<sys::$f64>(), sys::kq_object_size_f64(sys::$object), stringify!($f64));
            assert_eq!(size_of::<sys::$q31>(), sys::kq_object_size_q31(sys::$object), stringify!($q31));
        })*
    };
}

#[test]
fn structs_are_cs() {
    sizes! {
        KQ_OBJECT_PROCESS: kq_process_f32 kq_process_f64 kq_process_q31;
        KQ_OBJECT_SENSOR: kq_sensor_f32 kq_sensor_f64 kq_sensor_q31;
        KQ_OBJECT_FILTER: kq_filter_f32 kq_filter_f64 kq_filter_q31;
        KQ_OBJECT_HISTORY: kq_history_f32 kq_history_f64 kq_history_q31;
        KQ_OBJECT_LAG: kq_lag_f32 kq_lag_f64 kq_lag_q31;
        KQ_OBJECT_INSTANT: kq_instant_f32 kq_instant_f64 kq_instant_q31;
        KQ_OBJECT_DIFFUSE: kq_diffuse_f32 kq_diffuse_f64 kq_diffuse_q31;
        KQ_OBJECT_ADAPTATION: kq_adaptation_f32 kq_adaptation_f64 kq_adaptation_q31;
        KQ_OBJECT_CONSISTENCY: kq_consistency_f32 kq_consistency_f64 kq_consistency_q31;
        KQ_OBJECT_STEADY: kq_steady_f32 kq_steady_f64 kq_steady_q31;
        KQ_OBJECT_FREEZE: kq_freeze_f32 kq_freeze_f64 kq_freeze_q31;
    }
}
