"""Is a model fit for a filter?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.model import Model
from kalmanq.run.parts import Parts
from kalmanq.run.resolution import told_of
from kalmanq.run.steady import steady_state

SLOW, EPSILON = 0.9995, float(np.finfo(float).eps)  # what is kept of an error in a row, from where it reads as 1


@dataclass(frozen=True)
class Finding:
    """is_note: a filter runs all the same, and it is no good news"""

    is_good: bool
    subject: str
    said: str
    is_note: bool = False

    @property
    def mark(self) -> str:
        return "NO " if not self.is_good else "(!)" if self.is_note else "ok "


def note(subject: str, said: str) -> Finding:
    return Finding(True, subject, said, is_note=True)


def directions(A: np.ndarray, H: np.ndarray) -> np.ndarray:
    """The observability matrix, each row of norm 1, so that its rank is no matter of units alone."""
    rows, block = [], H.copy()
    for _ in range(len(A)):
        rows.append(block / np.maximum(np.linalg.norm(block, axis=1, keepdims=True), 1e-300))
        block = block @ A
    return np.vstack(rows)


def unseen(A: np.ndarray, H: np.ndarray) -> list[complex]:
    """Eigenvalues of A whose states no measurement shows (Popov, Belevitch, Hautus)."""
    n, found = len(A), []
    scale = max(np.abs(A).max(), 1.0)
    for value in np.linalg.eigvals(A):
        pencil = np.vstack([(A - value * np.eye(n)) / scale, H / max(np.abs(H).max(), 1e-300)])
        if np.linalg.svd(pencil, compute_uv=False)[-1] < 1e-9:
            found.append(complex(value))
    return found


def lasting(model: Model) -> str:
    """Of a direction that keeps a covariance from settling, why; empty: there is none"""
    noise = model.G if model.G is not None else model.Q
    for A, given, what in ((model.A, model.H, "is never measured and does not decay"),
                           (model.A.T, noise.T, "has no process noise and does not decay")):
        values = [value for value in unseen(A, given) if abs(value) >= 1 - 1e-12]
        if values:
            value = values[0]
            return f"a direction with eigenvalue {value.real if abs(value.imag) < 1e-12 else value:.4g} {what}"
    return ""


def findings(model: Model, arithmetic: Optional[str] = None) -> list[Finding]:
    """arithmetic: what measurements have to be fine enough for; None: f32, and q31 where there are ranges"""
    made = [_seen(model), _driven(model), _settles(model), _conditioned(model), resolution_finding(model, [arithmetic] if arithmetic else ["f32", "q31"])]
    made += [_fixed_point(model)] if any(one.range for one in model.states) else []
    made += [prior_finding(model)] if any(one.range for one in np.array(model.states)[~model.unknown]) else []
    return made


def _seen(model: Model) -> Finding:
    values = unseen(model.A, model.H)
    lasting = [value for value in values if abs(value) >= 1 - 1e-12]
    if lasting:
        return Finding(False, "observable", f"no: a direction with eigenvalue {lasting[0]:.4g} is never measured "
                       "and does not decay; measure it or leave it out")
    if values:
        return Finding(True, "observable", "not all of it, but what is not measured decays by itself")
    return Finding(True, "observable", "every state is seen by the measurements")


def _driven(model: Model) -> Finding:
    G = model.G if model.G is not None else np.linalg.cholesky(model.Q + 1e-300 * np.eye(model.n)) \
        if np.all(np.linalg.eigvalsh(model.Q) > 0) else model.Q
    lasting = [value for value in unseen(model.A.T, G.T) if abs(value) >= 1 - 1e-12]
    if lasting:
        return note("stabilisable", f"no: a direction with eigenvalue {lasting[0]:.4g} has no process noise; "
                    "its sigma falls without end and the filter stops listening to it")
    return Finding(True, "stabilisable", "the process noise reaches all that does not decay")


def _settles(model: Model) -> Finding:
    try:
        state = steady_state(model)
    except KalmanqError as problem:
        return note("steady state", f"none: {str(problem).removeprefix('steady state: ').removeprefix('no steady state: ')}")
    closed = model.A @ (np.eye(model.n) - state.gain @ model.H)
    kept = float(np.abs(np.linalg.eigvals(closed)).max())
    return Finding(True, "steady state", f"forgets by {f'{kept:.4g}' if kept < SLOW else f'1 - {max(1 - kept, EPSILON):.1e}'} a row")


def _conditioned(model: Model) -> Finding:
    values = np.linalg.svd(directions(model.A, model.H), compute_uv=False)
    condition = values[0] / max(values[-1], 1e-300)
    said = f"observability matrix: {condition:.3g}"
    return note("conditioning", f"{said}; some states are hardly distinguished") if condition > 1e8 else Finding(True, "conditioning", said)


def resolution_finding(model: Any, arithmetics: Sequence[str], z: Optional[np.ndarray] = None) -> Finding:
    coarse = [f"{one}: {told}" for one in arithmetics if (told := told_of(model, one, z))]
    return Finding(not coarse, "resolution", "; ".join(coarse) or "measurements are finer than their noise")


def _fixed_point(model: Model) -> Finding:
    try:
        parts = Parts(model, "q31")
    except KalmanqError as problem:
        return ranges_refused(model, str(problem))
    formats = ", ".join(f"{one.name} Q{31 - bits}.{bits}" for one, bits in
                        zip(model.states, parts.fractions("states")))
    return Finding(True, "ranges", f"fit the library's formats: {formats}")


def ranges_refused(model: Any, said: str) -> Finding:
    lacks = any(one.range is None for which in (model.states, model.measurements) for one in which)
    return Finding(False, "ranges", f"{said}; or leave all ranges out: f32 and f64 need none" if lacks else said)


def prior_finding(model: Model) -> Finding:
    """Does the filter begin within its ranges?  Beyond 3 sigma it hardly is."""
    wide, reaching = [], []
    for i, one in enumerate(model.states):
        if one.range is None or model.unknown[i]:
            continue
        sigma, mean = float(np.sqrt(model.P0[i, i])), abs(float(model.x0[i]))
        told = f"{one.name} is {model.x0[i]:g} +- {sigma:g}, its range {one.range:g}"
        if mean > one.range or sigma > one.range:
            wide.append(told)
        elif mean + 3 * sigma > one.range:
            reaching.append(told)
    if wide:
        return Finding(False, "prior", f"beyond its range: {'; '.join(wide)}; raise the range, or lower P0")
    if reaching:
        return note("prior", f"3 sigma reach beyond the range: {'; '.join(reaching)}")
    return Finding(True, "prior", "3 sigma are within the ranges")
