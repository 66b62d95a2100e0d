"""What `kalmanq study heavy-tails` has to show, each with its standard error: study.py SEEDS does it with many runs.

A bound may be passed by three standard errors, a value may be off by four: below alpha = 2 the size of an error has no
variance, and what is made of the runs for a standard error is too small as often as not.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from kalmanq.run.campaigns import run_campaign
from kalmanq_studies.heavy_tails import claims, population, scores
from kalmanq_studies.heavy_tails.claims import EVEN, METRICS, QUIET, TAILED
from kalmanq_studies.heavy_tails.collected import GAUSSIAN, Collected
from kalmanq_studies.heavy_tails.perform import perform
from kalmanq_studies.heavy_tails.settings import FULL, SETTINGS, Part, Plan, tasks_of

MANY = Plan(known=Part(10, 1000, (1.4, 1.5, 1.6, 1.65, 1.7, 1.75, 1.8, 1.9, GAUSSIAN)), skewed=FULL.skewed,
            fitted=Part(4, 50, (TAILED, GAUSSIAN)), robust=Part(10, 100, (*claims.ROBUST_ALPHAS, GAUSSIAN)))


def collected(plan: Plan, seed: int, workers: int | None = None) -> Collected:
    tasks = tasks_of(plan, seed)
    with tempfile.TemporaryDirectory() as folder:
        return Collected(tasks, run_campaign(perform, tasks, fingerprint={}, journal=Path(folder) / "journal",
                                             workers=workers))


def at_most(figure, bound, what):
    print(f"   {what}: {figure}, at most {bound}")
    assert figure.value <= bound + 3 * figure.error, what


def near(figure, value, what, slack=0.0):
    print(f"   {what}: {figure}, {value:.4g}" + (f" up to {slack}" if slack else ""))
    assert abs(figure.value - value) <= slack + 4 * figure.error, what


def check_known(c: Collected) -> None:
    """Of the population to three standard errors; the crossings are those said up to 0.03."""
    for alpha in (1.5, 1.7, GAUSSIAN):
        exact = claims.population_ratio(alpha)
        made = c.beside_gaussian("known", EVEN, alpha, "known", "MAE")
        near(made, exact, f"MAE at alpha = {alpha:g} over the Gaussian one", 1e-12)
    mae = claims.crossing(c, EVEN, "size")
    near(mae, population.crossing(SETTINGS[0]), "smoother over filter crosses 1, MAE", 0.005)
    near(mae, 1.50, "the same", 0.03)
    if c.runs("known") >= 5 * claims.GROUP:
        near(claims.crossings_of_groups(c, EVEN), 1.71, "smoother over filter crosses 1, RMSE of groups of runs", 0.03)
    at_most(claims.highest(c, QUIET, "RMSE"), 0.80, "smoother over filter, RMSE, Q/R = 0.02, at any alpha")


def check_skewed(c: Collected) -> None:
    for setting in SETTINGS:
        for kind in ("filter", "smoother"):
            for beta in c.betas()[c.betas() > 0]:
                exact = population.mean_size(setting, kind, 1.5, beta) / population.mean_size(setting, kind, 1.5)
                near(claims.skewed(c, setting.ratio, 1.5, beta, kind), exact,
                     f"{kind}, Q/R = {setting.ratio:g}, MAE of beta = +-{beta:g} over that of 0")


def check_fitted(c: Collected) -> None:
    for metric in METRICS:
        at_most(c.beside_gaussian("fitted", EVEN, TAILED, "EM of Q", metric), 1.2, f"EM of Q, {metric}")
        near(c.beside_gaussian("fitted", EVEN, GAUSSIAN, "EM of Q", metric), 1, f"EM of Q at alpha = 2, {metric}", 0.01)
        all_six = c.beside_gaussian("fitted", EVEN, TAILED, "EM of all six", metric)
        print(f"   EM of all six, {metric}: {all_six}")
        assert all_six.value > 1.02 * c.beside_gaussian("fitted", EVEN, TAILED, "EM of Q", metric).value
    if c.runs("fitted") >= 200:
        near(all_six, 1.45, "EM of all six, MAE", 0.15)
    free = c.of("fitted", EVEN, GAUSSIAN, "ML of all six from c = 2")
    assert 1.5 < scores.median(free["H"]).value < 2.2, "ML of all six keeps the c that it began with"
    assert not np.any(free["converged"]) and c.of("fitted", EVEN, GAUSSIAN, "ML of Q, R")["converged"].mean() > 0.9
    exploded = c.beside_gaussian("fitted", EVEN, GAUSSIAN, "ML of H, Q, R", "MAE")
    print(f"   ML of H, Q, R at alpha = 2, MAE: {exploded}")
    assert exploded.value > 5
    for name in ("ML of all six from c = 2", "ML of H, Q, R"):
        at_most(c.beside_gaussian("fitted", EVEN, GAUSSIAN, name, "MAE", "measured"), 1.05, f"{name}, of c x, MAE")


def check_robust(c: Collected) -> None:
    for (kind, name), bounds in claims.BOUNDS.items():
        for ratio, bound in zip((EVEN, QUIET), bounds):
            for metric in METRICS:
                at_most(claims.worst(c, ratio, name, metric, kind).above(), bound,
                        f"{name}, {kind}, Q/R = {ratio:g}, {metric}, % above the exact")
    for ratio in (EVEN, QUIET):
        for metric in METRICS:
            same = c.beside_exact(ratio, GAUSSIAN, "plain", metric, "filter")
            near(same, 1, "at alpha = 2 the exact mean is Kalman's", 1e-9)
            harm = c.beside_exact(ratio, 1.5, "Huber", metric, "filter")
            plain = c.beside_exact(ratio, 1.5, "plain", metric, "filter")
            assert harm.value > plain.value > 1.08, "a step for outliers where the state jumps"


CHECKS = (check_known, check_skewed, check_fitted, check_robust)


def main() -> None:
    for seed in map(int, sys.argv[1:]):
        print(f"seed {seed}", flush=True)
        c = collected(MANY, seed)
        for check in CHECKS:
            check(c)
    print("all that the study has to show")


if __name__ == "__main__":
    main()
