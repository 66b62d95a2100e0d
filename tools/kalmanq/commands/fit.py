"""kalmanq fit: parameters by EM."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

from rich.console import Console
from rich.progress import Progress, TextColumn

from kalmanq import model_file, tables
from kalmanq.errors import KalmanqError
from kalmanq.files import whole
from kalmanq.fitting.em import Estimate, Estimation
from kalmanq.fitting.expectation import FORMS


@dataclass(frozen=True)
class Asked:
    model: Path
    data: list[Path]
    free: list[str]
    Q_form: str
    R_form: str
    iterations: int
    tolerance: float
    out: Optional[Path]
    plot: Optional[Path]
    json: bool


def fit_files(asked: Asked, console: Console) -> None:
    model = model_file.read(asked.model)
    if not asked.free:
        raise KalmanqError("--free: names nothing")
    for form in (asked.Q_form, asked.R_form):
        if form not in FORMS:
            raise KalmanqError(f"{form!r} is no form: {', '.join(FORMS)}")
    records = [tables.measurements_and_controls(path, model) for path in asked.data]
    estimation = Estimation(model, [z for z, _ in records], asked.free, u=[u for _, u in records],
                            Q_form=asked.Q_form, R_form=asked.R_form)
    with Progress(*Progress.get_default_columns(), TextColumn("{task.fields[likelihood]}"), console=console,
                  disable=asked.json or not console.is_terminal) as progress:
        task = progress.add_task("EM", total=asked.iterations, likelihood="")
        estimate = estimation.run(asked.iterations, asked.tolerance, lambda k, value: progress.update(
            task, completed=k + 1, likelihood=f"log-likelihood {value:.6f}"))
    inputs = [asked.model, *asked.data]
    if asked.out:
        with whole(asked.out, inputs) as path:
            path.write_text(model_file.text_of(estimate.model), encoding="utf-8")
    if asked.plot:
        from kalmanq import pictures

        pictures.save(pictures.draw_course(estimate.course), asked.plot, inputs)
    _tell(asked, estimate, console)


def _tell(asked: Asked, estimate: Estimate, console: Console) -> None:
    model = estimate.model
    made = {name: getattr(model, name).tolist() for name in asked.free}
    if asked.json:
        print(json.dumps({"log_likelihood": estimate.log_likelihood, "iterations": len(estimate.course) - 1,
                          "settled": estimate.is_settled,
                          "distance": None if estimate.distance != estimate.distance else estimate.distance, **made},
                         indent=2))
        return
    ended = "settled" if estimate.is_settled else "NOT settled"
    console.print(f"{ended} after {len(estimate.course) - 1} iterations: log-likelihood "
                  f"{estimate.course[0]:.6f} -> {estimate.log_likelihood:.6f}")
    if estimate.distance == estimate.distance:
        console.print(f"  extrapolated, {estimate.distance:.2g} of log-likelihood is left")
    for name, value in made.items():
        console.print(f"  {name} = {value}")
    for path in (asked.out, asked.plot):
        if path:
            console.print(f"wrote {path}")
