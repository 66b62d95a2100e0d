"""A user's program, for a type checker: `mypy --strict` knows the package's names and what they answer."""

import numpy as np

import kalmanq

state = kalmanq.Quantity("level", range=10)
model = kalmanq.Model(A=[1], H=[1], Q=1, R=1, P0=1, x0=[5], states=[state])
run: kalmanq.Run = kalmanq.Smoother(model, "f32").run([6.0, np.nan])
total: float = float(run.log_likelihood.sum())
settled: kalmanq.SteadyState = kalmanq.steady_state(model)
mean: np.ndarray = run.mean
try:
    kalmanq.Filter(model, "q31").run([float("inf")])
except kalmanq.KalmanqError as problem:
    row: int | None = problem.row
lists = kalmanq.Model([[1, 1], [0, 1]], H=[1, 0], R=4, G=[0.5, 1], P0=[100, 10], states=["position", "velocity"])
cart: kalmanq.Model = kalmanq.constant_velocity(dt=0.1, density=0.2, noise=[0.04], variance=[100, 10])
span: float | None = kalmanq.Quantity("height", range=(0, 500)).range
found: kalmanq.Fit = kalmanq.fit(lists, [[1.0, 2.0], np.ones(3)], ["R"])
try:
    kalmanq.Filter([1, 2])  # type: ignore[arg-type]
    lists.nothing  # type: ignore[attr-defined]
except (TypeError, AttributeError) as told:
    print(told)
wrong: str = run.mean  # type: ignore[assignment]  # mypy --strict complains if there is nothing to ignore
