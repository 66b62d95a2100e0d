"""What comes in: rows of measurements and controls as arrays, lists or tables of pandas; their times, their matrices."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.data.dates import counts_rows, in_index, numbers_from, warn_of_steps
from kalmanq.data.layouts import Source
from kalmanq.data.times import time_column
from kalmanq.errors import KalmanqError
from kalmanq.model import ColumnModel, Model, Quantity
from kalmanq.model.arrays import by_name, numbers_of

LONGEST = 100_000  # steps of dt between two rows, that are gone one by one


@dataclass(frozen=True)
class Varying:
    """Matrices that are others at each row; what is None is the model's.  One axis less where a matrix has one row or one column.

    Parameters
    ----------
    A, B, Q : T x n x n, T x n x l (an offset c its last column), T x n x n or T x n variances: of the step from row t to row t + 1;
        the last one leads to the first row of the next call
    H, R, D : T x m x n, T x m x m or T x m variances, T x m x l without an offset: of the measurements of row t

    Raises
    ------
    KalmanqError
        from `run`: a shape that does not fit, an entry that is not finite

    Examples
    --------
    >>> f = kalmanq.Filter(kalmanq.Model([1], H=[1], R=1, Q=1, P0=1))
    >>> f.run([1.0, 1.0], varying=kalmanq.Varying(R=[1, 1e6])).mean.round(3).ravel()    # the second one says little
    array([0.5, 0.5])
    """

    A: Optional[ArrayLike] = None
    B: Optional[ArrayLike] = None
    Q: Optional[ArrayLike] = None
    H: Optional[ArrayLike] = None
    R: Optional[ArrayLike] = None
    D: Optional[ArrayLike] = None


Varying.__init__ = by_name("Varying(A=..., B=..., Q=..., H=..., R=..., D=...)", 0)(Varying.__init__)  # type: ignore[method-assign]


@dataclass(frozen=True)
class Rows:
    """T rows that have been looked at: z (T x m; NaN: missing), u (T x l, or None), times (T, or None), and by name the
    matrices that vary (T x ...).  index: of the table that z or u was; origin: the date that times are counted from, if any;
    fed: D u (T x m), which is in z and not in what a filter takes"""

    z: np.ndarray
    u: Optional[np.ndarray] = None
    times: Optional[np.ndarray] = None
    matrices: Mapping[str, np.ndarray] = field(default_factory=dict)
    index: Optional[Any] = None
    origin: Optional[np.datetime64] = None
    fed: Optional[np.ndarray] = None

    @classmethod
    def of(cls, model: Model, z: Any, u: Any = None, times: Any = None, varying: Optional[Varying] = None,
           origin: Optional[np.datetime64] = None) -> Rows:
        """Rows stay as they are.  origin: of rows before"""
        if isinstance(z, cls):
            return z
        made, index = rows_of(z, model.measurements, "z"), index_of(z, u)
        if times is None and index is not None and not _moves(varying):
            times = times_in(model, z, u)
        at, begun = (None, None) if times is None else times_of(times, model, len(made), varying, origin)
        matrices = {} if varying is None else _matrices_of(varying, model, len(made))
        if isinstance(model, ColumnModel):
            u, own = _columns_apart(u, z, model, made)
            matrices = {**own, **matrices}
        if u is None and (getattr(model, "D", None) is not None or "D" in matrices) and np.isfinite(made).any():
            raise KalmanqError("u is left out, and the measurements have a part of it, D u: give u, 0 where there is none")
        u = controls_of(u, model, len(made))
        fed = _fed(model, u, matrices)
        return cls(made, u, at, matrices, index, begun, fed)

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, rows: slice) -> Rows:
        z, u, times, fed = (None if one is None else one[rows] for one in (self.z, self.u, self.times, self.fed))
        return replace(self, z=z, u=u, times=times, fed=fed, matrices={name: one[rows] for name, one in self.matrices.items()})

    @property
    def net(self) -> np.ndarray:
        """z - D u, as a filter takes it"""
        return self.z if self.fed is None else self.z - self.fed

    @property
    def is_varying(self) -> bool:
        return self.times is not None or bool(self.matrices)


def _moves(varying: Optional[Varying]) -> bool:
    """Are there other steps than the model's?"""
    return varying is not None and any(getattr(varying, name) is not None for name in "ABQ")


def times_in(model: Any, z: Any, u: Any) -> Optional[Any]:
    """What the table that z or u is says of when its rows are.  None: they are steps, and where these are not alike that is warned of"""
    of, name = getattr(model, "continuous", None), "z" if is_table(z) else "u"
    is_timed = of is not None or getattr(model, "reads_times", False)
    index, what = _clock_of(z if is_table(z) else u, model, is_timed)
    if is_timed:
        unit, dt = (of.seconds, of.dt) if of else (1.0, model.dt)
        made = in_index(index, unit, dt, name, what)
        try:
            if made is not None:
                at, _ = rising(made, len(index), unit, repeats=of is not None or model.has_empty_steps)
                if len(at) > 1 and at[0] == at[-1]:
                    raise KalmanqError("all rows have one time", row=1)
        except KalmanqError as problem:
            raise KalmanqError(f"the {what} of {name}: {problem.text}; or give times=, or {name}.to_numpy()", row=problem.row) from problem
        return made
    warn_of_steps(index, name, what, "a model in continuous time takes them as they are: Model.of_continuous" if isinstance(model, Model) else
                  "functions of dt take them as they are: f(x, t, u, dt)")
    return None


def _clock_of(table: Any, model: Any, is_timed: bool) -> tuple[Any, str]:
    """The index of a table or, where that counts rows, the column that is called as one of times; and how messages call it"""
    columns = list(getattr(table, "columns", ()))
    if not columns or not counts_rows(table.index):
        return table.index, "index"
    names = [one.name for one in (*model.measurements, *model.inputs)]
    place = time_column(Source(Path()), list(map(str, columns)), [columns.index(one) for one in names if one in columns], () if is_timed else names)
    return (table.index, "index") if place is None else (table.iloc[:, place], f"column {columns[place]}")


def times_of(given: Any, model: Model, rows: int, varying: Optional[Varying] = None,
             origin: Optional[np.datetime64] = None) -> tuple[np.ndarray, Optional[np.datetime64]]:
    """The time of each row, in the unit of dt, rising; and the date that it is counted from, if it is one"""
    if getattr(model, "continuous", None) is None:
        raise KalmanqError("times: the model is of steps that are all alike: give F, Qc and dt (Model.of_continuous)")
    if _moves(varying):
        raise KalmanqError("times: the times make A, B and Q, so these cannot vary otherwise")
    return rising(given, rows, model.continuous.seconds, origin)


def rising(given: Any, rows: int, unit: float = 1.0, origin: Optional[np.datetime64] = None, repeats: bool = True
           ) -> tuple[np.ndarray, Optional[np.datetime64]]:
    """Times as numbers of units of so many seconds, each after the one before, or if it may repeat, not before it; and the date that they are
    counted from, if any"""
    made, begun = numbers_from(given, unit, origin)
    if made.shape != (rows,):
        raise KalmanqError(f"times are {shape_of(made)}, not {rows}")
    if not np.all(np.isfinite(made)):
        raise KalmanqError("the time is missing: leave the row out, or fill it in", row=int(np.argmin(np.isfinite(made))))
    refuse_back(np.diff(made), repeats, 1)
    return made, begun


def refuse_back(steps: np.ndarray, repeats: bool, first: int = 0) -> None:
    """first: the row that the first of these steps leads to"""
    back = steps < 0 if repeats else steps <= 0
    if np.any(back):
        raise KalmanqError("the time is before the row before: sort the rows" if repeats else
                           "the time is not after the one before: sort the rows, and join rows of one time", row=int(np.argmax(back)) + first)


def require_one_origin(before: Optional[np.datetime64], now: Optional[np.datetime64]) -> None:
    """Of rows that follow rows with times"""
    if (before is None) != (now is None):
        raise KalmanqError(f"times: {'numbers' if now is None else 'dates'}, the rows before had {'numbers' if before is None else 'dates'}")


def require_steps(model: Model, times: Optional[np.ndarray], what: str, cure: str) -> None:
    """Of what runs steps of dt alone"""
    whole_steps(model, times, what, cure, 1)


def whole_steps(model: Model, times: Optional[np.ndarray], what: str, cure: str, most: int = LONGEST) -> Optional[np.ndarray]:
    """How many steps of dt are between rows, of what has no others; None where rows have no times"""
    if times is None or model.continuous is None:
        return None
    steps, dt = model.continuous.between(times), model.continuous.dt
    count = np.maximum(np.round(steps / dt), 1)
    wrong = (steps != count * dt) | (count > most)
    if np.any(wrong):
        at = int(np.argmax(wrong))
        said = "none, join rows of one time" if steps[at] == 0 else "not one" if most == 1 else f"not 1 to {most} of them"
        raise KalmanqError(f"{what}: a filter of steps of dt = {dt:g} alone, and the step from {times[at]:g} to {times[at + 1]:g} {model.continuous.unit} "
                           f"is {said}: {cure}")
    return count.astype(int)


def _matrices_of(varying: Varying, model: Model, rows: int) -> dict[str, np.ndarray]:
    for name in "BD":
        if getattr(varying, name) is not None and not (model.l if name == "B" else _own(model)):
            raise KalmanqError(f"{name}: the model has no controls")
    n, m, l = model.n, model.m, model.l
    shapes = {"A": (n, n), "B": (n, l), "Q": (n, n), "H": (m, n), "R": (m, m), "D": (m, len(_own(model)))}
    return {name: _matrix_a_row(name, getattr(varying, name), rows, shape) for name, shape in shapes.items()
            if getattr(varying, name) is not None}


def _own(model: Any) -> tuple[Quantity, ...]:
    """Controls that are given, without columns"""
    return tuple(one for one in model.controls if not one.constant)


def _columns_apart(u: Any, z: Any, model: ColumnModel, made: np.ndarray) -> tuple[Optional[np.ndarray], dict[str, np.ndarray]]:
    """The controls alone, and what the columns make.  They are in u, or in the table that z is"""
    given = z if u is None and is_table(z) and hasattr(z, "columns") else u
    if given is None:
        raise KalmanqError(f"u is missing: {', '.join(one.name for one in model.inputs)}")
    inputs = rows_of(given, model.inputs, "u")
    if len(inputs) != len(made):
        raise KalmanqError(f"u has {len(inputs)} rows, z has {len(made)}")
    count = len(_own(model))
    return inputs[:, :count] if count else None, model.matrices(inputs, made)


def _fed(model: Any, u: Optional[np.ndarray], matrices: dict[str, np.ndarray]) -> Optional[np.ndarray]:
    """D u, and d where it is from columns; `matrices` loses them"""
    D, d = matrices.pop("D", getattr(model, "D", None)), matrices.pop("d", None)
    if D is None or u is None:
        return d
    through = (D @ u[:, : D.shape[-1], None])[..., 0]
    return through if d is None else through + d


def _matrix_a_row(name: str, given: ArrayLike, rows: int, shape: tuple[int, int]) -> np.ndarray:
    try:
        made = numbers_of(given)
    except (TypeError, ValueError, OverflowError) as problem:
        raise KalmanqError(f"{name}: not an array of numbers{told(problem)}") from problem
    if shape == (1, 1) and made.shape == (rows,) or 1 in shape and made.shape == (rows, max(shape)):
        made = made.reshape(rows, *shape)
    elif name in "QR" and made.shape == (rows, shape[0]):
        made = made[:, :, None] * np.eye(shape[0])
    if made.shape != (rows, *shape):
        raise KalmanqError(f"{name} is {shape_of(made)}, not {rows} x {shape[0]} x {shape[1]}")
    if not np.all(np.isfinite(made)):
        raise KalmanqError(f"{name} has an entry that is not finite", row=int(np.argwhere(~np.isfinite(made))[0][0]))
    return np.ascontiguousarray(made)


def shape_of(array: np.ndarray) -> str:
    return " x ".join(map(str, array.shape)) if array.ndim else "a number"


def rows_of(given: Any, quantities: Sequence[Quantity], name: str) -> np.ndarray:
    """T x k of float64: a flat array where k = 1; of a DataFrame the columns with the quantities' names."""
    columns = len(quantities)
    try:
        array = numbers_of(_values(given, quantities, name))
    except (TypeError, ValueError, OverflowError) as problem:
        raise KalmanqError(f"{name}: not an array of numbers{told(problem)}") from problem
    if array.ndim == 1 and columns == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2 or array.shape[1] != columns:
        raise KalmanqError(f"{name} is {shape_of(array)}, not T x {columns}")
    return np.ascontiguousarray(array)


def controls_of(u: Any, model: Model, rows: int) -> Optional[np.ndarray]:
    """A row for each row of z."""
    if getattr(model, "c", None) is not None:
        return _with_one(u, model, rows)
    if u is None:
        return None
    made = rows_of(u, model.controls, "u")
    if len(made) != rows:
        raise KalmanqError(f"u has {len(made)} rows, z has {rows}")
    return made


def _with_one(u: Any, model: Model, rows: int) -> np.ndarray:
    """Controls, 0 where none are given, and the 1 of the offset, which may be there already"""
    if isinstance(u, np.ndarray) and u.shape == (rows, model.l) and np.all(u[:, -1] == 1):
        return u
    own = _own(model)
    made = np.zeros((rows, len(own))) if u is None else rows_of(u, own, "u")
    if len(made) != rows:
        raise KalmanqError(f"u has {len(made)} rows, z has {rows}")
    return np.column_stack([made, np.ones(rows)])


def _values(given: Any, quantities: Sequence[Quantity], name: str) -> Any:
    if not is_table(given):
        return given
    if hasattr(given, "columns"):
        wanted, there = [one.name for one in quantities], list(given.columns)
        for one in wanted:
            if there.count(one) != 1:
                reason = f"the column {one} is there twice" if one in there else \
                    f"there is no column {one}; there are {', '.join(map(str, there))}"
                raise KalmanqError(f"{name}: {reason}")
        given = given[wanted]
    if _is_complex(given):
        return given.to_numpy()
    # what pandas calls missing is no float by itself
    return given.to_numpy(dtype=np.float64, na_value=np.nan)


def _is_complex(table: Any) -> bool:
    """pandas leaves imaginary parts out without an error"""
    columns = [table[name] for name in table.columns] if hasattr(table, "columns") else [table]
    return any(getattr(one.dtype, "kind", "") == "c" or one.dtype == object and any(
        isinstance(value, (complex, np.complexfloating)) for value in one) for one in columns)


def told(problem: Exception) -> str:
    """Of what numbers_of refuses"""
    return f" ({problem})" if "complex" in str(problem) else ""


def is_table(given: Any) -> bool:
    """A DataFrame or a Series?  A list has an `index`, too, which is another thing."""
    return hasattr(given, "to_numpy") and hasattr(given, "index")


def index_of(z: Any, u: Any = None) -> Optional[Any]:
    """Of the table that there is; two tables have to agree."""
    tables = [one for one in (z, u) if is_table(one)]
    if len(tables) == 2 and not tables[0].index.equals(tables[1].index):
        raise KalmanqError("z and u have different indices")
    return tables[0].index if tables else None


def present_of(z: np.ndarray) -> np.ndarray:
    """A mask for each row: bit c where component c is there."""
    bits = np.uint32(1) << np.arange(z.shape[1], dtype=np.uint32)
    return ((~np.isnan(z)) * bits).sum(axis=1, dtype=np.uint32)


def row_of(given: ArrayLike, size: int, name: str) -> np.ndarray:
    if is_table(given) and size > 1 and any(isinstance(one, str) for one in given.index):  # type: ignore[union-attr]
        raise KalmanqError(f"{name} is a row of a table, whose names are not looked at here: give {name}[[...]].to_numpy() in the model's order, or the table to run")
    try:
        row = np.atleast_1d(numbers_of(given))
    except (TypeError, ValueError, OverflowError) as problem:
        raise KalmanqError(f"{name}: not an array of numbers{told(problem)}") from problem
    if row.shape != (size,):
        raise KalmanqError(f"{name} is {row.shape}, not {size} numbers")
    return row.reshape(1, size)
