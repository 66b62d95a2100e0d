"""kalmanq compile: every constant model, the settled gain by a bound, and C that is as exact as its arithmetic."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Callable, Optional
from unittest import mock

import numpy as np
import pytest
from command import twice
from driven import Driven
from equations import STRICT
from library import cc, passes, saved, written
from products import ALL, drone, gps, heart, interferometer, load_cell, rover, spring, tank, tilt, ultrasound, well
from scipy.stats import chi2
from whole import WHOLE, first, paired

import kalmanq
from kalmanq import Model
from kalmanq.compiler.algorithm.ud import columns_of_noise
from kalmanq.compiler.given.request import GAP, LONGEST_GAP, Options
from kalmanq.compiler.report import report
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.run.record import Accuracy, drawn, tried
from kalmanq.compiler.run.trial import trial
from kalmanq.compiler.text.product import compiled
from kalmanq.errors import KalmanqError
from kalmanq.model import model_file

ARITHMETICS = ("f32", "f64")
LONG = np.longdouble
MEAN = {"f32": 3e-4, "f64": 3e-6}  # sigma; f64: what a gain that counts as constant leaves
COVARIANCE = {"f32": 1e-4, "f64": 2e-6}  # sigma_i sigma_j


@pytest.mark.parametrize("arithmetic", [*ARITHMETICS, "q31"])
@pytest.mark.parametrize("options", [{}, {"nis": True, "gate": 4.0}, {"lag": 2}, {"loops": True}, {"every": (1, 2)}], ids=str)
def test_nothing_of_a_template_is_left(arithmetic: str, options: dict):
    product = compiled(gps(), "gps", Options(arithmetic, **options))
    with Host(product) as host:
        text = "\n".join([*product.sources().values(), trial(product, host)])
    assert not re.search(r"\$\{|\{[%#]|//[?*]|\0", text)


# ------------------------------------------------------------------------------ every product


def accurate(model: Model, arithmetic: str, rows: int, seeds: tuple, folder: Path) -> list[Accuracy]:
    """Its C has no warning, its test prints OK, and it is beside long double with gaps of ten times the declared."""
    product = compiled(model, model.name, Options(arithmetic))
    with Host(product) as host:
        made = tried(product, host, rows, seeds, 10 * max(model.gaps.max_gap, GAP))
        texts = report.files(product, trial(product, host), [], "")
    written(folder, texts)
    digest = passes(folder, model.name, compiler="gcc", flags=(*STRICT, "-O1", "-ffp-contract=off")).split("digest ")[1].split()[0]
    assert f"(-ffp-contract=off): {digest}." in texts[f"{model.name}_test.c"]
    if shutil.which("clang"):
        cc("clang", *STRICT, "-fsyntax-only", f"{model.name}.c", f"{model.name}_test.c", folder=folder)
    assert max(one.mean for one in made) < MEAN[arithmetic]
    assert max(one.covariance for one in made) < COVARIANCE[arithmetic]
    return made


@pytest.mark.parametrize("make, arithmetic", [(make, "f32") for make in ALL] + [
    pytest.param(make, "f64", marks=[WHOLE] if k % 3 else []) for k, make in enumerate(ALL)])
def test_every_product(make: Callable[[], Model], arithmetic: str, tmp_path: Path) -> None:
    seeds = (1, 2, 3) if make in (gps, tilt, rover) else (1,)
    accurate(make(), arithmetic, 1000, seeds, tmp_path)


@pytest.mark.parametrize("make", [gps, ultrasound, interferometer, drone])
def test_noise_of_fewer_columns_than_states_is_as_many(make: Callable[[], Model]) -> None:
    """In double G G' has a rank that is rounding"""
    model = make()
    assert len(columns_of_noise(compiled(model, "flt").given.of.Q)) == model.G.shape[1]


@pytest.mark.parametrize("make", first(2, (interferometer, load_cell, ultrasound, gps, rover, tank)))
def test_a_measurement_that_is_known_far_better_than_the_start(make: Callable[[], Model]) -> None:
    model = make()
    spread = np.einsum("ji,ik,jk->j", model.H, model.P0, model.H)
    product = compiled(model.changed(R=1e-10 * spread), "flt")
    with Host(product) as host:
        made, found = tried(product, host, 1500, (1, 2)), report.findings(product, host)
    mean, covariance = max(one.mean for one in made), max(one.covariance for one in made)
    if make is gps:  # after second updates a float knows the velocity less well; compile says so
        assert report.warned(product, found) and mean < 3 * found.mean and covariance < 3 * found.covariance
    else:
        assert mean < 1e-2 and covariance < 7e-4


@pytest.mark.skipif(not shutil.which("g++"), reason="no C++ compiler")
@pytest.mark.parametrize("options", [Options(nis=True), Options("f64", gate=4.0, nis=True), Options(student=5.0)])
def test_cpp_takes_the_header(options: Options, tmp_path: Path) -> None:
    written(tmp_path, compiled(rover(), "flt", options).sources())
    (tmp_path / "main.cpp").write_text('#include "flt.h"\nint main()\n{\n    flt_filter f;\n    flt_start(&f);\n'
                                       "    return f.events;\n}\n")
    strict = [one for one in STRICT if one != "-std=c11"]
    cc("g++", "-fsyntax-only", *strict, tmp_path / "main.cpp")


# ------------------------------------------------------------------------------ after how many samples it has settled


class Pasts:
    """Covariances of many pasts at once, in long double"""

    def __init__(self, model: Model, count: int, seed: int):
        self.product = compiled(model, "x", Options("f64"))
        of, steady = self.product.given.of, self.product.steady
        assert steady is not None
        self.steady, self.count, self.draws = steady, count, np.random.default_rng(seed)
        self.A, self.H, self.Q, self.R = (getattr(of, one).astype(float).astype(LONG) for one in ("A", "H", "Q", "R"))
        self.aim = steady.filtered.astype(float).astype(LONG)
        self.P = np.broadcast_to(self.aim, (count, of.n, of.n)).copy()

    def predict(self, which: Optional[np.ndarray] = None) -> None:
        P = np.matmul(np.matmul(self.A, self.P), self.A.T) + self.Q
        self.P = P if which is None else np.where(which[:, None, None], P, self.P)

    def take(self, j: int, which: Optional[np.ndarray] = None) -> None:
        row = self.P @ self.H[j]
        weight = 1 / (row @ self.H[j] + self.R[j])
        P = self.P - row[:, :, None] * row[:, None, :] * weight[:, None, None]
        self.P = P if which is None else np.where(which[:, None, None], P, self.P)

    def full(self, count: int) -> None:
        for _ in range(count):
            self.predict()
            for j in range(len(self.H)):
                self.take(j)

    def begin(self) -> None:
        """Variances of 16 decades and any correlations; then gaps, samples in part, in any order and repeated"""
        n, sigma = len(self.A), np.sqrt(np.diag(self.aim))
        mixed = self.draws.standard_normal((self.count, n, n + 1))
        mixed /= np.sqrt((mixed**2).sum(axis=2))[:, :, None]
        scale = 10 ** self.draws.uniform(-4, 4, (self.count, n)) * sigma
        mixed = mixed * scale[:, :, None]
        self.P = np.matmul(mixed, mixed.transpose(0, 2, 1)).astype(LONG)
        for _ in range(30):
            self.predict(self.draws.random(self.count) < 0.7)
            for j in self.draws.permutation(len(self.H)):
                self.take(int(j), self.draws.random(self.count) < 0.4)

    @property
    def off(self) -> float:
        """The largest relative distance to the steady variances"""
        variance = np.diag(self.aim)
        return float((np.abs(np.einsum("tii->ti", self.P) - variance) / variance).max())

    def gain_error(self) -> tuple[np.ndarray, np.ndarray]:
        """The largest of each entry, and its bound: from variances that are within the tolerance"""
        gain = self.P @ self.H.T / self.R
        sigma = np.sqrt(np.diag(self.aim))
        bound = self.steady.tolerance * np.outer(sigma, (np.abs(self.H) @ sigma) / self.R)
        return np.abs(gain - self.steady.gain.astype(float).astype(LONG)).max(axis=0), bound


SETTLING = [make for make in ALL if make.__name__ not in ("scale", "quartz", "bldc", "variometer", "lift", "truckscale")]
SOON = [make for make in SETTLING if make is not drone and make.__name__ not in (  # within 500 samples
    "press", "tilt", "battery", "clock", "motor", "meter", "calendar", "borehole", "gnss_odo", "thermistors", "spindle", "tide", "airdata", "hydraulic",
    "picoammeter", "gpsdo", "calorimeter")]


@pytest.mark.parametrize("make, many", [*((make, False) for make in SOON), *first(0, [(make, True) for make in SETTLING])])
def test_it_has_settled_after_any_past(make: Callable[[], Model], many: bool) -> None:
    model = make()
    count = 40 if not many else 10_000 if model.n < 4 else 1000
    pasts = Pasts(model, count, 1)
    pasts.begin()
    pasts.full(pasts.steady.samples)
    error, bound = pasts.gain_error()
    off, ratio = pasts.off / pasts.steady.tolerance, float((error / np.maximum(bound, 1e-300)).max())
    print(f"settles {model.name}: {count} pasts, {pasts.steady.samples} samples, variance {off:.3f}, gain {ratio:.3f} of the bound")
    assert off <= 1 and np.all(error <= bound)


@pytest.mark.parametrize("make", [one for one in SETTLING if one in SOON or one in (drone, tilt)])
def test_it_has_settled_after_a_gap(make: Callable[[], Model]) -> None:
    """Not a sample later than it is said, and not one sooner"""
    pasts, gap = Pasts(make(), 1, 1), 0
    steady = pasts.steady
    assert len(steady.after_gap) == min(max(make().gaps.max_gap, GAP), LONGEST_GAP)
    for rest in steady.after_gap:
        gap += 1
        pasts.P = pasts.aim[None].copy()
        for _ in range(gap):
            pasts.predict()
        pasts.full(rest - 1)
        assert pasts.off > steady.tolerance or rest == 1
        pasts.full(1)
        assert pasts.off <= steady.tolerance * (1 + 1e-9)


def test_what_does_not_settle_has_no_fast_path() -> None:
    bias = Model(np.eye(2), H=[1, 1], R=1.0, Q=[1, 0], P0=[1, 1])
    unseen = Model(np.eye(2), H=[1, 0], R=1.0, Q=[1, 1], P0=[1, 1])
    explodes = Model([[1e9, 0], [0, 0.9]], H=[0, 1], R=1.0, Q=[0.1, 0.1], P0=[1, 1])
    for model in (bias, unseen, explodes):
        product = compiled(model, "x")
        assert product.steady is None and "SETTLED" not in product.code
        assert "no steady state" in product.code


def test_a_coarser_settling_comes_sooner() -> None:
    samples = [compiled(tank(), "x", Options(settle=one)).steady.samples for one in (1e-8, 1e-6, 1e-4, 1e-2)]
    assert samples == sorted(samples, reverse=True) and samples[0] > 2 * samples[-1]


# ------------------------------------------------------------------------------ settled is as not settled


class Pair:
    """The same calls of a filter with a settled path, and of one without"""

    def __init__(self, model: Model, arithmetic: str, folder: Path):
        self.with_ = Driven(model, folder / "with", Options(arithmetic))
        with mock.patch("kalmanq.compiler.text.product.enclosure.settled", return_value=None):
            self.without = Driven(model, folder / "without", Options(arithmetic))
        assert self.with_.product.steady is not None and self.without.product.steady is None
        self.samples = self.with_.product.steady.samples
        self.mean = self.covariance = 0.0
        product = self.with_.product
        self.record = drawn(product.given, 4 * self.samples + 200, 1)
        self.row = 0

    def next(self) -> tuple[np.ndarray, np.ndarray]:
        self.row = (self.row + 1) % len(self.record.z)
        return self.record.z[self.row], self.record.u[self.row]

    def call(self, name: str, *given: object) -> None:
        taken = [getattr(one, name)(*given) for one in (self.with_, self.without)]
        assert taken[0] == taken[1]
        sigma = np.sqrt(np.diag(self.without.covariance))
        self.mean = max(self.mean, float((np.abs(self.with_.mean - self.without.mean) / sigma).max()))
        self.covariance = max(self.covariance, float(
            (np.abs(self.with_.covariance - self.without.covariance) / np.outer(sigma, sigma)).max()))

    def settle(self, in_one: bool = True) -> None:
        for k in range(self.samples + 2):
            z, u = self.next()
            if in_one:
                self.call("step", z, u)
            else:
                self.call("predict", u)
                self.call("update", z)
        assert self.with_.is_settled
        self.call("step", *self.next())

    def rows(self, count: int = 3) -> None:
        for _ in range(count):
            self.call("step", *self.next())


@pytest.mark.parametrize("make, arithmetic", paired((gps, rover, heart, ultrasound), ARITHMETICS))
def test_settled_is_as_not_settled(make: Callable[[], Model], arithmetic: str, tmp_path: Path) -> None:
    pair = Pair(make(), arithmetic, tmp_path)
    m, none = pair.with_.of.m, np.full(pair.with_.of.m, np.nan)
    mean, covariance = {"f32": (2e-5, 2e-5), "f64": (5e-6, 2e-6)}[arithmetic]

    def left() -> None:
        assert not pair.with_.is_settled
        pair.rows()

    pair.settle(), pair.settle(in_one=False)
    z, _ = pair.next()
    pair.call("update", z), left()  # twice
    pair.settle()
    pair.call("update", z), pair.call("update", z), left()  # three times
    pair.settle()
    for count in (1, 2, 3, 20):  # a gap: not enough samples, then enough
        for _ in range(count):
            pair.call("predict", pair.next()[1])
        pair.rows(2)
        assert not pair.with_.is_settled
        pair.settle()
    z, u = pair.next()  # nothing is taken: no sample is there
    for bad in (np.nan, np.inf, -np.inf, 1e30):
        pair.call("step", none * 0 + bad, u)
        assert pair.with_.events & 1 and pair.without.events & 1
    left()
    pair.settle()
    pair.call("predict", u)
    pair.call("update", np.where(np.arange(m) == 0, np.nan, z))  # refused, then a good one: as if it were the first
    assert pair.with_.is_settled == (m == 1 or make is rover)  # correlated ones are taken together
    pair.call("update", z)
    pair.settle()
    if m > 1 and make is not rover:
        pair.call("predict", u), pair.call("update", z, 1), left()
        pair.settle()
        pair.call("predict", u), pair.call("update", z, 1), pair.call("update", z, 2), left()  # in two parts
        pair.settle()
        pair.call("predict", u), pair.call("update", z, 0)
        assert pair.with_.is_settled
        pair.call("update", z, 3)
    assert pair.mean < mean and pair.covariance < covariance
    for one in (pair.with_, pair.without):  # a gap of 100,000
        one.start()
    pair.settle()
    for one in (pair.with_, pair.without):
        for _ in range(100_000):
            one.predict()
    pair.rows(5)
    pair.settle()
    # R is 1e-13 of what is known then
    assert pair.mean < {"f32": 1e-2, "f64": 5e-6}[arithmetic]
    assert pair.covariance < {"f32": 7e-4, "f64": 5e-6}[arithmetic]


def test_one_gap_is_the_shorter_way_back(tmp_path: Path) -> None:
    one = Driven(gps(), tmp_path)
    steady = one.product.steady
    for _ in range(steady.samples + 1):
        one.step([0, 0])
    for gap, rest in enumerate(steady.after_gap, 1):
        assert one.is_settled
        for _ in range(gap):
            one.predict()
        for k in range(rest):
            one.step([0, 0])
            assert one.is_settled == (k >= rest - 1)
    for _ in range(2):  # a second gap before that: all samples again
        one.predict()
        one.step([0, 0])
    for _ in range(steady.samples - 1):
        assert not one.is_settled
        one.step([0, 0])
    assert one.is_settled


def test_a_sample_without_a_predict_does_not_count(tmp_path: Path) -> None:
    one = Driven(heart(), tmp_path)
    for _ in range(3 * one.product.steady.samples):
        one.update([70, 70])
    assert not one.is_settled


# ------------------------------------------------------------------------------ what a float has trouble with


A_BIT = 0.1
TROUBLE = {
    "fades without noise": lambda: Model([[1, 1], [0, 0.5]], H=[1, 0], R=1, Q=[A_BIT, 0], P0=[1, 1]),
    "nothing is driven": lambda: Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[0, 0], P0=[1, 1]),
    "all fades": lambda: Model([[0.5, 0], [0, 0.9]], H=[1, 1], R=1, Q=[0, 0], P0=[1, 1]),
    "unseen": lambda: Model([[1, 0], [0, 0.9]], H=[0, 1], R=1, Q=[0.01, A_BIT], P0=[1, 1]),
    "a delay line": lambda: Model([[1, 0, 0], [1, 0, 0], [0, 1, 0]], H=[0, 0, 1], R=1, Q=[A_BIT, 0, 0], P0=[1, 1, 1]),
    "known at first": lambda: Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[A_BIT, A_BIT], P0=[0, 0]),
    "known for ever": lambda: Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[0, 0], P0=[0, 0]),
    "an oscillator": lambda: Model([[0.8, 0.6], [-0.6, 0.8]], H=[1, 0], R=1, Q=[0, 0], P0=[1, 1]),
    "unstable": lambda: Model([[1.2, 0], [0, 0.9]], H=[1, 1], R=1, Q=[A_BIT, A_BIT], P0=[1, 1]),
    "signs": lambda: Model([[-1, 0], [0, -0.5]], H=[-2, 0.5], R=1, Q=[1, 0], P0=[1, 1]),
    "a short step": lambda: Model([[1, 1e-6], [0, 1]], H=[1, 0], R=1e-4, Q=[1e-12, 1e-4], P0=[1, 1]),
    "a sum": lambda: Model([[2, -1], [1, 0]], H=[1, 0], R=1, Q=[1e-3, 0], P0=[1, 1]),
    "no row of A": lambda: Model([[0, 0], [1, 0]], H=[1, 1], R=1, Q=[1, 0], P0=[1, 1]),
    "a row of H that is 0": lambda: Model([[1, 1], [0, 1]], H=[[1, 0], [0, 0]], R=[1, 1], Q=[A_BIT, A_BIT], P0=[1, 1]),
    "a column of B that is 0": lambda: Model(1, H=1, R=1, Q=1, P0=1, B=[[1.0, 0.0]]),
    "a clock in s": lambda: Model([[1, 1], [0, 1]], H=[1, 0], R=1e-28, Q=[1e-30, 1e-34], P0=[1e-24, 1e-28]),
    "a clock that fades": lambda: Model([[1, 1], [0, 0.9]], H=[1, 0], R=1e-24, Q=[1e-26, 0], P0=[1e-20, 1e-24]),
    "large units": lambda: Model([[1, 1], [0, 1]], H=[1, 0], R=1e18, Q=[1e16, 1e12], P0=[1e22, 1e18]),
    "far from 0": lambda: Model([[1, 1], [0, 1]], H=[1, 0], R=1, Q=[A_BIT, A_BIT], P0=[1, 1], x0=[101325, 0]),
}


@pytest.mark.parametrize("what", TROUBLE)
def test_what_a_float_has_trouble_with(what: str, tmp_path: Path) -> None:
    for arithmetic in ARITHMETICS:
        product = compiled(TROUBLE[what](), "flt", Options(arithmetic))
        with Host(product) as host:
            made, = tried(product, host, 1500, (1,))
            record = drawn(product.given, 1500, 2)
            ran, found = host.run_record(record), report.findings(product, host)
        is_told = any("is coarse for this model" in one for one in report.warned(product, found))
        is_right = made.mean < MEAN[arithmetic] and made.covariance < COVARIANCE[arithmetic]
        assert is_right or is_told and arithmetic == "f32" and what in ("an oscillator", "a sum", "a clock that fades")
        assert np.all(np.einsum("tii->ti", ran.covariance) >= 0) and np.all(np.isfinite(ran.mean))
        written(tmp_path, product.sources())
        cc("gcc", "-fsyntax-only", *STRICT, tmp_path / "flt.c")


@pytest.mark.parametrize("what", first(3, ("fades without noise", "a row of H that is 0", "known at first", "unseen",
                                           "an oscillator")))
def test_nothing_is_undefined(what: str, tmp_path: Path) -> None:
    model = TROUBLE[what]()
    product = compiled(model, "flt", Options(gate=3.0, nis=True))
    with Host(product) as host:
        texts = report.files(product, trial(product, host), [], "")
    written(tmp_path, texts)
    passes(tmp_path, "flt", compiler="gcc", flags=(*STRICT, "-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover"))


def test_every_entry_is_read_where_a_part_is_constant(tmp_path: Path) -> None:
    """One entry is carried and those after it are constant: they are not read behind the carried ones."""
    one = Driven(Model(np.eye(2), H=[1, 0], R=1.0, Q=[1, 0], P0=[4, 0]), tmp_path / "0")
    one.predict()
    assert np.allclose(one.covariance, [[5, 0], [0, 0]])
    one = Driven(Model(np.eye(2), H=[1, 0], R=1.0, Q=[1, 0], P0=[4, 9]), tmp_path / "9")
    one.predict()
    assert np.allclose(one.covariance, [[5, 0], [0, 9]])


def test_fast_math_is_refused(tmp_path: Path) -> None:
    written(tmp_path, compiled(tank(), "flt").sources())
    for flags in (["-ffast-math"], ["-Ofast"], ["-funsafe-math-optimizations"], ["-ffinite-math-only"]):
        done = subprocess.run(["gcc", "-c", *flags, str(tmp_path / "flt.c"), "-o", str(tmp_path / "flt.o")],
                              capture_output=True, text=True)
        assert done.returncode and "-ffast-math" in done.stderr


# ------------------------------------------------------------------------------ events, ranges, controls


def test_events_say_what_was_refused(tmp_path: Path) -> None:
    model = rover().changed(R=[0.01, 0.02])
    one = Driven(model, tmp_path)
    refused, control = 1, 2
    assert one.update([1, 1]) == 3 and one.events == 0
    for z, taken in (([1, np.nan], 1), ([np.inf, 1], 2), ([5.001, -5.001], 0), ([5, -5], 3), ([1e38, 1], 2)):
        assert one.update(z) == taken
        assert one.events == (0 if taken == 3 else refused)
    assert one.update([1, np.nan], 1) == 1 and one.events == 0  # what is not there is not refused
    assert one.update([1, np.nan], 3) == 1 and one.events == refused
    assert one.update([1, 1], 0) == 0 and one.events == 0
    assert one.update([1, 1], 0xfffffffc) == 0 and one.events == 0
    for u, same in (([13, 0], [12, 0]), ([-np.inf, 0], [-12, 0]), ([np.nan, 1], [0, 1]), ([1, 1e38], [1, 12])):
        one.start()
        one.predict(u)
        assert one.events == control
        bits = one.bits
        one.start()
        one.predict(same)
        assert one.events == 0 and one.bits == bits
    one.update([9, 9]), one.predict([99, 0])
    assert one.events == refused | control


def test_a_refused_row_changes_nothing_but_its_event(tmp_path: Path) -> None:
    one = Driven(gps(), tmp_path, Options(nis=True))
    one.update([1, 2])
    one.predict()
    before = one.mean, one.covariance
    assert one.update([np.nan, np.nan]) == 0 and one.events == 1
    assert np.array_equal(one.mean, before[0]) and np.array_equal(one.covariance, before[1])
    assert one.likelihood(0) == 0


def test_groups_of_correlated_measurements_are_taken_together(tmp_path: Path) -> None:
    R = np.array([[1, 0.5, 0], [0.5, 1, 0], [0, 0, 1]])
    one = Driven(Model(1, H=[[1], [1], [1]], R=R, Q=1, P0=1), tmp_path)
    assert one.update([1, 2, 3]) == 7
    assert one.update([1, np.nan, 3]) == 4 and one.events == 1
    assert one.update([1, 2, 3], 0b101) == 4 and one.events == 1
    assert one.update([1, 2, np.nan]) == 3


# ------------------------------------------------------------------------------ beside the library


def run(one: Driven, z: np.ndarray, u: np.ndarray) -> dict[str, np.ndarray]:
    """As Filter.run: no predict before the first row, NaN is missing"""
    means, covariances, nis, likelihood, taken = [], [], [], [], []
    for t, row in enumerate(z):
        if t:
            one.predict(u[t - 1] if one.of.l else None)
        there = ~np.isnan(row)
        taken.append(one.update(row, int(there @ (1 << np.arange(len(row))))) if there.any() else 0)
        means.append(one.mean), covariances.append(one.covariance)
        if one.product.given.options.nis:
            nis.append(one.nis), likelihood.append(one.likelihood(taken[-1]))
    return {"mean": np.array(means), "sigma": np.sqrt(np.einsum("tii->ti", np.array(covariances))),
            "nis": np.array(nis), "likelihood": np.array(likelihood), "taken": np.array(taken)}


def by_library(model: Model, z: np.ndarray, u: np.ndarray, robust: Optional[kalmanq.Robust] = None) -> kalmanq.Run:
    return kalmanq.Filter(model, "f64").run(z, u if model.l else None, robust=robust)


def apart(one: dict[str, np.ndarray], other: kalmanq.Run, after: int = 0) -> float:
    """Of means, in sigma"""
    return float(np.abs((one["mean"] - other.mean) / other.sigma)[after:].max())


def sampled(model: Model, rows: int, seed: int, missing: float = 0.05) -> tuple[np.ndarray, np.ndarray]:
    record = drawn(compiled(model, "x").given, rows, seed)
    z = record.z.copy()
    draws = np.random.default_rng(seed)
    z[draws.random(z.shape) < missing] = np.nan
    return z, record.u


@pytest.mark.parametrize("make", (gps, tilt, spring, lambda: rover().changed(R=[0.01, 0.02])))
def test_nis_and_likelihood(make: Callable[[], Model], tmp_path: Path) -> None:
    model = make()
    for arithmetic, tolerance in (("f64", 1e-5), ("f32", 1e-3)):
        one = Driven(model, tmp_path / arithmetic, Options(arithmetic, nis=True))
        z, u = sampled(model, 300, 1)
        ours, library = run(one, z, u), by_library(model, z, u)
        there = ~np.isnan(z).all(axis=1)
        assert np.allclose(ours["mean"], library.mean, rtol=1e-5, atol=1e-3 * library.sigma.min())
        assert np.allclose(ours["sigma"], library.sigma, rtol=1e-4)
        assert np.allclose(ours["nis"][there], library.nis[there], rtol=tolerance, atol=tolerance)
        assert np.allclose(ours["likelihood"][there], library.log_likelihood[there], rtol=tolerance, atol=tolerance)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_correlated_measurements(arithmetic: str, tmp_path: Path) -> None:
    model = rover()
    one = Driven(model, tmp_path, Options(arithmetic, nis=True))
    z, u = sampled(model, 300, 1, missing=0)
    z[np.random.default_rng(1).random(len(z)) < 0.1] = np.nan
    ours = run(one, z, u)
    taken = ours["taken"] == 3
    assert taken.sum() > 200
    z[~taken] = np.nan
    library = by_library(model, z, u)
    assert apart(ours, library) < 1e-5
    assert np.allclose(ours["sigma"], library.sigma, rtol=1e-5)
    assert np.allclose(ours["nis"][taken], library.nis[taken], rtol=1e-3, atol=1e-4)
    assert np.allclose(ours["likelihood"][taken], library.log_likelihood[taken], rtol=1e-3, atol=1e-3)


def outliers(model: Model, rows: int, seed: int, in_a_row: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Single ones, and some in a row"""
    z, u = sampled(model, rows, seed, missing=0.02)
    draws = np.random.default_rng(seed)
    far = 12 * np.sqrt(np.diag(model.R) + np.diag(model.H @ model.Q @ model.H.T))
    z += far * (draws.random(z.shape) < 0.05) * draws.choice([-1, 1], z.shape)
    z[rows // 2:rows // 2 + in_a_row] += 3 * far
    return z, u


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("make", (tank, spring))
def test_a_gate_is_the_library_s(make: Callable[[], Model], arithmetic: str, tmp_path: Path) -> None:
    model, level = make(), 0.9999
    one = Driven(model, tmp_path, Options(arithmetic, gate=float(np.sqrt(chi2.ppf(level, 1)))))
    z, u = outliers(model, 400, 1, in_a_row=6)  # the ninth the library takes with a covariance that it raises
    ours = run(one, z, u)
    there = ~np.isnan(z[:, 0])
    assert 10 < np.sum(ours["taken"][there] == 0) < 200
    assert apart(ours, by_library(model, z, u, kalmanq.Robust("gate", level))) < 1e-4
    assert one.events & 2


def test_a_gate_looks_at_each_component(tmp_path: Path) -> None:
    model, gate = gps(), 4.0
    one = Driven(model, tmp_path, Options("f64", gate=gate))
    z, _ = outliers(model, 400, 2)
    ours = run(one, z, np.zeros((len(z), 0)))
    x, P, rejected, settled = model.x0, model.P0, np.zeros(2, int), 0
    for t, row in enumerate(z):
        if t:
            x, P = model.A @ x, model.A @ P @ model.A.T + model.Q
        bits = 0
        for j in range(2):
            if np.isnan(row[j]):
                continue
            h, r = model.H[j], model.R[j, j]
            y, s = row[j] - h @ x, h @ P @ h + r
            is_near = y * y <= gate**2 * s
            if not is_near and rejected[j] < 8:
                rejected[j] += 1
                continue
            rejected[j], bits = 0 if is_near else 8, bits | 1 << j
            k = P @ h / s
            x, P = x + k * y, P - np.outer(k, h @ P)
        settled += one.is_settled
        assert ours["taken"][t] == bits, t
        assert np.abs((ours["mean"][t] - x) / np.sqrt(np.diag(P))).max() < 1e-4


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_a_gate_follows_a_jump_that_lasts(arithmetic: str) -> None:
    z = np.zeros((400, 1))
    z[200:] = 100.0
    with Host(compiled(tank(), "filter", Options(arithmetic, gate=3.89))) as host:
        ran = host.run(z)
    assert np.flatnonzero(ran.taken[:220] == 0).tolist() == list(range(200, 208))  # eight rejections, then all
    assert abs(ran.mean[-1, 0] - 100) < 0.1


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("make, nu", [(tank, 4.0), (spring, 10.0)])
def test_student_is_the_library_s(make: Callable[[], Model], nu: float, arithmetic: str, tmp_path: Path) -> None:
    model = make()
    one = Driven(model, tmp_path, Options(arithmetic, student=nu))
    z, u = outliers(model, 400, 3)
    ours = run(one, z, u)
    library = by_library(model, z, u, kalmanq.Robust("student", nu))
    assert apart(ours, library) < 1e-3 < apart(vars(by_library(model, z, u)), library)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_start_that_is_given(arithmetic: str, tmp_path: Path) -> None:
    model, mean, sigma = gps(), [3, -1, 40, 0.5], [20, 3, 20, 1]
    at, as_ = Driven(model, tmp_path / "at", Options(arithmetic)), \
        Driven(model.changed(x0=mean, P0=np.square(sigma)), tmp_path / "as", Options(arithmetic))
    for _ in range(50):
        at.step([5, 5])
    assert at.start_at(mean, sigma) and np.array_equal(at.mean, mean)
    assert arithmetic == "q31" or not at.start_at([0, 0, 0, 0], [20, -3, 20, 1]) and np.array_equal(at.mean, mean)
    for t in range(60):
        for one in (at, as_):
            one.step([t * 0.3, -t]) if t else one.update([3, 41])
        spread = np.sqrt(np.diag(as_.covariance))
        assert np.abs((at.mean - as_.mean) / spread).max() < 1e-5
        if t > 20:  # axes that are alike share a variance: the larger one
            assert np.allclose(at.covariance, as_.covariance, rtol=1e-3, atol=1e-3 * spread.min()**2)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_an_unknown_start_is_the_library_s(arithmetic: str, tmp_path: Path) -> None:
    for name, model in (("well", well()), ("gps", gps().changed(P0=None, unknown="all")),
                        ("part", tank().changed(P0=[0, 1], unknown=["level"]))):
        one = Driven(model, tmp_path / name, Options(arithmetic))
        z, u = sampled(well() if name == "well" else model.changed(P0=np.ones(model.n), unknown=()), 200, 1, missing=0)
        ours, library = run(one, z, u), by_library(model, z, u)
        assert apart(ours, library, 4) < 2e-4
        assert np.allclose(ours["sigma"][4:], library.sigma[4:], rtol=1e-4)


# ------------------------------------------------------------------------------ the command


def test_the_same_text_whatever_was_compiled_before() -> None:
    alone = [compiled(make(), "x", Options(gate=3.0, nis=True)).sources() for make in (rover, gps, spring)]
    for make in (tank, drone, rover):
        compiled(make(), "y")
    again = [compiled(make(), "x", Options(gate=3.0, nis=True)).sources() for make in (spring, gps, rover)]
    assert alone == again[::-1]


def test_the_same_input_gives_the_same_bytes(tmp_path: Path) -> None:
    path = saved(tmp_path / "m.toml", model_file.text_of(rover()))
    assert set(twice(tmp_path, path, "--robust", "gate=4", "--nis")) == {"cart.c", "cart.h", "cart_test.c", "cart_report.txt"}


REFUSED = [
    (lambda: tank().changed(R=0.0), Options(), "R: float has no noise.*resolution over 12"),
    (lambda: tank().changed(Q=[[1, 2], [2, 1]]), Options(), "Q: is no covariance.*semi-definite"),
    (lambda: tank().changed(P0=[[1, 2], [2, 1]]), Options(), "P0: is no covariance"),
    (lambda: rover().changed(R=[[1, 1], [1, 1]]), Options(), "R: is no covariance: it is not positive definite"),
    (lambda: tank().changed(R=1e-42), Options(), r"R\[0,0\]: 1e-42 is below what a float can hold; use other units, or --arith f64"),
    (lambda: tank().changed(P0=[1e39, 1]), Options(), r"P0\[0,0\]: 1e\+39 is above what a float can hold"),
    (tank, Options(gate=0.0), "--robust gate: 0 is not a positive number"),
    (tank, Options(student=-1.0), "--robust student: -1 is not a positive number"),
    (tank, Options(settle=0.0), "settle: 0 is not"),
    (tank, Options(gate=3.0, student=3.0), "gate and student: .*leave one of them out"),
]


@pytest.mark.parametrize("model, options, said", REFUSED)
def test_refused_by_name(model: Callable[[], Model], options: Options, said: str) -> None:
    with pytest.raises(KalmanqError, match=said):
        compiled(model(), "x", options)


def test_f64_takes_what_a_float_cannot_hold() -> None:
    assert compiled(tank().changed(R=1e-42), "x", Options("f64")).steady is not None


@pytest.mark.skipif(not shutil.which("avr-gcc"), reason="no compiler for AVR")
@pytest.mark.parametrize("arithmetic, said", [("f32", ""), ("f64", "use --arith f32")])
def test_an_int_of_16_bits_counts_as_far(arithmetic: str, said: str, tmp_path: Path) -> None:
    """76041 samples until it has settled; a double of 32 bits is refused."""
    written(tmp_path, compiled(tilt(), "flt", Options(arithmetic)).sources())
    done = subprocess.run(["avr-gcc", "-mmcu=atmega2560", "-Os", *STRICT, "-c", str(tmp_path / "flt.c"), "-o",
                           str(tmp_path / "flt.o")], capture_output=True, text=True)
    assert said in done.stderr if said else done.returncode == 0, done.stderr


@pytest.mark.skipif(not shutil.which("avr-gcc"), reason="no compiler for AVR")
def test_the_table_of_roots_stays_in_the_flash_of_an_avr(tmp_path: Path) -> None:
    """Of 2 kB of RAM it would take 384 bytes, as constants do there"""
    model = Model(1.0, H=1.0, R=4.0, Q=0.04, P0=100.0, states=[kalmanq.Quantity("level", range=1000)],
                  measurements=[kalmanq.Quantity("count", range=1000)])
    written(tmp_path, compiled(model, "flt", Options("q31")).sources())
    cc("avr-gcc", "-mmcu=atmega328p", "-Os", *STRICT, "-c", "flt.c", "-o", "flt.o", folder=tmp_path)
    sizes = subprocess.run(["avr-size", "-A", str(tmp_path / "flt.o")], check=True, capture_output=True, text=True).stdout
    of = {line.split()[0]: int(line.split()[1]) for line in sizes.splitlines() if line.startswith(".")}
    assert sum(size for name, size in of.items() if name.startswith((".rodata", ".data", ".bss"))) < 100
    assert sum(size for name, size in of.items() if name.startswith(".progmem")) == 4 * 96


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_sixteen_controls_have_names_of_their_own(arithmetic: str) -> None:
    """u12 is a control, and was an entry of U"""
    A = 0.9 * np.eye(3) + np.triu(np.full((3, 3), 0.05), 1)
    model = Model(A, H=[1, 0, 0], R=1.0, Q=0.1 * np.eye(3), B=0.1 * np.ones((3, 16)), P0=np.eye(3))
    z, u = np.random.default_rng(1).standard_normal((40, 1)), np.random.default_rng(2).standard_normal((40, 16))
    expected = kalmanq.Filter(model, "f64").run(z, u)
    with Host(compiled(model, "flt", Options(arithmetic))) as host:
        ran = host.run(z, np.vstack([np.zeros((1, 16)), u[:-1]]))
    assert np.abs((ran.mean - expected.mean) / expected.sigma).max() < (1e-5 if arithmetic == "f32" else 1e-9)


def test_sixteen_measurements_have_a_bit_each(tmp_path: Path) -> None:
    model = Model(0.9, H=np.ones((16, 1)), R=np.ones(16), Q=0.1, P0=1)
    accurate(model.changed(name="many"), "f32", 200, (1,), tmp_path)


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_a_model_without_any_noise_compiles(arithmetic: str, tmp_path: Path) -> None:
    for model in (Model([[1, 1], [0, 1]], H=[1, 0], R=1e-30, Q=[0, 0], P0=[0, 0]), Model(1, H=1, R=1e-30, Q=0, P0=0)):
        with Host(compiled(model, "filter", Options(arithmetic))) as host:
            ran = host.run(np.zeros((5, 1)))
        assert not np.any(ran.mean) and not np.any(ran.covariance)
