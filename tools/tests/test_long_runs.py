"""kalmanq compile for long: gaps that an unstable model does not survive by itself, and runs in which a float adds up what is far below it."""

from __future__ import annotations

import ctypes
import decimal
from pathlib import Path
from typing import Callable

import numpy as np
import pytest
from driven import Driven, library
from library import EXAMPLES
from products import ALL, quartz, scale, tank
from whole import WHOLE, first

from kalmanq import Model, Quantity
from kalmanq.compiler.given.enclosure import DIGITS, steps
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import report
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import Record, exact_of
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import compiled
from kalmanq.model import model_file
from kalmanq.nonlinear import NonlinearModel


# ------------------------------------------------------------------------------ what grows without end


def pendulum() -> Model:
    """Upside down, and its encoder has a bias that wanders"""
    return Model([[1.02, 0.05, 0], [0.3, 1.02, 0], [0, 0, 1]], H=[1, 0, 1], R=1e-3, Q=[1e-4, 1e-2, 1e-8], B=[0, 0.05, 0], P0=[0.1, 0.1, 0.01],
                 states=[Quantity("angle", "", 10), Quantity("rate", "", 50), Quantity("bias", "", 1)],
                 measurements=[Quantity("encoder", "", 12)], controls=[Quantity("torque", "", 20)], name="pendulum")


def robot() -> Model:
    """It balances: no range is declared"""
    return Model([[1.00125, 0.010004], [0.2501, 1.00125]], H=[1, 0], R=1e-4, Q=[[1.67e-7, 2.5e-5], [2.5e-5, 5e-3]], P0=[0.1, 0.1], name="robot")


def tower() -> Model:
    """Two axes that are alike, and share their variances"""
    return Model(np.kron(np.eye(2), [[1.01, 0.02], [0.2, 1.01]]), H=np.kron(np.eye(2), [[1, 0]]), R=[1e-2, 1e-2],
                 Q=np.diag([1e-6, 1e-3] * 2), P0=[1, 1] * 2, name="tower")


def reactor() -> Model:
    """An oscillation that grows, in units of which one is a million times the other, and what it heats"""
    turn = 1.03 * np.array([[np.cos(0.4), 1e6 * np.sin(0.4), 0], [-1e-6 * np.sin(0.4), np.cos(0.4), 0], [1e-7, 0, 0.9]])
    return Model(turn, H=[[1, 0, 0], [0, 0, 1]], R=[1e4, 1e-2], Q=[1e4, 1e-8, 1e-3], P0=[1e8, 1e-4, 1], name="reactor")


def culture() -> Model:
    """One state that doubles every ten rows, fed"""
    return Model([[2**0.1]], H=[1], R=0.01, Q=1e-3, B=[1], P0=[1], controls=[Quantity("feed", "", 5)], name="culture")


def delayed_culture() -> Model:
    """The measurement is of the state two rows ago"""
    return Model([[1.05, 0, 0], [1, 0, 0], [0, 1, 0]], H=[0, 0, 1], R=0.01, Q=[1e-3, 0, 0], P0=[1, 1, 1], name="delayed")


UNSTABLE = (pendulum, robot, tower, reactor, culture, delayed_culture)


def seen(model: Model, arithmetic: str, gap: int, rows: int, **more: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """After 100 samples, a gap and `rows` samples: means and covariances of these, events of the gap and after it"""
    draws = np.random.default_rng(1)
    z = np.sqrt(np.diag(model.R)) * draws.standard_normal((100 + gap + rows, model.m))
    z[100:100 + gap] = np.nan
    product = compiled(model, "flt", Options(arithmetic, **more))  # type: ignore[arg-type]
    with Host(product) as host:
        ran = host.run(z, np.zeros((len(z), model.l)))
    wide = model.changed(x0=np.zeros(model.n), P0=1e6 * np.maximum(np.diag(model.P0), np.diag(model.Q)))
    after = Record(np.r_[UPDATES, np.full(rows - 1, PREDICTS | UPDATES)], np.full(rows, product.given.all), z[-rows:], np.zeros((rows, model.l)))
    means, covariances = exact_of(compiled(wide, "flt", Options("f64")).given, after, np.full(rows, product.given.all))
    sigma = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    apart = np.abs(ran.mean[-rows:] - means) / sigma
    spread = np.sqrt(np.diagonal(ran.covariance[-rows:], axis1=1, axis2=2)) / sigma - 1
    return apart.astype(float), np.abs(spread).astype(float), ran.events[100:100 + gap], ran.events[-rows:]


@pytest.mark.parametrize("more", first(2, [{}, {"loops": True}, {"gate": 8.0, "nis": True}, {"tunable": True}]), ids=str)
@pytest.mark.parametrize("gap", [1600, 20_000])
@pytest.mark.parametrize("make", UNSTABLE)
def test_samples_bring_back_what_has_grown_without_end(make: Callable[[], Model], gap: int, more: dict) -> None:
    """Held while nothing is measured, and an event says so; the gate takes all after 8 rejections"""
    model = make()
    apart, spread, held, after = seen(model, "f32", gap, 3000, **more)
    bit = 1 << [*compiled(model, "flt", Options("f32", **more)).events].index("OVERFLOW")
    assert np.bitwise_or.reduce(held) & bit
    assert np.isfinite(apart).all() and not after[20:].any()
    assert apart[-1].max() < 0.2 and spread[-1].max() < 0.03


@pytest.mark.parametrize("make", UNSTABLE)
def test_f64_holds_it_too(make: Callable[[], Model]) -> None:
    apart, spread, held, _ = seen(make(), "f64", 20_000, 3000)
    assert held.any() and apart[-1].max() < 0.2 and spread[-1].max() < 0.03


@pytest.mark.parametrize("arithmetic", ("f32", "f64"))
def test_a_mean_without_any_variance_is_held(arithmetic: str, tmp_path: Path) -> None:
    """Nothing drives it, and it is known exactly: only its mean grows"""
    f = Driven(Model([[1.1]], H=[1], R=1.0, Q=0.0, P0=[1.0]), tmp_path, Options(arithmetic))
    f.start_at([1.0], [0.0])
    for _ in range(9000):
        f.predict()
    assert f.mean == 0 and f.covariance > 0 and f.events
    for k in range(100):
        f.step([1.1**k])
    assert abs(f.mean[0] / 1.1**99 - 1) < 1e-4 and not f.events


@pytest.mark.parametrize("make", UNSTABLE)
def test_a_gap_that_a_float_bears_is_no_event(make: Callable[[], Model]) -> None:
    model = make()
    rate = np.log(np.abs(np.linalg.eigvals(model.A)).max())
    apart, spread, held, after = seen(model, "f32", int(np.log(300) / rate), 3000)
    assert not held.any() and not after.any() and apart[-1].max() < 0.2 and spread[-1].max() < 0.03


SLOW_TO_SETTLE = ("tilt", "meter", "scale", "bldc", "variometer", "hydraulic", "lift", "picoammeter", "truckscale", "co2")  # 23,000 samples or more


@pytest.mark.parametrize("models", ["products", "examples"])
def test_what_needs_none_of_it_pays_nothing(models: str) -> None:
    """Chains of sums and oscillations among them: their A has a spectral radius of 1, however it is rounded"""
    files = [one for one in sorted(EXAMPLES.glob("*.toml")) if one.stem not in ("ma", "arma")]
    for model in map(model_file.read, files) if models == "examples" else (make() for make in ALL):
        made = compiled(model, "flt", Options("f32"))
        assert "hold(" not in made.code and "OVERFLOW" not in made.header, model.name
        assert ("P_low" in made.code) == (model.name in SLOW_TO_SETTLE), model.name
        assert bool(made.arithmetic.unresolved) == (model.name in ("quartz", "tide", "co2")), model.name


@pytest.mark.parametrize("options", [Options("f32"), Options("f64", loops=True)])
def test_a_start_that_is_no_number_is_refused(options: Options, tmp_path: Path) -> None:
    f = Driven(tank(), tmp_path, options)
    f.step([3.0])
    before = f.bits
    for bad in (np.nan, np.inf, -np.inf):
        for mean, sigma in (([bad, 0], [1, 1]), ([0, bad], [1, 1]), ([0, 0], [bad, 1]), ([0, 0], [1, bad])):
            assert f.call("start_at", f.numbers(mean), f.numbers(sigma)) == 0 and f.bits == before
    assert f.call("start_at", f.numbers([5, 1]), f.numbers([2, 3])) == 1 and f.mean.tolist() == [5, 1]


def test_a_start_beyond_a_format_is_told(tmp_path: Path) -> None:
    f = Driven(tank(), tmp_path, Options("q31"))
    names = [*f.product.events]
    for mean, sigma, told in (([1, 1], [1, 1], set()), ([2**31 - 1, 1], [1, 1], {"MEAN_SATURATED"}), ([-2**31, 1], [1, 1], {"MEAN_SATURATED"}),
                              ([1, 1], [1, -1], {"SIGMA_SATURATED"}), ([1, 1], [2**31 - 1, 1], {"SIGMA_SATURATED"})):
        given = [(f.type * 2)(*one) for one in (mean, sigma)]
        assert f.call("start_at", *given) == (not told)
        events = f.events
        assert {name for k, name in enumerate(names) if events >> k & 1} == told


# ------------------------------------------------------------------------------ what moves by less than a float resolves


def creeping() -> Model:
    """A weighing scale at 10 Hz: load, creep, and a zero that wanders and that nothing tells from the load"""
    return Model(np.diag([1, 0.99983, 1]), H=[1, 1, 1], R=2.5e-3, Q=[[0.04, 2e-5, 0], [2e-5, 1e-7, 0], [0, 0, 1e-9]], P0=[100, 0.01, 0.04],
                 states=["load", "creep", "zero"], name="creeping")


def zero_first() -> Model:
    """The same, whose D has the zero only given the load"""
    model, order = creeping(), [2, 0, 1]
    two = np.ix_(order, order)
    return Model(model.A[two], H=model.H[:, order], R=model.R, Q=model.Q[two], P0=model.P0[two], states=["zero", "load", "creep"], name="zero_first")


def gyro() -> Model:
    """An angle that is measured, and the bias of what drives it, 1 kHz"""
    return Model([[1, -1e-3], [0, 1]], H=[1, 0], R=1e-2, Q=[1e-8, 1e-16], P0=[0.1, 1e-3], name="gyro")


def reference() -> Model:
    """A clock: offset, frequency and its ageing"""
    return Model([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], H=[1, 0, 0], R=1e2, Q=[1e-2, 1e-8, 1e-20], P0=[1e6, 1e2, 1e-4], name="reference")


def bias() -> Model:
    return Model(1, H=1, R=1e-2, Q=1e-14, P0=1e-2, name="bias")


def thermal() -> Model:
    """A place, and a sensor whose drift has a rate"""
    return Model([[1, 1e-2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1e-3], [0, 0, 0, 1]], H=[1, 0, 1, 0], R=1e-2, Q=[0, 1e-4, 1e-12, 1e-20],
                 P0=[1, 1, 1e-2, 1e-8], name="thermal")


def pair() -> Model:
    """Two biases of two sensors of one level"""
    return Model(np.eye(3), H=[[1, 1, 0], [1, 0, 1]], R=[1e-2, 1e-2], Q=[1e-2, 1e-13, 1e-12], P0=[1, 1e-2, 1e-2], name="pair")


SLOW = (creeping, zero_first, gyro, reference, bias, thermal, pair, scale)


class Many:
    """So many rows, each a full sample after a gap: the covariance of its C, and that in decimals"""

    def __init__(self, model: Model, folder: Path, options: Options, gap: int = 0):
        self.product, self.gap, self.rows = compiled(model, "flt", options), gap, 0
        a, n = self.product.arithmetic, model.n
        self.library = library(folder, self.product, f"""
#include <math.h>
#include "flt.h"
static flt_filter f;
void begin(void) {{ flt_start(&f); }}
void rows(unsigned count)
{{
    const {a.type} z[{model.m}] = {{0}};
    for (unsigned t = 0; t < count; t++) {{
        for (int k = 0; k <= {gap}; k++) flt_predict(&f);
        flt_update(&f, z);
    }}
}}
void read(double *P)
{{
    for (int i = 0; i < {n}; i++)
        for (int j = 0; j < {n}; j++) P[i * {n} + j] = {a.covariance_double("i", "j")};
}}
""")
        self.library.begin()

    def to(self, rows: int) -> float:
        """How far the sigmas are from the true ones, at most, a share"""
        of = self.product.given.of
        self.library.rows(ctypes.c_uint(rows - self.rows))
        self.rows, P = rows, np.zeros((of.n, of.n))
        self.library.read(ctypes.c_void_p(P.ctypes.data))
        with decimal.localcontext(DIGITS):
            predict, (cycle,) = steps(of, [range(of.m)])
            for _ in range(self.gap):
                cycle = predict.then(cycle)
            whole, left = None, rows
            while left:
                if left & 1:
                    whole = cycle if whole is None else whole.then(cycle)
                cycle, left = cycle.then(cycle), left >> 1
            true = np.diag(whole.of(of.P0)).astype(float)  # type: ignore[union-attr]
        return float(np.abs(np.sqrt(np.diag(P) / true) - 1).max())


@pytest.mark.parametrize("gap", (0, 7))
@pytest.mark.parametrize("make", SLOW)
def test_a_sigma_is_right_after_many_rows(make: Callable[[], Model], gap: int, tmp_path: Path) -> None:
    many = Many(make(), tmp_path, Options(), gap)
    assert many.product.steady is None and not many.product.arithmetic.unresolved
    assert max(many.to(10**k) for k in (4, 5, 6)) < 5e-4
    assert gap or many.to(10**7) < 5e-4


@pytest.mark.parametrize("more", [{"loops": True}, {"gate": 1e3, "nis": True}, {"student": 1e6}], ids=str)
@pytest.mark.parametrize("make", first(2, SLOW[:-2]))
def test_so_it_is_in_loops_and_with_options(make: Callable[[], Model], more: dict, tmp_path: Path) -> None:
    """In loops predict is no sum with an entry of U: it is told instead"""
    many = Many(make(), tmp_path, Options(**more))  # type: ignore[arg-type]
    assert bool(many.product.arithmetic.unresolved) == (make is thermal and "loops" in more)
    assert many.product.arithmetic.unresolved or many.to(3 * 10**6) < 5e-4


@pytest.mark.parametrize("gap", (0, 7))
@pytest.mark.parametrize("make", [pytest.param(one, marks=WHOLE) for one in SLOW])
def test_a_sigma_is_right_after_1e8_rows(make: Callable[[], Model], gap: int, tmp_path: Path) -> None:
    assert Many(make(), tmp_path, Options(), gap).to(10**8 // (gap + 1)) < 1e-3


@pytest.mark.parametrize("make", SLOW)
def test_f64_needs_no_second_number(make: Callable[[], Model], tmp_path: Path) -> None:
    many = Many(make(), tmp_path, Options("f64"))
    assert "P_low" not in many.product.code and many.to(10**6) < 1e-6


@pytest.mark.parametrize("arithmetic, make", [("f32", quartz), *(("q31", one) for one in (gyro, reference, bias, scale, quartz))])
def test_what_is_not_resolved_is_told(arithmetic: str, make: Callable[[], Model], tmp_path: Path) -> None:
    """An oscillation without noise, whose states turn into each other; words of which a sigma is few"""
    many = Many(make(), tmp_path, Options(arithmetic))
    told = many.product.arithmetic.unresolved
    assert min(told.values()) <= 2**22
    assert many.to(min(min(told.values()), 2**16) // 4) < 0.02
    said = "\n".join(report.lines(many.product, report.Findings(0, 0, 1, 0)))
    assert "may be wrong by more than 1 %. --arith f64 follows it." in said
    assert all(many.product.given.model.states[i].name in said for i in told)


# ------------------------------------------------------------------------------ the same of functions


@pytest.mark.parametrize("arithmetic, gap", [("f32", 1600), ("f32", 20_000), ("f64", 30_000)])
@pytest.mark.parametrize("options", [{}, {"smooth": 8}], ids=str)
def test_functions_that_grow_are_held(arithmetic: str, gap: int, options: dict) -> None:
    """A robot that falls, and a level that a float holds for long"""
    A = robot().A
    model = NonlinearModel(lambda x: [A[0, 0] * x[0] + A[0, 1] * x[1], A[1, 0] * x[0] + A[1, 1] * x[1] + 0.01 * np.sin(x[2]), x[2]],
                           lambda x: [x[0], x[2]], x0=[0.0, 0.0, 1.0], P0=[0.1, 0.1, 1.0], Q=[1e-6, 5e-3, 1e-4], R=[1e-4, 1e-2])
    product = compiled_equations(model, "flt", Options(arithmetic, **options))
    z = np.tile([0.0, 1.0], (gap + 400, 1))
    z[100:100 + gap] = np.nan
    with Host(product) as host:
        ran = host.run(z)
    bit = 1 << [*product.events].index("OVERFLOW")
    assert np.bitwise_or.reduce(ran.events[100:100 + gap]) & bit and not ran.events[130 + gap:].any()
    assert np.isfinite(ran.mean).all() and np.isfinite(ran.covariance).all()
    assert np.allclose(ran.mean[-1], ran.mean[99], atol=1e-3) and np.allclose(ran.covariance[-1], ran.covariance[99], rtol=1e-2, atol=1e-6)
