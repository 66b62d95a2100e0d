"""S, E w[t] v[t]' = S: filters, smoothers and likelihoods beside the joint normal of all states and measurements."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from dense import Dense, Steps, conditioned
from scipy.linalg import block_diag

from kalmanq import Filter, KalmanqError, Model, Quantity, Smoother, decorrelated
from kalmanq.model.model import root_of

ROWS = 6


def drawn(seed: int):
    """A model, S, controls, measurements with gaps, and whether the joint covariance is singular"""
    r = np.random.default_rng(seed)
    n, l = int(r.integers(1, 4)), int(r.integers(0, 2))
    m, rank = int(r.integers(1, n + 1)), n if seed % 4 else 1
    joint = (root := r.normal(size=(n + m, rank + m))) @ root.T
    A, H, B = 0.9 * r.normal(size=(n, n)) / n, r.normal(size=(m, n)), r.normal(size=(n, l)) if l else None
    offsets = {"c": r.normal(size=n), "d": r.normal(size=m)} if seed % 3 == 0 else {}
    model = Model(A, H=H, R=joint[n:, n:], Q=joint[:n, :n], B=B, P0=np.eye(n), x0=r.normal(size=n), **offsets,
                  states=[Quantity(f"x{i}", range=2.0**10) for i in range(n)], measurements=[Quantity(f"z{j}", range=2.0**10) for j in range(m)],
                  controls=[Quantity("u", range=16)] * l or None)
    z, u = r.normal(size=(ROWS, m)), r.normal(size=(ROWS, l)) if l else None
    z[r.random(z.shape) < 0.25] = np.nan
    return model, joint[:n, n:], z, u


def right_of(model: Model, S: np.ndarray, z: np.ndarray, u) -> Dense:
    """Of states that are x, w and v"""
    (m, n), T, noise = model.H.shape, len(z), np.block([[model.Q, S], [S.T, model.R]])
    A = np.vstack([np.hstack([model.A, np.eye(n, n + m)]), np.zeros((n + m, 2 * n + m))])
    H, B = np.hstack([model.H, np.zeros((m, n)), np.eye(m)]), np.pad(np.zeros((n, 0)) if model.B is None else model.B, ((0, n + m), (0, 0)))
    steps = Steps(*(np.tile(one, (T, 1, 1)) for one in (A, B, block_diag(np.zeros((n, n)), noise), H, np.zeros((m, m)))))
    pushes = np.hstack([np.zeros((T, 0)) if u is None else u, np.ones((T, 0 if model.c is None else 1))])
    return conditioned(np.pad(model.x0, (0, n + m)), block_diag(model.P0, noise), steps, z - (0 if model.d is None else model.d), pushes)


@pytest.mark.parametrize("seed", range(200))
def test_it_is_the_joint_normal(seed):
    model, S, z, u = drawn(seed)
    if not np.any(~np.isnan(z)):
        z[0] = 0
    right = right_of(model, S, z, u)
    equal, controls, varying = decorrelated(model, S, z, u)
    run = Smoother(equal).run(z, controls, varying=varying)
    for t, mean in enumerate(right.smoothed[:, :model.n].astype(float)):
        sigma = np.sqrt(np.diag(right.smoothed_covariance[t])[:model.n].astype(float).clip(1e-30))
        assert np.abs(run.smoothed[t] - mean).max() < 1e-8 * max(1, np.abs(mean).max())
        assert run.smoothed_sigma[t] == pytest.approx(sigma, rel=1e-6, abs=1e-7)
    assert float(np.sum(run.log_likelihood)) == pytest.approx(float(right.log_likelihood), abs=float(1e-7 * max(1, abs(right.log_likelihood))))
    full, _, varies = decorrelated(model, S, np.ones((3, model.m)), None if u is None else u[:3])
    assert varies is None and all(np.array_equal(getattr(full, name), getattr(equal, name)) for name in "ABQ")
    assert [one.name for one in equal.controls] == ["u"] * (u is not None) + ["offset"] * (model.c is not None) + [f"z{j} before" for j in range(model.m)]
    last = Filter(equal, "f32").run(z, controls, varying=varying)
    assert np.abs(last.mean[-1] - mean).max() < 1e-4 * max(1, np.abs(mean).max())


def test_ignoring_it_costs_what_it_costs():
    """A random walk whose steps are what its sensor misreads: without S the error is far larger"""
    r, errors = np.random.default_rng(1), []
    joint = np.array([[1.0, -0.9], [-0.9, 1.0]])
    noise = (root_of(joint) @ r.normal(size=(2, 5000))).T
    x = np.concatenate([[0], np.cumsum(noise[:-1, 0])])
    z, model = x + noise[:, 1], Model(1, H=1, R=1, Q=1, P0=1)
    equal, controls, varying = decorrelated(model, -0.9, z)
    errors = [np.sqrt(np.mean((run.mean[:, 0] - x)**2)) for run in (Filter(model).run(z), Filter(equal).run(z, controls, varying=varying))]
    run = Filter(equal).run(z, controls, varying=varying)
    assert errors[1] < errors[0] and np.mean(run.nis) == pytest.approx(1, abs=0.1)


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long double is double")
@pytest.mark.parametrize("ulps", [3, 100, 30000])
def test_what_is_left_of_q_is_rounded_at_its_own_size(ulps):
    for R in (3.0, 7.0, 11.0):
        Q = 1 / R + ulps * 2.0**-52
        equal, _, _ = decorrelated(Model(1, H=1, R=R, Q=Q, P0=1), 1.0, [1.0, 2.0])
        assert equal.Q[0, 0] == pytest.approx(float(Fraction(Q) - 1 / Fraction(R)), rel=1e-3)


def test_what_is_no_s_is_refused():
    model = Model(1, H=1, R=1, Q=1, P0=1)
    moved = decorrelated(model.changed(Q=0), 0.0, [1.0])[0]
    assert moved.Q == 0 and moved.A == 1
    small, quiet = model.changed(Q=1e-12, R=1e-12), Model(np.eye(2), H=[1, 0], R=1, Q=[1, 0], P0=[1, 1])
    for of, S, said in ((model, 1.1, "semidefinite"), (small, 1.1e-12, "semidefinite"), (quiet, [1.1, 0], "semidefinite"), (quiet, [0, 0.1], "semidefinite"),
                        (model, [1, 2], "1 x 1"), (model, np.nan, "not finite"), (Model(1, H=1, R=1, Q=1, P0=1, D=2), 0.1, "leave D out, and give z - D u")):
        with pytest.raises(KalmanqError, match=f"^S: .*{said}"):
            decorrelated(of, S, [1.0])
    with pytest.raises(KalmanqError, match="steps"):
        decorrelated(Model.of_continuous(-1, H=1, R=1, Qc=1, dt=1, P0=1), 0.1, [1.0])


@pytest.mark.parametrize("seed", range(6))
def test_a_root_of_many_units_gives_each_variance_back(seed):
    """One of several, too, and a singular one; one whose units are alike keeps the root that it had"""
    draw = np.random.default_rng(seed)
    B, units = draw.normal(size=(2, 4, 4 if seed % 2 else 2)), 10.0 ** draw.uniform(-9, 9, 4)
    plain = B @ B.swapaxes(1, 2)
    given = np.stack([plain[0], plain[1] * np.outer(units, units)])
    made, sigma = root_of(given), np.sqrt(np.diagonal(given, axis1=1, axis2=2))
    assert np.all(np.abs(made @ made.swapaxes(1, 2) - given) <= 1e-9 * sigma[:, :, None] * sigma[:, None])
    values, vectors = np.linalg.eigh(given[0])
    assert np.array_equal(made[0], vectors * np.sqrt(values.clip(0))) and np.array_equal(root_of(given[1]), made[1])


def test_it_keeps_variances_that_are_far_below_others():
    """Of a short step"""
    step = Model.of_continuous(np.eye(4, k=1), H=[1, 0, 0, 0], R=0.25, Qc=[0, 0, 0, 2.0], dt=1e-4, P0=np.ones(4))
    model = Model(step.A, H=step.H, R=step.R, Q=step.Q, P0=step.P0)
    along = model.Q[:, -1:] / np.sqrt(model.Q[-1, -1])  # of a noise that is part of Q
    equal, _, _ = decorrelated(model, 0.25 * along, np.ones((3, 1)))
    sigma = np.sqrt(np.diag(model.Q))
    assert np.all(np.abs(equal.Q - (model.Q - 0.25 * along @ along.T)) <= 1e-13 * np.outer(sigma, sigma))
