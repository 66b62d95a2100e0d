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
wrong: str = run.mean  # type: ignore[assignment]  # mypy --strict complains if there is nothing to ignore
