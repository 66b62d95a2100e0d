"""Numbers of a row from columns of the data, in model files: beside a textbook's filter whose matrices vary."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from library import saved
from models import varied

from kalmanq import Filter, KalmanqError, LagSmoother, Model, Smoother, Varying, fit, likelihood, run_series
from kalmanq.compiler.run.equation_run import CompiledEquations, FixedEquations
from kalmanq.model import ColumnModel, model_file
from kalmanq.model.columns import Expression
from kalmanq.nonlinear.of_columns import equations_of
from kalmanq.run.simulation import simulate

ROWS = 40
KEYS = ("A", "B", "Q", "H", "R", "D", "d")


def textbook(of: dict[str, np.ndarray], x: np.ndarray, P: np.ndarray, z: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Means, covariances and the log-likelihood"""
    means, covariances, _, _, terms = varied(of, x, P, z, u)
    return means, covariances, float(np.sum(terms))


def cell(key: str, at: tuple[int, ...], value: float, columns: dict[str, np.ndarray], draw: Any) -> tuple[str, np.ndarray]:
    """An expression around `value`, and what it is in each row"""
    name = f"{key}{'_'.join(map(str, at))}"
    columns[name] = c = np.round(draw.uniform(0.5, 1.5, ROWS), 4)
    text, made = [(f"{value!r}*{name}", value * c), (f"{value!r} * sqrt({name}^2)", value * np.sqrt(c**2)),
                  (f"-(-{value!r}) / {name}", value / c), (f"{value!r}*exp(log(abs({name})))", value * c)][draw.integers(4)]
    return text, made


def case(seed: int, n: int, keys: str, folder: Path, share: float = 0.7) -> tuple[ColumnModel, dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray]:
    """A model file whose matrices `keys` have expressions, what they come to, z, u with the columns, and u alone"""
    draw = np.random.default_rng(100 * seed + n)
    m, l = min(n, 2), 1 + seed % 2
    A = draw.normal(size=(n, n))
    A *= 0.6 / np.abs(np.linalg.eigvals(A)).max()
    own: dict[str, np.ndarray] = {"A": A, "B": draw.normal(size=(n, l)), "Q": np.diag(draw.uniform(0.1, 1, n)), "H": draw.normal(size=(m, n)),
                                  "R": np.diag(draw.uniform(0.1, 1, m)), "D": draw.normal(size=(m, l)), "d": draw.normal(size=m)}
    columns: dict[str, np.ndarray] = {}
    texts, of = {}, {}
    for key, array in own.items():
        shown, whole = np.array(array, object), np.repeat(array[None], ROWS, axis=0)
        for at in np.ndindex(array.shape) if key in keys else ():
            if (array[at] and draw.random() < share) or not any(at):
                shown[at], whole[(slice(None), *at)] = cell(key, at, float(array[at]), columns, draw)
        texts[key], of[key] = json.dumps(shown.tolist()), whole
    lines = ["[model]", *(f"{key} = {text}" for key, text in texts.items()), f"P0 = {np.full(n, 2.0).tolist()}"]
    for section, count, span in (("states", n, 400), ("measurements", m, 2000), ("controls", l, 8)):
        lines += [f"[{section}]", f"ranges = {[span] * count}"]
    lines += ["[columns]", f"names = {json.dumps(list(columns))}", f"ranges = {[[0.5, 1.5]] * len(columns)}"] if columns else []
    path = saved(folder / "model.toml", "\n".join(lines))
    u, x, z = np.round(draw.normal(size=(ROWS, l)), 3), draw.normal(size=n), np.empty((ROWS, m))
    for t in range(ROWS):
        z[t] = of["H"][t] @ x + of["D"][t] @ u[t] + of["d"][t] + np.sqrt(np.diag(of["R"][t])) * draw.normal(size=m)
        x = of["A"][t] @ x + of["B"][t] @ u[t] + np.sqrt(np.diag(of["Q"][t])) * draw.normal(size=n)
    z[draw.random(z.shape) < 0.15] = np.nan
    z[7] = np.nan
    return model_file.read(path), of, z, np.column_stack([u, *columns.values()]), u


def apart(mean: np.ndarray, sigma: np.ndarray, right: tuple[np.ndarray, np.ndarray, float]) -> float:
    """In sigma, or relative to sigma"""
    exact = np.sqrt(np.diagonal(right[1], axis1=1, axis2=2))
    return float(max(np.abs((mean - right[0]) / exact).max(), np.abs(sigma / exact - 1).max()))


@pytest.mark.parametrize("n", [1, 3, 16])
@pytest.mark.parametrize("keys", [*KEYS, "ABQHRDd"])
@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-10), ("f32", 2e-5), ("q31", 2e-5)])
def test_each_matrix_beside_a_textbook(n, keys, arithmetic, most, tmp_path):
    for seed in range(2 if n == 16 and arithmetic == "q31" else 4):
        model, of, z, inputs, u = case(seed, n, keys, tmp_path)
        right = textbook(of, model.x0, model.P0, z, u)
        run = Filter(model, arithmetic).run(z, inputs)
        assert apart(run.mean, run.sigma, right) < most
        assert abs(run.log_likelihood.sum() - right[2]) < 20 * most * (1 + abs(right[2]))


@pytest.mark.parametrize("n", [1, 3, 16])
def test_rows_one_by_one_blocks_lags_and_forecasts(n, tmp_path):
    for seed in range(3):
        model, of, z, inputs, u = case(seed, n, "ABQHRDd", tmp_path)
        whole = Filter(model).run(z, inputs)
        one, blocks = Filter(model), Filter(model)
        for t in range(ROWS):
            if t:
                one.predict(inputs[t - 1])
            one.update(z[t], u=inputs[t])
        parts = [blocks.run(z[a:b], inputs[a:b]).mean for a, b in ((0, 1), (1, 17), (17, ROWS))]
        assert np.array_equal(one.mean, whole.mean[-1]) and np.array_equal(np.vstack(parts), whole.mean)
        ahead = blocks.forecast(2, np.repeat(inputs[-1:], 2, axis=0))
        x = whole.mean[-1]
        for _ in range(2):
            x = of["A"][-1] @ x + of["B"][-1] @ u[-1]
        assert np.allclose(ahead.mean, x, rtol=1e-9, atol=1e-9)
        smoothed, lagged = Smoother(model).run(z, inputs), LagSmoother(model, ROWS - 1).run(z, inputs)
        assert np.allclose(lagged.lagged[-1], smoothed.smoothed[0], rtol=1e-8, atol=1e-8)
        assert abs(likelihood(model, [z], [inputs]) - whole.log_likelihood.sum()) < 1e-9 * abs(whole.log_likelihood.sum())


@pytest.mark.parametrize("n, keys, arithmetic, most", [
    *((n, keys, arithmetic, most) for n in (1, 3) for keys in ("ABHDd", "ABQHRDd", "D", "R") for arithmetic, most in (("f32", 1e-4), ("f64", 1e-9))),
    *((n, keys, "q31", 1e-3) for n in (1, 3) for keys in ("ABHDd", "D")), pytest.param(16, "H", "f32", 1e-4, marks=pytest.mark.whole)])
def test_the_compiled_c_is_the_filter(n, keys, arithmetic, most, tmp_path):
    for seed in range(1 if n == 16 else 2):
        model, _, z, inputs, _ = case(seed, n, keys, tmp_path, 0.1)
        right = Filter(model).run(z, inputs)
        functions = equations_of(model, arithmetic)
        with FixedEquations(functions) if arithmetic == "q31" else CompiledEquations(functions, arithmetic) as compiled:
            run = compiled.run(z, inputs)
        assert (np.abs(run.mean - right.mean) / right.sigma).max() < most
        assert np.abs(run.sigma / right.sigma - 1).max() < most


def test_expressions_are_numbers_of_numpy():
    a, b = np.array([1.0, 2.0, 4.0]), np.array([0.5, -1.0, 3.0])
    for text, right in (("-a^2", -(a**2)), ("2^-b", 2.0**-b), ("a/b/2", a / b / 2), ("a - b - 1", a - b - 1), ("sin(pi*a)+cos(b)", np.sin(np.pi * a) + np.cos(b)),
                        ("abs(b)*exp(-a)", np.abs(b) * np.exp(-a)), ("+a*1e-3", a * 1e-3), ("a^b^2", a ** (b**2))):
        assert np.array_equal(Expression("R", text).values({"a": a, "b": b}), right), text
        assert np.allclose(eval(Expression("R", text).in_python({"a": "a", "b": "b"}), {"np": np, "a": a, "b": b}), right, rtol=1e-15), text


def test_a_file_is_written_as_it_was(tmp_path):
    for seed in range(3):
        model, _, z, inputs, _ = case(seed, 3, "ABQHRDd", tmp_path)
        (tmp_path / "again.toml").write_text(model_file.text_of(model))
        again = model_file.read(tmp_path / "again.toml")
        assert np.array_equal(Filter(again).run(z, inputs).mean, Filter(model).run(z, inputs).mean)


@pytest.mark.parametrize("n", [1, 3])
@pytest.mark.parametrize("arithmetic", ["f64", "f32", "q31"])
def test_d_of_a_model_and_of_varying(n, arithmetic, tmp_path):
    """Beside the model without it, of z - D u"""
    for seed in range(3):
        model, of, z, _, u = case(seed, n, "", tmp_path)
        assert not isinstance(model, ColumnModel) and model.D is not None
        equal, less = model.changed(D=None), (model.D @ u[:, :, None])[..., 0]
        bound = 0.0 if arithmetic != "q31" else 1e-5
        right, run = Filter(equal, arithmetic).run(z - less, u), Filter(model, arithmetic).run(z, u)
        assert (np.abs(run.mean - right.mean) / right.sigma).max() <= bound
        varied = Filter(equal, arithmetic).run(z, u, varying=Varying(D=of["D"]))
        assert np.array_equal(varied.mean, right.mean)
        if arithmetic == "f64":
            smooth, plain = Smoother(model).run(z, u), Smoother(equal).run(z - less, u)
            assert np.array_equal(smooth.smoothed, plain.smoothed)
            found, other = fit(model, [z], ["R"], u=[u]), fit(equal, [z - less], ["R"], u=[u])
            assert np.allclose(found.model.R, other.model.R, rtol=1e-6) and np.array_equal(found.model.D, model.D)


@pytest.mark.parametrize("n, free", [(1, "A,H,Q,R"), (3, "Q,R"), (1, "F,Q,R"), (2, "Q,R")])
def test_fit_is_that_of_the_model_without_columns(n, free, tmp_path):
    """Of columns that are 1 in each row: slopes by differences beside those of the core"""
    for seed in range(2):
        draw = np.random.default_rng(10 * seed + n)
        A = "F = -0.3" if "F" in free else f"F = {(-0.3 * np.eye(n)).tolist()}" if n == 2 else f"A = {(0.7 * np.eye(n)).tolist()}"
        Q = f"Qc = {[0.3] * n}\ndt = 0.5" if A[0] == "F" else f"Q = {[0.3] * n}"
        texts = {"plain": ("1.0", "0.5"), "columns": ('"c^2"', '"0.5 * c"')}
        models = {}
        for name, (of_H, of_d) in texts.items():
            H = [["1.0" if i == k else "0.0" for k in range(n)] for i in range(n)] + [[of_H, *["0.0"] * (n - 1)]]
            rows = ", ".join(f"[{', '.join(row)}]" for row in H)
            (tmp_path / f"{name}.toml").write_text(f"[model]\n{A}\n{Q}\nH = [{rows}]\nR = {[0.2] * (n + 1)}\nd = [{'0.0, ' * n}{of_d}]\nP0 = {[2.0] * n}\n")
            models[name] = model_file.read(tmp_path / f"{name}.toml")
        _, z = simulate(models["plain"], 150, 7 + seed)
        z[draw.random(z.shape) < 0.1] = np.nan
        held = {"H": np.array([[False]] * n + [[True]])} if "H" in free else {}
        how = {"Q_form": "diagonal", "R_form": "diagonal", "held": held, "method": "ml"}
        found = {name: fit(one, [z], free.split(","), u=[np.ones((150, 1))] if name == "columns" else None, **how) for name, one in models.items()}
        right, made = found["plain"], found["columns"]
        assert isinstance(made.model, ColumnModel) and abs(made.log_likelihood - right.log_likelihood) < 1e-5
        for name in ("A", "Q", "R"):
            assert np.allclose(getattr(made.model, name), getattr(right.model, name), rtol=5e-3, atol=1e-4), name


def test_fit_finds_the_numbers_and_leaves_the_texts(tmp_path):
    for seed in range(2):
        model, _, z, inputs, _ = case(seed, 3, "AHR", tmp_path, 0.2)
        found = fit(model, [z], ["Q", "R"], u=[inputs], Q_form="diagonal", R_form="diagonal")
        assert found.log_likelihood > likelihood(model, [z], [inputs]) + 1
        assert {at: one.text for at, one in found.model.cells["R"].items()} == {at: one.text for at, one in model.cells["R"].items()}
        assert abs(likelihood(found.model, [z], [inputs]) - found.log_likelihood) < 1e-6


@pytest.mark.parametrize("n", [1, 3])
def test_what_is_simulated_fits(n, tmp_path):
    """NIS of 80 draws, within 4 sigma of what is right"""
    for seed in range(2):
        model, _, z, inputs, _ = case(seed, n, "ABQHRDd", tmp_path)
        runs = [Filter(model).run(simulate(model, ROWS, 1000 * seed + k, inputs)[1], inputs) for k in range(80)]
        taken = sum(int(one.taken.sum()) for one in runs)
        assert abs(sum(float(one.nis.sum()) for one in runs) / taken - 1) < 4 * np.sqrt(2 / taken)
    with pytest.raises(KalmanqError):
        simulate(model, ROWS, 1)


def test_python_is_refused_what_it_lacks(tmp_path):
    model, _, z, inputs, u = case(1, 3, "HR", tmp_path)
    for call in (lambda: Filter(model).run(z), lambda: Filter(model).run(z, u), lambda: Filter(model).step(z[0], inputs[0]), lambda: Filter(model).gain(),
                 lambda: Filter(model).update(z[0]), lambda: Filter(model).run(z, np.full_like(inputs, np.nan)), lambda: fit(model, [z], ["Q"], u=[u])):
        with pytest.raises(KalmanqError):
            call()


def test_series_of_rows_are_refused(tmp_path):
    """They know no D and no columns: what is left out of account would be a wrong number"""
    for model, z, inputs in ((Model(0.9, H=1, R=0.1, Q=0.1, P0=1, D=2), np.ones((2, 5, 1)), np.ones((2, 5, 1))),
                             *((one, z[None], inputs[None]) for one, _, z, inputs, _ in (case(1, 3, "HR", tmp_path), case(1, 3, "D", tmp_path)))):
        with pytest.raises(KalmanqError):
            run_series(model, z, inputs)


@pytest.mark.parametrize("call", [lambda model, z: Filter(model).run(z), lambda model, z: Filter(model).update(z[0]),
                                  lambda model, z: Smoother(model, "f32").run(z), lambda model, z: likelihood(model, [z]), lambda model, z: fit(model, [z])])
def test_what_feeds_through_is_not_left_out(call):
    """Without u the measurements were taken as if it were 0"""
    model, z = Model(0.9, H=1, R=0.1, Q=0.1, P0=1, D=2), np.ones((5, 1))
    with pytest.raises(KalmanqError, match="give u"):
        call(model, z)
    assert Filter(model).run(np.full((5, 1), np.nan)).mean.shape == (5, 1)


def test_a_row_of_a_table_is_refused_and_no_series_too():
    """Its names stand in another order"""
    pandas = pytest.importorskip("pandas")
    model = Model(np.eye(2), H=np.eye(2), R=[1, 1], Q=[1, 1], P0=[1, 1], measurements=["p", "q"])
    with pytest.raises(KalmanqError, match="names"):
        Filter(model).update(pandas.Series({"q": 10.0, "p": 0.0}))
    for z in (np.zeros((0, 5, 2)), np.zeros((2, 0, 2)), [[[1.0, 2.0]], [[3.0, 4.0], [5.0, 6.0]]], None):
        with pytest.raises(KalmanqError, match="S x T x 2"):
            run_series(model, z)


def test_a_table_has_the_columns(tmp_path):
    pandas = pytest.importorskip("pandas")
    model, _, z, inputs, _ = case(1, 3, "HR", tmp_path)
    table = pandas.DataFrame(np.column_stack([z, inputs]), columns=[one.name for one in (*model.measurements, *model.inputs)])
    right = Filter(model).run(z, inputs).mean
    assert np.array_equal(Filter(model).run(table).mean, right) and np.array_equal(Filter(model).run(table, table).mean, right)
