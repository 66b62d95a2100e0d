"""gallery_fitted.py OUT.json: every entry of the gallery, fitted: its data, its parameters, its matrices and what the
C core says of them.  For gallery_peers.py, whose Python has no kalmanq."""

from __future__ import annotations

import json
import sys

import numpy as np

from kalmanq_studies.gallery import ENTRIES
from kalmanq_studies.gallery.fitted import fit, run_of


def listed(array: np.ndarray | None) -> object:
    """NaN: None"""
    if array is None:
        return None
    return np.where(np.isnan(array), None, array.astype(object)).tolist()


def of(name: str) -> dict[str, object]:
    entry = ENTRIES[name]
    made, data = fit(entry, name), entry.data()
    model = made.model
    run = run_of(model, data)
    return {"parameters": made.parameters, "free": list(entry.free), "converged": made.converged,
            "log_likelihood": made.log_likelihood, "z": listed(data.z), "regressors": listed(data.regressors),
            "unknown": bool(model.unknown.all()), "smoothed": listed(run.smoothed),
            "smoothed_sigma": listed(run.smoothed_sigma),
            **{key: getattr(model, key).tolist() for key in ("A", "Q", "H", "R", "x0", "P0")}}


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as out:
        json.dump({name: of(name) for name in ENTRIES}, out)
