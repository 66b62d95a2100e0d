"""Is a model with numbers from columns, or with D, fit for a filter?  At the medians of its columns, and along the data."""

from __future__ import annotations

import warnings
from typing import Optional

import numpy as np

from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import ColumnModel, Model
from kalmanq.run import checks
from kalmanq.run.checks import Finding
from kalmanq.run.filters import Filter

Record = tuple[np.ndarray, Optional[np.ndarray], Optional[np.ndarray]]  # z, u, times


def findings(model: Model, record: Optional[Record], arithmetic: Optional[str] = None) -> list[Finding]:
    if not isinstance(model, ColumnModel):
        return [*checks.findings(model.frame, arithmetic), *([] if record is None else [_runs(model, record, arithmetic)])]
    if record is None:
        raise KalmanqError(f"{model.name} has numbers from columns: give the data with {', '.join(one.name for one in model.inputs)}, too")
    inputs = record[1]
    assert inputs is not None
    middle = np.nanmedian(inputs, axis=0)
    return [_columns(model, inputs, middle), *checks.findings(model.at(middle).frame, arithmetic), _runs(model, record, arithmetic)]


def _columns(model: ColumnModel, inputs: np.ndarray, middle: np.ndarray) -> Finding:
    first = len(model.inputs) - len(model.columns)
    said = ", ".join(f"{one.name} from {np.nanmin(column):g} to {np.nanmax(column):g}" for one, column in zip(model.columns, inputs[:, first:].T))
    at = ", ".join(f"{one.name} = {value:g}" for one, value in zip(model.inputs, middle))
    return Finding(True, "columns", f"{said}; what follows but run is at {at}")


def _runs(model: Model, record: Record, arithmetic: Optional[str]) -> Finding:
    z, u, times = record
    every = [one for which in (model.states, model.measurements, model.inputs) for one in which]
    names = [arithmetic] if arithmetic else ["f64", "f32", *(["q31"] if all(one.range for one in every) else [])]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KalmanqWarning)
            for name in names:
                Filter(model, name).run(z, u, times=times)
    except KalmanqError as problem:
        return Finding(False, "run", f"along the data in {name}: {problem}")
    return Finding(True, "run", f"along the data in {', '.join(names)}")
