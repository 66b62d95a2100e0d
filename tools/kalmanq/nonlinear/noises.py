"""Q, G and R as functions of x, t, u and the step: what they answer is looked at as an array of a file is."""

from __future__ import annotations

from typing import Any, Callable, Mapping, Optional, Sequence, Union

import numpy as np

from kalmanq.errors import KalmanqError, ModelError
from kalmanq.model.arrays import block_diagonal, numbers_of
from kalmanq.model.model import SIZE_MAX, _columns, _covariance
from kalmanq.nonlinear.calls import Given

Point = tuple[np.ndarray, float, np.ndarray]  # x, t, u
NEGATIVE = 1e-9  # an eigenvalue of the correlations below: no covariance


def looked_at(given: Given, at: Point, size: int) -> np.ndarray:
    """A covariance, size x size; of G: size x r"""
    made = given.raw(*at)
    try:
        if made.dtype.kind == "c" and np.any(made.imag != 0):
            raise ModelError(given.name, "answers complex numbers")
        if given.name == "G":
            return _columns("G", made.real, size)
        covariance = _covariance(given.name, made.real, size)
        sigma = np.sqrt(np.diag(covariance))
        unit = np.where(sigma > 0, sigma, 1)
        if np.linalg.eigvalsh(covariance / np.outer(unit, unit))[0] < -NEGATIVE or np.any(covariance[sigma == 0]):
            raise ModelError(given.name, "is no covariance: it is not positive semidefinite")
        return covariance
    except ModelError as problem:
        x, t, _ = at
        raise given.error(f"{problem.reason}, at x = ({', '.join(f'{value:g}' for value in x)}), t = {t:g}") from None


class Noises:
    """R of sensors, one after the other: arrays or functions"""

    def __init__(self, given: Mapping[str, Any]):
        labels = {name: f"R of {name}" if name else "R" for name in given}
        self.parts: dict[str, Union[Given, np.ndarray]] = {
            name: Given(labels[name], one) if callable(one) else _covariance(labels[name], one, length(labels[name], one))
            for name, one in given.items()}
        self.sizes: dict[str, int] = {}
        self.start = np.zeros((0, 0))

    def measured(self, start: Callable[[], Point], measurements: Optional[Sequence[Any]]) -> int:
        """The numbers of all sensors: of a function as the measurements have names, otherwise what it answers at the start"""
        for name, one in self.parts.items():
            if not isinstance(one, Given):
                self.sizes[name] = len(one)
            else:
                is_named = measurements is not None and len(self.parts) == 1
                self.sizes[name] = len(measurements) if is_named else len(np.atleast_1d(one.raw(*start())))
        self.start = block_diagonal([self._at_start(name, start) for name in self.parts])
        return len(self.start)

    def _at_start(self, name: str, start: Callable[[], Point]) -> np.ndarray:
        """In the place of R where a matrix has to be; where a function has no value yet, 1"""
        one = self.parts[name]
        if not isinstance(one, Given):
            return one
        try:
            return looked_at(one, start(), self.sizes[name])
        except KalmanqError:
            return np.eye(self.sizes[name])

    @property
    def functions(self) -> dict[str, Given]:
        return {name: one for name, one in self.parts.items() if isinstance(one, Given)}

    def at(self, point: Point) -> np.ndarray:
        """R of them all, m x m"""
        return block_diagonal([looked_at(one, point, self.sizes[name]) if isinstance(one, Given) else one
                               for name, one in self.parts.items()])



def length(key: str, given: Any) -> int:
    try:
        made = len(np.atleast_1d(numbers_of(given)))
    except (TypeError, ValueError, OverflowError):
        raise ModelError(key, "not an array of numbers, with rows of one length") from None
    if not 1 <= made <= SIZE_MAX:
        raise ModelError(key, f"has {made} rows; there are 1 to {SIZE_MAX}")
    return made
