"""What fixed point does to a model's own formulas, compared with double at the same raw values."""

from __future__ import annotations

from typing import Mapping, Sequence

import numpy as np

from kalmanq.compiler.algorithm.fixed.device import Evaluated, FixedDevice
from kalmanq.compiler.algorithm.fixed.python import Far
from kalmanq.compiler.run.lint import Lossy, Visited, formulas, points, worst
from kalmanq.formulas.program import Program
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.formulas import values_of

POINTS = 600


def lossy_formulas(model: NonlinearModel, device: FixedDevice, visited: Sequence[Visited]) -> list[Lossy]:
    """All formulas, the worst one first; what an event tells is left out"""
    x, sigma, t, u, _ = points(model, visited)
    some = np.random.default_rng(1).permutation(len(x))[:POINTS]
    words = {**_words(device, "carried", "x", x[some]), **_words(device, "controls", "u", u[some]), "t": t[some].astype(int)}
    given = values_of(_values(words, "x", device.x), t[some], _values(words, "u", device.u))
    rows = list(formulas(model, np.maximum(sigma[some], 2.0 ** -np.array(device.d))))
    exact = [np.broadcast_to(one, len(some)) for one in Program([one for _, one, _ in rows]).values(given)]
    errors = np.array([_errors(device, {key: int(one[k]) for key, one in words.items()}, np.array([one[k] for one in exact]))
                       for k in range(len(some))])
    made = [worst(model, name, np.abs(column) * scale, given) for (name, _, scale), column in zip(rows, errors.T)]
    return sorted(made, key=lambda one: -one.error)


def _words(device: FixedDevice, which: str, stem: str, values: np.ndarray) -> dict[str, np.ndarray]:
    return {f"{stem}{k}": np.array([device.raw(which, k, value) for value in column]) for k, column in enumerate(values.T)}


def _values(words: Mapping[str, np.ndarray], stem: str, fractions: Sequence[int]) -> np.ndarray:
    return np.array([np.ldexp(words[f"{stem}{k}"].astype(float), -fraction) for k, fraction in enumerate(fractions)])


def _errors(device: FixedDevice, given: dict[str, int], exact: np.ndarray) -> np.ndarray:
    """Of increments, A, h and H, given what they are, as formulas() has them; NaN where an event tells"""
    n, m = device.n, device.nonlinear.m
    d, A, h, H = (part.copy() for part in np.split(exact, np.cumsum([0 if device.has_errors else n, n * n, m])))
    z = device.raws("measurements", h)
    given = {**given, **{f"z{j}": value for j, value in enumerate(z)}}
    made = [np.zeros(len(one)) for one in (d, A, h, H)]
    if device.predicted:
        made[0], made[1] = _off(device.predicted, given, device.d, d, np.subtract.outer(device.d, device.d), A)
    for one in device.sensors:
        if one not in device.plain:
            own, rows = slice(one.first, one.first + one.m), slice(n * one.first, n * (one.first + one.m))
            fractions = [device.innovation_fraction(j) for j in range(one.first, one.first + one.m)]
            e = np.ldexp(np.array(z[own], float), -np.array(device.z[own])) - h[own]
            exponents = np.subtract.outer(fractions, device.d)
            made[2][own], made[3][rows] = _off(device.measured_by[one.name], given, fractions, e, exponents, H[rows])
    return np.concatenate(made)


def _off(of: Evaluated, given: Mapping[str, int], fractions: Sequence[int], exact: np.ndarray, exponents: np.ndarray,
         table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Errors of its words and of its table"""
    far = Far()
    values = of.run(far, **{name: given.get(name, 0) for name in of.formulas.inputs})
    if far.bits:
        return np.full(len(exact), np.nan), np.full(len(table), np.nan)
    entries = np.zeros(len(table))
    for (k, _), one in zip(of.table, values[len(of.words):]):
        entries[k] = np.ldexp(float(one.mantissa), one.exponent - int(exponents.ravel()[k])) - table[k]
    count = len(exact)
    return np.ldexp(np.array(values[:count], float), -np.array(fractions[:count], int)) - exact, entries
