"""Where the gallery's data come from: public files beside this one, or a model that draws them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence

import numpy as np

import kalmanq
from kalmanq.data import tables
from kalmanq.model import Model
from kalmanq.model.builders import build
from kalmanq.run.simulation import simulate

HERE = Path(__file__).parent / "data"
MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
NILE = Path(kalmanq.__path__[0]) / "examples" / "nile.csv"


@dataclass(frozen=True)
class Data:
    """said: where it comes from, one line.  axis, at: what rows are counted by, and T of it.  names, z: T x m.
    regressor_names, regressors: T x n, of a regression"""

    said: str
    axis: str
    at: np.ndarray
    names: tuple[str, ...]
    z: np.ndarray
    regressors: Optional[np.ndarray] = None
    regressor_names: tuple[str, ...] = ()


def _read(path: Path, *names: str) -> list[np.ndarray]:
    block = tables.joined(list(tables.read(path, names)))
    return [block.columns[name] for name in names]


def source_of(path: Path) -> str:
    """The comment above the header, on one line"""
    lines = path.read_text(encoding="utf-8").splitlines()
    return " ".join(line[1:].strip() for line in lines if line.startswith("#"))


def nile() -> Data:
    year, flow = _read(NILE, "year", "flow")
    return Data(source_of(NILE), "year", year, ("flow",), flow[:, None])


def co2() -> Data:
    at, value = _from_rows(HERE / "co2.csv", "year", MONTHS, np.arange(12) / 12)
    return Data(source_of(HERE / "co2.csv"), "year", at, ("co2",), value[:, None])


def _from_rows(path: Path, name: str, columns: Sequence[str], after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of a file with several values a row: each so long after what its row is called"""
    at, *values = _read(path, name, *columns)
    value = np.ravel(np.column_stack(values))
    first, last = np.flatnonzero(np.isfinite(value))[[0, -1]]
    return np.ravel(at[:, None] + after)[first : last + 1], value[first : last + 1]


def sunspots() -> Data:
    path = HERE / "sunspots.csv"
    year, number = _from_rows(path, "decade", [str(k) for k in range(10)], np.arange(10))
    said = f"{source_of(path)} Here: less their mean, {number.mean():.4f}."
    return Data(said, "year", year, ("sunspots",), (number - number.mean())[:, None])


def _macro(*names: str) -> tuple[str, np.ndarray, list[np.ndarray]]:
    path = HERE / "us_macro.csv"
    quarter, *columns = _read(path, "quarter", *names)
    return source_of(path), quarter, columns


def income() -> Data:
    said, quarter, (value,) = _macro("income")
    return Data(f"{said} Here: 100 times the logarithm of income.", "year", quarter, ("income",),
                100 * np.log(value)[:, None])


def inflation() -> Data:
    said, quarter, (value,) = _macro("inflation")
    return Data(f"{said} Here: inflation less its mean, {value.mean():.4f}.", "year", quarter, ("inflation",),
                (value - value.mean())[:, None])


def growth() -> Data:
    """100 times the change of the logarithm, less its mean, over its standard deviation"""
    names = ("income", "consumption", "investment")
    said, quarter, columns = _macro(*names)
    change = 100 * np.diff(np.log(columns), axis=1).T
    z = (change - change.mean(axis=0)) / change.std(axis=0)
    return Data(f"{said} Here: growth, 100 times the change of the logarithm, less its mean, over its standard "
                "deviation.", "year", quarter[1:], names, z)


def consumption() -> Data:
    """Growth of consumption on a constant and growth of income, percent a quarter"""
    said, quarter, columns = _macro("consumption", "income")
    change = 100 * np.diff(np.log(columns), axis=1)
    regressors = np.column_stack([np.ones(len(change[1])), change[1]])
    return Data(f"{said} Here: growth, 100 times the change of the logarithm.", "year", quarter[1:], ("consumption",),
                change[0][:, None], regressors, ("constant", "income"))


def drawn(builder: str, rows: int, seed: int, names: tuple[str, ...], **parameters: Any) -> Data:
    truth = Model.of(**build(builder, arrays(parameters)))
    _, z = simulate(truth, rows, seed)
    text = ", ".join(f"{key} = {np.asarray(value).tolist()}" for key, value in parameters.items())
    return Data(f"Simulated: {builder}, {text}; seed {seed}.", "row", np.arange(rows, dtype=float), names, z)


def arrays(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """As a model file gives them to a builder"""
    return {key: np.array(value, float) if isinstance(value, (list, tuple)) else value
            for key, value in parameters.items()}
