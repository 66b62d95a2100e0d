"""kalmanq fit: parameters by EM and maximum likelihood."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Optional

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from kalmanq.data import tables
from kalmanq.data.files import refuse_one_output, whole
from kalmanq.errors import KalmanqError
from kalmanq.fitting import Fit, fit
from kalmanq.fitting.choice import require_units
from kalmanq.fitting.entries import free_and_held
from kalmanq.model import model_file
from kalmanq.model import Model


@dataclass(frozen=True)
class Asked:
    model: Path
    data: list[tables.AnySource]
    free: str
    hold: str
    method: str
    Q_form: str
    R_form: str
    starts: int
    seed: int
    iterations: int
    tolerance: float
    out: Optional[Path]
    plot: Optional[Path]
    json: bool


def fit_files(asked: Asked, console: Console) -> str:
    """Why the maximum was not found, in a line; empty where it was.  The best point is written in both cases."""
    _require_two_outputs(asked)
    model = model_file.read(asked.model)
    free, held = free_and_held(asked.free, asked.hold, model)
    if not free:
        raise KalmanqError("--free: names nothing")
    require_units(model, free, held)
    records = [tables.measurements_and_controls(path, model) for path in asked.data]
    found = _fit(asked, console, model, records, free, held)
    inputs = [asked.model, *asked.data]
    if asked.out:
        with whole(asked.out, inputs) as path:
            path.write_text(model_file.text_of(found.model), encoding="utf-8")
    if asked.plot:
        from kalmanq.pages import pictures

        pictures.save(pictures.draw_course(found, model.name), asked.plot, inputs)
    _tell(asked, found, free, console)
    return "" if found.is_settled else found.message


def _require_two_outputs(asked: Asked) -> None:
    refuse_one_output(asked.out, asked.plot)
    if asked.plot:
        from kalmanq.pages import pictures

        pictures.require_png(asked.plot)


def _fit(asked: Asked, console: Console, model: Model, records: list[Any], free: list[str],
         held: dict[str, np.ndarray]) -> Fit:
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TextColumn("{task.fields[now]}"))
    with Progress(*columns, console=console, disable=asked.json or not console.is_terminal) as progress:
        task = progress.add_task("fit", total=None, now="")
        return fit(
            model, [z for z, _ in records], free, u=[u for _, u in records], method=asked.method, held=held,
            Q_form=asked.Q_form, R_form=asked.R_form, starts=asked.starts, seed=asked.seed,
            iterations=asked.iterations, tolerance=asked.tolerance,
            report=lambda k, value: progress.update(task, now=f"{k} evaluations, log-likelihood {value:.6f}"))


# ------------------------------------------------------------------------------ what came out


def _tell(asked: Asked, found: Fit, free: list[str], console: Console) -> None:
    if asked.json:
        print(json.dumps(_for_machines(found, free), indent=2))
        return
    begun = f"{found.course[0]:.6g} -> " if found.course else ""
    console.print(f"log-likelihood {begun}{found.log_likelihood:.6f} in {len(found.course)} evaluations "
                  f"({found.evaluations} in all)")
    if found.is_settled:
        console.print(found.message)
    table = Table("parameter", "estimate", "standard error", box=None, pad_edge=False)
    for row in _rows(found, free):
        table.add_row(*row)
    console.print(table)
    if any(np.any(np.isfinite(errors)) for errors in found.standard_errors.values()):
        console.print("standard errors: from the exact Hessian of the log-likelihood")
    for name in found.boundary:
        console.print(f"at the boundary, no standard error: {name}")
    for path in (asked.out, asked.plot):
        if path:
            console.print(f"wrote {path}")


def _rows(found: Fit, free: list[str]) -> Iterator[tuple[str, str, str]]:
    """Entries that were estimated: of a covariance those up to the diagonal that are not 0 and held."""
    for name in free:
        value = getattr(found.model, name)
        errors = found.standard_errors.get(name, np.full(value.shape, np.nan))
        for at in np.ndindex(value.shape):
            if name in ("Q", "R", "P0") and (at[1] > at[0] or (value[at] == 0 and np.isnan(errors[at]))):
                continue
            yield f"{name}[{','.join(map(str, at))}]", f"{value[at]:.6g}", _number(errors[at])


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.6g}"


def _for_machines(found: Fit, free: list[str]) -> dict[str, Any]:
    return {
        "log_likelihood": _or_none(found.log_likelihood), "settled": found.is_settled, "message": found.message,
        "distance": _or_none(found.distance), "evaluations": found.evaluations,
        "course": [_or_none(value) for value in found.course], "em_evaluations": found.em_evaluations,
        "boundary": list(found.boundary), "undetermined": list(found.undetermined),
        **{name: getattr(found.model, name).tolist() for name in free},
        "standard_errors": {name: _nested(errors.tolist()) for name, errors in found.standard_errors.items()}}


def _or_none(value: float) -> Optional[float]:
    return float(value) if np.isfinite(value) else None


def _nested(given: Any) -> Any:
    return [_nested(one) for one in given] if isinstance(given, list) else _or_none(given)
