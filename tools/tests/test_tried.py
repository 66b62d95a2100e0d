"""What kalmanq compile says of how it tried a nonlinear model: where rows go wrong, what float loses, and what was compared."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import costs, report
from kalmanq.compiler.report.equation_report import Findings, refuse_wrong
from kalmanq.compiler.run.lint import lossy_formulas
from kalmanq.compiler.text.equation_device_text import compiled_device
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.errors import KalmanqError
from kalmanq.nonlinear import NonlinearModel, read, simulate

PENDULUM = """
import math

states, measurements = ["angle", "rate", "length"], ["encoder"]
x0, P0, Q, R = [0.2, 0.0, 8.0], [0.01, 0.01, 4.0], [1e-9, 1e-5, 1e-6], 2.5e-5

def f(x):
    rate = x[1] - 0.2 / x[2] * math.sin(x[0])
    return [x[0] + 0.02 * rate, rate, x[2]]

def h(x):
    return x[0]
"""
RUNAWAY = """
states = {"names": ["calm", "hot"], "ranges": [RANGES]}
measurements, x0, P0, Q, R = ["z"], [0.5, 2.0], [0, 0], [0, 0], 1.0

def increment(x):
    return [0, x[1]**2]

def h(x):
    return x[1]
"""


def model_of(folder: Path, text: str) -> NonlinearModel:
    (folder / "model.py").write_text(text)
    return read(folder / "model.py")


@pytest.mark.parametrize("ranges, said", [("1, 10", "hot .*row 2, at 42: "),
                                          ("1, [-5, 5]", "hot .*row 1, at 6: "), ("[1, 2], 1e3", "calm .*row 0, at 0.5: ")])
def test_rows_that_go_wrong_are_told_from_where_they_left_the_ranges(ranges: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(KalmanqError, match=f"^row [0-9]+: .*{said}"):
        simulate(model_of(tmp_path, RUNAWAY.replace("RANGES", ranges)), 50, 1)


@pytest.mark.parametrize("length, sigma, is_lossy", [(8.0, 1.0, False), (-8.0, 1.0, False), (0.1, 0.05, True)])
def test_float_is_tried_near_0_only_where_a_row_comes_near(length: float, sigma: float, is_lossy: bool, tmp_path: Path) -> None:
    """The first row's sigma is three times what others have, its mean no nearer to 0 for that"""
    rows = 50
    x = np.column_stack([0.2 * np.sin(np.arange(rows)), 0.1 * np.cos(np.arange(rows)), np.full(rows, length)])
    sigmas = np.tile([0.01, 0.01, sigma], (rows, 1))
    x[0, 2], sigmas[0, 2] = 2 * length, 3 * sigma
    found = lossy_formulas(model_of(tmp_path, PENDULUM), [(x, sigmas, np.zeros((rows, 0)), None)])
    assert any("length = " in one.where and one.error > 0.05 for one in found) == is_lossy


@pytest.mark.parametrize("options", [Options("f64"), Options("f64", gate=3.0), Options("f64", student=5.0), Options("f32"), Options("f32", gate=3.0)])
def test_the_report_says_what_was_compared(options: Options, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After `Observed`, of each arithmetic and of a device"""
    monkeypatch.setattr(costs, "lines", lambda *_: [])
    model, found = model_of(tmp_path, PENDULUM), Findings(1e-5, 2e-5, 3e-13, np.nan, 0, ())
    is_compared = options.gate is None and options.student is None
    devices = [compiled_device(model, "own", options)] if is_compared else []
    for product in (compiled_equations(model, "own", options), *devices):
        said = report.lines(product, found)
        at = next(k for k, line in enumerate(said) if line.endswith("measurements missing:"))
        after = " ".join(said[at + 1 :])
        assert ("means within 1.0e-05 sigma, covariances within 2.0e-05" in after) == (options.arithmetic == "f32")
        assert ("within 3.0e-13 sigma of the library's filter" in after) == is_compared
        assert ("No other program" in after) == (not is_compared and options.arithmetic == "f64")


@pytest.mark.parametrize("old, new, said", [
    ("x0, P0, Q, R = [0.2, 0.0, 8.0]", "x0, P0, Q, R = [0.2]", "line 5: x0: has 1 number, and P0 3 variances: one for each state"),
    ("[0.01, 0.01, 4.0]", "'unknown'", "P0: has to be known"), ("[0.01, 0.01, 4.0]", "[0.01, 'unknown', 4.0]", "P0: has to be known"),
    ("8.0]", "float('inf')]", "x0: has an entry that is not finite: x0[2] is inf")])
def test_a_prior_that_does_not_fit(old: str, new: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(KalmanqError) as problem:
        model_of(tmp_path, PENDULUM.replace(old, new))
    assert said in str(problem.value)


@pytest.mark.parametrize("factor, is_refused", [(1.0, False), (2.0, True)])
def test_f_and_an_increment_that_contradict_each_other(factor: float, is_refused: bool, tmp_path: Path) -> None:
    both = f"def increment(x):\n    return [{factor} * (new - old) for new, old in zip(f(x), x)]\n"
    model = model_of(tmp_path, PENDULUM + both)
    if is_refused:
        with pytest.raises(KalmanqError, match="increment: .*correct"):
            refuse_wrong(model)
    else:
        refuse_wrong(model)
