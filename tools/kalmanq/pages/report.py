"""One page that says whether the data fit the model, and shows why."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from kalmanq.compiler.given.rates import rates_of
from kalmanq.compiler.report.costs import UNKNOWN, built, reasons
from kalmanq.compiler.report.offers import COLUMNS, EXPLAINED, offers
from kalmanq.compiler.report.settling import of_rates
from kalmanq.compiler.run.equation_run import COMPILED, compiled_equations_run
from kalmanq.compiler.run.simulation import NO_SMOOTHER, compiled_run
from kalmanq.data.rows import controls_of
from kalmanq.firmware.costs import CORES
from kalmanq.firmware.ranges import widened
from kalmanq.firmware.reach import Record
from kalmanq.model import Model, Quantity
from kalmanq.model.column_model import row_needs
from kalmanq.nonlinear import NonlinearModel, NonlinearSmoother
from kalmanq.nonlinear.comparison import arithmetics
from kalmanq.pages import charts, page, verdict
from kalmanq.pages.across import Across, across, spoken
from kalmanq.pages.charts import NARROW, buckets_for, chart
from kalmanq.pages.pictures import measured_states, without_offsets
from kalmanq.pages.verdict import Finding, Whiteness
from kalmanq.run.campaigns import versions
from kalmanq.run.comparison import compare
from kalmanq.run.filters import Smoother
from kalmanq.run.results import Run

AnyModel = Union[Model, NonlinearModel]
MATRICES = {
    "A": "A, from a row to the next", "B": "B, of the controls (1: the offset c)", "H": "H, from states to measurements",
    "G": "G, with the process noise G G'", "Q": "Q, covariance of the process noise",
    "R": "R, covariance of the measurement noise", "D": "D, from controls to measurements", "d": "d, offsets of the measurements"}


@dataclass(frozen=True)
class Study:
    """What the page is of."""

    model: AnyModel
    run: Run
    z: np.ndarray
    found: list[Finding]
    white: list[Whiteness]
    compared: dict[str, dict]
    buckets: int
    across: Across
    is_compiled: bool = False

    @property
    def rows(self) -> int:
        return len(self.run)

    @property
    def rows_across(self) -> dict[str, Any]:
        """Of a chart over the rows"""
        return {"buckets": self.buckets, "across": self.across}


LEFT_OUT = f"left out: smoothed states and sigmas; {NO_SMOOTHER}"


def made_of(model: AnyModel, z: np.ndarray, u: Optional[np.ndarray], arithmetic: str, is_compiled: bool = False,
            times: Optional[np.ndarray] = None) -> Study:
    """is_compiled: of what the emitted C estimates"""
    of = partial(_nonlinear_of if isinstance(model, NonlinearModel) else _linear_of, times=times)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the page has the events, of each arithmetic
        run, compared, wider = of(model, z, u, arithmetic, is_compiled)
    white = [verdict.whiteness(column) for column in verdict.standardised(run).T]
    return Study(model, run, z, verdict.findings(run, z, wider, times), white, compared,
                 buckets_for(7 * model.n + 2 * model.m + 3), across(model, len(z), times), is_compiled)


def _linear_of(model: Model, z: np.ndarray, u: Optional[np.ndarray], arithmetic: str,
               is_compiled: bool, times: Optional[np.ndarray]) -> tuple[Run, dict[str, dict], list[str]]:
    """The run, arithmetics compared with double, and ranges that are too narrow"""
    run = compiled_run(model, arithmetic, z, u, times) if is_compiled else Smoother(model, arithmetic).run(z, u, times=times)
    _, compared = compare(model, z, u, {"compiled": partial(compiled_run, times=times)} if is_compiled else {}, times)
    return run, compared, widened(model, [Record(z, controls_of(u, model, len(z)))])[1] if run.is_held and not row_needs(model) else []


def _nonlinear_of(model: NonlinearModel, z: np.ndarray, u: Optional[np.ndarray], arithmetic: str,
                  is_compiled: bool, times: Optional[np.ndarray]) -> tuple[Run, dict[str, dict], list[str]]:
    run = compiled_equations_run(model, arithmetic, z, u, times) if is_compiled else \
        NonlinearSmoother(model, arithmetic).run(z, u, times=times)
    _, compared = arithmetics(model, z, u, COMPILED if is_compiled else {}, times)
    return run, compared, []


# ------------------------------------------------------------------------------ the page


def page_of(study: Study, model_path: Path, data_name: str) -> str:
    model, run = study.model, study.run
    sizes = ", ".join(counted(count, what) for count, what in (
        (model.n, "state"), (model.m, "measurement"), (len(model.inputs), "control")) if count)
    facts = [data_name, counted(study.rows, "row"), f"{100 * np.mean(np.isnan(study.z)):.3g} % missing",
             f"arithmetic {run.arithmetic}{', compiled' if study.is_compiled else ''}", sizes, f"log-likelihood {number(float(np.sum(run.log_likelihood)), 8)}"]
    sections = [_verdict(study), _states(study), _residuals(study), _nis(study), _autocorrelation(study),
                _sigmas(study), _arithmetics(study), _costs(model, study.z) if isinstance(model, Model) and not row_needs(model) else "", _model(model, model_path)]
    return page.page(model.name, facts, [one for one in sections if one], f"kalmanq {versions()['kalmanq']}")


def counted(count: int, what: str) -> str:
    return f"{count} {what}" + ("" if count == 1 else "s")


def _verdict(study: Study) -> str:
    said = [page.paragraph("Estimates, verdict and pictures come from the C that `kalmanq compile` writes, run on this "
                           f"machine; {LEFT_OUT}.")] if study.is_compiled else []
    return page.section("Does the data fit the model?", page.paragraph(verdict.headline(study.found), "headline"), *said,
                        page.finding_list(study.found), name="verdict", kind="verdict")


def _states(study: Study) -> str:
    run, shown, z = study.run, measured_states(study.model), without_offsets(study.run, study.z)
    figures = []
    for i, state in enumerate(study.model.states):
        measured = [z[:, c] / factor for c, factor in shown.get(i, [])]
        filtered = run.mean[:, i], run.sigma[:, i]
        smoothed = None if run.smoothed is None else (run.smoothed[:, i], run.smoothed_sigma[:, i])
        later = f"; {_ends(*smoothed)}, smoothed, each" if smoothed else ""
        said = f"{state.label} over the rows: {_ends(*filtered)}, filtered{later} with a band of 95 %"
        figures.append(page.figure(state.label, chart(
            f"state{i}", said, charts.draw_state, measured, filtered, smoothed, height=150, **study.rows_across)))
    entries = [("filtered", "filtered: given the rows so far, with a band of 95 %")]
    entries += [] if run.smoothed is None else [("smoothed", "smoothed: given all rows, with a band of 95 %")]
    return page.section("Data and bands", page.legend([("data", "measured")] * bool(shown) + entries),
                        _drawn(study), *figures, _often(study), name="states")


def _often(study: Study) -> str:
    """Of sensors with rates of their own, or times"""
    along, there = study.across, ~np.isnan(study.z)
    if np.all(there) and not along.unit:
        return ""
    told = [(one.name, spoken(column, along)) for one, column in zip(study.model.measurements, there.T)]
    return page.table("How often each was measured", ["", "times", "every", "longest gap"], [
        [name, str(one.count), along.lasts(one.usual) if one.count > 1 else "", along.lasts(one.longest)] for name, one in told])


def _ends(mean: np.ndarray, sigma: np.ndarray) -> str:
    known = np.flatnonzero(np.isfinite(mean) & np.isfinite(sigma))
    if not len(known):
        return "nothing is known of it"
    first, last = known[0], known[-1]
    return f"from {mean[first]:.4g} with sigma {sigma[first]:.2g} to {mean[last]:.4g} with sigma {sigma[last]:.2g}"


def _drawn(study: Study) -> str:
    """What pictures of many rows leave out."""
    if study.rows <= 2 * study.buckets:
        return ""
    return page.paragraph(f"Of every {round(study.rows / study.buckets)} rows or so the lowest and highest values are "
                          "drawn, or all between them as a cloud. All figures are of all rows.")


def _residuals(study: Study) -> str:
    figures = []
    for c, (one, series) in enumerate(zip(study.model.measurements, verdict.standardised(study.run).T)):
        known = series[np.isfinite(series)]
        beyond = f"{100 * np.mean(np.abs(known) > 2):.3g} % of {len(known)} are beyond 2" if len(known) else "none"

        figures.append(page.figure(f"{one.name}: {beyond}", chart(
            f"residual{c}", f"Standardised innovations of {one.name} over the rows: {beyond}", charts.draw_residuals,
            series, height=120, **study.rows_across)))
    return page.section(
        "Residuals", page.paragraph("What each measurement differs by from its prediction, in sigmas of that "
                                    "difference. Of a right model they look like noise, and 4.6 % are beyond 2."),
        page.legend([("dot", "standardised innovation"), ("dashed", "2 sigma")]), *figures, name="residuals")


def _nis(study: Study) -> str:
    run = study.run
    scored = verdict.is_scored(run, study.z)
    nis, taken = np.where(scored, run.nis, np.nan), np.where(scored, run.taken, 0)

    one = next(one for one in study.found if one.subject == "NIS")
    said = f"NIS over the rows: {one.said}"
    picture = chart("nis", said, charts.draw_nis, nis, taken, height=150, **study.rows_across)
    return page.section(
        "NIS", page.paragraph("The squared innovation of each row, by its covariance (normalised innovation squared). "
                              "Its mean is the number of measurements of the row, and 95 % are within the bounds of "
                              "chi-square."),
        page.legend([("data", "a row"), ("filtered", "mean over neighbouring rows"),
                     ("band", "bounds of a row, 95 %")]),
        page.figure("NIS of each row", picture), name="nis")


def _autocorrelation(study: Study) -> str:
    figures = []
    for c, (one, white) in enumerate(zip(study.model.measurements, study.white)):
        if not white.is_judged:
            figures.append(page.paragraph(f"{one.name}: {verdict.TOO_FEW}."))
            continue
        outside = f"{len(white.significant)} of {len(white.correlation)} lags outside"

        figures.append(page.figure(f"{one.name}: {outside}", chart(
            f"lags{c}", f"Autocorrelation of the innovations of {one.name}: {outside} of the bounds of 95 %",
            charts.draw_autocorrelation, white, height=150, **study.rows_across, label="lag, in measurements",
            sizes=(NARROW,))))
    return page.section(
        "Autocorrelation", page.paragraph("How innovations resemble those some measurements of the same sensor before. Of a right "
                                          "model they do not: 95 % of the lags are within the bounds."),
        page.legend([("filtered", "correlation"), ("band", "bounds of a lag, 95 %")]),
        page.small(figures), name="autocorrelation")


def _sigmas(study: Study) -> str:
    run = study.run
    figures = []
    for i, state in enumerate(study.model.states):
        filtered, smoothed = run.sigma[:, i], None if run.smoothed is None else run.smoothed_sigma[:, i]

        said = f"Sigma of {state.label} over the rows, {_last(filtered)} in the end"
        figures.append(page.figure(f"{state.label}: {_last(filtered)} in the end", chart(
            f"sigma{i}", said, charts.draw_sigma, filtered, smoothed, height=110, **study.rows_across)))
    return page.section("Sigma", page.paragraph("How well each state is known."),
                        page.legend([("filtered", "filtered"), ("smoothed", "smoothed")][:1 if run.smoothed is None else 2]),
                        *figures, name="sigma")


def _last(sigma: np.ndarray) -> str:
    return f"{sigma[-1]:.3g}" if np.isfinite(sigma[-1]) else "unknown"


# ------------------------------------------------------------------------------ tables


def number(value: Optional[float], digits: int = 6) -> str:
    return "" if value is None or not np.isfinite(value) else f"{value:.{digits}g}"


def _arithmetics(study: Study) -> str:
    rows, emitted = [], "and through the emitted C, " if study.is_compiled else ""
    for name, of in study.compared.items():
        if "refused" in of:
            rows.append([name, "", "", "", "", f"refused: {of['refused']}"])
            continue
        error = of["mean_error_in_sigma"]
        place = f"{of['worst_row']}, {of['worst_state']}" if np.isfinite(error) and error > 0 else ""
        rows.append([name, number(error, 2), place, number(of["sigma_relative_error"], 2),
                     number(of["log_likelihood_error"], 2), ", ".join(of["events"]) or "no events"])
    return page.section(
        "The arithmetics", page.paragraph(f"The same rows in the other arithmetics of the library, {emitted}compared with double. An "
                                          "error of 0.01 sigma is a hundredth of what is uncertain anyway."),
        page.table("Largest differences of a filter from double (f64)",
                   ["arithmetic", "mean, in sigma", "at row, state", "sigma, relative", "log-likelihood", "events"],
                   rows, text_columns=(2, 5)), name="arithmetics")


def _costs(model: Model, z: np.ndarray) -> str:
    return page.section("What it costs", page.paragraph("`kalmanq design` measures the library's forms, too, on one core."), *_compiled(model, z), name="costs")


def _compiled(model: Model, z: np.ndarray) -> list[str]:
    """What kalmanq compile would write, on the cores where it is measured here; of what is refused, why"""
    made = offers(model)
    counted_on = list(dict.fromkeys(core for one in made for core, cost in one.costs.items() if cost.of))
    rows = [[CORES.get(core, UNKNOWN), *offer.cells(core)] for offer in made if offer.product for core in counted_on or [""]]
    why = dict.fromkeys(line for offer in made for line in reasons(offer.costs))
    table = [page.table("Compiled for this model alone", ["core", *COLUMNS], rows, text_columns=(1,))] if rows else []
    return [page.paragraph("`kalmanq compile` writes C for this model alone. Its errors were observed over "
                           "records with gaps. Costs were counted when this page was made, on emulated cores"
                           f"{f': {built(counted_on)}' if counted_on else ''}. Columns: {EXPLAINED}."), *table, *map(page.paragraph, why),
            *([page.paragraph(f"Of these data: {of_rates(model, rates)}.")] if (rates := rates_of(z)) else []),
            *(page.paragraph(f"Compiled in {one.arithmetic}: {one.remark}.") for one in made if one.remark)]


def _model(model: AnyModel, path: Path) -> str:
    names = {"x": model.states, "u": model.controls, "z": model.measurements, "c": getattr(model, "columns", ())}
    sides = {"A": ("x", "x"), "B": ("x", "u"), "H": ("z", "x"), "G": ("x", ""), "Q": ("x", "x"), "R": ("z", "z"), "D": ("z", "u"), "d": ("z", "")}
    made = [page.table("States, measurements and controls", ["name", "what", "unit", "range", "fraction bits"],
                       [_quantity(one, what) for what, which in (("state", "x"), ("measurement", "z"),
                                                                 ("control", "u"), ("column", "c")) for one in names[which]],
                       text_columns=(1, 2))]
    for name, (of_row, of_column) in sides.items():
        matrix = getattr(model, name, None)
        if matrix is None or (name == "Q" and model.G is not None):
            continue
        matrix = matrix if name != "d" else matrix[:, None]
        texts = {(*at, 0)[:2]: one.text for at, one in getattr(model, "cells", {}).get(name, {}).items()}
        columns = [one.name for one in names[of_column]] if of_column in names else \
            ["d"] if name == "d" else [f"noise {k + 1}" for k in range(matrix.shape[1])]
        made.append(page.table(MATRICES[name], ["", *columns], [
            [one.name, *(texts.get((i, k)) or number(cell) for k, cell in enumerate(row))] for i, (one, row) in enumerate(zip(names[of_row], matrix))]))
    made.append(_prior(model if isinstance(model, Model) else model.frame))
    return page.section("The model", page.folded("Matrices and parameters", *made),
                        page.folded(f"The model file, {path.name}", page.verbatim(
                            path.read_text(encoding="utf-8-sig"))), name="model")


def _quantity(one: Quantity, what: str) -> list[str]:
    return [one.name, what, one.unit, number(one.range), "" if one.fraction is None else str(one.fraction)]


def _prior(model: Model) -> str:
    cells = [[state.name, number(mean), *("unknown" if model.unknown[i] else number(cell) for cell in row)]
             for i, (state, mean, row) in enumerate(zip(model.states, model.x0, model.P0))]
    return page.table("Before the first row: x0 and the covariance P0", ["", "x0", *(one.name for one in model.states)],
                      cells)
