"""Fits of nonlinear models: the likelihood beside the library's filter, its exact slopes beside differences, constants and noises
that come back with errors as large as their standard errors say, the fitted file, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq as command, succeeds
from library import saved
from scipy.stats import chi2

import kalmanq
from kalmanq.data.written import writing
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.expectation import Records
from kalmanq.fitting.problem import Problem
from kalmanq.nonlinear import NonlinearModel, read, simulate
from kalmanq.nonlinear.constants import Numbers, written

FITTED = Path(__file__).parent / "fitted"
NAMES = ("cell", "rover", "gyro")


def drawn(name: str, rows: int, seed: int) -> tuple[NonlinearModel, np.ndarray, np.ndarray]:
    """With gaps in every measurement"""
    model = read(FITTED / f"{name}.py")
    _, z, u = simulate(model, rows, seed)
    z[np.random.default_rng(seed).random(z.shape) < 0.1] = np.nan
    return model, z, u


def problem_of(model: NonlinearModel, z: list, u: list, free: tuple[str, ...]) -> Problem:
    return Problem(model, Records(model, z, u), Choice(model, free, "full", "full", None))


@pytest.mark.parametrize("name,more", [("cell", ()), ("cell", ("x0", "P0")), ("rover", ("Q",)), ("gyro", ("R", "P0"))])
@pytest.mark.parametrize("seed", range(2))
def test_slopes(name, more, seed):
    """Of two records, beside central differences"""
    model, z, u = drawn(name, 80, seed)
    _, z2, u2 = drawn(name, 50, seed + 100)
    e = problem_of(model, [z, z2], [u, u2], (*model.free, *more)).expectation
    e.run()
    assert e.log_likelihood == pytest.approx(kalmanq.likelihood(model, [z, z2], [u, u2]), rel=1e-10)
    for key, slopes in ((key, slopes.copy()) for key, slopes in e.gradient().items()):
        array = e.arrays[key]
        size = 1e-4 * (np.sqrt(np.outer(np.diag(array), np.diag(array))) if array.ndim == 2 else np.maximum(np.abs(array), 1e-2))
        for at in np.ndindex(array.shape):
            step = np.zeros(array.shape)
            step[at] = step[at[::-1]] = size[at]
            values = []
            for share, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
                array += share * step
                e.run()
                values.append(weight * e.log_likelihood)
                array -= share * step
            found, wanted = np.sum(slopes * step), sum(values) / 12
            assert found == pytest.approx(wanted, rel=2e-6, abs=1e-6), (key, at)


def constants_of(path: Path) -> dict[str, float]:
    """What is free in a file, by label"""
    model = read(path)
    return problem_of(model, [np.zeros((2, model.m))], [np.zeros((2, model.l))], model.free).choice.equations.traced.values


def begun(name: str, seed: int, folder: Path) -> Path:
    """The file with other constants: each by some 20 %"""
    source, draw = (FITTED / f"{name}.py").read_text(), np.random.default_rng(seed)
    space: dict = {}
    exec(source, space)
    free = {key: np.array(space[key]) for key in read(FITTED / f"{name}.py").free}
    path = saved(folder / f"{name}.py", written(source, {key: one * np.exp(draw.normal(scale=0.2, size=one.shape)) for key, one in free.items()}))
    return path


@pytest.mark.parametrize("name", NAMES)
def test_constants_come_back(name, tmp_path):
    """The likelihood at what is found is higher than at the truth, by a chi-square of as many degrees as are free"""
    truth, above = read(FITTED / f"{name}.py"), []
    for seed in range(3):
        _, z, u = simulate(truth, 300, 40 + seed)
        found = kalmanq.fit(read(begun(name, seed, tmp_path)), [z], truth.free, u=[u])
        assert found.converged, found.message
        assert found.log_likelihood == pytest.approx(kalmanq.likelihood(found.model, [z], [u]), rel=1e-10)
        above.append(2 * (found.log_likelihood - kalmanq.likelihood(truth, [z], [u])))
    count = len(constants_of(FITTED / f"{name}.py"))
    assert all(one > 0 for one in above)
    assert chi2.sf(np.sum(above), 3 * count) > 1e-3


def test_standard_errors():
    """Of a scale and a drift: as the curvature of the library filter's likelihood says"""
    model, z, u = drawn("rover", 200, 5)
    found = kalmanq.fit(model, [z], ["SCALE", "DRIFT"], u=[u])
    keys, J = ["SCALE", "DRIFT"], np.zeros((2, 2))
    for i, j in np.ndindex(2, 2):
        for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            at = dict(found.model.constants)
            for key, sign in ((keys[i], a), (keys[j], b)):
                at[key] += sign * 0.2 * found.standard_errors[key][0]
            J[i, j] -= a * b * kalmanq.likelihood(read(model.path, Numbers(keys, at)), [z], [u])
    errors = np.array([found.standard_errors[key][0] for key in keys])
    assert np.sqrt(np.diag(np.linalg.inv(J / np.outer(errors, errors) / 0.16))) == pytest.approx(errors, rel=1e-3)


def log(tmp_path: Path, name: str) -> Path:
    model, path = read(FITTED / f"{name}.py"), tmp_path / "log.csv"
    _, z, u = simulate(model, 300, 7)
    with writing(path, [one.name for one in (*model.measurements, *model.controls)]) as write:
        write([*z.T, *u.T])
    return path


def test_file(tmp_path):
    """What is written is the file, with other numbers of what was free; a constant that is made of them follows"""
    path, out = begun("cell", 3, tmp_path), tmp_path / "fitted.py"
    done = succeeds("fit", path, log(tmp_path, "cell"), "--json", "--out", out)
    said, again = json.loads(done.stdout), constants_of(out)
    assert list(again) == ["CAPACITY", "TAU", "R1", "R0", "SIGMA", "NOISE"] and again == {key: said[key][0] for key in again}
    before, after = path.read_text().splitlines(), out.read_text().splitlines()
    assert [a == b for a, b in zip(before, after)].count(False) == 4 and len(before) == len(after)
    assert "SIGMA: float = " in out.read_text() and "# s, A s" in out.read_text()
    assert read(out).Q[1, 1] == again["SIGMA"] ** 2


def test_file_of_covariances(tmp_path):
    path, out = begun("gyro", 3, tmp_path), tmp_path / "fitted.py"
    said = json_of("fit", path, log(tmp_path, "gyro"), "--out", out, "--free", "GAIN,R", "--r-form", "diagonal")
    assert np.allclose(read(out).R, said["R"], 1e-12, 0) and f"GAIN, WALK = {said['GAIN'][0]!r}, " in out.read_text()


def test_starts():
    """x0 and P0 of twelve records, and a constant"""
    model = read(FITTED / "cell.py")
    z, u = zip(*(simulate(model, 100, seed)[1:] for seed in range(12)))
    found = kalmanq.fit(model, z, ["x0", "P0", "R0"], u=u)
    assert found.converged, found.message
    assert found.value("x0") == pytest.approx(model.x0, abs=4 * np.max(found.standard_errors["x0"]))
    assert found.log_likelihood > kalmanq.likelihood(model, z, u)
    assert found.log_likelihood == pytest.approx(kalmanq.likelihood(found.model, z, u), rel=1e-10)


def test_nothing_there():
    model, z, u = drawn("cell", 20, 1)
    for given, said in ((None, "^u .*current"), ([np.full_like(u, np.nan)], "current: .*missing")):
        with pytest.raises(kalmanq.KalmanqError, match=said):
            kalmanq.fit(model, [z], model.free, u=given)
    assert kalmanq.fit(model, [np.full_like(z, np.nan)], model.free, u=[u]).message == "there is no data: every measurement is missing"


@pytest.mark.parametrize("name, free, said", [
    ("rover", ["R"], "^R .*sensors .*constant"),
    ("gyro", ["x0"], "^x0 .*nominal")])
def test_refused_as_a_whole(name, free, said):
    model, z, u = drawn(name, 20, 1)
    with pytest.raises(kalmanq.KalmanqError, match=said):
        kalmanq.fit(model, [z], free, u=[u])


def test_q_of_a_g_is_refused():
    model, z, u = drawn("cell", 20, 1)
    with pytest.raises(kalmanq.KalmanqError, match="^Q .*G .*constant"):
        kalmanq.fit(model.changed(G=np.diag([1e-5, 2e-3])), [z], ["Q"], u=[u])


REFUSED = {  # what is changed in cell.py, options, what is said
    "no constant": ("", ["--free", "MASS"], "cell.py: MASS: is free, but is no constant of the file: write NAME = number"),
    "twice": ("R0 = 0.04\n", ["--free", "R0"], "R0: is free, but is assigned in lines 9, 13: assign it once"),
    "text": ("LABEL = 'a'\n", ["--free", "LABEL"], "line 13: LABEL: is free, but is str, not a number or an array of numbers"),
    "matrix": ("M = np.eye(2)\n", ["--free", "M"], "line 13: M: is free, but is a matrix: make its entries constants"),
    "lost": ("K = float(str(1 / TAU))\n", ["--free", "TAU"], "(TAU free, so what is made of it is a formula: NumPy and math take it; or leave it out of --free)"),
    "branch": ("K = 1 if TAU > 3 else 2\n", ["--free", "TAU"], "line 13: a branch depends on a value"),
    "Q and a part of it": ("", ["--free", "SIGMA,Q"], "Q is free, and depends on a constant that is free: leave one of them out"),
    "no noise": ("QUIET = 0.0\nNOISE = NOISE + QUIET\n", ["--free", "QUIET"], "QUIET is 0, and is of the noise: begin with some noise"),
    "EM": ("", ["--method", "em"], "a nonlinear model has no EM: take maximum likelihood (ml)"),
    "entries of A": ("", ["--free", "A[0,0]"], "--free: there are entries of Q, R, not of A"),
    "a list": ("free = 'R0'\n", [], "line 13: free: is a list of names of constants of the file, or of Q, R, x0, P0"),
    "another file": ("", ["--out", "fitted.toml"], "fitted.toml: is to be a .py file, as the model is"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case, tmp_path):
    line, options, said = REFUSED[case]
    text = (FITTED / "cell.py").read_text().replace("x0, P0 =", f"{line}x0, P0 =", 1)
    path, out = tmp_path / "cell.py", tmp_path / "out.py"
    path.write_text(text)
    done = command("fit", path, log(tmp_path, "cell"), *(["--out", out] if "--out" not in options else []), *options, folder=tmp_path)
    assert done.returncode == 1 and said in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1 and not out.exists()
