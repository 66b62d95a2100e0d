"""A model in continuous time at any times: its log-likelihood and gradient, what Expectation is to a model of steps that are alike.

The likelihood is the C core's.  Its slopes to each step's A, Q and B, to R and to the start are those of the disturbance smoother
(Koopman and Shephard, Biometrika 79, 1992; with an unknown start de Jong, Annals of Statistics 19, 1991), which inverts no Q.  Those
to F, Qc and a builder's parameters follow by the derivatives of the steps, which are steps of a model twice as large.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple, Sequence

import numpy as np

from kalmanq.core import lib
from kalmanq.data.rows import Rows
from kalmanq.errors import KalmanqError
from kalmanq.fitting.noise import Noise
from kalmanq.model import Model
from kalmanq.model.builders import searched
from kalmanq.model.model_file import rebuilt
from kalmanq.run.filters import Filter

ARRAYS = ("F", "Q", "H", "R", "x0", "P0")  # Q is of Qc
STEP = 1e-3  # share of a builder's parameter, of differences of what it makes
# x[k + 1] - x[k - 1] and x[k + 2] - x[k - 2], in steps: a derivative whose error is of fourth order
STENCIL = ((1, 2 / 3), (-1, -2 / 3), (2, -1 / 12), (-2, 1 / 12))
AGREES = 1e-7  # share of the log-likelihood by which the covariances here may be off from C's roots
FLAT = 16 * np.finfo(float).eps  # of a change of EM, rounded up


class Flow:
    """What is free: numbers of the model's builder (`labels`: parameter and place of each), or of ARRAYS"""

    def __init__(self, model: Model, names: Sequence[str]):
        self.model, self.labels = model, {}
        known = searched(model.builder)
        if any(name.partition("[")[0] in known for name in names):
            self._label(known, names)
        elif set(names) - {*ARRAYS, "Qc"}:
            name = next(one for one in names if one not in (*ARRAYS, "Qc"))
            more = f", and {', '.join(known)} of its builder" if known else ""
            raise KalmanqError(f"{name} of records at irregular times is not fitted: leave it out of --free. Free are Q (that is Qc), R, F, H, "
                               f"x0 and P0{more}; --time none takes each row for a step of dt")
        self.free = tuple(self.labels) or tuple(name for name in ARRAYS if name in names or name == "Q" and "Qc" in names)
        self.noises = {label for label, (name, _) in self.labels.items() if name in ("density", "sigma", "noise")}

    def _label(self, known: Sequence[str], names: Sequence[str]) -> None:
        size = next(name for name in ("density", "sigma") if name in known)
        for name in ({"Q": size, "Qc": size, "R": "noise"}.get(one, one) for one in names):
            parameter, _, entry = name.rstrip("]").partition("[")
            if parameter not in known:
                raise KalmanqError(f"{name} cannot be free beside parameters of the builder: {', '.join(known)}, Q (its {size}) and "
                                   "R (its noise) can")
            values = self.values_of(self.model, parameter)
            places = [int(entry)] if entry.isdigit() else np.flatnonzero(values).tolist()
            if entry and not (entry.isdigit() and int(entry) < len(values)):
                raise KalmanqError(f"{name} is not there: {parameter} has {len(values)} number{'s' * (len(values) > 1)}")
            if not places or not np.all(values[places] > 0):
                raise KalmanqError(f"{name} is not above 0, and its logarithm is searched: begin above 0")
            for at in places:
                self.labels[parameter if len(values) == 1 else f"{parameter}[{at}]"] = parameter, at

    @staticmethod
    def values_of(model: Model, parameter: str) -> np.ndarray:
        return np.atleast_1d(np.array(model.builder.get(parameter, 0.0), float))

    def model_at(self, arrays: dict[str, np.ndarray], noise: Noise) -> Model:
        """With what is free as it is in `arrays`"""
        if not self.labels:
            made = {name: arrays[name] for name in self.free if name in ("H", "R", "x0", "P0")}
            return self.model.flowing(F=arrays["F"] if "F" in self.free else None,
                                      Qc=noise.whole(arrays["Q"]) if "Q" in self.free else None, **made)
        given: dict[str, Any] = {}
        for label, (name, at) in self.labels.items():
            given.setdefault(name, self.values_of(self.model, name))[at] = arrays[label][0]
        made = rebuilt(self.model, {name: values.tolist() if np.ndim(self.model.builder[name]) else float(values[0])
                                    for name, values in given.items()})
        made.constants = {label: float(arrays[label][0]) for label in self.labels}
        return made


class Change(NamedTuple):
    """Of a model, or of its log-likelihood by it"""

    F: np.ndarray
    Qc: np.ndarray
    H: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray

    @classmethod
    def of(cls, model: Model) -> Change:
        return cls(model.continuous.F, model.continuous.Qc, model.H, model.R, model.x0, model.P0)

    def times(self, share: float) -> Change:
        return Change(*(share * one for one in self))

    def plus(self, other: Change) -> Change:
        return Change(*(a + b for a, b in zip(self, other)))


class FlowExpectation:
    """arrays: of what is free, and what else a problem asks for: Q of the noises (r x r, Qc = F Q F'), a label's one number"""

    def __init__(self, flow: Flow, model: Model, records: Any, noise: Noise, forms: dict[str, str]):
        self.flow, self.records, self.noise, self.forms, self.evaluations = flow, records, noise, forms, 0
        self.arrays = {label: Flow.values_of(model, name)[[at]] for label, (name, at) in flow.labels.items()}
        self.arrays.update({name: np.array(one) for name, one in zip(ARRAYS, Change.of(model))})
        self.arrays["Q"] = np.array(noise.inner)
        free = sum(self.arrays[name].size for name in flow.free if name not in ("Q", "R", "P0"))
        self.status = lib.KQ_OK if records.measurements > free else lib.KQ_ERR_FEW_DATA
        self.rows = [Rows.of(model, z, u, None if records.times is None else records.times[k])
                     for k, (z, u) in enumerate(zip(records.z, records.u))]
        self.begin()

    def begin(self) -> int:
        """Forgets what iterations have been"""
        self.log_likelihood = self.change = self.distance = float("nan")
        return self.status

    def run(self) -> int:
        self.evaluations += 1
        try:
            self.model, total = self.flow.model_at(self.arrays, self.noise), 0.0
            for rows in self.rows:
                run = Filter(self.model)
                run._sequence(rows)
                if run.events & lib.KQ_EVENT_OVERFLOW:  # a measurement that the filter has left out
                    return lib.KQ_ERR_LIKELIHOOD
                total += run.log_likelihood
        except (KalmanqError, FloatingPointError):
            return lib.KQ_ERR_NOT_FINITE
        self.log_likelihood = float(total)
        return lib.KQ_OK

    # ------------------------------------------------------------------ slopes

    def gradient(self) -> dict[str, np.ndarray]:
        """After `run`; NaN where the covariances here lose what C's roots keep"""
        of, n = self.model.continuous, self.model.n
        steps = [np.full(len(rows) - 1, of.dt) if rows.times is None else of.between(rows.times) for rows in self.rows]
        self._dt, which = np.unique(np.concatenate(steps), return_inverse=True)
        self._A, Q, B = of.steps(self._dt)
        ends, k = np.cumsum([0, *map(len, steps)]), len(self._dt)
        B = np.zeros((k, n, 0)) if B is None else B
        self._by = Slopes(*(np.zeros(shape) for shape in ((k, n, n), (k, n, n), B.shape, self.model.H.shape, self.model.R.shape, n, (n, n))))
        value = sum(_slopes(self.model, rows, which[a:b], (self._A, Q, B), self._by)
                    for rows, a, b in zip(self.rows, ends, ends[1:]))
        if not abs(value - self.log_likelihood) < AGREES * (1 + abs(value)):
            return {name: np.full_like(self.arrays[name], np.nan) for name in self.flow.free}
        return {name: self._of(name) for name in self.flow.free}

    def gradient_of(self, name: str) -> np.ndarray:
        self.run()
        return self.gradient()[name]

    def _of(self, name: str) -> np.ndarray:
        of = self.model.continuous
        if name in self.flow.labels:
            return np.array([self._along(self._tangent(name))])
        if name == "Q":
            back = replace(of, F=of.F.T, Qc=self._by.Q, B=None).steps(self._dt)[1].sum(axis=0)
            return back if self.noise.F is None else self.noise.F.T @ back @ self.noise.F
        if name != "F":
            return getattr(self._by, name)
        none, made = Change.of(self.model).times(0.0), np.zeros_like(of.F)
        for at in np.ndindex(made.shape):
            one = np.zeros_like(made)
            one[at] = 1
            made[at] = self._along(none._replace(F=one))
        return made

    def _tangent(self, label: str) -> Change:
        """What a builder's number moves, by its unit"""
        value, made = self.arrays[label][0], []
        for steps, weight in STENCIL:
            there = self.flow.model_at({**self.arrays, label: np.array([value * (1 + steps * STEP)])}, self.noise)
            made.append(Change.of(there).times(weight / (STEP * value)))
        return made[0].plus(made[1]).plus(made[2]).plus(made[3])

    def _along(self, change: Change) -> float:
        by, total = self._by, 0.0
        if np.any(change.F) or np.any(change.Qc):
            of, n = self.model.continuous, self.model.n
            none = np.zeros((n, n))
            twice = replace(of, F=np.block([[of.F, none], [change.F, of.F]]),
                            Qc=np.block([[of.Qc, change.Qc / 2], [change.Qc / 2, none]]),
                            B=None if of.B is None else np.vstack([of.B, 0 * of.B]))
            A, Q, B = (None if one is None else one[:, n:] for one in twice.steps(self._dt))
            total = np.sum(by.A * A[:, :, :n]) + 2 * np.sum(by.Q * Q[:, :, :n]) + (0.0 if B is None else np.sum(by.B * B))
        return float(total + sum(np.sum(getattr(by, name) * getattr(change, name)) for name in ("H", "R", "x0", "P0")))

    # ------------------------------------------------------------------ EM

    @staticmethod
    def has_em(model: Model, noise: Noise, form: str) -> bool:
        """Is the best Qc, given the states, one that can be said?  A size, and what is Qc dt over each step"""
        return form == "multiple" or len(noise.inner) == 1 or not np.any(model.continuous.F @ noise.whole(noise.inner))

    def iterate(self) -> int:
        """The E-step, and the M-step by Fisher's identity: the best C of N, given the states, is C + 2 C G C / N"""
        before = self.log_likelihood
        status = self.run()
        if status < lib.KQ_OK:
            return status
        slopes, moved, gain, steps, made = self.gradient(), [], self.log_likelihood - before, self.records.steps, []
        for name, count in (("Q", max(steps - len(self.records), 1)), ("R", steps)):
            if name in self.flow.free:
                C = self.arrays[name]
                step = self._best(name, C, slopes[name], count) if np.all(np.isfinite(slopes[name])) else np.full_like(C, np.nan)
                deviation = np.sqrt(np.maximum(np.diag(C), 1e-300))
                moved.append(float(np.max(np.abs(step) / np.outer(deviation, deviation))))
                made.append((C, (step + step.T) / 2))
        if not np.all(np.isfinite(moved)):
            return lib.KQ_ERR_NOT_FINITE
        for C, step in made:
            C += step
        rate, self.change = (max(moved) + FLAT) / self.change, max(moved)
        self.distance = gain * rate**2 / (1 - rate) if rate < 1 else float("nan")
        return lib.KQ_OK

    def _best(self, name: str, C: np.ndarray, slope: np.ndarray, count: int) -> np.ndarray:
        """How far the M-step goes"""
        form = self.forms[name]
        if name == "Q" and (form == "multiple" or len(C) == 1):
            return 2 * C * np.sum(slope * C) / (count * self._reached())
        if form == "multiple":
            return 2 * C * np.sum(slope * C) / (count * np.count_nonzero(np.diag(C)))
        step = 2 * C @ slope @ C / count
        return np.diag(np.diag(step)) if form == "diagonal" else step

    def _reached(self) -> int:
        """States that the noise of a step moves"""
        of = self.model.continuous
        reached = np.diag(of.Qc) > 0
        for _ in reached:
            reached = reached | ((of.F != 0) @ reached)
        return int(np.sum(reached))


# ------------------------------------------------------------------ the disturbance smoother


class Slopes(NamedTuple):
    """Of the log-likelihood, to each distinct step's A, Q and B, and to the rest; symmetric where what it is of is"""

    A: np.ndarray
    Q: np.ndarray
    B: np.ndarray
    H: np.ndarray
    R: np.ndarray
    x0: np.ndarray
    P0: np.ndarray


class _Row(NamedTuple):
    """Before the measurement x, P; after it filtered, covariance; H, S^-1, S^-1 H and S^-1 v of what is there, which is `at`"""

    P: np.ndarray
    filtered: np.ndarray
    covariance: np.ndarray
    at: np.ndarray
    H: np.ndarray
    inverse: np.ndarray
    weighed: np.ndarray
    innovation: np.ndarray


def _slopes(model: Model, rows: Rows, which: np.ndarray, steps: Any, by: Slopes) -> float:
    """Adds to `by` those of a record; the log-likelihood.  Means have a column more for each unknown state, which is 1 in it."""
    kept, total, squares = _forwards(model, rows, which, steps)
    W, s = squares[1:, 1:], squares[1:, 0]
    try:
        spread = np.linalg.inv(W) if len(W) else W
    except np.linalg.LinAlgError:
        return float("nan")
    start = -spread @ s
    total -= (squares[0, 0] + s @ start + (np.linalg.slogdet(W)[1] if len(W) else 0.0)) / 2
    c = np.concatenate([[1.0], start])
    C = np.outer(c, c)
    C[1:, 1:] += spread
    _backwards(rows, which, steps[0], kept, c, C, by)
    return float(total)


def _forwards(model: Model, rows: Rows, which: np.ndarray, steps: Any) -> tuple[list[_Row], float, np.ndarray]:
    A, Q, B = steps
    unknown = model.unknown
    X = np.column_stack([np.where(unknown, 0.0, model.x0), np.eye(model.n)[:, unknown]])
    P = np.where(unknown | unknown[:, None], 0.0, model.P0)
    kept, total, squares = [], 0.0, np.zeros((X.shape[1], X.shape[1]))
    for t, z in enumerate(rows.z):
        before, at = P, np.flatnonzero(~np.isnan(z))
        H = model.H[at]
        S = H @ P @ H.T + model.R[np.ix_(at, at)]
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / S if len(at) == 1 else _inverse(S)
        V = -H @ X
        V[:, 0] += z[at]
        weighed, innovation = inverse @ H, inverse @ V
        if len(at):
            gain = P @ weighed.T
            X, P = X + gain @ V, P - gain @ (H @ P)
            P = (P + P.T) / 2
            total -= (np.linalg.slogdet(S)[1] + len(at) * np.log(2 * np.pi)) / 2
            squares += V.T @ innovation
        kept.append(_Row(before, X, P, at, H, inverse, weighed, innovation))
        if t < len(which):
            k = which[t]
            X, P = A[k] @ X, A[k] @ P @ A[k].T + Q[k]
            if rows.u is not None:
                X[:, 0] += B[k] @ rows.u[t]
    return kept, float(total), squares


def _inverse(S: np.ndarray) -> np.ndarray:
    try:
        return np.linalg.inv(S)
    except np.linalg.LinAlgError:
        return np.full_like(S, np.nan)


def _backwards(rows: Rows, which: np.ndarray, A: np.ndarray, kept: list[_Row], c: np.ndarray, C: np.ndarray, by: Slopes) -> None:
    n = A.shape[1]
    r, N = np.zeros((n, len(c))), np.zeros((n, n))
    for t in range(len(kept) - 1, -1, -1):
        row = kept[t]
        if t < len(which):
            k, a = which[t], A[which[t]]
            back = a.T @ r
            by.Q[k] += (r @ C @ r.T - N) / 2
            by.A[k] += r @ C @ (row.filtered + row.covariance @ back).T - N @ a @ row.covariance
            if rows.u is not None:
                by.B[k] += np.outer(r @ c, rows.u[t])
            r, N = back, a.T @ N @ a
        if len(row.at):
            gain = row.P @ row.weighed.T
            error = row.innovation - gain.T @ r
            by.R[np.ix_(row.at, row.at)] += (error @ C @ error.T - row.inverse - gain.T @ N @ gain) / 2
            by.H[row.at] += error @ C @ (row.filtered + row.covariance @ r).T - row.weighed @ row.P + gain.T @ N @ row.covariance
            kept_part = np.eye(n) - gain @ row.H
            r, N = r + row.H.T @ error, row.H.T @ row.weighed + kept_part.T @ N @ kept_part
    by.x0[:] += r @ c
    by.P0[:] += (r @ C @ r.T - N) / 2
