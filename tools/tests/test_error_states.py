"""Models of error states: the C of kalmanq compile beside a filter of NumPy with Jacobians by differences."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command import kalmanq, refused, succeeds
from models import updated

import kalmanq as kalmanq_package
from kalmanq import KalmanqError
from kalmanq.compiler.run.equation_run import CompiledEquations
from kalmanq.nonlinear import NonlinearFilter, NonlinearModel, read, simulate

ATTITUDE = Path(__file__).parent / "equations" / "attitude.py"
RANGE_BEARING = Path(kalmanq_package.__file__).parent / "examples" / "range_bearing.py"
STEP = 1e-5


def by_errors(function, model: NonlinearModel, x: np.ndarray) -> np.ndarray:
    """Derivatives of function(plus(x, d)) where d = 0"""
    return np.column_stack([(function(model.plus(x, d)) - function(model.plus(x, -d))) / (2 * STEP)
                            for d in STEP * np.eye(model.n)])


def textbook(model: NonlinearModel, z: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nominal numbers and covariances after each row; the sensors one after the other"""
    x, P, means, covariances = np.array(model.x0), np.array(model.P0), [], []
    for t, row in enumerate(z):
        if t:
            moved = model.moved(x, t - 1, u[t - 1])
            A = by_errors(lambda at: model.minus(model.moved(at, t - 1, u[t - 1]), moved), model, x)
            x, P = moved, A @ P @ A.T + model.Q
        for sensor in model.sensors:
            some = slice(sensor.first, sensor.first + sensor.m)
            H = by_errors(lambda at: model.expected(at, t, u[t])[some], model, x)
            error, P, _ = updated(np.zeros(model.n), P, (row - model.expected(x, t, u[t]))[some], H, model.R[some, some])
            x = model.plus(x, error)
        means.append(x)
        covariances.append(P)
    return np.array(means), np.array(covariances)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_attitude_is_that_of_the_textbook(seed):
    model = read(ATTITUDE)
    _, z, u = simulate(model, 80, seed)
    z[np.random.default_rng(seed).random(len(z)) < 0.2, :3] = np.nan
    z[40:60, 3:] = np.nan
    means, covariances = textbook(model, z, u)
    sigma = np.sqrt(np.einsum("tii->ti", covariances))
    for arithmetic, most in (("f64", 1e-5), ("f32", 2e-3)):  # the textbook's differences are good to 1e-6
        with CompiledEquations(model, arithmetic) as made:
            run = made.run(z, u)
        errors = np.array([model.minus(*pair) for pair in zip(run.mean, means)])
        assert np.abs(errors / sigma).max() < most and np.abs(run.sigma / sigma - 1).max() < most
        assert run.event_names == []
        assert np.abs(np.sum(run.mean[:, :4] ** 2, axis=1) - 1).max() < (1e-14 if arithmetic == "f64" else 3e-7)


def test_its_errors_are_as_large_as_it_says():
    model = read(ATTITUDE)
    scores = []
    with CompiledEquations(model, "f32") as made:
        for seed in range(20):
            x, z, u = simulate(model, 100, seed)
            made.restart()
            run = made.run(z, u)
            error = model.minus(x[-1], run.mean[-1])
            scores.append(error @ np.linalg.solve(run.covariance[-1], error))
    assert 4.5 < np.mean(scores) < 7.7  # 6 of 120 draws, 99.9 %


def test_the_library_s_filter_says_who_runs_it():
    with pytest.raises(KalmanqError, match="--compiled"):
        NonlinearFilter(read(ATTITUDE))


def test_a_root_without_a_derivative_is_refused_with_the_cure(tmp_path):
    for name in ("attitude.py", "rotations.py"):
        text = (ATTITUDE.parent / name).read_text().replace("(np.cos(angle), np.sin(angle) / angle) if angle > 1e-5 else (1.0, 1.0)",
                                                            "np.cos(angle), (np.sin(angle) / angle if angle > 1e-5 else 1.0)")
        (tmp_path / name).write_text(text.replace("from rotations", "from turns"))
    (tmp_path / "rotations.py").rename(tmp_path / "turns.py")
    refused(kalmanq("compile", tmp_path / "attitude.py", "-o", tmp_path / "out.c"), "a root or a quotient of errors", tmp_path)


@pytest.mark.parametrize("model", [ATTITUDE, RANGE_BEARING])
def test_many_runs_are_as_good_as_they_say(model, tmp_path):
    done = kalmanq("simulate", model, "-n", 60, "--runs", 8, "--compiled", "--arith", "f32", "--out", tmp_path / "runs.csv", "--json")
    told = json.loads(done.stdout)
    assert done.returncode == 0 and told["way"] == "compiled" and 0.9 < told["nis"]["mean"] < 1.1
    assert told["runs_with_events"] == 0


def test_run_takes_it(tmp_path):
    data, out = tmp_path / "data.csv", tmp_path / "out.csv"
    for arguments in (["simulate", ATTITUDE, "-n", 50, "--truth", "--out", data], ["run", ATTITUDE, data, "--out", out]):
        succeeds(*arguments)
    assert "q_w_true" in data.read_text().splitlines()[0]
    head = out.read_text().splitlines()[0].split(",")
    assert {"q_w_mean", "b_z_mean", "roll_sigma", "m_z_innovation"} <= set(head) and "roll_mean" not in head
