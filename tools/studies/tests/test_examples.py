"""The theory's examples: their numbers beside the textbook's, in each arithmetic; theory beside many drawn records."""

from __future__ import annotations

import ctypes
import json
import subprocess
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from command import kalmanq as command
from models import textbook
from scipy.stats import chi2
from whole import first

from kalmanq.run.simulation import simulate
from kalmanq_studies.lectures import EXAMPLES, numerics, smoothing
from kalmanq_studies.lectures.example import caption, covariances_apart

ARITHMETICS, SEEDS = ("f32", "f64", "q31"), (1, 2, 3)
DRAWN = first(3, [(arithmetic, seed) for seed in SEEDS for arithmetic in ARITHMETICS])
# A number in memory is so far, relative, from what is meant: half a unit in the last place of 24 or 53 bits.  A word of
# 31 bits holds 1.5 times what is reached and up to the next power of two: its unit is under 2^-29.4 of that, half of
# it 2^-30.
EPS = {"f32": 2.0**-24, "f64": 2.0**-53, "q31": 2.0**-30}
# What a few dozen such roundings may come to at these sizes: data, prior, root, and their products, one after the other
# in rows that forget.
ROUNDINGS = 16
PNG = b"\x89PNG\r\n\x1a\n"


def bound(arithmetic: str, largest: float, sigma: float = 1.0) -> float:
    """In sigma, of a mean whose numbers are as large as `largest`"""
    return ROUNDINGS * EPS[arithmetic] * max(1.0, largest / sigma)


def covariance_bound(arithmetic: str, largest: float, sigma: float) -> float:
    """In sigma_i sigma_j.  Fixed point has the root in words of states that are as large as `largest`."""
    return bound(arithmetic, largest if arithmetic == "q31" else sigma, sigma)


def result(name: str, arithmetic: str = "f64", seed: int = 1):
    return computed(name, arithmetic, seed)


@lru_cache(None)
def computed(*of: object):  # a default that is given is the same call
    name, *others = of
    return EXAMPLES[name].compute(*others)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_stationary_covariances(arithmetic):
    printed = {0.1: [[0.16433113, 0.06508848], [0.06508848, 0.16752408]],
               0.3: [[0.40329108, 0.1050718], [0.1050718, 0.41061709]],
               0.5: [[0.62286148, 0.12527948], [0.12527948, 0.63270989]]}
    made = result("stationary", arithmetic)
    for size, P in printed.items():
        digits = 5e-9 / np.min(np.diag(P))  # eight of them are printed
        most = covariance_bound(arithmetic, 8, P[0][0] ** 0.5)
        assert covariances_apart(made.course[size][-1], np.array(P)) < digits + most
        assert covariances_apart(made.limit[size], np.array(P)) < digits
        left = made.left(size)
        assert left[-1] < most < 1e-5 < left[3], left
        assert np.all(np.diff(left[:6]) < 0)


@lru_cache(None)
def textbook_of(rows: int):
    """What the textbook has of the smoothers' model: its covariances know no measurements"""
    return textbook(smoothing.model(), np.zeros((rows, 1)), None)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_smoothing_has_the_textbooks_covariances(arithmetic):
    """Lag, point, interval and horizon each beside a dense smoother of the rows that they are given"""
    made, model, rows = result("smoothing", arithmetic), smoothing.model(), smoothing.ROWS
    whole = textbook_of(rows)
    of_row = [textbook_of(end + 1)["smoothed_covariance"][smoothing.POINT] for end in range(smoothing.POINT, rows)]
    ahead, P = [], whole["covariance"][-1]
    for _ in range(smoothing.FAR):
        P = model.A @ P @ model.A.T + model.Q
        ahead.append(P)
    for of, exact in ((made.filtered, whole["covariance"]), (made.interval, whole["smoothed_covariance"]),
                      (made.lag, whole["smoothed_covariance"][::-1][: smoothing.FAR + 1]),
                      (made.point, np.array(of_row)), (made.horizon, np.array(ahead))):
        assert np.max(np.abs(of.sigma / np.sqrt(exact[:, 0, 0]) - 1)) < covariance_bound(arithmetic, 20, 1.2)


@pytest.mark.parametrize("arithmetic, seed", DRAWN)
def test_smoothing_errors_are_those_of_theory(arithmetic, seed):
    """The errors of the records are independent and normal: their squares are chi-square, estimate by estimate."""
    low, high = chi2.ppf([1e-7, 1 - 1e-7], smoothing.RUNS)
    made = result("smoothing", arithmetic, seed)
    for of in (made.lag, made.horizon, made.point, made.interval, made.filtered):
        score = smoothing.RUNS * of.mean_square / of.sigma**2
        assert np.all((low < score) & (score < high)), score / smoothing.RUNS
    # a filter's sigma is not that of a smoother
    assert np.any(smoothing.RUNS * made.interval.mean_square / made.filtered.sigma**2 < low)


def test_the_usual_filter_loses_what_kalmanq_keeps():
    """In the same numbers: more than a digit in float32, four in Q16.16"""
    for case in numerics.CASES:
        for arithmetic, better in (("f32", 30), ("q31", 1e4)):
            of = result("numerics", arithmetic)[case]
            assert better * of.error("mean").max() < of.error("usual").max(), (case, arithmetic)
            assert of.indefinite["mean"] == 0
        assert result("numerics")[case].error("usual").max() < 1e-9


def test_q16_is_the_filter_of_the_cost_tables(tmp_path):
    """tests/cost/q16_filter.c, word for word of the mean"""
    of = numerics.model("low noise")
    z = np.round(simulate(of, 50, 3)[1][:, 0] / numerics.GRID) * numerics.GRID
    cost = Path(__file__).parents[3] / "tests/cost"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", tmp_path / "q16.so", cost / "q16_filter.c"], check=True)
    library, words = ctypes.CDLL(str(tmp_path / "q16.so")), lambda a: [int(one) for one in np.ravel(np.round(np.asarray(a) / numerics.UNIT))]
    filter_, process, sensor = ((ctypes.c_int32 * 128)(*given) for given in (
        [3, *[0] * 9, *words(of.P0)], [3, *words(of.A), *[0] * 72, *words(of.Q)], [3, 1, *words(of.H), *[0] * 24, *words(of.R)]))
    for row, (x, _) in enumerate(numerics.q16_filter(of, z)):
        if row:
            library.q16_predict(filter_, process)
        library.q16_update(filter_, sensor, (ctypes.c_int32 * 1)(*words(z[row])))
        assert filter_[1:4] == words(x)


@pytest.mark.parametrize("name", EXAMPLES)
def test_arithmetics_agree(name):
    """Largest numbers in sigma: 8 / 0.4, 20 / 1.2, 1900 m / 14 mm"""
    largest = {"stationary": 20, "smoothing": 17, "numerics": 1.4e5}[name]
    for arithmetic in ("f32", "q31"):
        apart = EXAMPLES[name].distance(result(name, arithmetic), result(name))
        assert 0 < apart < bound(arithmetic, largest), (arithmetic, apart)


@pytest.mark.parametrize("name", EXAMPLES)
def test_figures(name, tmp_path):
    example, results = EXAMPLES[name], {arithmetic: result(name, arithmetic) for arithmetic in ARITHMETICS}
    assert caption(example, {"q31": results["q31"]}) == "drawn from q31"
    said = caption(example, results)
    assert said.startswith("drawn from f64; at most so far from it, in sigma: f32 ")
    figure = example.figure(results, said)
    figure.savefig(tmp_path / "figure.png")
    assert (tmp_path / "figure.png").read_bytes()[:8] == PNG
    assert any(text.get_text() == said for text in figure.texts)
    for axis in figure.axes:
        assert axis.get_ylabel() and (axis.get_xlabel() or axis.get_shared_x_axes().joined(axis, figure.axes[-1]))


# ------------------------------------------------------------------------------ the command


def kalmanq(*arguments):
    return command("examples", *arguments)


def test_the_command(tmp_path):
    listed = kalmanq()
    assert listed.returncode == 0 and all(name in listed.stdout for name in EXAMPLES)
    done = kalmanq("stationary", "--json", "--out", tmp_path / "way.png", "--seed", 7)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert set(said) == {"example", "seed", "f32", "f64", "q31"} and said["seed"] == 7
    assert np.allclose(said["f64"]["Q = 0.3 I: after 40 rows"], [[0.40329108, 0.1050718], [0.1050718, 0.41061709]], rtol=2e-8)
    assert (tmp_path / "way.png").read_bytes()[:8] == PNG
    one = kalmanq("stationary", "--arith", "q31")
    assert one.returncode == 0 and "drawn from q31" in one.stdout and "f64" not in one.stdout


@pytest.mark.parametrize("arguments, code, reason", [
    (["rocket"], 2, "rocket"), (["--out", "x.png"], 1, "of which example?"),
    (["smoothing", "--arith", "f16"], 2, "f16"), (["smoothing", "--out", "none/x.png"], 1, "there is no such folder")])
def test_wrong_input(arguments, code, reason, tmp_path):
    done = kalmanq(*arguments)
    assert done.returncode == code and reason in done.stderr and "Traceback" not in done.stderr
    if code == 1:
        assert done.stderr.count("\n") == 1
