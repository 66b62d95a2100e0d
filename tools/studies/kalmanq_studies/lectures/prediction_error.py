"""The squared error of a prediction from measurements, beside one that sees the true state before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Mapping

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from kalmanq.model import Model
from kalmanq.run.filters import Filter
from kalmanq.run.simulation import simulate
from kalmanq_studies.lectures.example import BLUE, ORANGE, Example, apart, predicted_covariances, ranged, shown

ROWS, RUNS = 51, 400  # the first row is not predicted


def model(Q: float = 0.3) -> Model:
    """Eigenvalues of A: 0.9 and -0.1."""
    return Model(A=[[0.5, 0.4], [0.6, 0.3]], H=np.eye(2), R=0.5 * np.eye(2), Q=Q * np.eye(2), x0=[8, 8],
                 P0=[[0.9, 0.3], [0.3, 0.9]], name="prediction error")


@dataclass(frozen=True)
class Result:
    """predicted: RUNS x 50 x 2, means; filter, oracle: RUNS x 50, squared errors; run 0 is the one that is shown.
    covariance: 50 x 2 x 2, of the prediction; expected: 50 and a number, what theory makes of the mean errors"""

    predicted: np.ndarray
    covariance: np.ndarray
    filter: np.ndarray
    oracle: np.ndarray
    expected_filter: np.ndarray
    expected_oracle: float


def compute(arithmetic: str, seed: int) -> Result:
    """The true state begins where the prior has it: theory and errors are then of one thing."""
    records = [simulate(model(), ROWS, one) for one in np.random.SeedSequence(seed).spawn(RUNS)]
    known = ranged(model(), [z for _, z in records])
    x, z = (np.array(of) for of in zip(*records))
    # H = I: what is left of a measurement without its innovation is the predicted mean
    predicted = np.array([one - Filter(known, arithmetic).run(one).innovation for one in z])[:, 1:]
    covariance = predicted_covariances(known, arithmetic, ROWS)[1:]
    return Result(predicted, covariance, np.sum((x[:, 1:] - predicted) ** 2, axis=2),
                  np.sum((x[:, 1:] - x[:, :-1] @ known.A.T) ** 2, axis=2),
                  np.trace(covariance, axis1=1, axis2=2), float(np.trace(known.Q)))


def standard_error(errors: np.ndarray) -> np.ndarray:
    return errors.std(axis=0, ddof=1) / np.sqrt(len(errors))


def numbers(result: Result) -> dict[str, Any]:
    """Over the last 25 rows, where the filter has settled."""
    late = {"filter": result.filter[:, 25:].mean(axis=1), "true state": result.oracle[:, 25:].mean(axis=1)}
    made: dict[str, Any] = {"this run, filter": result.filter[0].mean(),
                            "this run, true state": result.oracle[0].mean()}
    for (name, errors), theory in zip(late.items(), (result.expected_filter[25:].mean(), result.expected_oracle)):
        made[f"settled, {name}: mean of {RUNS} runs"] = errors.mean()
        made[f"settled, {name}: its standard error"] = standard_error(errors)
        made[f"settled, {name}: theory"] = theory
    return made


def distance(result: Result, exact: Result) -> float:
    return apart(result.predicted, exact.predicted, np.sqrt(np.diagonal(exact.covariance, axis1=1, axis2=2)))


def draw(results: Mapping[str, Result]) -> Figure:
    result, rows = shown(results), np.arange(1, ROWS)
    figure, (one, mean) = plt.subplots(2, 1, figsize=(7.6, 5.6), sharex=True, layout="constrained")
    for errors, theory, colour, mark, label in (
            (result.filter, result.expected_filter, BLUE, "o", "filter"),
            (result.oracle, np.full(ROWS - 1, result.expected_oracle), ORANGE, "s", "sees the true state")):
        one.plot(rows, errors[0], color=colour, marker=mark, ms=2.8, lw=1, label=label)
        mean.errorbar(rows, errors.mean(axis=0), 2 * standard_error(errors), color=colour, marker=mark, ms=2.8,
                      lw=0, elinewidth=0.9, label=label)
        mean.plot(rows, theory, color="black", lw=1, ls="--", label="theory" if mark == "s" else None)
    one.set(ylabel="squared error", ylim=(0, None), title="One run: either may be the better one in a row")
    mean.set(xlabel="row", ylabel="mean squared error", ylim=(0, None),
             title=f"Mean of {RUNS} runs, ± 2 standard errors: not to see the true state costs "
                   f"{result.expected_filter[-1] / result.expected_oracle:.2f} times the error")
    one.legend(loc="upper right", ncols=2)
    mean.legend(loc="lower right", ncols=3)
    return figure


EXAMPLE = Example("one-step prediction errors beside those of a predictor that sees the true state before", compute,
                  numbers, distance, draw)
