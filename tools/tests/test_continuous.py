"""Models in continuous time: their steps beside 60 digits, their files, and NAME_move of the C that kalmanq compile writes."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from driven import Driven
from library import saved

from kalmanq import KalmanqError, Model, ModelError
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.text.product import compiled
from kalmanq.model import model_file
from kalmanq.model.continuous import UNITS

LONG = np.longdouble


def random_model(seed: int) -> Model:
    """Stable or not, stiff or not, of n = 1 to 6"""
    draws = np.random.default_rng(seed)
    n = 1 + seed % 6
    F = draws.standard_normal((n, n)) * 10.0 ** draws.uniform(-1, 1)
    if seed % 3 == 0:
        F = np.triu(F, 1)  # its powers end
    G = draws.standard_normal((n, n))
    return Model.of_continuous(F, H=np.eye(1, n), R=0.1, Qc=G @ G.T, dt=float(10.0 ** draws.uniform(-3, 0)),
                               B=draws.standard_normal((n, 2)), P0=np.ones(n))


def exact_step(model: Model) -> tuple[np.ndarray, ...]:
    """A, Q and B from the series of the whole matrix, in 60 digits"""
    of, n = model.continuous, model.n
    with localcontext() as context:
        context.prec = 60
        whole = np.zeros((2 * n + 2, 2 * n + 2))
        whole[:n, :n], whole[:n, n:2 * n], whole[n:2 * n, n:2 * n] = -of.F, of.Qc, of.F.T
        pushed = np.zeros((n + 2, n + 2))
        pushed[:n, :n], pushed[:n, n:] = of.F, of.B
        e, p = (exponential(one, of.dt) for one in (whole, pushed))
        A = e[n:2 * n, n:2 * n].T
        return tuple(np.array(one, float) for one in (A, A @ e[:n, n:2 * n], p[:n, n:]))


def exponential(M: np.ndarray, dt: float) -> np.ndarray:
    made = np.array([[Decimal(float(one)) * Decimal(dt) / 1024 for one in row] for row in M], object)
    total = term = np.array([[Decimal(int(i == j)) for j in range(len(M))] for i in range(len(M))], object)
    for k in range(1, 60):
        term = term @ made / k
        total = total + term
    for _ in range(10):
        total = total @ total
    return total


@pytest.mark.parametrize("seed", range(24))
def test_a_step_is_that_of_60_digits(seed):
    model = random_model(seed)
    for got, right in zip((model.A, model.Q, model.B), exact_step(model)):
        assert np.abs(got - right).max() <= 4e-15 * max(np.abs(right).max(), 1e-3) * max(1, np.abs(model.A).max())
    assert np.linalg.eigvalsh(model.Q).min() >= -1e-15 * np.abs(model.Q).max()


def test_a_file_of_it_reads_back_to_the_same(tmp_path):
    model = random_model(4)
    path = saved(tmp_path / "model.toml", model_file.text_of(model))
    again = model_file.read(path)
    assert "F = " in path.read_text() and all(np.array_equal(getattr(model, key), getattr(again, key)) for key in "AQBHR")
    assert again.continuous.dt == model.continuous.dt
    assert model.changed(R=[[1.0]]).continuous is model.continuous and model.changed(Q=model.Q).continuous is None


@pytest.mark.parametrize("text, said", [
    ("F = [[0.0]]\nQc = 1\nH = 1\nR = 1\nP0 = 1", "dt: is missing"), ("F = [[0.0]]\ndt = 1\nH = 1\nR = 1\nP0 = 1", "Qc: is missing"),
    ("F = [[0.0]]\nQc = 1\ndt = 0\nH = 1\nR = 1\nP0 = 1", "line 4: dt: .*above 0"),
    ("F = [[0.0]]\nQc = 1\ndt = [1, 2]\nH = 1\nR = 1\nP0 = 1", "line 4: dt: "),
    ("F = [[0.0]]\nA = [[1.0]]\nQc = 1\ndt = 1\nH = 1\nR = 1\nP0 = 1", "line 3: A: .*steps"),
    ("F = [[0.0, 1.0]]\nQc = 1\ndt = 1\nH = 1\nR = 1\nP0 = 1", "line 2: F: "),
    ("F = [[900.0]]\nQc = 1\ndt = 1000\nH = 1\nR = 1\nP0 = 1", "line 4: dt: .*long"),
    ("F = [[0.0]]\nL = 1\nQc = [1, 1]\ndt = 1\nH = 1\nR = 1\nP0 = 1", "line 4: Qc: is 2, not 1 x 1"),
    ("F = [[0.0]]\nL = [1, 1]\nQc = 1\ndt = 1\nH = 1\nR = 1\nP0 = 1", "line 3: L: is 2 x 1"),
    ("F = [[0.0]]\nL = 1e200\nQc = 1\ndt = 1\nH = 1\nR = 1\nP0 = 1", "line 3: L: .*representable"),
    ("A = [[1.0]]\nL = 1\nQ = 1\nH = 1\nR = 1\nP0 = 1", "line 2: A: .*steps")])
def test_what_is_no_model_is_refused(text, said, tmp_path):
    path = saved(tmp_path / "model.toml", f"[model]\n{text}\n")
    with pytest.raises(KalmanqError, match=said):
        model_file.read(path)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noises_that_move_several_states_are_their_density(seed, tmp_path):
    """L, n x r, in a call and in a file"""
    rng = np.random.default_rng(seed)
    F, L, root = rng.normal(size=(3, 3)), rng.normal(size=(3, 2)), rng.normal(size=(2, 2))
    of = dict(F=F, H=[1.0, 0, 0], R=1.0, dt=0.5, P0=np.ones(3))
    whole, made = Model.of_continuous(Qc=L @ root @ root.T @ L.T, **of), Model.of_continuous(Qc=root @ root.T, L=L, **of)
    np.testing.assert_allclose(made.Q, whole.Q, rtol=1e-13, atol=1e-13 * np.abs(whole.Q).max())
    path = tmp_path / "a.toml"
    L[1] = np.linalg.solve([root @ root.T @ L[0], [1.0, 0.0]], [0.0, 1.0])  # two entries cancel but for their rounding
    made = Model.of_continuous(Qc=root @ root.T, L=L, **of)
    path.write_text(model_file.text_of(made))
    assert np.array_equal(model_file.read(path).continuous.Qc, made.continuous.Qc)
    path.write_text("[model]\n" + "".join(f"{key} = {np.asarray(value).tolist()}\n" for key, value in
                                          (*of.items(), ("Qc", [2.0]), ("L", L[:, 0]))))
    np.testing.assert_allclose(model_file.read(path).Q, Model.of_continuous(Qc=2 * np.outer(L[:, 0], L[:, 0]), **of).Q, rtol=1e-12)


def test_dt_is_a_number():
    for dt in (0, -1, np.nan, np.inf, "1", True):
        with pytest.raises(ModelError, match="dt"):
            Model.of_continuous([[0]], H=[1], R=1, Qc=[1], dt=dt, P0=[1])


# ------------------------------------------------------------------------------ NAME_move

MODELS = {
    "cart": dict(F=[[0, 1], [0, 0]], Qc=[0, 0.5], H=[1, 0], R=0.01, B=[0, 1]),
    "spring": dict(F=[[0, 1], [-30, -0.4]], Qc=[0, 2], H=[1, 0], R=0.01, B=[0, 1]),
    "gyro": dict(F=[[0, -1, 0], [0, -0.01, 0], [0, 0, -3]], Qc=[1e-4, 1e-6, 0.1], H=[[1, 0, 1]], R=0.02, B=[1, 0, 0])}


def test_a_decay_that_is_1_in_a_float_is_a_field_all_the_same():
    model = Model.of_continuous([[0, 1, 0], [0, 0, 0], [0, 0, -1e-9]], H=[[1, 0, 1]], R=0.01, Qc=[0, 0.5, 1e-9], dt=0.05, P0=[1, 1, 1])
    assert np.float32(model.A[2, 2]) == 1
    made = compiled(model, "flt", Options("f32", tunable=True))
    assert made.arithmetic.coefficients.places == [(0, 1), (2, 2)]


@pytest.mark.parametrize("arithmetic, most", [("f32", 1e-4), ("f64", 1e-9)])
@pytest.mark.parametrize("name", MODELS)
def test_move_is_a_step_of_another_length(name, arithmetic, most, tmp_path):
    model = Model.of_continuous(**MODELS[name], dt=0.05, P0=np.ones(len(MODELS[name]["F"])))
    f, draws = Driven(model, tmp_path, Options(arithmetic, tunable=True)), np.random.default_rng(1)
    x, P, H = np.zeros(model.n, LONG), np.eye(model.n, dtype=LONG), model.H[0].astype(LONG)
    for row in range(300):
        dt = float(np.float32(draws.exponential(0.05) + 1e-3 if row % 50 else 10.0))
        u, z = (float(np.float32(one)) for one in draws.standard_normal(2))
        assert f.call("move", f.type(dt)) == 1
        f.predict(u)
        f.update(z)
        mean, covariance = f.read()
        A, Q, B = (one.astype(LONG) for one in model.continuous.step(dt))
        x, P = A @ x + B[:, 0] * u, A @ P @ A.T + Q
        k = P @ H / (H @ P @ H + LONG(np.float32(model.R[0, 0]) if arithmetic == "f32" else model.R[0, 0]))
        x, P = x + k * (z - H @ x), P - np.outer(k, H @ P)
        sigma = np.sqrt(np.diag(P))
        assert np.abs((mean - x) / sigma).max() < 10 * most and np.abs(covariance - P).max() < most * P.max(), row
    before = f.bits
    for dt in (0.0, -1.0, float("nan"), float("inf")):
        assert f.call("move", f.type(dt)) == 0 and f.bits == before


def test_units_are_as_long_as_those_of_numpy():
    """A year is that of the calendar, in the mean of 400"""
    known = {one: np.timedelta64(1, letter) / np.timedelta64(1, "s") for one, letter in (
        ("ms", "ms"), ("s", "s"), ("min", "m"), ("h", "h"), ("day", "D"), ("week", "W"))}
    assert UNITS == {**known, "year": (np.datetime64("2400-01-01") - np.datetime64("2000-01-01")) / np.timedelta64(1, "s") / 400}
