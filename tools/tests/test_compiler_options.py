"""Options of kalmanq compile: each beside another way to the same numbers."""

import ctypes
import re
from itertools import product

import numpy as np
import pytest
from compiled_models import kinematic
from driven import Driven, doubles, library
from library import cc, written
from products import anemometer, calendar, drone, fridge, gps, heart, motor, oven, press, rover, spring, tank, ultrasound, well
from test_words import TRAPS, compared
from whole import first

from kalmanq import Model, Quantity
from kalmanq.compiler.given.request import Options, due
from kalmanq.compiler.run import record
from kalmanq.compiler.run.building import compiler
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.product import compiled

MEAN, COVARIANCE = 7e-4, 5e-4  # of q31: sigma, sigma_i sigma_j


def navigation() -> Model:
    """A position ten times less often than a speed, which has a bias"""
    dt = 0.01
    return Model([[1, dt, 0], [0, 1, 0], [0, 0, 1]], H=[[1, 0, 0], [0, 1, 1]], R=[4, 0.01], Q=[1e-6, 1e-3, 1e-7],
                 P0=[100, 10, 1], name="navigation")


# ------------------------------------------------------------------------------ --lag

LAG = """\
#include "flt.h"
#include <math.h>
void run(int rows, const double *z, const double *u, double *lagged, double *reading, int *is_there)
{{
    static flt_filter f;
    static flt_lag l;
    flt_start(&f);
    flt_lag_start(&l);
    for (int t = 0; t < rows; t++, z += {m}, u += {l}) {{
        {type} v[{m}], w[{l} + 1];
        (void)w;
        {given}
        if (t == 0) flt_update(&f, v);
        else flt_step(&f{u}, v);
        is_there[t] = flt_lag_step(&l, &f);
        for (int i = 0; i < {n}; i++) lagged[{n} * t + i] = (double)l.x[{lag}][i];
        {read}
    }}
}}
"""


def augmented(of, z, u, lag):
    """Means and sigmas `lag` samples ago, by a filter whose state holds the last ones, too"""
    n, N = of.n, of.n * (lag + 1)
    A, Q, H, x, P = np.zeros((N, N)), np.zeros((N, N)), np.zeros((of.m, N)), np.zeros(N), np.zeros((N, N))
    A[:n, :n], A[n:, :-n], Q[:n, :n], H[:, :n], x[:n], P[:n, :n] = of.A, np.eye(N - n), of.Q, of.H, of.x0, of.P0
    for t, row in enumerate(z):
        if t:
            x, P = A @ x, A @ P @ A.T + Q
            x[:n] += of.B @ u[t]
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + np.diag(of.R))
        left = np.eye(N) - K @ H
        x, P = x + K @ (row - H @ x), left @ P @ left.T + K @ np.diag(of.R) @ K.T
        yield x[-n:].copy(), np.sqrt(np.diag(P)[-n:])


LAGGED = [(gps, "f64", 1e-5), (oven, "f64", 1e-5),
          *((make, "q31", MEAN) for make in (gps, spring, anemometer, heart, oven, press, tank))]


@pytest.mark.parametrize("make, arithmetic, most", first(4, LAGGED))
def test_the_lagged_mean_is_that_of_the_augmented_filter(make, arithmetic, most, tmp_path):
    lag, made = 5, compiled(make(), "flt", Options(arithmetic, lag=5))
    a, of, rows = made.arithmetic, made.given.of.doubles(), made.steady.samples + 60
    given = [f"v[{j}] = {a.from_double('measurements', j, f'z[{j}]')};" for j in range(of.m)]
    given += [f"w[{k}] = {a.from_double('controls', k, f'u[{k}]')};" for k in range(of.l)]
    read = [f"reading[{of.n} * t + {i}] = (double)flt_lagged_{state}(&l);" for i, state in enumerate(made.given.states)]
    called = library(tmp_path, made, LAG.format(type=a.type, u=", w" if of.l else "", l=of.l, m=of.m, n=of.n, lag=lag,
                                                given=" ".join(given), read=" ".join(read)), TRAPS)
    x, readings = (a.formats.x, a.formats.read) if arithmetic == "q31" else (np.zeros(of.n, int),) * 2
    for seed in (1, 2, 3):
        drawn = record.as_taken(made, record.drawn(made.given, rows, seed))
        lagged, reading, is_there = np.zeros((rows, of.n)), np.zeros((rows, of.n)), np.zeros(rows, np.int32)
        called.run(rows, doubles(drawn.z.ravel()), doubles(drawn.u.ravel()),
                   *(one.ctypes.data_as(ctypes.c_void_p) for one in (lagged, reading, is_there)))
        assert is_there.sum() > 50 and not is_there[:made.steady.samples].any()
        apart = np.abs(np.ldexp(reading, -np.array(readings)) - np.ldexp(lagged, -np.array(x)))
        assert (apart <= 0.5 * 2.0 ** -np.array(readings)).all()
        for t, (mean, sigma) in enumerate(augmented(of, drawn.z, drawn.u, lag)):
            assert not is_there[t] or np.abs((np.ldexp(lagged[t], -np.array(x)) - mean) / sigma).max() < most, t


def test_a_long_gap_is_a_start_for_a_lag(tmp_path):
    """It takes the samples after it that a gap takes, and then the lag; the variance is held, and an event says so"""
    called = {}
    for arithmetic in ("f64", "q31"):
        made = compiled(ultrasound(), "flt", Options(arithmetic, lag=3))
        (folder := tmp_path / arithmetic).mkdir()
        called[arithmetic] = library(folder, made, """
#include "flt.h"
unsigned run(int rows, int *is_there)
{
    static flt_filter f;
    static flt_lag l;
    flt_start(&f);
    flt_lag_start(&l);
    for (int t = 0; t < 2 * rows + 1000; t++) {
        ZERO;
        if (t < rows || t >= rows + 1000) flt_step(&f, z);
        else flt_predict(&f);
        is_there[t] = flt_lag_step(&l, &f);
    }
    return f.events;
}""".replace("ZERO", f"const {made.arithmetic.type} z[1] = {{0}}"), TRAPS)
    rows, there = made.steady.samples + 100, []
    for arithmetic, one in called.items():
        there.append(np.zeros(2 * rows + 1000, np.int32))
        events = one.run(rows, there[-1].ctypes.data_as(ctypes.c_void_p))
        assert arithmetic == "f64" or events == 1 << list(made.events).index("SIGMA_SATURATED")
    assert np.array_equal(*there) and there[0].sum() > 100


# ------------------------------------------------------------------------------ --every


def regular(made, rows):
    """A record in which every row has what is due in it"""
    drawn = record.drawn(made.given, rows, 3)
    drawn.what[:], drawn.what[0] = PREDICTS | UPDATES, UPDATES
    drawn.present[:] = [due(made.given.options.every, t) for t in range(rows)]
    return drawn


CYCLES = [(gps, (1, 4)), (press, (1, 5)), (navigation, (10, 1)), (heart, (1, 3)), (drone, (1, 1, 2)), (well, (1, 6))]
# of any rows, and of those in which it settles: as `settle` says, and it takes the constant gains
NEAR = {"f64": ((1e-6, 1e-6), (1e-5, 1e-5)), "q31": ((MEAN, COVARIANCE), (MEAN, COVARIANCE))}


@pytest.mark.parametrize("arithmetic, make, every", [*(("f64", *one) for one in CYCLES[:4]), *first(2, [("q31", *one) for one in CYCLES])])
def test_a_cycle_of_rows_settles(arithmetic, make, every):
    made, (of_any, of_settled) = compiled(make(), "flt", Options(arithmetic, every=every)), NEAR[arithmetic]
    length, cycles = len(made.cycle.rows), made.cycle.cycles
    rows = min(length * (cycles + 4), 20_000)
    with Host(made, TRAPS) as host:
        for seed in (1, 2, 3):  # with gaps, samples in part and second updates, it never settles for long
            drawn = record.as_taken(made, record.drawn(made.given, 1000, seed))
            found = compared(made.given, drawn, host.run_record(drawn))
            assert found.mean < of_any[0] and found.covariance < of_any[1] and (arithmetic == "q31" or not found.events)
        drawn = record.as_taken(made, regular(made, rows))
        ran = host.run_record(drawn)
    found = compared(made.given, drawn, ran)
    assert found.mean < of_settled[0] and found.covariance < of_settled[1] and not found.events
    last = ran.covariance[-2 * length:]
    assert rows < length * (cycles + 4) or np.array_equal(last[:length], last[length:])


# ------------------------------------------------------------------------------ --student


def reweighted(given, record, taken, nu):
    """Means and covariances in double: each component with the variance that three steps of EM come to"""
    of, x, P = given.of.doubles(), given.of.doubles().x0, given.of.doubles().P0
    for t, bits in enumerate(taken):
        if record.what[t] & PREDICTS:
            x, P = of.A @ x + of.B @ record.u[t], of.A @ P @ of.A.T + of.Q
        for j in (j for j in range(of.m) if int(bits) >> j & 1):
            h, y = of.H[j], given.mixing[j] @ record.z[t] - of.H[j] @ x
            spread, r = h @ P @ h, of.R[j]
            for _ in range(3):
                share = r / (spread + r)
                r = of.R[j] * nu / (nu + 1) + ((y * share)**2 + spread * share) / (nu + 1)
            k = P @ h / (spread + r)
            left = np.eye(of.n) - np.outer(k, h)
            x, P = x + k * y, left @ P @ left.T + r * np.outer(k, k)
        yield x, P


@pytest.mark.parametrize("make, nu", first(2, [(tank, 4.0), (rover, 2.5), (gps, 1.0), (motor, 5.0), (heart, 0.2), (press, 3.0),
                                               (drone, 4.0), (spring, 10.0), (fridge, 1e9)]))
def test_student_in_words_is_that_of_doubles(make, nu):
    """Gaps, samples in part, second updates, and outliers of up to 300 sigma"""
    made = compiled(make(), "flt", Options("q31", student=nu))
    with Host(made, TRAPS) as host:
        for seed in (1, 2, 3):
            drawn, draws = record.drawn(made.given, 1000, seed), np.random.default_rng(seed)
            far = 10.0 ** draws.uniform(0.5, 2.5, drawn.z.shape) * draws.choice([-1, 1], drawn.z.shape)
            drawn.z[:] += far * (draws.random(drawn.z.shape) < 0.03) * np.sqrt(made.given.of.doubles().R)
            drawn = record.as_taken(made, drawn)
            ran = host.run_record(drawn)
            for t, (mean, P) in enumerate(reweighted(made.given, drawn, ran.taken, nu)):
                sigma = np.sqrt(np.diag(P))
                assert np.abs((ran.mean[t] - mean) / sigma).max() < MEAN
                assert np.abs((ran.covariance[t] - P) / np.outer(sigma, sigma)).max() < COVARIANCE


@pytest.mark.parametrize("arithmetic, most", [("f32", 1e-3), ("f64", 1e-9), ("q31", 1e-3)])
def test_the_report_compares_student_with_itself(arithmetic, most):
    """It was compared with the plain filter: sigmas apart, of which the report said that R is very small"""
    made = compiled(tank(), "flt", Options(arithmetic, student=4.0))
    with Host(made) as host:
        tried, = record.tried(made, host, 500, (1,))
    assert tried.mean < most and tried.covariance < most


@pytest.mark.parametrize("make", first(2, [gps, tank, heart, spring]))
def test_nis_with_student_is_that_of_the_model_s_noise(make, tmp_path):
    nis = {}
    for arithmetic in ("f64", "q31"):
        one = Driven(make(), tmp_path / arithmetic, Options(arithmetic, student=4.0, nis=True), TRAPS)
        z = record.drawn(one.product.given, 500, 2).z
        z[::20] += 30 * np.sqrt(one.of.doubles().R)
        made = []
        for t, row in enumerate(z):
            one.step(row) if t else one.update(row)
            made.append(one.nis)
        nis[arithmetic] = np.ldexp(made, -one.product.arithmetic.nis_fraction if arithmetic == "q31" else 0)
    assert np.allclose(nis["q31"], nis["f64"], rtol=1e-3, atol=1e-3) and nis["f64"].max() > 100


# ------------------------------------------------------------------------------ --tunable


@pytest.mark.parametrize("make", [gps, oven, motor])
def test_a_tuned_filter_is_that_of_the_other_model(make, tmp_path):
    """A couplings, Q and R of another model, written into the fields"""
    model = make()
    other = model.changed(A=np.where(np.eye(model.n) == 1, model.A, 0.5 * model.A), Q=3 * model.Q, R=2 * model.R)
    made, expected = compiled(model, "flt", Options("f64", tunable=True)), compiled(other, "flt", Options("f64"))
    of, n = made.given.of.doubles(), model.n
    places = [(i, k) for i in range(n) for k in range(n) if of.A[i, k] and not (i == k and of.A[i, k] == 1)]
    values = ", ".join(repr(float(other.A[one])) for one in places)
    noises = ", ".join(repr(float(one)) for one in np.diag(other.R))
    text = f"""
#include "flt.h"
int tune(flt_filter *f, const double *Q)
{{
    static const double A[] = {{{values}}}, r[] = {{{noises}}};
    for (int k = 0; k < {len(places)}; k++) f->A[k] = A[k];
    for (int j = 0; j < {model.m}; j++) f->r[j] = r[j];
    return flt_noise(f, Q);
}}
unsigned size(void) {{ return sizeof(flt_filter); }}
void step(flt_filter *f, const double *u, const double *z) {{ (void)u; flt_step(f{', u' if model.l else ''}, z); }}
void mean(const flt_filter *f, double *x) {{ for (int i = 0; i < {n}; i++) x[i] = f->x[i] + f->low[i]; }}
"""
    called = library(tmp_path, made, text)
    f, drawn, x = ctypes.create_string_buffer(called.size()), record.drawn(expected.given, 200, 1), np.zeros(n)
    drawn.what[:], drawn.present[:] = PREDICTS | UPDATES, expected.given.all
    called.flt_start(f)
    assert called.tune(f, doubles(np.asarray(other.Q).ravel())) == 1
    with Host(expected) as host:
        ran = host.run_record(drawn)
    sigma = np.sqrt(np.diagonal(ran.covariance, axis1=1, axis2=2))
    for t in range(200):
        called.step(f, doubles(drawn.u[t]), doubles(drawn.z[t]))
        called.mean(f, x.ctypes.data_as(ctypes.c_void_p))
        assert np.abs((x - ran.mean[t]) / sigma[t]).max() < 1e-5, t
    before = f.raw
    for bad in (-np.asarray(other.Q), np.asarray(other.Q) + np.ones((n, n)), np.full((n, n), np.nan)):
        assert called.flt_noise(f, doubles(bad.ravel())) == 0 and f.raw == before


# ------------------------------------------------------------------------------ --loops


LOOPED = {"f32": ([*product([tank, gps, motor], [{}, {"gate": 4.0, "nis": True}, {"student": 5.0}])], 2e-4, 5e-5),
          "q31": ([(motor, {"student": 5.0, "nis": True}), (press, {"every": (1, 5)}), (tank, {"gate": 4.0, "nis": True}), (gps, {}),
                   (drone, {}), (calendar, {"gate": 4.0}), (rover, {"lag": 2})], MEAN, COVARIANCE)}


@pytest.mark.parametrize("arithmetic, make, more", [*(("f32", *one) for one in LOOPED["f32"][0]),
                                                    *first(2, [("q31", *one) for one in LOOPED["q31"][0]])])
def test_loops_come_to_what_straight_lines_come_to(arithmetic, make, more):
    ran = []
    for loops in (True, False):
        made = compiled(make(), "flt", Options(arithmetic, loops=loops, **more))
        with Host(made, TRAPS) as host:
            ran.append([host.run_record(record.as_taken(made, record.drawn(made.given, 1000, seed))) for seed in (1, 2, 3)])
    for looped, straight in zip(*ran):
        sigma = np.sqrt(np.diagonal(straight.covariance, axis1=1, axis2=2))
        assert np.array_equal(looped.taken, straight.taken) and np.array_equal(looped.events, straight.events)
        assert np.abs((looped.mean - straight.mean) / sigma).max() < LOOPED[arithmetic][1]
        apart = (looped.covariance - straight.covariance) / (sigma[:, :, None] * sigma[:, None, :])
        assert np.abs(apart).max() < LOOPED[arithmetic][2]


def test_a_large_model_takes_loops_by_itself():
    for arithmetic, n, order in (("f32", 12, 3), ("q31", 8, 2)):
        assert "predict_factor" in compiled(dense(n), "flt", Options(arithmetic)).code
        assert "predict_factor" not in compiled(kinematic(3, order, ranged=True), "flt", Options(arithmetic)).code


def dense(n: int) -> Model:
    draws = np.random.default_rng(1)
    G = draws.standard_normal((n, n))
    return Model(0.9 * np.eye(n) + 0.05 * draws.standard_normal((n, n)), H=draws.standard_normal((4, n)), R=np.ones(4),
                 Q=G @ G.T / n, P0=10 * np.ones(n))


# ------------------------------------------------------------------------------ the struct, and starting anew


@pytest.mark.parametrize("arithmetic, more", list(product(["f32", "f64", "q31"], [{}, {"nis": True, "gate": 4.0}])))
def test_the_ram_that_is_told_is_the_struct_s(arithmetic, more, tmp_path):
    for model in (tank(), gps(), motor()):
        made = compiled(model, "flt", Options(arithmetic, **more))
        size = f'#include "flt.h"\n_Static_assert(sizeof(flt_filter) == {made.ram}, "RAM");\n'
        written(tmp_path, {**made.sources(), "size.c": size})
        cc(compiler(), "-std=c11", "-c", "size.c", "-o", "size.o", folder=tmp_path)


def test_q31_starts_anew_within_its_formats(tmp_path):
    made = compiled(tank(), "flt", Options("q31"))
    called = library(tmp_path, made, """
#include "flt.h"
unsigned size(void) { return sizeof(flt_filter); }
void start_at(flt_filter *f, int mean, int sigma)
{
    const int32_t a[] = {mean, -mean}, b[] = {sigma, sigma};
    flt_start_at(f, a, b);
}
int level(const flt_filter *f) { return flt_mean_level(f); }
int flow(const flt_filter *f) { return flt_mean_flow(f); }
""")
    f = ctypes.create_string_buffer(called.size())
    called.start_at(f, 12345, 1000)
    assert (called.level(f), called.flow(f)) == (12345, -12345)
    called.start_at(f, 2**31 - 1, 2**31 - 1)
    assert 0 < called.level(f) <= 2**31 - 1 and called.flow(f) == -called.level(f)


def test_the_end_of_a_control_s_range_is_a_raw_value():
    for span, fraction in ((1.0, 30), (0.5, 31), (0.75, 31), (4.0, 28), (50.0, 25)):
        model = Model([[1.0]], H=[[1.0]], R=0.01, Q=1e-4, B=[0.1], P0=[1.0], controls=[Quantity("on", range=span)])
        header = compiled(model, "flt", Options("q31")).header
        found = int(re.search(r"FLT_U_ON_FRACTION = (\d+)", header).group(1))
        assert found == fraction and span * 2**found <= 2**31 - 1
        assert "u: the controls since the last sample" in header


def test_q31_takes_0_for_a_control_that_is_no_value(tmp_path):
    model = Model([[1.0]], H=[[1.0]], R=0.01, Q=1e-4, B=[0.1], P0=[1.0], controls=[Quantity("on", range=2.0)])
    called = library(tmp_path, compiled(model, "flt", Options("q31")), """
#include <math.h>
#include "flt.h"
int differs(double with)
{
    static flt_filter f, g;
    const int32_t u[] = {FLT_U_ON_RAW(NAN)}, v[] = {FLT_U_ON_RAW(with)};
    flt_start(&f), flt_start(&g), flt_predict(&f, u), flt_predict(&g, v);
    return f.events != FLT_CONTROL_REFUSED || f.x[0] != g.x[0];
}
""")
    called.differs.argtypes = [ctypes.c_double]
    assert not called.differs(0.0) and called.differs(-2.0)


def test_q31_s_header_has_values_in_units_and_back(tmp_path):
    made = compiled(tank(), "flt", Options("q31"))
    called = library(tmp_path, made, """
#include "flt.h"
int raw(double value) { return FLT_Z_FLOAT_RAW(value); }
double value(int raw) { return FLT_Z_FLOAT_VALUE(raw); }
double state(int raw) { return FLT_FLOW_VALUE(raw); }
""")
    called.raw.argtypes, called.value.restype, called.state.restype = [ctypes.c_double], ctypes.c_double, ctypes.c_double
    z, flow = (int(re.search(rf"FLT_{name}_FRACTION = (\d+)", made.header).group(1)) for name in ("Z_FLOAT", "FLOW"))
    for value in (0.0, 1.5, -0.1, 1 / 3, -7.0):
        assert abs(called.raw(value) - value * 2**z) <= 0.5 and called.value(called.raw(value)) == called.raw(value) * 2.0**-z
    assert called.state(12345) == 12345 * 2.0**-flow
    assert [called.raw(value) for value in (1e30, -1e30, float("nan"))] == [2**31 - 1, 1 - 2**31, -2**31]
