"""fit_peers.py EXAMPLES: the figures of fit_cases.py, by statsmodels; fails where one is another."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np
from statsmodels.tsa.statespace.kalman_filter import KalmanFilter
from statsmodels.tsa.statespace.structural import UnobservedComponents

import fit_cases


def fitted(z: np.ndarray, level: str, known: bool = False) -> tuple[float, ...]:
    model = UnobservedComponents(z, level, use_exact_diffuse=not known)
    if known:
        model.ssm.initialize_known(np.zeros(1), np.array([[1e7]]))
        model.loglikelihood_burn = 0
    start = model.fit(disp=0, maxiter=2000, method="powell")
    found = model.fit(start.params, disp=0, maxiter=2000, method="bfgs", gtol=1e-9)
    return (found.llf, *found.params)


def diffuse(harmonics: int) -> float:
    A, Q, H, R, z = fit_cases.waves(harmonics)
    f = KalmanFilter(k_endog=1, k_states=len(A), k_posdef=len(A), tolerance=0)
    f.bind(z)
    f["transition"], f["design"], f["selection"], f["state_cov"], f["obs_cov"] = A, H, np.eye(len(A)), Q, R
    f.initialize_diffuse()
    return float(f.filter().llf_obs.sum())


def standard_errors(z: np.ndarray, exact: dict[str, float]) -> float:
    """Prints those of the Nile's Q and R as statsmodels has them; how far its exact ones are from what is recorded."""
    model = UnobservedComponents(z, "local level", use_exact_diffuse=True)
    at = fit_cases.NILE_EXACT[1:]
    made = {kind: model.smooth(at, cov_type=kind, cov_kwds={"approx_complex_step": True}).bse for kind in ("oim", "approx")}
    for kind, errors in made.items():
        print(f"standard errors of R and Q, {kind}:", *(f"{error:.6g}" for error in errors))
    assert np.all(np.abs(made["oim"] / made["approx"] - 1) > 0.1)
    return max(abs(made["approx"][k] / exact[name] - 1) for k, name in enumerate(("R", "Q")))


def main() -> None:
    warnings.simplefilter("ignore")
    nile = fit_cases.nile(Path(sys.argv[1]))
    worst = 0.0
    for name, figures in (("NILE_EXACT", fitted(nile, "local level")),
                          ("NILE_KNOWN", fitted(nile, "local level", True)),
                          ("TREND_EXACT", fitted(fit_cases.trend(0)[:, 0], "local linear trend"))):
        expected = getattr(fit_cases, name)
        print(name, *(f"{figure:.10g}" for figure in figures))
        worst = max(worst, *(abs(a / b - 1) for a, b in zip(figures, expected)))
    for harmonics, expected in fit_cases.DIFFUSE.items():
        found = diffuse(harmonics)
        print(f"exact diffuse log-likelihood, {harmonics} waves: {found:.12g}")
        if abs(found / expected - 1) > 1e-9:
            sys.exit(f"{found / expected - 1:.1e} from what is recorded")
    worst = max(worst, standard_errors(nile, fit_cases.NILE_ERRORS))
    if worst > 1e-5:
        sys.exit(f"{worst:.1e} from what is recorded")
    print(f"statsmodels: farthest from what is recorded {worst:.1e}")


if __name__ == "__main__":
    main()
