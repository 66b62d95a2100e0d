"""fit_peers.py EXAMPLES: the figures of fit_cases.py, by statsmodels; fails where one is another."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np
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
    if worst > 1e-5:
        sys.exit(f"{worst:.1e} from what is recorded")
    print(f"statsmodels: farthest from what is recorded {worst:.1e}")


if __name__ == "__main__":
    main()
