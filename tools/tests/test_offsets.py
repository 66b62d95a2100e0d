"""Offsets, x' = A x + B u + c and z = H x + d: beside the same model with a control that is given as 1 and measurements less d."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
import pytest
from command import kalmanq, refused, succeeds
from library import saved
from whole import first

from kalmanq import Filter, Model, Quantity, Smoother, likelihood
from kalmanq.compiler.run.simulation import CompiledFilter
from kalmanq.model import model_file
from kalmanq.run.simulation import simulate

SEEDS = range(40)  # five models each
FILE = """[model]
name = "fall"
F = [[0.0, 1.0], [0.0, -0.2]]
c = [0.0, -9.81]
Qc = [0.01, 0.5]
dt = 0.05
x0 = [1000.0, 0.0]
P0 = [100.0, 25.0]
[states]
ranges = [5000, 200]
[[sensors]]
name = "barometer"
H = [[1.0, 0.0]]
R = 4.0
d = [113.0]
ranges = [6000]
[[sensors]]
name = "radar"
H = [[1.0, 0.0], [0.0, 1.0]]
R = [1.0, 0.25]
ranges = [6000, 300]
"""


def pair(seed: int) -> tuple[Model, Model, np.ndarray, np.ndarray, Optional[np.ndarray], np.ndarray]:
    """A model with offsets and its equal, z of both, u of both"""
    r = np.random.default_rng(seed)
    n, l = int(r.integers(1, 5)), int(r.integers(0, 3))
    m = int(r.integers(1, n + 1))
    A, H = r.normal(size=(n, n)), r.normal(size=(m, n))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    B, c, d = r.normal(size=(n, l)), r.normal(size=n), 3 * r.normal(size=m)
    given: dict[str, Any] = dict(A=A, H=H, R=r.uniform(0.1, 1, m), Q=r.uniform(0.01, 1, n), P0=np.ones(n),
                                 states=[Quantity(f"x{i}", range=2.0**12) for i in range(n)])
    z = [Quantity(f"z{j}", range=2.0**13) for j in range(m)]
    u = [Quantity(f"u{k}", range=8) for k in range(l)]
    model = Model(**given, B=B if l else None, c=c, d=d, measurements=z, controls=u or None)
    equal = Model(**given, B=np.column_stack([B, c]), measurements=[Quantity(one.name, range=one.range + abs(by)) for one, by in zip(z, d)],
                  controls=[*u, Quantity("one", range=1, fraction=30)])
    controls = r.normal(size=(50, l)) if l else None
    _, measured = simulate(model, 50, seed, controls)
    measured[r.random(measured.shape) < 0.1] = np.nan
    ones = np.ones((50, 1)) if controls is None else np.column_stack([controls, np.ones(50)])
    return model, equal, measured, measured - d, controls, ones


@pytest.mark.parametrize("seed", SEEDS)
def test_a_filter_is_that_of_a_control_that_is_1_and_of_measurements_less_d(seed):
    for k in range(5):
        model, equal, z, rest, u, ones = pair(5 * seed + k)
        rounded = z.astype(np.float32) - model.d.astype(np.float32)
        for arithmetic, bound in (("f64", 0.0), ("f32", 0.0), ("q31", 1e-4)):
            f, g = Filter(model, arithmetic), Filter(equal, arithmetic)
            taken = rounded.astype(float) if arithmetic == "f32" else rest
            for rows in (slice(0, 20), slice(20, 50)):
                run, other = f.run(z[rows], None if u is None else u[rows]), g.run(taken[rows], ones[rows])
                assert (np.abs(run.mean - other.mean) / other.sigma).max() <= bound
            one = Filter(model, arithmetic)
            one.update(z[0])
            for t in range(1, 50):
                one.step(z[t], None if u is None else u[t - 1])
            assert np.array_equal(one.mean, f.mean)
            assert f.measurement()[0] - model.d == pytest.approx(g.measurement()[0], abs=1e-4)
            if u is None:
                assert f.forecast(3).mean == pytest.approx(g.forecast(3, ones[:3]).mean, rel=1e-5, abs=1e-4)
        assert Smoother(model).run(z, u).smoothed == pytest.approx(Smoother(equal).run(rest, ones).smoothed, rel=1e-12, abs=1e-12)
        assert likelihood(model, [z], None if u is None else [u]) == pytest.approx(likelihood(equal, [rest], [ones]), rel=1e-12)


@pytest.mark.parametrize("seed", first(1, range(3)))
def test_compiled_c_is_within_its_rounding_of_the_host(seed):
    model, _, z, _, u, _ = pair(seed + 100)
    wanted = Filter(model, "f64").run(z, u)
    for arithmetic, bound in (("f64", 1e-6), ("f32", 1e-3), ("q31", 1e-3)):
        with CompiledFilter(model, arithmetic) as f:
            run = f.run(z, u)
        assert (np.abs(run.mean - wanted.mean) / wanted.sigma).max() < bound
        assert np.nanmax(np.abs(run.innovation - wanted.innovation) / wanted.innovation_sigma) < bound


@pytest.mark.parametrize("seed", range(3))
def test_c_of_a_continuous_model_acts_over_each_step(seed):
    """Beside a state that stays at 1"""
    times = np.cumsum(np.random.default_rng(seed).exponential(0.1, 80))
    c, F = np.array([0.3, -9.81]), np.array([[0, 1], [0, -0.2]])
    model = Model.of_continuous(F, H=[[1, 0]], R=0.04, Qc=[0.01, 0.5], dt=0.05, c=c, d=[2.0], P0=[1, 1])
    more = Model.of_continuous(np.block([[F, c[:, None]], [np.zeros((1, 3))]]), H=[[1, 0, 0]], R=0.04, Qc=[0.01, 0.5, 0], dt=0.05,
                               x0=[0, 0, 1], P0=[1, 1, 0])
    _, z = simulate(model, 80, seed, times=times)
    run, other = Filter(model).run(z, times=times), Filter(more).run(z - 2, times=times)
    assert run.mean == pytest.approx(other.mean[:, :2], rel=1e-12, abs=1e-12)
    assert float(np.mean(run.nis)) == pytest.approx(1, abs=0.5)


def test_files_and_commands(tmp_path):
    path = saved(tmp_path / "fall.toml", FILE)
    model = model_file.read(path)
    assert model.c is not None and list(model.d) == [113, 0, 0] and model.inputs == ()
    text = model_file.text_of(model)
    path.write_text(text)
    assert model_file.text_of(model_file.read(path)) == text
    data = tmp_path / "data.csv"
    succeeds("simulate", path, "-n", 200, "--seed", 3, "--out", data)
    assert data.read_text().splitlines()[0] == "step,barometer,radar1,radar2"
    for more in (["run", "--smooth", "--out", tmp_path / "run.csv", "--plot", tmp_path / "a.png"], ["run", "--arith", "q31"],
                 ["run", "--forecast", 9], ["report", "-o", tmp_path / "page.html"], ["compare"], ["fit", "--out", tmp_path / "fitted.toml"]):
        succeeds(more[0], path, data, *more[1:])
    fitted = model_file.read(tmp_path / "fitted.toml")
    assert np.array_equal(fitted.c, model.c) and np.array_equal(fitted.d, model.d)
    refused(kalmanq("fit", path, data, "--free", "R,d"), "d is no parameter", tmp_path)
    for key, value, said in (("d = [113.0]", "d = [1.0, 2.0]", "d"), ("c = [0.0, -9.81]", "c = [0.0]", "c")):
        path.write_text(FILE.replace(key, value))
        refused(kalmanq("run", path, data), said, tmp_path)
