"""kalmanq.fit: parameters of a model from records."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Callable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import lib, words_of
from kalmanq.errors import KalmanqError
from kalmanq.fitting.choice import Choice
from kalmanq.fitting.entries import ARRAYS
from kalmanq.fitting.expectation import Records
from kalmanq.fitting.findings import Findings, findings
from kalmanq.fitting.likelihood import likelihood
from kalmanq.fitting.one_start import Ended, Task, one_start
from kalmanq.model import ColumnModel, Model
from kalmanq.nonlinear import NonlinearModel

METHODS = ("em", "ml", "both")
IN_OTHER_UNITS = {"H": "+1", "Q": "-2", "x0": "-1", "P0": "-2"}  # per cent
SAME_TOP = 1e-3  # of log-likelihood, between starts that ended at one maximum


@dataclass
class Fit:
    """What `fit` has found.

    Attributes
    ----------
    model, log_likelihood : with what was estimated, the best that was found where there is no optimum; exact where the start is unknown
    standard_errors : of the entries of each free parameter, in arrays of their shapes; NaN where there is none:
        of what is held, at a boundary or not determined
    boundary : variances whose best value is 0, or so small that 0 is as good, such as "Q[1,1]": a limit, without a standard error
    undetermined : combinations that the records do not determine, such as "H[0,0] +1 %, Q[0,0] -2 %"
    evaluations : E-steps in all, those of the standard errors and of further starts too
    em_evaluations : of the course, those of EM
    course : the log-likelihood at each evaluation of the search, of the best start
    converged : is this a maximum, with every parameter determined, and no more than `tolerance` below its top?
    distance : of the log-likelihood from the maximum, extrapolated; NaN where that is not known
    message : one line: how it ended

    Examples
    --------
    >>> model = kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)
    >>> found = kalmanq.fit(model, [np.random.default_rng(0).normal(size=300).cumsum()], ["Q"])
    >>> found.converged, round(float(found.standard_errors["Q"][0, 0]), 1)
    (True, 0.1)
    """

    model: Union[Model, NonlinearModel]
    log_likelihood: float
    standard_errors: dict[str, np.ndarray] = field(default_factory=dict)
    boundary: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = ()
    evaluations: int = 0
    em_evaluations: int = 0
    course: list[float] = field(default_factory=list)
    converged: bool = False
    distance: float = float("nan")
    message: str = ""

    def names(self, free: Sequence[str]) -> list[str]:
        """Of what was free: a constant that is an array has one name a number, as a builder's parameter has, of which Q and R are;
        Q of records at irregular times is Qc"""
        if isinstance(self.model, Model) and self.model.constants:
            return list(self.model.constants)
        made = ["Qc" if name == "Q" and getattr(self.model, "continuous", None) else name for name in free if name in (*ARRAYS, "Qc", "F")]
        return [*getattr(self.model, "constants", ()), *made]

    def value(self, name: str) -> np.ndarray:
        constants = getattr(self.model, "constants", {})
        if name in ("Qc", "F"):
            return getattr(self.model.continuous, name)
        return np.array([constants[name]]) if name in constants else np.asarray(getattr(self.model, name))


def fit(model: Union[Model, NonlinearModel], records: Sequence[ArrayLike], free: Sequence[str] = ("Q", "R"), *,
        u: Optional[Sequence[Optional[ArrayLike]]] = None, times: Optional[Sequence[Optional[ArrayLike]]] = None,
        method: str = "both", Q_form: str = "full",
        R_form: str = "full", held: Optional[Mapping[str, ArrayLike]] = None, starts: int = 1, seed: int = 0,
        iterations: int = 1000, tolerance: float = 1e-6, arithmetic: str = "f64",
        report: Optional[Callable[[int, float], None]] = None) -> Fit:
    """Parameters under which `records` are most likely.

    Parameters
    ----------
    model : Model or NonlinearModel, where the search begins; a start that is unknown in it stays so, and is exact
    records : each T x m; NaN: missing
    free : of A, H, Q, R, x0, P0, by name; of a model in continuous time of F, Qc, H, R, x0, P0, or of its builder's parameters,
        Q and R among them (its sigma or density, and its noise).  H and Q are determined only as H^2 Q, but for what a known P0 tells:
        leave one out, or hold an entry.  Of a nonlinear model: of Q, R, x0, P0, and names of constants of its
        file, which are free in all that the file makes of them (its likelihood is C, with exact slopes)
    u : for each record T x l, or None
    times : for each record T, or None, of a model in continuous time or a nonlinear one, as Filter.run has them.  Where its steps are
        not all dt, Q is Qc; standard_errors has "Qc"
    method : "em" (Shumway and Stoffer 1982), "ml" (BFGS over the likelihood, with Fisher's gradient, Segal and
        Weinstein 1989), or "both": a few iterations of EM, then ML
    Q_form, R_form : "full", "diagonal", or "multiple": of what it is.  Q of a model with G is G Q' G', of Q' this form
    held : masks, n x n or m x n, by name (A, H, Q, R): where true, that entry stays as it is
    starts, seed : how often ML begins: once at `model`, then at random from `seed`; the best counts
    iterations, tolerance : E-steps that a start may take; what may be left of the log-likelihood
    arithmetic : "f64"; EM has "f32", too
    report : is told the number of each evaluation and its log-likelihood

    Returns
    -------
    Fit
        Its standard errors are the roots of the diagonal of J^-1, J the observed information from differences of the
        gradient (Harvey 1989, section 3.4).  Too few records, no maximum, or a likelihood that is not finite: `converged` is False
        and `message` says why

    Raises
    ------
    KalmanqError
        what is asked for cannot be

    Examples
    --------
    >>> model = kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)
    >>> z = np.random.default_rng(0).normal(size=300).cumsum() + np.random.default_rng(1).normal(size=300)
    >>> found = kalmanq.fit(model, [z], ["Q", "R"])
    >>> found.converged, found.model.R.round(0)
    (True, array([[1.]]))
    """
    if method not in METHODS:
        raise KalmanqError(f"{method!r} is no method: {', '.join(METHODS)}")
    if arithmetic != "f64" and method != "em":
        raise KalmanqError("maximum likelihood is in f64")
    _require_counts(starts=(starts, 1), seed=(seed, 0), iterations=(iterations, 1))
    if not tolerance >= 0:
        raise KalmanqError(f"tolerance: {tolerance} is not at least 0")
    made = Records(model, records, u, times)
    if isinstance(model, Model) and not isinstance(model, ColumnModel) and (model.d is not None or model.D is not None):
        fed = [0.0 if model.D is None or u is None else u[:, : model.D.shape[1]] @ model.D.T for u in made.u]
        rest = [z - by - (0.0 if model.d is None else model.d) for z, by in zip(made.z, fed)]
        found = fit(model.changed(d=None, D=None), rest, free, u=made.u, times=made.times, method=method, Q_form=Q_form, R_form=R_form, held=held, starts=starts,
                    seed=seed, iterations=iterations, tolerance=tolerance, arithmetic=arithmetic, report=report)
        whole = found.model.changed(d=model.d, D=model.D)
        whole.constants = found.model.constants
        return replace(found, model=whole)
    task = Task(model, made, Choice(model, free, Q_form, R_form, held, isinstance(model, Model) and (made.times is not None or _is_late(model) or isinstance(model, ColumnModel) and model.continuous is not None)), method, iterations, tolerance, arithmetic,
                report)
    if method == "em":
        task.choice.require_em(model)
    if task.choice.flow and arithmetic != "f64":
        raise KalmanqError("a model in continuous time is fitted in f64")
    impossible = task.impossible()
    if impossible:
        return Fit(model, likelihood(model, made.z, made.u, times=made.times) if made.measurements else 0.0, message=impossible)
    random = np.random.default_rng(seed)
    ended = [one_start(task)] + [one_start(task, random) for _ in range(starts - 1)]
    return _fit_of(task, max(ended, key=lambda one: float(np.nan_to_num(one.value, nan=-np.inf))), ended)


def _is_late(model: Model) -> bool:
    """Is it in continuous time, with delays in its unit?  They mean nothing beside an A and a Q of steps"""
    return model.continuous is not None and any(one.delay for one in model.sensors)


def _require_counts(**given: tuple[int, int]) -> None:
    for name, (value, least) in given.items():
        if not isinstance(value, (int, np.integer)) or value < least:
            raise KalmanqError(f"{name}: {value!r} is no whole number from {least}")


def _fit_of(task: Task, best: Ended, ended: list[Ended]) -> Fit:
    found = findings(best.problem, best.optimum) if best.optimum and np.isfinite(best.value) else None
    distance = best.distance
    undetermined = found.undetermined if found else _as_far_as_em_knows(task)
    why = _why_not(task, best, found, undetermined)
    why = task.choice.named(why)
    said = why or f"at the maximum: about {max(distance, 1e-12):.1g} of log-likelihood is left"
    if len(ended) > 1 and np.isfinite(best.value):
        there = sum(abs(one.value - best.value) < SAME_TOP for one in ended)
        said += f"; {there} of {len(ended)} starts ended there"
    return Fit(
        best.model, best.value, {task.choice.named(name): one for name, one in found.errors.items()} if found else {},
        tuple(map(task.choice.named, found.boundary if found else ())), tuple(map(task.choice.named, undetermined)), sum(one.evaluations for one in ended), best.em_evaluations, best.course,
        not why, distance, said)


def _as_far_as_em_knows(task: Task) -> tuple[str, ...]:
    """Without the information nothing says how much a known P0 tells of H."""
    if not task.has_no_unit:
        return ()
    return (", ".join(f"{name} {change} %" for name, change in IN_OTHER_UNITS.items() if name in task.choice.free),)


def _why_not(task: Task, best: Ended, found: Optional[Findings], undetermined: Sequence[str]) -> str:
    """Why this is no maximum, in a line; empty where it is one."""
    if not np.isfinite(best.value):
        status = best.status or best.problem.status
        cause = f": {words_of(status)}" if status < lib.KQ_OK else _refused(task)
        return f"the log-likelihood is not finite where the search begins{cause}; begin nearer to the records, or take units in which numbers are smaller"
    exhausted = best.optimum is not None and best.optimum.is_exhausted
    if found and found.runaway:
        return f"no maximum: the log-likelihood rises without an end with {', '.join(found.runaway)}"
    if best.status < lib.KQ_OK:
        return f"EM ended: {words_of(best.status)}"
    if exhausted:
        return f"given up after {best.evaluations} evaluations: {_left(best)}"
    if best.optimum and not best.optimum.information.is_finite:
        return "no maximum: next to the best point the log-likelihood is not finite, a covariance becomes singular"
    if best.optimum and not best.optimum.information.is_maximum:
        return "no maximum: the information matrix is not positive definite at the best point, and was not inverted"
    if undetermined:
        return f"not determined by the records: {'; '.join(undetermined)} changes nothing; hold some of it"
    if not best.distance <= task.tolerance or not best.em_is_near:
        return f"not at the maximum after {len(best.course)} evaluations: {_left(best)}"
    return ""


def _refused(task: Task) -> str:
    """What a filter of the model says of the records, where it does not run"""
    try:
        likelihood(task.model, task.records.z, task.records.u, times=task.records.times)
        return ""
    except KalmanqError as problem:
        return f": {problem}"


def _left(best: Ended) -> str:
    if best.distance == best.distance:
        return f"about {best.distance:.2g} of log-likelihood is left"
    return "how far it is, is not known"
