"""How coarse are measurements as an arithmetic has them?  A float has 24 bits: near 1e9 its step is 64, and what is measured to 10 is lost.

Rounding adds step^2 / 12 to the variance R of the noise.  The mean of a filter has more bits (f32: a pair of floats), a measurement has not.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any, Optional, Sequence

import numpy as np

from kalmanq.core import nearest
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import Model
from kalmanq.run.parts import prepare_formats

COARSE = 0.5  # of the sigma of the noise: such a step adds 2 % to R
MOST = 0.9  # of the rows of data are as near to 0 as what is told: the others may be outliers
FINER = 2**7  # times a float's step at a range is q31's
FLOATS = {"f32": np.float32, "f64": np.float64}


@dataclass(frozen=True)
class Coarse:
    """A measurement whose step is large beside its noise

    where  how large it is, in words
    step   between neighbouring numbers of the arithmetic there
    sigma  of its noise, sqrt(R)
    """

    name: str
    where: str
    step: float
    sigma: float

    @property
    def share(self) -> float:
        return self.step / self.sigma


def coarse_of(model: Model, arithmetic: str, z: Optional[np.ndarray] = None, least: float = COARSE) -> list[Coarse]:
    """Measurements whose step is more than `least` sigma.  z: T x m, where they are; otherwise their ranges count, or H x0 + d.
    What is measured without noise does not count, nor data that the arithmetic has without rounding them."""
    if arithmetic == "f64" and z is not None:
        return []  # as given
    steps = _steps(model, arithmetic)
    sigmas, made = np.sqrt(np.diag(model.R)), []
    expected = model.H @ model.x0 + (0.0 if model.d is None else model.d)
    for k, (one, sigma) in enumerate(zip(model.measurements, sigmas)):
        if not sigma > 0 or steps is None:
            continue
        at, where = _place(one, expected[k]) if z is None else _place_in(z[:, k])
        step = float(steps[k](np.abs(at)))
        if step > least * sigma and (z is None or _is_rounded(z[:, k], arithmetic, step, least * sigma)):
            made.append(Coarse(one.name, where, step, float(sigma)))
    return made


def said(found: Sequence[Coarse], arithmetic: str, model: Model, z: Optional[np.ndarray] = None, has_q31: bool = True) -> str:
    """One sentence with the cure; empty where nothing is coarse"""
    if not found:
        return ""
    if arithmetic == "q31":
        told = [f"{one.name} has steps of {one.step:g} in q31, and its noise a sigma of {one.sigma:.3g}" for one in found]
        return f"{'; '.join(told)}: give a smaller range, with an origin subtracted from the measurement and x0"
    kind = {"f32": "a float", "f64": "a double"}[arithmetic]
    told = [f"{one.name} {one.where}, where the step of {kind} is {one.step:g}, and its noise has a sigma of {one.sigma:.3g}" for one in found]
    is_finer = not coarse_of(model, "q31", z) and all(one.step / FINER <= COARSE * one.sigma for one in found)
    finer = ", or take q31" if arithmetic == "f32" and has_q31 and is_finer else ""
    return f"{'; '.join(told)}: subtract an origin from the measurement and x0{finer}"


def told_of(model: Any, arithmetic: str, z: Optional[np.ndarray] = None) -> str:
    """The same of a model, or of data.  Of a nonlinear one its functions are the user's in q31, too"""
    is_linear = isinstance(model, Model)
    of = model if is_linear else model.measured
    return said(coarse_of(of, arithmetic, z), arithmetic, of, z, is_linear)


def warn_of_coarse(filter_: Any, arithmetic: str, z: np.ndarray) -> None:
    """Of the rows that a filter is given; once, `filter_.coarse` has it then"""
    if not filter_.coarse:
        filter_.coarse = told_of(filter_.model, arithmetic, z)
        if filter_.coarse:
            warnings.warn(f"{filter_.model.name}, {arithmetic}: {filter_.coarse}", KalmanqWarning, stacklevel=3)


def _steps(model: Model, arithmetic: str) -> Optional[list[Any]]:
    """Of each measurement: its step at a value; None: without ranges q31 has none"""
    if arithmetic != "q31":
        return [lambda at: np.spacing(FLOATS[arithmetic](at))] * model.m
    try:
        formats = prepare_formats(model, "measurements")
    except KalmanqError:
        return None
    return [lambda at, k=k: 2.0 ** -formats[k].fraction for k in range(model.m)]


def _place(one: Any, expected: float) -> tuple[float, str]:
    if one.range is not None:
        return one.range, f"may be {one.range:g}"
    return expected, f"is {expected:.4g} at first"


def _place_in(z: np.ndarray) -> tuple[float, str]:
    there = np.abs(z[np.isfinite(z)])
    at = float(np.quantile(there, MOST)) if there.size else 0.0
    return at, f"is as large as {at:.4g}"


def _is_rounded(z: np.ndarray, arithmetic: str, step: float, least: float) -> bool:
    """Is most of it changed by as much as such steps do?"""
    there = z[np.isfinite(z)]
    kept = nearest(there / step) * step if arithmetic == "q31" else there.astype(FLOATS[arithmetic]).astype(float)
    return bool(np.quantile(np.abs(there - kept), MOST) > MOST * least / 2) if there.size else False
