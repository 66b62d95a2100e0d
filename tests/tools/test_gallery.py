"""The gallery: what is fitted is the optimum, what is written reads back; H that changes at each row.

gallery.sh has every log-likelihood beside statsmodels'.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from functools import lru_cache

import numpy as np
import pytest
from command import kalmanq as command
from models import pair, textbook

from kalmanq import Filter, KalmanqError, Model, Quantity, Smoother, Varying
from kalmanq.commands.messages import console
from kalmanq.data import tables
from kalmanq.model import model_file
from kalmanq_studies.commands.gallery import Options, show
from kalmanq_studies.gallery import ENTRIES, sources
from kalmanq_studies.gallery.fitted import fit, log_likelihood

PNG = b"\x89PNG\r\n\x1a\n"
RECORDED = [name for name, entry in ENTRIES.items() if entry.data().regressors is None]


@lru_cache(None)
def fitted(name):
    return fit(ENTRIES[name], name)


@pytest.mark.parametrize("name", ENTRIES)
def test_no_parameter_leads_uphill(name):
    """Moved by 2 % of its size, either way; and where fitting began was lower"""
    entry, made, data = ENTRIES[name], fitted(name), ENTRIES[name].data()
    assert made.converged and made.log_likelihood > log_likelihood(entry.model(), data) + 0.1
    for parameter in entry.free:
        value = np.array(made.parameters[parameter], float)
        for k in np.ndindex(value.shape):
            for factor in (0.98, 1.02):
                moved = value.copy()
                moved[k] *= factor
                if entry.Q_form == "multiple" and parameter == "density":
                    moved = value * factor
                changed = entry.model({**made.parameters, parameter: moved.tolist()})
                assert log_likelihood(changed, data) < made.log_likelihood + 1e-4, (parameter, k, factor)


@pytest.mark.parametrize("name", [name for name in RECORDED if not ENTRIES[name].is_unknown])
def test_the_likelihood_is_the_textbooks(name):
    made, data = fitted(name), ENTRIES[name].data()
    exact = np.sum(textbook_terms(made.model, data.z))
    assert abs(made.log_likelihood - exact) < 1e-9 * abs(exact)


def textbook_terms(model, z, H=None):
    """Of each row, of a start that is known; H: T x m x n"""
    x, P, terms = model.x0, model.P0, []
    for t, row in enumerate(z):
        if t:
            x, P = model.A @ x, model.A @ P @ model.A.T + model.Q
        there = ~np.isnan(row)
        h, term = (model.H if H is None else H[t])[there], 0.0
        if there.any():
            S, e = h @ P @ h.T + model.R[np.ix_(there, there)], row[there] - h @ x
            K = np.linalg.solve(S, h @ P).T
            x, P = x + K @ e, P - K @ S @ K.T
            term = -0.5 * (np.linalg.slogdet(2 * np.pi * S)[1] + e @ np.linalg.solve(S, e))
        terms.append(term)
    return np.array(terms)


@pytest.mark.parametrize("name", ["season", "ar-noise", "ma", "constant-velocity", "constant-acceleration"])
def test_drawn_data_are_more_likely_where_they_are_fitted_than_by_their_truth(name):
    """By half of chi-square with a degree of freedom a parameter: 12 is beyond 1e-3 of 6 of them"""
    entry = ENTRIES[name]
    truth = {key: value for key, value in entry.data.keywords.items() if key in entry.free}
    assert set(truth) == set(entry.free)
    gain = fitted(name).log_likelihood - log_likelihood(entry.model({**entry.start, **truth}), entry.data())
    assert 0 <= gain < 12


@pytest.mark.parametrize("name", RECORDED)
def test_files_read_back(name, tmp_path, capsys):
    show(Options(name, tmp_path, True), console())
    said = json.loads(capsys.readouterr().out)
    stems = [f"{name}{end}" for end in (".toml", "_fitted.toml", ".csv", "_smoothed.csv", ".png")]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(stems)
    assert sorted(said["files"]) == sorted(str(tmp_path / stem) for stem in stems)
    assert (tmp_path / f"{name}.png").read_bytes()[:8] == PNG
    model = model_file.read(tmp_path / f"{name}_fitted.toml")
    z, _ = tables.measurements_and_controls(tmp_path / f"{name}.csv", model)
    run = Smoother(model).run(z)
    assert np.sum(run.log_likelihood) == pytest.approx(said["log_likelihood"], rel=1e-12)
    with open(tmp_path / f"{name}_smoothed.csv", newline="") as text:
        rows = list(csv.DictReader(text))
    first = model.states[0].name
    assert [float(row[f"{first}_smoothed"]) for row in rows] == run.smoothed[:, 0].tolist()
    assert model_file.read(tmp_path / f"{name}.toml").n == model.n
    # in fixed point by the ranges that are in the file, and in floats: a row's term rests on an innovation, which is
    # the difference of numbers as large as z
    for arithmetic, eps in (("q31", 2.0**-30), ("f32", 2.0**-24)):
        other = Filter(model, arithmetic).run(z)
        assert not other.events
        most = 32 * eps * np.nanmax(np.abs(z)) / np.nanmin(run.innovation_sigma)
        error = other.log_likelihood - run.log_likelihood
        known = int(np.argmax(np.all(np.isfinite(run.mean), axis=1)))  # q31 counts in ranges before: their sum is right
        assert abs(np.mean(error[:known + 1])) < most, arithmetic
        assert np.max(np.abs(error[known + 1:])) < most, arithmetic
        assert arithmetic == "q31" or np.max(np.abs(error)) < most, arithmetic


def test_files_of_a_regression(tmp_path):
    done = kalmanq("regression-drifting", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"regression-drifting{end}" for end in (".csv", ".png", "_smoothed.csv")]


@pytest.mark.parametrize("path", [sources.NILE, *sorted(sources.HERE.glob("*.csv"))], ids=lambda path: path.name)
def test_public_data_name_their_source_and_terms(path):
    said = sources.source_of(path)
    assert "Source: " in said and "public domain" in said.lower()


# ------------------------------------------------------------------------------ H that changes


def regression(unknown: bool = False) -> Model:
    return Model(np.eye(2), [1, 1], 0.25, [0.01, 0.0025], x0=None if unknown else [1, 2],
                 P0=None if unknown else [4, 1], states=[Quantity("a", "", 16), Quantity("b", "", 16)],
                 measurements=[Quantity("z", "", 64)], name="regression")


def regressors(seed: int, rows: int = 80):
    draw = np.random.default_rng(seed)
    H = np.column_stack([np.ones(rows), draw.normal(0, 2, rows)])
    x = np.array([1.5, 1.0]) + np.cumsum(draw.normal(size=(rows, 2)) * [0.1, 0.05], axis=0)
    z = np.sum(H * x, axis=1) + draw.normal(0, 0.5, rows)
    z[[5, 6, 40]] = np.nan
    return z[:, None], H[:, None, :]


@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-12), ("f32", 1e-5), ("q31", 1e-6)])
def test_varying_beside_the_dense_solution(arithmetic, most):
    """All states of all rows at once, by the normal equations"""
    for seed in (1, 2, 3):
        model, (z, H) = regression(), regressors(seed)
        run = Smoother(model, arithmetic).run(z, varying=Varying(H=H))
        mean, sigma = dense(model, z, H)
        assert np.max(np.abs(run.smoothed - mean) / sigma) < most
        assert np.max(np.abs(run.smoothed_sigma / sigma - 1)) < most
        assert np.max(np.abs(run.log_likelihood - textbook_terms(model, z, H))) < 100 * most
        assert np.array_equal(run.mean[-1], run.smoothed[-1]) and len(run.innovation) == len(z)


def dense(model, z, H):
    T, n = len(z), model.n
    information, right = np.zeros((T * n, T * n)), np.zeros(T * n)
    W = np.linalg.inv(model.Q)
    information[:n, :n] += np.linalg.inv(model.P0)
    right[:n] += np.linalg.solve(model.P0, model.x0)
    for t in range(T):
        here = slice(t * n, t * n + n)
        if t:
            D = np.hstack([-model.A, np.eye(n)])
            both = slice(t * n - n, t * n + n)
            information[both, both] += D.T @ W @ D
        if not np.isnan(z[t, 0]):
            information[here, here] += np.outer(H[t, 0], H[t, 0]) / model.R[0, 0]
            right[here] += H[t, 0] * z[t, 0] / model.R[0, 0]
    covariance = np.linalg.inv(information)
    return (covariance @ right).reshape(T, n), np.sqrt(np.diag(covariance)).reshape(T, n)


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_varying_by_the_same_H_is_the_smoother(arithmetic):
    model = pair()
    z = np.random.default_rng(4).normal(size=(30, 2))
    z[3, 1] = z[8] = np.nan
    plain = Smoother(model, arithmetic).run(z, covariance=True)
    run = Smoother(model, arithmetic).run(z, varying=Varying(H=np.tile(model.H, (30, 1, 1))), covariance=True)
    for name in ("mean", "sigma", "innovation", "nis", "log_likelihood", "smoothed", "smoothed_sigma",
                 "smoothed_covariance"):
        assert np.array_equal(getattr(plain, name), getattr(run, name), equal_nan=True), name
    alone = Filter(model, arithmetic).run(z, varying=Varying(H=np.tile(model.H, (30, 1, 1))))
    assert alone.smoothed is None and np.array_equal(alone.mean, plain.mean)
    assert not np.allclose(textbook(model, z, None)["smoothed"][0], plain.mean[0])


def test_varying_from_an_unknown_start_is_least_squares():
    """Constant coefficients: each row's smoothed state is the solution of all rows"""
    z, H = regressors(7)
    there = ~np.isnan(z[:, 0])
    model = regression(unknown=True).changed(Q=np.zeros((2, 2)))
    run = Smoother(model).run(z, varying=Varying(H=H))
    exact = np.linalg.lstsq(H[there, 0], z[there, 0], rcond=None)[0]
    assert np.allclose(run.smoothed, exact, rtol=0, atol=1e-12)
    spread = np.sqrt(np.diag(np.linalg.inv(H[there, 0].T @ H[there, 0])) * 0.25)
    assert np.allclose(run.smoothed_sigma, spread, rtol=1e-11)


@pytest.mark.parametrize("H, reason", [
    (np.ones((80, 1, 3)), "H is 80 x 1 x 3, not 80 x 1 x 2"), (np.ones((79, 2)), "H is 79 x 2, not 80 x 1 x 2"),
    (np.full((80, 2), np.nan), "row 0: H has an entry that is not finite")])
def test_varying_refuses(H, reason):
    with pytest.raises(KalmanqError, match=reason):
        Smoother(regression()).run(regressors(1)[0], varying=Varying(H=H))


def test_varying_names_the_row():
    z, H = regressors(1)
    z[17] = 70
    with pytest.raises(KalmanqError, match="row 17: z = 70: measurements: beyond the declared range"):
        Smoother(regression(), "q31").run(z, varying=Varying(H=H))


# ------------------------------------------------------------------------------ the command


def kalmanq(*arguments):
    return command("gallery", *arguments)


def test_without_the_studies_the_command_says_how_to_have_them():
    program = ("import sys; sys.modules['kalmanq_studies'] = None\n"
               "from kalmanq.__main__ import main\nsys.argv = ['kalmanq', 'gallery', 'level']\nmain()")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 1 and done.stdout == "" and done.stderr.count("\n") == 1
    assert done.stderr.startswith("kalmanq: gallery is one of the studies") and "pip install" in done.stderr


def test_the_command():
    assert len(ENTRIES) >= 12
    listed = kalmanq("--json")
    assert listed.returncode == 0 and list(json.loads(listed.stdout)) == list(ENTRIES)
    done = kalmanq("level")
    assert done.returncode == 0 and "1469.18" in done.stdout and "log-likelihood -633.46" in done.stdout


@pytest.mark.parametrize("arguments, code, reason", [
    (["levels"], 2, "levels"), (["--out", "."], 1, "of which model?"),
    (["level", "--out", "none"], 1, "no such folder")])
def test_wrong_input(arguments, code, reason):
    done = kalmanq(*arguments)
    assert done.returncode == code and reason in done.stderr and "Traceback" not in done.stderr
    if code == 1:
        assert done.stderr.count("\n") == 1
