"""The C of kalmanq compile is right for long, in f32 and q31: beside long double on the numbers of the model file.  What is not in
q31 is told, with a cure that is one; and what the report has observed is what others see."""

from __future__ import annotations

import math
import platform
from typing import Any, Callable

import numpy as np
import pytest
from dense import cholesky, forward
from products import ALL, airdata, interferometer, motor, spindle, thermistors, truckscale, variometer
from test_words import TRAPS
from whole import first

from kalmanq import Model, Quantity
from kalmanq.compiler.algorithm.fixed.first import first_variances
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import report
from kalmanq.compiler.run import record, truth
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import Record
from kalmanq.compiler.text.emit import PREDICTS, UPDATES
from kalmanq.compiler.text.product import Product, compiled
from kalmanq.core import ffi, lib
from kalmanq.model import Gaps

ROWS, SETTLED = 20_000, 4000  # of a record from the start, and of one that begins settled
MEAN, COVARIANCE = 3e-4, {"f32": 1e-4, "q31": 2e-4}  # sigma, sigma_i sigma_j
LONG = np.longdouble


class Exact:
    """The filter of a model file: nothing of the compiler's, but for the sigma that it starts with what is unknown with"""

    def __init__(self, model: Model, P0: np.ndarray):
        self.A, self.H, self.Q, self.x0, self.P0 = (np.asarray(one, LONG) for one in (model.A, model.H, model.Q, model.x0, P0))
        self.B = np.zeros((model.n, 0), LONG) if model.B is None else np.asarray(model.B, LONG)
        self.d = np.zeros(model.m, LONG) if model.d is None else np.asarray(model.d, LONG)
        self.L = cholesky(np.asarray(model.R, LONG))  # noises that are independent, of variance 1
        self.H = np.column_stack([forward(self.L, column) for column in self.H.T])

    def run(self, of: Record, taken: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rows, n, m = len(taken), len(self.x0), len(self.H)
        means, covariances = np.empty((rows, n), LONG), np.empty((rows, n, n), LONG)
        means[0], covariances[0] = self.x0 if of.mean is None else of.mean, self.P0
        z = forward(self.L, (of.z.astype(LONG) - self.d).T).T
        matrices = (self.A, self.B, self.H, self.Q, np.ones(m, LONG))
        exact = ffi.new("kq_exact *", (n, m, self.B.shape[1], 0, *map(_in_c, matrices), 0.0, work := _in_c(np.empty(n * (n + 3), LONG))))
        lib.kq_exact_run(exact, rows, ffi.from_buffer("uint8_t[]", (of.what & PREDICTS).astype(np.uint8)),
                         ffi.from_buffer("uint32_t[]", taken.astype(np.uint32)), *map(_in_c, (of.u.astype(LONG), z, means, covariances)))
        return means, covariances

    def by_hand(self, of: Record, taken: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same in NumPy, as textbooks have it"""
        x, P, made = self.x0 if of.mean is None else of.mean.astype(LONG), self.P0, []
        for what, bits, u, z in zip(of.what, taken, of.u.astype(LONG), of.z.astype(LONG) - self.d):
            if what & PREDICTS:
                x, P = self.A @ x + self.B @ u, self.A @ P @ self.A.T + self.Q
            y = forward(self.L, z)
            for h, one in ((self.H[j], y[j]) for j in range(len(y)) if int(bits) >> j & 1):
                row = P @ h
                x, P = x + row * ((one - h @ x) / (h @ row + 1)), P - np.outer(row, row) / (h @ row + 1)
            made.append((x, P))
        means, covariances = zip(*made)
        return np.array(means), np.array(covariances)


def _in_c(values: np.ndarray) -> Any:
    return ffi.from_buffer("long double[]", np.ascontiguousarray(values))


def errors(product: Product, host: Host, rows: int, seed: int, is_settled: bool = False) -> tuple[float, float]:
    """The largest, of means in sigma and of covariances in sigma_i sigma_j"""
    given, steady = product.given, product.steady.filtered.astype(float) if is_settled else None
    drawn = record.as_taken(product, record.drawn(given, rows, seed, 0, steady))
    ran = host.run_record(drawn)
    means, covariances = Exact(given.model, given.of.doubles().P0 if steady is None else steady).run(drawn, ran.taken)
    sigma = np.sqrt(np.einsum("tii->ti", covariances))
    sigma = np.maximum(sigma, record.FADED * sigma.max(axis=0))  # without noise it fades away
    assert not np.any(ran.events > 1)  # 1: what is refused
    return float(np.abs((ran.mean - means) / sigma).max()), \
        float(np.abs((ran.covariance - covariances) / (sigma[:, :, None] * sigma[:, None, :])).max())


def observed(product: Product, host: Host, seeds: tuple, rows: int = ROWS, settled: int = SETTLED) -> tuple[float, float]:
    found = [errors(product, host, rows, seed) for seed in seeds]
    found += [errors(product, host, settled, seed, True) for seed in seeds if product.arithmetic.steady is not None]
    return max(mean for mean, _ in found), max(covariance for _, covariance in found)


def right_or_told(product: Product, *of: Any) -> None:
    """of: of what is observed"""
    with Host(product) as host:
        mean, covariance = observed(product, host, *of)
        print(f"right {product.given.name} {product.given.options.arithmetic} {mean:.2e} {covariance:.2e}")
        if mean <= MEAN and covariance <= COVARIANCE[product.given.options.arithmetic]:
            return
        assert product.given.options.arithmetic == "q31", (mean, covariance)
        found = report.findings(product, host)
    assert any("is coarse for this model" in one for one in report.warned(product, found)), (mean, covariance, found)
    assert mean <= 3 * found.mean and covariance <= 3 * found.covariance


def test_the_filter_beside_is_the_textbooks() -> None:
    """Measurements that miss, of correlated noises, controls"""
    product = compiled(airdata(), "airdata")
    of, exact = record.drawn(product.given, 300, 3), Exact(product.given.model, product.given.of.doubles().P0)
    (x, P), (y, S) = exact.run(of, of.present), exact.by_hand(of, of.present)
    sigma = np.sqrt(np.einsum("tii->ti", S))
    assert np.abs((x - y) / sigma).max() < 1e-10 and np.abs((P - S) / (sigma[:, :, None] * sigma[:, None, :])).max() < 1e-10


BOTH = [(make, arithmetic) for arithmetic in ("f32", "q31") for make in ALL]


@pytest.mark.parametrize("make, arithmetic", [one for k, one in enumerate(BOTH) if one[1] == "q31" or k % 3 == 0])
def test_every_product_is_right_or_it_is_told(make: Callable[[], Model], arithmetic: str) -> None:
    """In f32 each third; test_compiler.py has each"""
    right_or_told(compiled(make(), make().name, Options(arithmetic)), (1,))


@pytest.mark.parametrize("make, arithmetic", first(0, BOTH))
def test_so_it_is_for_long_with_more_seeds(make: Callable[[], Model], arithmetic: str) -> None:
    right_or_told(compiled(make(), make().name, Options(arithmetic)), (1, 2, 3, 4))


# ------------------------------------------------------------------------------ states that are far beyond their sigma


def cistern() -> Model:
    """One state that leaks"""
    return Model(0.99997, H=1.0007, R=1e-4, Q=1e-7, B=0.037, P0=100, x0=20000, name="cistern", states=[Quantity("level", "mm", 5e4)],
                 measurements=[Quantity("float", "mm", 5e4)], controls=[Quantity("pump", "l/s", 50)])


def rail() -> Model:
    """Sixteen states, of which the factor is in loops: eight carriages on a rail of 2 km"""
    G = np.kron(np.eye(8), [[1e-5], [2e-3]])
    return Model(np.kron(np.eye(8), [[1, 0.01], [0, 1]]), H=np.kron(np.eye(8), [[1, 0]]), R=[1e-6 * (1 + k) for k in range(8)], G=G, P0=[1, 1] * 8, name="rail",
                 states=[Quantity(f"{what} {k}", "", most) for k in range(8) for what, most in (("place", 2e3), ("speed", 30))],
                 measurements=[Quantity(f"tape {k}", "m", 2e3) for k in range(8)])


def swing() -> Model:
    """A quarter of a turn a row: A - I is larger than 1, so what is left in the low part of the mean would grow"""
    return Model(0.98 * np.array([[0.0, -1.0], [1.0, 0.0]]), H=[1, 0], R=1e-6, Q=[1e-6, 1e-6], P0=[1.0, 1.0], name="swing",
                 states=[Quantity("place", "", 1e4), Quantity("other", "", 1e4)], measurements=[Quantity("tape", "", 1e4)])


FUSED = ("-ffp-contract=fast", "-march=haswell") if platform.machine() == "x86_64" else ("-ffp-contract=fast",)


@pytest.mark.parametrize("make, options, flags", [
    (cistern, {}, ()), (rail, {}, ()), (swing, {}, ()), (spindle, {}, FUSED), (truckscale, {}, FUSED), (thermistors, {}, FUSED), (airdata, {"loops": True}, ()),
    (spindle, {"gate": 6.0}, ()), (airdata, {"nis": True}, ()), (airdata, {"every": (1, 4)}, ())], ids=str)
def test_far_rows_are_right_in_each_form(make: Callable[[], Model], options: dict, flags: tuple) -> None:
    """In loops, with options, and where multiply and add are one operation"""
    product = compiled(make(), make().name, Options(**options))
    assert any(product.arithmetic.far)
    with Host(product, flags) as host:
        mean, covariance = errors(product, host, SETTLED, 1)
    assert mean <= MEAN and covariance <= COVARIANCE["f32"]


def test_a_motor_may_turn_at_full_speed() -> None:
    """A row counts by what it is rounded by at the ends of the ranges; states of a record have sigmas of a quarter of them"""
    product = compiled(motor().changed(states=[Quantity("angle", "rad", 1e5), *motor().states[1:]], measurements=[Quantity("encoder", "rad", 1e5)]), "motor")
    of, draws, rows = product.given.of.doubles(), np.random.default_rng(1), ROWS
    x, u, z = np.array([0, 450.0, 0]), np.full((rows, 1), 9.0), np.empty((rows, 1))
    for t in range(rows):
        x = of.A @ x + of.B @ u[t] if t else x
        z[t] = of.H @ x + 1e-3 * draws.standard_normal()
    drawn = Record(np.full(rows, PREDICTS | UPDATES, np.uint8) - (np.arange(rows) == 0).astype(np.uint8) * PREDICTS, np.ones(rows, np.uint32),
                   z.astype(np.float32).astype(float), u)
    with Host(product) as host:
        ran = host.run_record(drawn)
    means, covariances = Exact(product.given.model, of.P0).run(drawn, ran.taken)
    off = np.abs(ran.mean - means) / np.sqrt(np.einsum("tii->ti", covariances))
    assert off[SETTLED:].max() <= MEAN / 10


@pytest.mark.parametrize("P0", (1e8, 1e12, 1e16, 1e18, 1e32))
def test_a_first_sigma_that_is_far_above_is_told(P0: float) -> None:
    """Without a shift that C has not, in words that become finer and in those that would have to by more bits than there are"""
    product = compiled(Model([[1, 1], [0, 1]], H=[1, 0], R=1.0, Q=[[1e-6, 0], [0, 1e-8]], P0=[P0, P0 / 1e4]), "far", Options("q31"))
    with Host(product, TRAPS) as host:
        found = report.findings(product, host)
    is_right = found.mean <= MEAN and found.covariance <= COVARIANCE["q31"]
    assert is_right == (P0 < 1e9) and is_right != any("is coarse for" in one for one in report.warned(product, found))


def test_controls_hold_what_an_offset_moves() -> None:
    """Gravity: the states stay within their ranges, as what is refused shows"""
    product = compiled(variometer(), "variometer", Options("q31"))
    with Host(product) as host:
        assert report.findings(product, host).taken > 0.9


def speedometer() -> Model:
    """Its place is as unknown as it may be"""
    return Model([[1, 0.005], [0, 1]], H=[[0, 1], [1, 0]], R=[0.01, 4], Q=[1e-6, 1e-5], P0=[1e14, 4], states=["place", "speed"], name="speedometer")


@pytest.mark.parametrize("make", (interferometer, speedometer))
def test_the_p0_that_is_told_does(make: Callable[[], Model]) -> None:
    product = compiled(make(), make.__name__, Options("q31"))
    with Host(product) as host:
        found = report.findings(product, host)
    times = max(found.mean / report.MEAN, found.covariance / COVARIANCE["q31"])
    said, of = product.arithmetic.finer(times), product.given.of.doubles()
    less = first_variances(product.given, product.arithmetic.formats, product.steady, times)
    assert all(f"{product.given.model.states[i].name} " in said for i in less) and "P0 of at most" in said
    by = np.array([math.sqrt(less.get(i, of.P0[i, i]) / of.P0[i, i]) for i in range(of.n)])
    cured = compiled(make().changed(P0=of.P0 * np.outer(by, by)), make.__name__, Options("q31"))
    with Host(cured) as host:
        mean, covariance = observed(cured, host, (5,))
        assert not any("is coarse for" in one for one in report.warned(cured, report.findings(cured, host)))
    assert mean <= MEAN and covariance <= COVARIANCE["q31"]


@pytest.mark.parametrize("make", [make for make in ALL if make().n < 9])
def test_records_follow_the_model_and_stay_within_its_ranges(make: Callable[[], Model]) -> None:
    """Squares of innovations are as many as they are in a filter that is right; none of what is given is refused"""
    product = compiled(make(), "flt", Options("f64"))
    given, of = product.given, product.given.of.doubles()
    drawn = record.drawn(given, 6000, 7)
    moves = drawn.what & PREDICTS > 0
    taken = np.where(drawn.what & UPDATES, drawn.present, 0)
    x, u, _ = truth.drawn(given, moves, np.random.default_rng(3))
    means, covariances = (one.astype(float) for one in record.exact_of(given, drawn, taken))
    assert all(np.abs(x[:, i]).max() <= one.range for i, one in enumerate(given.model.states) if one.range)
    assert all(np.abs(drawn.z[:, j]).max() <= one.range for j, one in enumerate(given.model.measurements) if one.range)
    t = np.flatnonzero(moves & (taken == given.all))
    d = 0.0 if given.model.d is None else given.model.d
    y = drawn.z[t] - d - (means[t - 1] @ of.A.T + drawn.u[t] @ of.B.T) @ given.model.H.T
    S = given.model.H @ (of.A @ covariances[t - 1] @ of.A.T + of.Q) @ given.model.H.T + given.model.R
    squares = np.einsum("tj,tj->t", y, np.linalg.solve(S, y[:, :, None])[:, :, 0]) / of.m
    assert 0.9 < np.mean(squares) < 1.1 and squares.max() < 40


# ------------------------------------------------------------------------------ what is reported, and what others see


def _cart() -> Model:
    return Model([[1, 0.02, 0.0002], [0, 1, 0.02], [0, 0, 0.999]], H=[[1, 0, 0], [0, 1, 0]], R=[1e-4, 0.04], Q=[0, 1e-5, 1e-4],
                 B=[0.0002, 0.02, 0], P0=[1, 1, 0.25], name="cart", states=[Quantity("place", "m", 50), Quantity("speed", "m/s", 5), Quantity("slope", "m/s2", 3)],
                 measurements=[Quantity("wheel", "m", 50), Quantity("radar", "m/s", 6)], controls=[Quantity("push", "m/s2", 4)])


def _sump() -> Model:
    return Model([[1, 60], [0, 0.95]], H=[[1, 0], [1, 0]], R=[4, 100], Q=[0.1, 1e-5], P0=[1e4, 1e-2], name="sump", gaps=Gaps(30),
                 states=[Quantity("level", "mm", 3000), Quantity("inflow", "mm/s", 1)], measurements=["pressure", "sonar"])


def _gimbal() -> Model:
    A = np.kron(np.eye(2), [[1, 0.005], [0, 0.998]])
    return Model(A, H=np.kron(np.eye(2), [[1, 0]]), R=[[1e-6, 4e-7], [4e-7, 2e-6]], Q=[0, 1e-6, 0, 2e-6], P0=[0.01, 0.1] * 2, name="gimbal",
                 states=["yaw", "yaw rate", "pitch", "pitch rate"], measurements=["yaw camera", "pitch camera"])


def _bearing() -> Model:
    return Model([[1.8, -0.95, 0], [1, 0, 0], [0, 0, 1]], H=[1, 0, 1], R=0.09, Q=[0.01, 0, 1e-8], P0=[4, 4, 1], name="bearing",
                 states=["swing", "before", "offset"], measurements=[Quantity("accelerometer", "g", 16)])


def _pack() -> Model:
    return Model([[1, 0, -2.8e-5], [0, 0.995, 0], [0, 0, 1]], H=[[0.9, -1, 0], [0, 0, 1]], R=[4e-4, 1e-2], Q=[1e-10, 1e-7, 1e-8], B=[-2.8e-5, 4e-5, 0],
                 P0=[0.06, 1e-3, 0.04], x0=[0.5, 0, 0], name="pack", states=[Quantity("charge", "", 1.2), Quantity("relaxation", "V", 0.5), Quantity("offset", "A", 2)],
                 measurements=[Quantity("volts", "V", 2), Quantity("rest", "A", 5)], controls=[Quantity("amps", "A", 100)])


def _turbine() -> Model:
    return Model([[0.998, 0.05, 0], [-0.08, 0.99, 0.01], [0, 0, 0.9999]], H=[[1, 0, 0], [0, 1, 0]], R=[0.01, 0.25], Q=[1e-4, 1e-3, 1e-4], P0=[1, 1, 4],
                 name="turbine", states=["sway", "rate", "wind"], measurements=["gps", "gyro"], gaps=Gaps(5))


def _flow() -> Model:
    return Model([[0.97, 0], [0, 1]], H=[[1, 1], [1, 0]], R=[0.01, 0.5], Q=[0.02, 1e-9], P0=None, unknown="all", name="flow",
                 states=[Quantity("flow", "l/s", 40), Quantity("zero", "l/s", 4)], measurements=[Quantity("ultrasonic", "l/s", 50), Quantity("turbine", "l/s", 50)])


def _greenhouse() -> Model:
    return Model([[0.96, 0.03, 0], [0.002, 0.997, 0.001], [0, 0, 0.9995]], H=[[1, 0, 0], [0, 0, 1]], R=[0.04, 0.25], Q=[0.01, 1e-4, 1e-3], B=[0.2, 0, 0],
                 P0=[25, 25, 100], x0=[18, 15, 8], name="greenhouse", states=[Quantity("air", "C", 60), Quantity("soil", "C", 60), Quantity("outside", "C", 60)],
                 measurements=[Quantity("inside", "C", 80), Quantity("mast", "C", 80)], controls=[Quantity("burner", "kW", 10)])


@pytest.mark.parametrize("arithmetic", ("f32", "q31"))
@pytest.mark.parametrize("make", first(3, (_sump, _pack, _bearing, _cart, _gimbal, _turbine, _flow, _greenhouse)))
def test_what_is_reported_is_what_is_seen(make: Callable[[], Model], arithmetic: str) -> None:
    """On models that nothing was tuned on"""
    product = compiled(make(), make().name, Options(arithmetic))
    with Host(product) as host:
        found, (mean, covariance) = report.findings(product, host), observed(product, host, (11, 12))
    print(f"seen {make().name} {arithmetic} {mean:.1e} {found.mean:.1e} {covariance:.1e} {found.covariance:.1e}")
    assert mean <= 3 * found.mean and covariance <= 3 * found.covariance
    assert found.mean <= 10 * mean and found.covariance <= 10 * covariance and found.taken == 1
