"""Is a filter consistent with its measurements?  And least squares, the filter without a process."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from kalmanq.core import arithmetic_of, ffi, require
from kalmanq.data.rows import index_of, row_of, rows_of
from kalmanq.errors import KalmanqError
from kalmanq.model import Model, Quantities, Quantity
from kalmanq.model.arrays import by_name
from kalmanq.model.spellings import require_model
from kalmanq.run.filters import Filter
from kalmanq.run.readings import Results
from kalmanq.run.results import Run


class Consistency:
    """Statistics of the last `window` updates (consistency.h): normalised innovation squared, mean and whiteness.

    `quantile` of its methods: of the normal distribution, for two-sided bounds: 1.96 for 95 %, 2.576 for 99 %.

    Parameters
    ----------
    model : Model, of the filter that is watched
    window : updates, in the order of their calls of `run` and `update`; those that took nothing do not count
    arithmetic : that of the filter

    Raises
    ------
    KalmanqError
        a filter of another arithmetic or with other components

    Examples
    --------
    >>> model = kalmanq.Model([1], H=[1], R=1, Q=1, P0=1)
    >>> watch = kalmanq.Consistency(model, 100)
    >>> run = kalmanq.Filter(model).run(np.random.default_rng(0).normal(size=100).cumsum(), watch=watch)
    >>> nis, low, high = watch.nis()
    >>> len(watch), bool(nis < low)     # 1 if the model is right: these measurements have no noise
    (100, True)
    """

    def __init__(self, model: Model, window: int = 100, arithmetic: str = "f64"):
        require_model(model, Model, "its frame is one")
        self.model, self.window, self.arithmetic = model, window, arithmetic_of(arithmetic)
        a = self.arithmetic
        self._handle = a.struct("consistency")
        self._memory = a.empty(int(a.length("consistency", model.m, window)))
        require(a.function("consistency_assign")(self._handle, model.m, window, a.pointer(self._memory),
                                                 self._memory.size), "window")

    def __len__(self) -> int:
        """Updates in the window."""
        return int(self.arithmetic.function("consistency_count")(self._handle))

    def clear(self) -> None:
        require(self.arithmetic.function("consistency_clear")(self._handle), "window")

    def nis(self, quantile: float = 1.96) -> tuple[float, float, float]:
        """Mean NIS per degree of freedom, which is 1 but for chance, and its bounds, low and high."""
        return self._ask("nis", quantile, 3)

    def innovation(self, component: int, quantile: float = 1.96) -> tuple[float, float, float, float]:
        """Of a component's innovations over their sigma: mean, its bound, lag-one correlation, its bound."""
        return self._ask("innovation", quantile, 4, component)

    def _ask(self, what: str, quantile: float, count: int, *which: int) -> Any:
        a = self.arithmetic
        made = np.zeros(count, a.score)
        kind = "int64_t *" if a.is_fixed else {"f32": "float *", "f64": "double *"}[a.name]
        out = [ffi.cast(kind, made.ctypes.data + k * made.itemsize) for k in range(count)]
        given = round(quantile * 2**24) if a.is_fixed else quantile
        require(a.function(f"consistency_{what}")(self._handle, *which, given, *out), "window")
        return tuple(map(float, a.scores(made)))

    def of(self, filter_: Filter) -> Any:
        """The C object, for a filter that it can watch."""
        if filter_.arithmetic is not self.arithmetic:
            raise KalmanqError(f"the window is in {self.arithmetic}, the filter in {filter_.arithmetic}")
        if filter_.model.m != self.model.m:
            raise KalmanqError(f"the window is of {self.model.m} components, the filter's rows of {filter_.model.m}")
        return self._handle


class LeastSquares:
    """Least squares of z = h x + v, v ~ N(0, r), from a prior, with or without forgetting (least_squares.h).

    `filter` is the filter that does it: mean, sigma, covariance, memory, events.  KalmanqError: rows that do not fit.

    Parameters
    ----------
    x0 : n, mean of the prior
    P0 : n x n, or n variances
    arithmetic : "f64", "f32" or "q31"
    forgetting : lambda: 0 < lambda <= 1, what is k rows old weighs lambda^k
    states, measurement : names, units and ranges; fixed point needs them

    Examples
    --------
    >>> t = np.arange(5.0)
    >>> fit = kalmanq.LeastSquares(x0=[0, 0], P0=[1e4, 1e4])
    >>> run = fit.run(H=np.column_stack([np.ones(5), t]), z=3 + 2 * t, r=0.04)
    >>> run.mean[-1].round(3)
    array([3., 2.])
    """

    @by_name("LeastSquares(x0=..., P0=..., arithmetic=...)", 0)
    def __init__(self, *, x0: ArrayLike, P0: ArrayLike, arithmetic: str = "f64", forgetting: float = 1.0,
                 states: Quantities = None, measurement: Quantity = Quantity("z")):
        n = np.size(x0)
        self.model = Model(np.eye(n), H=np.zeros((1, n)), R=1.0, Q=np.zeros(n), x0=np.ravel(x0), P0=P0, states=states,
                           measurements=[measurement], name="least squares")
        self.filter = Filter(self.model, arithmetic)
        self.arithmetic = a = self.filter.arithmetic
        self._handle = a.struct("least_squares")
        formats = [self.filter.parts.formats["measurements"]] if a.is_fixed else []
        require(a.function("least_squares_init")(self._handle, self.filter._handle, a.parameter(forgetting), *formats),
                "forgetting")

    @by_name("run(H=..., z=..., r=...)", 0)
    def run(self, *, H: ArrayLike, z: ArrayLike, r: ArrayLike = 1.0) -> Run:
        """T rows in one call of C, which may be called again for more.

        H   T x n, or T where n = 1
        z   T
        r   T variances, or one; 1 / r is the weight
        """
        a, f = self.arithmetic, self.filter
        given, rows = rows_of(z, self.model.measurements, "z"), rows_of(H, self.model.states, "H")
        if len(rows) != len(given) or np.ndim(r) and np.shape(r) != (len(given),):
            raise KalmanqError(f"H is {len(rows)} rows, z {len(given)}, r {np.shape(r)}: one for each row")
        noise = np.broadcast_to(row_of(r, np.size(r), "r")[0] if np.ndim(r) else float(r), len(given))
        if not all(np.all(np.isfinite(one)) for one in (rows, given, noise)):
            raise KalmanqError("H, z or r has an entry that is not finite")
        words = np.ascontiguousarray(f.parts.words(given, "measurements"))
        own, states = f.parts.fractions("measurements")[0], np.array(f.parts.fractions("states"))
        coefficients, variances = a.made_of(rows, own - states), a.made_of(noise, 2 * own)
        out, done = Results(f, len(given), False), ffi.new("size_t *")
        results = [f._pointer(out.numbers.get(name)) for name in ("mean", "mean_low", "sigma")]
        results += [f._pointer(out.any_size.get("variance"), f._any_size)]
        results += [f._scores(out.scores[name]) for name in ("nis", "log_likelihood")]
        status = a.function("least_squares_run")(
            self._handle, len(given), f._pointer(coefficients, f._any_size), f._pointer(words),
            f._pointer(variances, f._any_size), *results, a.pointer(out.taken, "int32_t"), done)
        require(status, "least squares", int(done[0]))
        run = out.run()
        run.innovation = run.innovation_sigma = None  # of no one measurement matrix
        run.index = index_of(z)
        return run

    @property
    def mean(self) -> np.ndarray:
        return self.filter.mean

    @property
    def sigma(self) -> np.ndarray:
        return self.filter.sigma

    @property
    def covariance(self) -> np.ndarray:
        return self.filter.covariance

    @property
    def residual(self) -> float:
        """The minimum: the weighted sum of squared residuals, with the prior's term."""
        return self._score("residual")

    @property
    def weight(self) -> float:
        """The sum of the weights of what was taken; residual / weight estimates an unknown factor of all r."""
        return self._score("weight")

    def _score(self, name: str) -> float:
        made = self.arithmetic.function(f"least_squares_{name}")(self._handle)
        return float(self.arithmetic.scores(np.array([made], self.arithmetic.score))[0])
