"""kalmanq compile: what is proven is what runs; what is wrong is found; what cannot be done is refused by name."""

from __future__ import annotations

import decimal
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from command import kalmanq as kalmanq_command, twice
from compiled import Compiled, compiled, make
from compiled_models import five, kinematic, random_model
from typer.testing import CliRunner
from whole import WHOLE, first

import kalmanq
from kalmanq import Model, Quantity, command_line
from kalmanq.commands import compile as compile_command
from kalmanq.compiler import exact
from kalmanq.compiler.offers import cheaper
from kalmanq.compiler.product import compiled as factor
from kalmanq.compiler.proven import fixed, forms
from kalmanq.compiler.names import named
from kalmanq.compiler.proven.product import Maker, NotProven, Wanted, ram_of
from kalmanq.compiler.proven.proof_file import no_less
from kalmanq.compiler.proven.routines import QUOTIENT
from kalmanq.compiler.proven.search import Runner
from kalmanq.compiler.request import Options
from kalmanq.errors import KalmanqError
from kalmanq.model import model_file
from kalmanq.model import Gaps
from kalmanq.run.simulation import simulate

ARITHMETICS = ("f32", "q31")
SEEDS = (1, 2, 3)
SCORED = {"nis": True, "lag": 4}  # of the filter that several tests look at


def steered() -> Model:
    """Velocity fades, is pushed, and is measured with a part of the position"""
    return Model([[1, 0.1], [0, 0.9]], H=[[1, 0], [0.5, 2]], R=[0.04, 0.3], G=[0.01, 0.1], B=[0.005, 0.1], P0=[4, 1],
                 states=[Quantity("position", "m"), Quantity("velocity", "m/s")], gaps=Gaps(3, 60), x0=[1, -0.5],
                 measurements=[Quantity("range", "m", 60), Quantity("mixed", "", 60)],
                 controls=[Quantity("push", "", 5)], name="steered")


def record(model: Model, seed: int, rows: int = 400, gap: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """z and u with gaps of one length, far enough apart"""
    random = np.random.default_rng(seed)
    z = 5 * np.sin(0.05 * np.arange(rows)[:, None] + np.arange(model.m)) + random.standard_normal((rows, model.m)) * \
        np.sqrt(np.diag(model.R))
    for begin in range(7, rows - 80, 90) if gap else ():
        z[begin:begin + int(random.integers(1, gap + 1))] = np.nan
    u = np.sin(0.1 * np.arange(rows))[:, None] * random.uniform(0, 2, model.l)
    # on a grid that a float and a word of fixed point both have
    return np.round(z * 2**10) / 2**10, np.round(u * 2**10) / 2**10


def single(model: Model) -> Model:
    """With each number rounded to a float, as the C of f32 has them; a singular Q stays what it is"""
    def f(a: np.ndarray) -> np.ndarray:
        return a.astype(np.float32).astype(float)

    noise = {} if model.G is not None else {"Q": f(model.Q)}
    return model.changed(**noise, A=f(model.A), H=f(model.H), R=f(model.R), P0=f(model.P0), x0=f(model.x0),
                         B=None if model.B is None else f(model.B))


# ------------------------------------------------------------------------------ what is proven


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("which", range(3))
def test_ordinary_models_are_proven(which: int, arithmetic: str) -> None:
    product = compiled(five(ranged=True)[which], Wanted(arithmetic, "filter_x"))
    assert product.plan.form.name == "covariance" and not product.refused
    for found in product.proof.found.values():
        assert found.closed and found.bad == 0 and found.error < 1e-5 and found.pivot > 0.03
    assert product.proof.track.worst < 5e-6 and product.proof.track.covariance < 1e-5
    assert arithmetic == "f32" or product.proof.track.last < 2e-7
    assert ram_of(product.plan) <= {2: 28, 3: 48, 4: 72}[product.model.n] + 12


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("model", first(1, [steered, lambda: kinematic(2, 2, ranged=True), lambda: random_model(0, True)]))
def test_it_is_the_filter(model, arithmetic: str, tmp_path: Path) -> None:
    """Beside the package's own filter in double, which is another program"""
    model = model()
    made = Compiled(model, tmp_path, arithmetic)
    known = single(model) if arithmetic == "f32" else model
    for seed in SEEDS:
        z, u = record(model, seed, gap=model.gaps.max_gap)
        ours = made.run(z, u)
        double = kalmanq.Filter(known, "f64").run(z, u if model.l else None)
        assert not ours["refused"].any()
        # a reading is a word: rounded where the mean is not
        rounding = np.abs(double.mean).max(axis=0) * 2.0**-24 if arithmetic == "f32" else \
            2.0 ** -np.array(made.product.plan.subject.mean.readings, float)
        assert np.all(np.abs(ours["mean"] - double.mean) <= 2e-5 * double.sigma + rounding)
        assert np.allclose(ours["variance"], double.sigma**2, rtol=3e-5)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_nis_and_likelihood(arithmetic: str, tmp_path: Path) -> None:
    model = steered()
    made = Compiled(model, tmp_path, arithmetic, **SCORED)
    z, u = record(model, 1, gap=3)
    ours = made.run(z, u)
    double = kalmanq.Filter(single(model) if arithmetic == "f32" else model, "f64").run(z, u)
    there = ~np.isnan(z[:, 0])
    assert np.allclose(ours["nis"][there], double.nis[there], rtol=1e-4, atol=1e-4)
    if arithmetic == "f32":
        assert np.allclose(ours["likelihood"][there], double.log_likelihood[there], rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_the_mean_some_samples_ago(arithmetic: str, tmp_path: Path) -> None:
    model, lag = steered(), SCORED["lag"]
    made = Compiled(model, tmp_path, arithmetic, **SCORED)
    z, u = record(model, 1, gap=3)
    ours = made.run(z, u)["lagged"]
    double = kalmanq.LagSmoother(single(model) if arithmetic == "f32" else model, lag, "f64").run(z, u)
    known = np.isfinite(ours[:, 0])
    gaps = np.flatnonzero(np.isnan(z[:, 0]))
    assert 150 < known.sum() and not known[:made.product.plan.rows].any()
    assert not any(known[gap:gap + made.product.plan.rows + lag - 1].any() for gap in gaps)
    assert np.abs(ours[known] - double.lagged[known]).max() < 3e-6
    assert np.abs(ours[known] - double.mean[known]).max() > 0.01


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_samples_in_part(arithmetic: str, tmp_path: Path) -> None:
    model = kinematic(2, 2, ranged=True, gaps=Gaps(2, 40))
    made = Compiled(model, tmp_path, arithmetic, partial=True)
    whole = compiled(model, Wanted(arithmetic, "filter_x"))
    assert made.product.proof.worst.count > whole.proof.worst.count
    assert made.program().stdout.endswith("OK\n")
    z, _ = record(model, 2)
    z[5, 0] = z[60, 1] = z[61, 0] = z[120, 0] = np.nan
    z[121] = np.nan
    ours = made.run(z)
    double = kalmanq.Filter(single(model) if arithmetic == "f32" else model, "f64").run(z)
    assert not ours["refused"].any()
    assert np.abs((ours["mean"] - double.mean) / double.sigma).max() < 1e-4
    assert np.allclose(ours["variance"], double.sigma**2, rtol=3e-5)
    z[130, 0] = np.nan  # too soon after the last gap
    told = made.run(z)
    assert not told["refused"][129].any() and list(told["refused"][130]) == [0, 1]  # not taken; a gap by the next predict
    assert told["refused"][131, 0] == 1


@pytest.mark.parametrize("gaps", (Gaps(), Gaps(2, 5)))
def test_a_lag_of_constant_gain_waits_until_the_start_is_forgotten(gaps: Gaps, tmp_path: Path) -> None:
    model, lag = steered().changed(gaps=gaps, P0=[400, 100]), 4
    made = Compiled(model, tmp_path, "f32", form="gain", lag=lag)
    forgets = made.product.plan.forgets
    z, u = record(model, 1)
    if gaps.max_gap:
        z[200:202] = np.nan
    ours = made.run(z, u)["lagged"]
    double = kalmanq.LagSmoother(single(model), lag, "f64").run(z, u)
    known = np.isfinite(ours[:, 0])
    assert np.abs(ours[known] - double.lagged[known]).max() < 1e-5
    assert np.argmax(known) == forgets + lag - 1 and known.sum() > 100
    if gaps.max_gap:
        assert known[199] and not known[200:202 + forgets + lag - 1].any() and known[202 + forgets + lag - 1]
    assert f"given {forgets + lag} samples in a row" in (tmp_path / "filter_x.h").read_text()


# ------------------------------------------------------------------------------ ranges of fixed point


def pattern(random: np.random.Generator, model: Model, rows: int, run: int, in_part: bool) -> np.ndarray:
    """Which components are measured, rows x m: gaps as declared, the first of them at any row but the first"""
    masks = [mask for mask in product((False, True), repeat=model.m) if not any(mask) or in_part and not all(mask)]
    measured, begin = np.ones((rows, model.m), bool), 1 + int(random.integers(12))
    while begin + model.gaps.max_gap < rows:
        length = int(random.integers(1, model.gaps.max_gap + 1))
        measured[begin:begin + length] = [masks[k] for k in random.integers(len(masks), size=length)]
        begin += length + run + int(random.integers(3)) * int(random.integers(4))
    return measured


def responses(model: Model, measured: np.ndarray, settles: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How means answer to each measurement, rows x n x inputs, and innovations, rows x m x inputs (those of a
    settled row all at once); which rows are settled.  The start is 0."""
    A, H, R, n, m = model.A, model.H, np.diag(model.R), model.n, model.m
    P, X, run = model.P0, np.zeros((n, len(measured) * m)), 0
    means, innovations, settled = [], [], []
    for row, there in enumerate(measured):
        if row:
            P, X = A @ P @ A.T + model.Q, A @ X
        at_once = H @ X
        settled.append(bool(there.all()) and run >= settles - 1)
        Y = np.zeros((m, X.shape[1]))
        for j in np.flatnonzero(there):
            own = np.eye(X.shape[1])[row * m + j]
            Y[j] = own - (at_once[j] if settled[-1] else H[j] @ X)
            k = P @ H[j] / (H[j] @ P @ H[j] + R[j])
            X, P = X + np.outer(k, own - H[j] @ X), P - np.outer(k, H[j] @ P)
        run = run + 1 if there.all() else 0
        means.append(X)
        innovations.append(Y)
    return np.array(means), np.array(innovations), np.array(settled)


@pytest.mark.parametrize("in_part", (False, True))
def test_no_input_goes_beyond_the_proven_ranges(in_part: bool, tmp_path: Path) -> None:
    """Of gaps as declared, drawn at random, the worst input is known exactly: the signs of the responses.  The bounds
    hold, are not twice what is reached, and the filter comes through without an overflow."""
    model = kinematic(2, 2, ranged=True, gaps=Gaps(3, 40))
    made = Compiled(model, tmp_path, "q31", partial=in_part)
    plan, near = made.product.plan, []
    bounds, formats = made.product.proof.means, plan.subject.words.formats
    for seed in SEEDS:
        measured = pattern(np.random.default_rng(seed), model, 150, model.gaps.min_run, in_part)
        means, innovations, settled = responses(model, measured, plan.rows)
        x, y = 64 * np.abs(means).sum(axis=2), 64 * np.abs(innovations).sum(axis=2)
        assert np.all(x <= bounds.x) and np.all(y[~settled] <= bounds.y) and np.all(y[settled] <= bounds.settled)
        near.append([(x / bounds.x).max(), (y[~settled] / bounds.y).max(), (y[settled] / bounds.settled).max()])
        row, state = np.unravel_index(np.argmax(x / bounds.x), x.shape)
        z = np.where(measured, 64 * np.sign(means[row, state]).reshape(measured.shape), np.nan)
        ours, double = made.run(z), kalmanq.Filter(model, "f64").run(z)
        assert not ours["refused"].any() and np.abs((ours["mean"] - double.mean) / double.sigma).max() < 1e-4
    # where a gap begins means are taken as a box
    assert np.all(np.array(near) > (0.5, 0.5, 0.95))
    assert all(2.0 ** (30 - fine) <= most < 2.0 ** (31 - fine) for fine, most in zip(formats.settled, bounds.settled))


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_constant_gain(arithmetic: str, tmp_path: Path) -> None:
    model = steered().changed(gaps=Gaps())
    made = Compiled(model, tmp_path, arithmetic, form="gain")
    z, u = record(model, 1)
    ours = made.run(z, u)
    steady = kalmanq.SteadyFilter(model, "f64").run(z, u)
    assert np.abs(ours["mean"] - steady.mean).max() < 1e-4
    begun, gaps = made.product.proof.losses
    assert begun > 1.001 and gaps == 1.0
    assert made.program().stdout.endswith("OK\n")


def test_dense_models_of_three_axes_are_one() -> None:
    """Three axes alike share one covariance, whatever their noises have to do with each other's."""
    alike = kinematic(3, 3, mixing=np.eye(3), variances=(1.0, 1.0, 1.0))
    plan = compiled(alike, Wanted("f32", "filter_x")).plan
    assert len(plan.structure.carried) == 6 and plan.subject.of.n == 9
    apart = compiled(kinematic(2, 2, mixing=np.eye(2)), Wanted("f32", "filter_x")).plan
    assert len(apart.structure.carried) == 6


# ------------------------------------------------------------------------------ what is wrong is found


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_program_that_goes_wrong_says_so(arithmetic: str, tmp_path: Path) -> None:
    made = Compiled(kinematic(1, 2, ranged=True), tmp_path, arithmetic)
    done = made.program()
    assert done.returncode == 0 and done.stdout.endswith("OK\n")
    text = (tmp_path / "filter_x.c").read_text()
    gain = {"f32": "0.56865925f * y_range", "q31": "product(76324155, y_range)"}[arithmetic]
    assert gain in text
    worse = {"f32": "0.56875925f * y_range", "q31": "product(76324165, y_range)"}[arithmetic]
    (tmp_path / "filter_x.c").write_text(text.replace(gain, worse))
    done = made.program()
    assert done.returncode == 1 and "OK" not in done.stdout


def maker(model: Model, arithmetic: str = "f32") -> Maker:
    return Maker(model, Wanted(arithmetic, "filter_x"))


def test_the_search_finds_wrong_constants() -> None:
    with decimal.localcontext(exact.DIGITS):
        one = maker(kinematic(1, 2))
        plan = one.plan(forms.Covariance(), one.subject)
        one._judge(one._run(plan)[0], "")
        settled = replace(plan.settled, filtered=plan.settled.filtered * decimal.Decimal("1.0001"))
        with pytest.raises(NotProven, match="sigma_i sigma_j from the exact one"):
            one._judge(one._run(replace(plan, settled=settled))[0], "")


def test_the_search_finds_what_is_indefinite_and_takes_the_next_form() -> None:
    sharp = kinematic(1, 2).changed(R=0.01, P0=[100, 100])
    product = compiled(sharp, Wanted("f32", "filter_x"))
    assert product.plan.form.name == "square root"
    assert [one.form for one in product.refused] == ["covariance", "plain covariance"]
    sharper = sharp.changed(R=1e-9, P0=[1e6, 1e6])
    with pytest.raises(KalmanqError, match="plain covariance: .* not positive definite.*square root: a covariance is"):
        compiled(sharper, Wanted("f32", "filter_x"))


def test_the_search_counts_on() -> None:
    """It does not say that it has closed where it was stopped."""
    with decimal.localcontext(exact.DIGITS):
        one = maker(kinematic(1, 2))
        with Runner(one.plan(forms.Covariance(), one.subject)) as runner:
            few, all_ = runner.search(100), runner.search(10_000)
    assert not few.closed and few.count == 100 and all_.closed and all_.count < 10_000


def test_the_quotient_without_a_division_is_the_quotient(tmp_path: Path) -> None:
    """For each number that it can be asked for; both round down, so that all cores have the same words."""
    (tmp_path / "q.c").write_text("#include <stdint.h>\n" + QUOTIENT + """
int main(void)
{
    for (uint32_t d = UINT32_C(1) << 15; d < UINT32_C(1) << 16; d++) {
        if (quotient(d) != UINT32_C(0xffffffff) / d) return 1;
    }
    return 0;
}
""")
    make(tmp_path, ["q.c"], "q", "-D__AVR__", "-fsanitize=undefined", "-fno-sanitize-recover")
    assert subprocess.run([str(tmp_path / "q")]).returncode == 0


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_where_states_are_large_a_mean_of_floats_keeps_to_its_bound(seed: int, tmp_path: Path) -> None:
    """Beside the model with its own numbers, which no float has; a damped record says nothing of it."""
    model = Model([[1, 0.1], [0, 1]], H=[1.2521, -0.549], R=0.0018, Q=[0.37, 0.29], P0=[1, 1],
                  states=[Quantity("position", "", 1e6), Quantity("velocity", "", 1e4)])
    made = Compiled(model, tmp_path, "f32")
    random, x = np.random.default_rng(seed), np.array([8e5, -7e3])
    z = np.zeros((600, 1))
    for t in range(len(z)):
        x = model.A @ x + np.sqrt(np.diag(model.Q)) * random.standard_normal(2)
        z[t] = np.float32(model.H @ x + np.sqrt(0.0018) * random.standard_normal())
    double = kalmanq.Filter(model, "f64").run(z)
    reading = np.abs(double.mean) * 2.0**-24
    error = np.max(np.maximum(np.abs(made.run(z)["mean"] - double.mean) - reading, 0)[300:] / double.sigma[300:])
    proof = made.product.proof
    assert 10 * proof.track.worst < error < proof.rounding
    assert "more than 1e-03: smaller ranges, or q31" in (tmp_path / "filter_x_proof.txt").read_text()


@pytest.mark.parametrize("model", first(1, (kinematic(1, 3), kinematic(1, 3, dt=2.0), kinematic(3, 3))))
def test_the_larger_error_of_a_mean_is_said_first(model: Model, tmp_path: Path) -> None:
    """Of a record that is not damped, where it is so: as large as in other records of the model"""
    model = model.changed(gaps=Gaps())
    made, seen = Compiled(model, tmp_path, "f32"), []
    for seed in SEEDS:
        _, z = simulate(single(model), 2000, seed)
        z = z.astype(np.float32).astype(float)
        double = kalmanq.Filter(single(model), "f64").run(z)
        error = np.abs(made.run(z)["mean"] - double.mean) - np.abs(double.mean) * 2.0**-24
        seen.append(np.max(error / double.sigma))
    proof = made.product.proof
    assert proof.wandering.worst > 10 * proof.track.worst and max(seen) / 5 < proof.wandering.worst < max(seen) * 5
    assert proof.mean is proof.wandering
    for file, pattern in (("filter_x_proof.txt", r"^means +(\S+) sigma"), ("filter_x.c", r"^ \* Means: (\S+) sigma")):
        figures = [float(one) for one in re.findall(pattern, (tmp_path / file).read_text(), re.M)]
        assert len(figures) == 2 and figures[0] == float(f"{proof.wandering.worst:.1e}") > figures[1]


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_where_innovations_are_large_a_mean_keeps_to_its_bound(arithmetic: str, tmp_path: Path) -> None:
    """At the ends of all ranges: coefficients and gains are words, and a covariance that has not settled is not quite
    the exact one.  The record that is drawn shows neither."""
    model = steered().changed(gaps=Gaps())
    made = Compiled(model, tmp_path, arithmetic)
    proof, plan = made.product.proof, made.product.plan
    assert proof.ends is not None
    worst, settled = [], []
    for seed in SEEDS:
        z, u = at_the_ends(model, seed)
        ours, double = made.run(z, u), kalmanq.Filter(model, "f64").run(z, u)
        assert not ours["refused"].any()
        reading = np.abs(double.mean) * 2.0**-24 if arithmetic == "f32" else \
            2.0 ** -np.array(plan.subject.mean.readings, float)
        error = np.maximum(np.abs(ours["mean"] - double.mean) - reading, 0) / double.sigma
        worst.append(error[:300].max())
        settled.append(error[300:].max())
    assert 5 * proof.track.last < max(settled) < proof.rounding
    assert max(worst) > 10 * proof.track.worst and proof.ends.worst > max(worst) / 3
    text = (tmp_path / "filter_x_proof.txt").read_text()
    assert {"f32": "a float has 24 bits ", "q31": "words of coefficients "}[arithmetic] in text
    assert re.search(r"at the ends of ranges +means .*; more than 1e-03: smaller ranges", text) or arithmetic == "f32"


def test_the_ends_of_ranges_are_no_step_beyond_them() -> None:
    model = changed(R=1.0, measurements=[Quantity("range", "m", 60.5, fraction=0)])
    ends = compiled(model, Wanted("q31", "filter_x")).proof.ends
    assert ends is not None and not ends.refused and ends.worst < 1e-3


def at_the_ends(model: Model, seed: int, rows: int = 900) -> tuple[np.ndarray, np.ndarray]:
    """z and u"""
    random = np.random.default_rng(seed)
    return tuple(np.cumprod(np.where(random.random((rows, len(which))) < 0.25, -1.0, 1.0), axis=0) *
                 [one.range for one in which] for which in (model.measurements, model.controls))


def test_coefficients_of_a_mean_are_what_is_multiplied_by() -> None:
    """Whole numbers, shifts, and parts of 32 bits"""
    for c, taken in ((3, 3), (-0.25, -0.25), (2.0**-31, 2.0**-31), (1 + 2.0**-32, 1 + 2.0**-32),
                     (1.3, round(1.3 * 2**32) / 2**32), (-0.7, round(-0.7 * 2**32) / 2**32)):
        assert float(fixed.held(decimal.Decimal(c))) == taken


def test_a_range_below_the_noise_is_told(tmp_path: Path) -> None:
    """Each sample is as good as missing then."""
    Compiled(changed(measurements=[Quantity("range", "m", 0.01)]), tmp_path, "f32")
    for file in ("filter_x.c", "filter_x_proof.txt"):
        assert "range of range: 0.01 is less than 3 sigma of its innovation" in (tmp_path / file).read_text()
    Compiled(changed(), tmp_path, "f32")
    assert "of its innovation" not in (tmp_path / "filter_x_proof.txt").read_text()


def test_no_range_is_told_of_what_the_search_does_not_give(tmp_path: Path) -> None:
    """It measures nothing, so that NIS is 0 in it."""
    Compiled(steered(), tmp_path, "q31", **SCORED)
    text = (tmp_path / "filter_x.c").read_text()
    assert "n_range = " in text and ", 0 to 0 */" not in text and " to " in text


def test_a_promise_is_not_rounded_down() -> None:
    assert [no_less(one) for one in (8.5e-7, 8.501e-7, 9.99e-5)] == ["8.6e-07", "8.6e-07", "1.0e-04"]


# ------------------------------------------------------------------------------ at run time


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_beyond_the_declared_the_mean_goes_on_and_the_covariance_stays(arithmetic: str, tmp_path: Path) -> None:
    made = Compiled(kinematic(1, 2, ranged=True), tmp_path, arithmetic)
    model, plan = made.model, made.product.plan
    z, _ = record(model, 1, 120)
    for begin, count, refused in ((60, 8, 0), (60, 10, 1), (3, 8, 0), (3, 10, 1)):
        holed = z.copy()
        holed[begin:begin + count] = np.nan
        ours = made.run(holed)
        assert ours["refused"][-1, 0] == refused and np.all(ours["variance"] > 0)
        if refused:
            assert np.allclose(ours["mean"][begin + 9], model.A @ ours["mean"][begin + 8], rtol=1e-5)
            assert np.all(ours["variance"][begin + 9] == ours["variance"][begin + 8])
            assert list(ours["refused"][begin:begin + 10, 0]) == [0] * 9 + [1]
            double = kalmanq.Filter(model, "f64").run(holed)
            assert np.all(ours["variance"][begin + 10] < ours["variance"][begin + 9])  # measurements bring it back
            assert np.abs((ours["mean"] - double.mean) / double.sigma)[-20:].max() < 1e-3
            assert np.allclose(ours["variance"][begin + 10 + plan.rows:], double.sigma[-1]**2, rtol=3e-5)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_too_soon_after_a_gap_sigma_is_the_largest_of_those_declared(arithmetic: str, tmp_path: Path) -> None:
    made = Compiled(kinematic(1, 2, ranged=True), tmp_path, arithmetic)
    model, plan = made.model, made.product.plan
    early, _ = record(model, 1, 140)
    early[60:62] = early[70:75] = np.nan  # before the covariance has settled again
    ours, P = made.run(early), model.P0
    for _ in range(model.gaps.max_gap):
        P = model.A @ P @ model.A.T + model.Q
    assert list(ours["refused"][69:72, 0]) == [0, 0, 1]  # a missing row is known by the next predict
    assert np.allclose(ours["variance"][71:75], np.diag(P), rtol=1e-6) and np.all(np.diag(P) > ours["variance"][:71])
    double = kalmanq.Filter(model, "f64").run(early)
    assert np.all(ours["variance"][70:] > 0.99999 * double.sigma[70:]**2)
    assert np.abs((ours["mean"] - double.mean) / double.sigma)[-20:].max() < 1e-3
    assert np.allclose(ours["variance"][75 + plan.rows:], double.sigma[-1]**2, rtol=3e-5)


ANY_CALLS = """
#include <stdlib.h>
#include "filter_x.h"
int main(void)
{
    static filter_x_filter f;
    int least = 0, wrong = 0;
    srand(1);
    filter_x_start(&f);
    for (long t = 0; t < 400000; t++) {
        if (t % 500 == 0) least = 1 + rand() % 30;
        const int end = rand() % 3 - 1;
        int32_t z[1] = {end * RANGE}, u[1] = {(rand() % 3 - 1) * PUSH};
        const int kind = rand() % least;
        if (kind == 0) filter_x_predict(&f, u);
        else if (kind == 1) wrong += filter_x_update(&f, z) > 1;
        else filter_x_step(&f, u, z);
        const double variance = (double)filter_x_variance_velocity(&f), mean = (double)filter_x_mean_velocity(&f);
        wrong += !(variance >= LEAST && variance <= MOST && mean <= REACH && mean >= -REACH);
    }
    return wrong != 0 || !(f.events & FILTER_X_MEAN_SATURATED) || !(f.events & FILTER_X_SIGMA_SATURATED);
}
"""


@pytest.mark.parametrize("gaps", (Gaps(), Gaps(3, 60)))
def test_any_calls_stay_within_the_words_that_were_proven(gaps: Gaps, tmp_path: Path) -> None:
    """Measurements and controls at the ends of their ranges, gaps of any length at any time"""
    model = steered()
    model = model.changed(H=[1, 0], R=0.04, measurements=model.measurements[:1], gaps=gaps, A=[[1, 0.1], [0, 1]])
    made = Compiled(model, tmp_path, "q31")
    plan = made.product.plan
    variance = 2.0 ** plan.subject.words.covariance(1, 1)
    least, most = float(plan.settled.filtered[1, 1]), max(float(plan.cap[1, 1]), 1.0)
    assert plan.stays[1] < plan.bounds[1]
    given = {"RANGE": plan.doors[0], "PUSH": plan.stops[0], "LEAST": f"{0.999 * least * variance}",
             "MOST": f"{1.05 * most * variance}",
             "REACH": f"{plan.bounds[1] * 2.0 ** plan.fraction('states', 1)}"}
    (tmp_path / "main.c").write_text("".join(f"#define {name} {value}\n" for name, value in given.items()) + ANY_CALLS)
    make(tmp_path, ["filter_x.c", "main.c"], "main", "-fsanitize=undefined", "-fno-sanitize-recover", "-lm")
    done = subprocess.run([str(tmp_path / "main")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def first_beyond(measured: np.ndarray, gaps: Gaps, min_run: int) -> int:
    """The row at which a gap is told to be too long, or too soon: a missing row is known by the next predict"""
    missed, run = 0, min_run
    for row, there in enumerate(measured):
        if there.all():
            missed, run = 0, run + 1 if run < min_run else run
            continue
        missed += 1
        if missed > gaps.max_gap or missed == 1 and run < min_run:
            return row if there.any() else row + 1
        if missed:
            run = 0
    return len(measured)


GUARDED = [("f32", 1, Gaps(2, 12), {}), ("q31", 2, Gaps(2, 40), {"partial": True}), ("f32", 1, Gaps(), {}),
           ("q31", 1, Gaps(1, 19), {"form": "gain"})]


@pytest.mark.parametrize("arithmetic, axes, gaps, options", first(2, GUARDED))
def test_what_is_refused_is_what_was_not_proven(arithmetic: str, axes: int, gaps: Gaps, options: dict,
                                                tmp_path: Path) -> None:
    """Of records with gaps at random: not a row sooner, not a row later"""
    made = Compiled(kinematic(axes, 2, ranged=True, gaps=gaps), tmp_path, arithmetic, **options)
    random, ends, rows = np.random.default_rng(1), [], 120
    for _ in range(300):
        z = np.zeros((rows, axes))
        for begin in np.flatnonzero(random.random(rows) < random.choice([0.02, 0.05, 0.2])):
            length = int(random.integers(1, gaps.max_gap + 2))
            whole = not options.get("partial") or random.random() < 0.5
            z[begin:begin + length] = np.nan if whole else \
                np.where(random.random((len(z[begin:begin + length]), axes)) < 0.5, np.nan, 0.0)
        end = first_beyond(~np.isnan(z), gaps, made.product.plan.min_run)
        refused = made.run(z)["refused"].any(axis=1)
        assert np.array_equal(refused, np.arange(rows) >= end)
        ends.append(end)
    assert min(ends) < 10 and len(set(ends)) > 30


@pytest.mark.parametrize("model", first(1, (kinematic(1, 2, ranged=True), random_model(2, True),
                                            kinematic(1, 3, ranged=True), kinematic(2, 2, ranged=True))))
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_without_min_run_it_is_what_the_covariance_takes_to_settle(arithmetic: str, model: Model,
                                                                   tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(re.sub(r"\[gaps\][^[]*", "", model_file.text_of(model)) + "\n[gaps]\nmax_gap = 3\n")
    alone = model_file.read(path)
    assert alone.gaps == Gaps(3) and model_file.text_of(alone).count("min_run") == 0
    plan = compiled(alone, Wanted(arithmetic, "filter_x")).plan
    assert plan.min_run == plan.rows > 1
    said = compiled(model.changed(gaps=Gaps(3, plan.rows)), Wanted(arithmetic, "filter_x")).plan
    assert (said.min_run, said.rows) == (plan.min_run, plan.rows)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_the_door(arithmetic: str, tmp_path: Path) -> None:
    """What is outside its range is as good as missing."""
    made = Compiled(kinematic(1, 2, ranged=True), tmp_path, arithmetic)
    z, _ = record(made.model, 1, 120)
    missing, outside = z.copy(), z.copy()
    missing[70], outside[70] = np.nan, 65.0
    told, ours = made.run(missing), made.run(outside)
    assert np.array_equal(ours["mean"], told["mean"]) and np.array_equal(ours["variance"], told["variance"])
    assert ours["refused"][69, 1] == 0 and ours["refused"][70, 1] == 1 and told["refused"][-1, 1] == 0
    if arithmetic == "f32":
        assert np.array_equal(made.run(missing, missed_by_predict=False)["mean"], told["mean"])  # NaN


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_control_beyond_its_range_is_taken_as_the_end_of_it(arithmetic: str, tmp_path: Path) -> None:
    made = Compiled(steered(), tmp_path, arithmetic)
    point = 2.0 ** made.product.plan.fraction("controls", 0) if arithmetic == "q31" else 1
    lines = [f"filter_x_start(&{f}); filter_x_update(&{f}, z);" for f in "fg"]
    beyond = [(5.5, 5), (-5.5, -5), (7.9, 5), (-7.9, -5)]
    beyond += [] if arithmetic == "q31" else [("NAN", 0), ("INFINITY", 5)]
    for given, taken in beyond:
        word = given if isinstance(given, str) else f"({made.product.plan.subject.words.type})({given * point})"
        lines += [f"u[0] = {word}; v[0] = {int(taken * point)};",
                  "filter_x_step(&f, u, z); filter_x_step(&g, v, z); filter_x_predict(&f, u); filter_x_predict(&g, v);",
                  "wrong += f.events != FILTER_X_CONTROL_REFUSED || g.events; f.events = 0;",
                  "wrong += memcmp(&f, &g, sizeof f) != 0; filter_x_update(&f, z); filter_x_update(&g, z);"]
    (tmp_path / "main.c").write_text("\n".join([
        "#include <math.h>", "#include <string.h>", '#include "filter_x.h"', "int main(void)", "{",
        f"    {made.product.plan.subject.words.type} u[1], v[1], z[2] = {{0}};", "    filter_x_filter f, g;",
        "    int wrong = 0;", "    memset(&f, 0, sizeof f), memset(&g, 0, sizeof g);", *lines, "    return wrong;", "}",
        ""]))
    make(tmp_path, ["filter_x.c", "main.c"], "main", "-fsanitize=undefined", "-fno-sanitize-recover", "-lm")
    assert subprocess.run([str(tmp_path / "main")]).returncode == 0


TWICE = """
#include <stdlib.h>
#include <string.h>
#include "filter_x.h"
int main(int count, char **words)
{
    WORD z[M], again[M];
    filter_x_filter once, twice;
    int wrong = count != 2;
    srand((unsigned)atoi(words[1]));
    memset(&once, 0, sizeof once), memset(&twice, 0, sizeof twice);
    filter_x_start(&once), filter_x_start(&twice);
    for (int t = 0; t < 400; t++) {
        const int is_missing = t % 100 == 40, present = PARTS && t % 100 == 90 ? 1 : (1 << M) - 1;
        for (int j = 0; j < M; j++) z[j] = (WORD)(rand() % 60), again[j] = (WORD)(rand() % 60);
        if (t) filter_x_predict(&once), filter_x_predict(&twice);
        if (is_missing) continue;
        UPDATE(&once, z, present), UPDATE(&twice, z, present);
        if (rand() % 4) continue;
        AGAIN(&twice, again, 1u << rand() % 3);
        wrong += twice.events != FILTER_X_REFUSED;
        twice.events = 0;
        wrong += memcmp(&once, &twice, sizeof once) != 0;
    }
    return wrong || once.events;
}
"""


@pytest.mark.parametrize("options", first(1, ({}, {"form": "gain"}, {"partial": True})))
@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_a_second_update_is_refused(arithmetic: str, options: dict, tmp_path: Path) -> None:
    """Without a predict between: nothing changes but the event, however many samples there were"""
    model, some = kinematic(2, 2, ranged=True, gaps=Gaps(2, 40)), bool(options.get("partial"))
    word = Compiled(model, tmp_path, arithmetic, **options).product.plan.subject.words.type
    (tmp_path / "main.c").write_text("\n".join([
        f"#define WORD {word}", f"#define M {model.m}", f"#define PARTS {int(some)}",
        "#define UPDATE(f, z, present) filter_x_update_some(f, z, (unsigned)(present))" if some else
        "#define UPDATE(f, z, present) ((void)(present), filter_x_update(f, z))",
        "#define AGAIN(f, z, present) ((present) > M ? filter_x_update(f, z) : UPDATE(f, z, present))", TWICE]))
    make(tmp_path, ["filter_x.c", "main.c"], "main", "-fsanitize=undefined", "-fno-sanitize-recover", "-lm")
    for seed in SEEDS:
        done = subprocess.run([str(tmp_path / "main"), str(seed)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("options", ({}, {"form": "gain"}, {"partial": True}))
@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_what_is_no_number_is_as_good_as_missing(seed: int, options: dict, tmp_path: Path) -> None:
    """Floats without declared ranges: NaN, infinity, and what would soon become either"""
    model = kinematic(2, 2, gaps=Gaps(2, 40))
    made = Compiled(model, tmp_path, "f32", **options)
    z, _ = record(model, seed, 300)
    holed, bad, random = z.copy(), z.copy(), np.random.default_rng(seed)
    for row, number in zip(range(45, 300, 50), (np.nan, np.inf, -np.inf, 3e38, -3e38)):
        component = int(random.integers(model.m))
        bad[row, component] = number
        holed[row, component if options.get("partial") else slice(None)] = np.nan
    told = made.run(holed)
    ours = made.run(bad, missed_by_predict=False)
    assert np.array_equal(ours["mean"], told["mean"]) and np.array_equal(ours["variance"], told["variance"])
    assert np.array_equal(ours["refused"][:, 1], np.arange(300) >= 45) and not ours["refused"][:, 0].any()
    assert not told["refused"].any()


def test_a_control_that_is_no_number_is_none(tmp_path: Path) -> None:
    """Floats without declared ranges: in step and in predict, before and after the covariance has settled"""
    model = steered()
    model = model.changed(measurements=[one.name for one in model.measurements], controls=["push"])
    made = Compiled(model, tmp_path, "f32")
    for rows in (3, 300):
        for row, number in enumerate((np.nan, np.inf, -np.inf, 3e38)):
            z, u = record(model, row, rows + 20)
            u[rows], none = number, u.copy()
            none[rows] = 0
            ours, told = made.run(z, u), made.run(z, none)
            assert np.array_equal(ours["mean"], told["mean"]) and np.all(np.isfinite(ours["mean"]))
            z[rows + 1] = np.nan
            assert np.array_equal(made.run(z, u)["mean"], made.run(z, none)["mean"])
    assert "A control beyond 1e18, or NaN, is" in (tmp_path / "filter_x.h").read_text()


@pytest.mark.skipif(not shutil.which("g++"), reason="no C++ compiler")
@pytest.mark.parametrize("arithmetic", first(1, ARITHMETICS))
def test_cpp_takes_the_header(arithmetic: str, tmp_path: Path) -> None:
    Compiled(steered(), tmp_path, arithmetic, **SCORED)
    (tmp_path / "main.cpp").write_text('#include "filter_x.h"\nint main()\n{\n    filter_x_filter f;\n'
                                       "    filter_x_start(&f);\n    return f.events;\n}\n")
    make(tmp_path, ["filter_x.c"], "x.o", "-c")
    done = subprocess.run(["g++", "-Wall", "-Wextra", "-Wpedantic", "-Werror", str(tmp_path / "main.cpp"),
                           str(tmp_path / "x.o"), "-lm", "-o", str(tmp_path / "main")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert subprocess.run([str(tmp_path / "main")]).returncode == 0


@pytest.mark.parametrize("name", ["z range", "u push", "s range", "nis", "variance velocity"])
def test_names_that_would_be_one_in_the_header(name: str) -> None:
    """A fraction of a state and that of a measurement, a control, a variance or NIS"""
    model = steered()
    states = [replace(model.states[0], name=name), model.states[1]]
    assert named(states, model.measurements, model.controls) == (["s0", "s1"], ["range", "mixed"], ["push"])
    assert named(model.states, model.measurements, model.controls)[0] == ["position", "velocity"]


def test_a_component_beyond_its_range_is_as_good_as_missing(tmp_path: Path) -> None:
    """In one call as in two: of a sample that is there as a whole the other components are taken."""
    made = Compiled(kinematic(2, 2, ranged=True, gaps=Gaps(2, 40)), tmp_path, "f32", partial=True)
    z, _ = record(made.model, 1, 120)
    missing, outside = z.copy(), z.copy()
    missing[70, 0], outside[70, 0] = np.nan, 65.0
    told, ours = made.run(missing), made.run(outside)
    assert np.array_equal(ours["mean"], told["mean"]) and np.array_equal(ours["variance"], told["variance"])
    assert ours["refused"][70, 1] == 1 and told["refused"][-1, 1] == 0


# ------------------------------------------------------------------------------ what is refused


def changed(**what: object) -> Model:
    return kinematic(1, 2, ranged=True).changed(**what)


REFUSED = [
    ("f32", lambda: changed(P0=None, unknown="all"), "nothing is known of position"),
    ("f32", lambda: changed(R=0.0), "range has no noise"),
    ("f32", lambda: kinematic(2, 2).changed(R=[[1, 0.5], [0.5, 1]]), "correlated"),
    ("f32", lambda: changed(H=[0, 1]), "not observable.*measure it or leave it out"),
    ("f32", lambda: changed(Q=[0.0, 0.0]), "not stabilisable.*give it noise"),
    ("f32", lambda: changed(Q=[[1, 2], [2, 1]]), "Q: is no covariance"),
    ("f32", lambda: changed(R=1e-42), "float cannot hold"),
    pytest.param("f32", lambda: changed(gaps=Gaps(8, 3)), "more than .* covariances.*min_run = 19", marks=WHOLE),
    ("f32", lambda: changed(gaps=Gaps(251, 300)), "max_gap"),
    ("q31", lambda: changed(gaps=Gaps(8, 5)), "min_run = 19"),
    ("q31", lambda: changed(Q=[1e-9, 1e-9]), "more than 200 rows to settle: leave out --form, or take f32"),
    ("q31", lambda: changed(measurements=["range"]), "range has no range"),
    ("q31", lambda: changed(A=[[1.5, 0.5], [0, 1.5]], gaps=Gaps(60, 400)), "max_gap|bound|range"),
    ("q31", lambda: changed(R=1e-9, P0=[1e6, 1e6]), "R of range.*better known"),
    ("q31", lambda: changed(measurements=[Quantity("range", "m", 64, fraction=29)]), "does not fit Q2.29"),
]


@pytest.mark.parametrize("arithmetic, model, said", REFUSED)
def test_refused_by_name(arithmetic: str, model, said: str) -> None:
    with pytest.raises(KalmanqError, match=said):
        compiled(model(), Wanted(arithmetic, "filter_x"))


PARTS_REFUSED = [("q31", "covariance", 8, "9841 gaps of any components of 2 over 8 rows.*a smaller max_gap"),
                 ("q31", "gain", 2, "leave out --form gain"), ("f32", "gain", 2, "leave out --form gain")]


@pytest.mark.parametrize("arithmetic, form, gap, said", PARTS_REFUSED)
def test_samples_in_part_are_refused_by_name(arithmetic: str, form: str, gap: int, said: str) -> None:
    with pytest.raises(KalmanqError, match=said):
        compiled(kinematic(2, 2, ranged=True, gaps=Gaps(gap, 60)), Wanted(arithmetic, "filter_x", form, partial=True))


def test_samples_in_part_are_part_of_a_gap() -> None:
    with pytest.raises(KalmanqError, match="--partial: .* max_gap"):
        compiled(kinematic(2, 2, gaps=Gaps()), Wanted("f32", "filter_x", partial=True))


@pytest.mark.parametrize("model, bound, cure", [(lambda: changed(R=1e-12), 1.0, "--form factor"),
                                                (changed, 1e-9, "a larger --bound")])
def test_what_is_named_cures(model, bound: float, cure: str) -> None:
    """A larger --bound does nothing for a mean, which has a bound of its own."""
    with decimal.localcontext(exact.DIGITS), pytest.raises(NotProven) as problem:
        Maker(model(), Wanted("f32", "filter_x", bound=bound)).proven(forms.Covariance())
    assert problem.value.cures[-1] == cure and ("a larger --bound" in problem.value.cures) == (bound < 1)


# ------------------------------------------------------------------------------ the command


@pytest.mark.parametrize("arithmetic", first(1, ARITHMETICS))
def test_the_same_input_gives_the_same_bytes(arithmetic: str, tmp_path: Path) -> None:
    path = tmp_path / "steered.toml"
    path.write_text(model_file.text_of(steered()))
    assert set(twice(tmp_path, path, "--arith", arithmetic, "--form", "covariance")) == {"cart.c", "cart.h", "cart_test.c", "cart_proof.txt"}


def test_the_command_refuses_in_one_line_and_leaves_no_file(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(model_file.text_of(changed(H=[0, 1])))
    for words, said in (((path, "-o", tmp_path / "cart.c", "--form", "covariance"), "not observable"),
                        ((path, "-o", tmp_path / "Cart.c"), "-o"),
                        ((path, "-o", tmp_path / "math.c"), "math is a word or a header of C"),
                        ((tmp_path / "no.toml", "-o", tmp_path / "cart.c"), "no such file")):
        done = kalmanq_command("compile", *words)
        assert done.returncode == 1 and said in done.stderr and done.stderr.count("\n") == 1 and not done.stdout
    assert [one.name for one in tmp_path.iterdir()] == ["m.toml"]


@pytest.mark.skipif(os.name != "posix", reason="no signals")
@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_no_folder(number: int, code: int, tmp_path: Path) -> None:
    path, folders = tmp_path / "m.toml", tmp_path / "folders"
    path.write_text(model_file.text_of(kinematic(3, 3)))
    folders.mkdir()
    running = subprocess.Popen([sys.executable, "-m", "kalmanq.command_line", "compile", str(path), "-o",
                                str(tmp_path / "cart.c"), "--form", "covariance"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env={**os.environ, "TMPDIR": str(folders)})
    while running.poll() is None and not list(folders.glob("kalmanq-compile-*")):
        time.sleep(0.01)
    running.send_signal(number)
    _, said = running.communicate()
    assert running.returncode == code and said == "kalmanq: interrupted\n"
    assert not list(folders.glob("kalmanq-compile-*")) and not list(tmp_path.glob("*cart*"))


@pytest.mark.parametrize("words, module", [(["kalmanq"], "typer"), (["kalmanq", "steady", "m.toml"], "numpy")])
def test_an_interrupt_while_the_command_is_imported_is_no_traceback(words: list[str], module: str) -> None:
    program = f"""
import sys
sys.argv = {words}

class Interrupted:
    def find_spec(self, name, *_):
        if name == {module!r}:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupted())
from kalmanq.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 130 and done.stderr == "kalmanq: interrupted\n"


@pytest.mark.skipif(os.name != "posix", reason="no limits")
@pytest.mark.parametrize("command, named", [
    (["simulate", "MODEL", "-n", "5000", "--out", "out.csv"], "out.csv"),
    (["examples", "stationary", "--out", "out.png"], "out.png"),
    (["design", "MODEL", "--core", "m4f", "-o", "."], ".h"),
    (["compile", "MODEL", "-o", "out.c"], "kalmanq-compile-")])
def test_a_file_that_does_not_fit_is_named(command: list[str], named: str, tmp_path: Path) -> None:
    """By a limit of a file's size, which is to a program what a full disk is"""
    states = [Quantity("position", "m", 100), Quantity("velocity", "m/s", 10)]
    (tmp_path / "m.toml").write_text(model_file.text_of(changed(states=states)))
    words = ["kalmanq", *(one.replace("MODEL", "m.toml") for one in command)]
    program = f"""
import resource, sys
from kalmanq.command_line import main
from kalmanq.commands import COMMANDS
import importlib; importlib.import_module(COMMANDS[{command[0]!r}][0])
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
sys.argv = {words}
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path,
                          env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert re.fullmatch(rf"kalmanq: .*{re.escape(named)}.*: File too large\n", done.stderr), done.stderr
    assert [one.name for one in tmp_path.iterdir()] == ["m.toml"]


# ------------------------------------------------------------------------------ a hint at it


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_compile_names_the_covariance_form_where_it_is_cheaper(arithmetic: str, tmp_path: Path,
                                                               monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compile_command, "SECONDS", 60)
    path = tmp_path / "m.toml"
    path.write_text(model_file.text_of(kinematic(2, 2, ranged=True, gaps=Gaps(3, 40))))
    words = ["compile", str(path), "-o", str(tmp_path / "flt.c"), "--arith", arithmetic]
    said = CliRunner().invoke(command_line.app, words).output
    hint = re.search(r"--form covariance takes (\d+) in the place of (\d+) instructions a row that has not settled .*gaps of "
                     "at most 3 samples with 40 full ones between them, and none in part; no\\s+flt_start_at",
                     " ".join(said.split()))
    assert hint and int(hint[1]) < 0.85 * int(hint[2])
    files = {one.name: one.read_bytes() for one in tmp_path.glob("flt*")}
    told = json.loads(CliRunner().invoke(command_line.app, [*words, "--form", "factor", "--json"]).output)
    assert told["hint"] is None and told["form"] == "factor"
    assert files == {one.name: one.read_bytes() for one in tmp_path.glob("flt*")}  # the same with and without it


def test_there_is_no_hint_where_it_does_not_close_or_saves_nothing() -> None:
    several = kinematic(2, 2, ranged=True, gaps=Gaps(8, 3))
    for model, arithmetic in ((several, "f32"), (several, "q31"), (kinematic(1, 2, ranged=True), "f32")):
        assert cheaper(factor(model, "flt", Options(arithmetic))) is None
    assert cheaper(factor(kinematic(2, 2, ranged=True), "flt", Options("f32", nis=True))) is None


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no alarm")
def test_a_hint_is_searched_for_two_seconds_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compile_command, "SECONDS", 0.2)
    product, began = factor(kinematic(3, 3, ranged=True), "flt", Options("q31")), time.monotonic()
    assert compile_command._in_time(lambda: cheaper(product)) is None
    assert time.monotonic() - began < 2 and signal.getitimer(signal.ITIMER_REAL)[0] == 0
    assert compile_command._in_time(lambda: "found") == "found"
