"""Jacobians of functions that have none: by the complex step, or by central differences.

The derivative of the complex step is exact to rounding (Squire and Trapp, SIAM Review 40, 1998), for functions that
take complex numbers and keep their imaginary parts.  Many do not: atan2 refuses them, a norm drops the imaginary part
without a word.  So a difference along one direction, in which every state takes part, has to agree with each complex
Jacobian; where it does not, and where complex numbers are refused, the Jacobian is that of differences.
"""

from __future__ import annotations

import warnings
from typing import Any, Callable, Optional, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.nonlinear.calls import Given

STEP = 1e-100  # along the imaginary axis: its square is nothing beside 1
EPSILON = float(np.finfo(np.float64).eps)
SHARE = EPSILON ** (1 / 3)  # of a state's scale: where rounding and curvature of a central difference meet
AGREES = 1e-4  # of a difference and a derivative, of the sum of their terms' sizes
ROUNDING = 100 * EPSILON / SHARE  # of values, in a difference over a scale


class Derivative:
    """The Jacobian of a user's function.

    shape   of what the function answers: (rows,)
    scale   n: over which the function bends; sigmas of the prior
    angles  rows that are angles: they may jump by 2 pi
    """

    def __init__(self, given: Given, rows: int, scale: np.ndarray, angles: Sequence[int] = ()):
        self.given, self.rows, self.scale, self.angles = given, rows, scale, list(angles)
        self.why_differences: Optional[str] = None  # of the last Jacobian that was not by the complex step

    def at(self, x: np.ndarray, *others: Any) -> np.ndarray:
        """rows x n"""
        def values(point: np.ndarray) -> np.ndarray:
            return self.given.numbers((self.rows,), point, *others)

        scale = self.scales(x)
        made = self._complex(x, *others)
        if made is not None:
            if np.all(np.isfinite(made)) and agrees(made, values, x, scale, self.angles):
                return made
            self.why_differences = "it drops what is imaginary" if np.all(np.isfinite(made)) else "it is not smooth"
        return differences(values, x, scale, self.angles)

    def scales(self, x: np.ndarray) -> np.ndarray:
        made = np.maximum(np.abs(x), self.scale)
        return np.where(made > 0, made, 1.0)

    def _complex(self, x: np.ndarray, *others: Any) -> Optional[np.ndarray]:
        columns = []
        for unit in np.eye(len(x)):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # that the imaginary part was dropped, which is found out
                    answer = self.given.raw(x + 1j * STEP * unit, *others)
            except KalmanqError as problem:
                self.why_differences = f"it refuses complex numbers: {str(problem).rsplit(': ', 1)[-1]}"
                return None
            columns.append(np.imag(self.given.shaped(answer, (self.rows,))) / STEP)
        return np.column_stack(columns)


def differences(values: Callable[[np.ndarray], np.ndarray], x: np.ndarray, scale: np.ndarray,
                angles: Sequence[int] = ()) -> np.ndarray:
    """rows x n, by central differences of SHARE scales each way."""
    columns = []
    for i, step in enumerate(SHARE * scale):
        plus, minus = x.copy(), x.copy()
        plus[i] += step
        minus[i] -= step
        columns.append(unwrapped(values(plus) - values(minus), angles) / (plus[i] - minus[i]))
    return np.column_stack(columns)


def agrees(J: np.ndarray, values: Callable[[np.ndarray], np.ndarray], x: np.ndarray, scale: np.ndarray,
           angles: Sequence[int] = ()) -> bool:
    """Is J v a central difference along v?  v has a part of every state, of unlike sizes."""
    v = scale * (0.5 + np.mod(0.618034 * np.arange(1, len(x) + 1), 1)) * (-1.0) ** np.arange(len(x))
    plus, minus = values(x + SHARE * v), values(x - SHARE * v)
    slope = unwrapped(plus - minus, angles) / (2 * SHARE)
    allowed = AGREES * (np.abs(J) @ np.abs(v)) + ROUNDING * np.maximum(np.abs(plus), np.abs(minus))
    return bool(np.all(np.abs(J @ v - slope) <= allowed))


def unwrapped(change: np.ndarray, angles: Sequence[int]) -> np.ndarray:
    """Angles within half a turn"""
    made = change.copy()
    for c in angles:
        made[c] -= 2 * np.pi * np.round(made[c] / (2 * np.pi))
    return made


def arctan2(y: Any, x: Any) -> Any:
    """numpy.arctan2 that takes complex numbers, too, with the derivative in the imaginary part: for model files."""
    if not (np.iscomplexobj(y) or np.iscomplexobj(x)):
        return np.arctan2(y, x)
    (a, da), (b, db) = ((np.real(one), np.imag(one)) for one in (y, x))
    return np.arctan2(a, b) + 1j * (b * da - a * db) / (a**2 + b**2)
