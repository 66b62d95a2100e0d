"""A filter's object in C, and what can be read of it, alone or at every row of a run."""

from __future__ import annotations

import warnings
from typing import Any, Optional

import numpy as np

from kalmanq.core import ffi, lib, require
from kalmanq.errors import KalmanqWarning
from kalmanq.model.spellings import OfModel
from kalmanq.run.parts import Parts
from kalmanq.run.results import Run


class Readable(OfModel):
    """A filter of the C core with its memory.  Readings are float64."""

    def __init__(self, model: Any, parts: Parts):
        self.model, self.parts, self.arithmetic = model, parts, parts.arithmetic
        self.coarse = ""  # what is said of measurements that are coarse beside their noise (resolution.py)
        self._kept: list[Any] = []  # what C refers to
        self._widest = np.zeros(model.n)  # q31: each state's largest variance before an update, in words
        self._is_wide = np.zeros(model.n, bool)  # those that were warned of
        self._handle = self.arithmetic.struct("filter")
        self._memory = self.arithmetic.empty(self.arithmetic.length("filter", model.n))
        require(self._call("filter_assign", model.n, self._pointer(self._memory), self._memory.size), "filter")

    @property
    def mean(self) -> np.ndarray:
        made = self._words("mean")
        return self._values(made, self._words("mean_low"))

    @property
    def sigma(self) -> np.ndarray:
        made = self._values(self._words("sigma"))
        if not self.arithmetic.is_fixed:
            return made
        exact = np.sqrt(np.diag(self.covariance))  # a word ends at the range, and is coarse near 0
        return np.where(np.isnan(exact), made, exact)

    @property
    def covariance(self) -> np.ndarray:
        n, a = self.model.n, self.arithmetic
        made = np.zeros((n, n), a.number_of_any_size)
        status = self._call("covariance", self._pointer(made, self._any_size))
        if status == lib.KQ_ERR_NOT_READY:  # of a start that is in part unknown so far
            return np.full((n, n), np.nan)
        require(status, "covariance")
        return a.numbers(made, self.parts.covariance_scale)

    @property
    def log_likelihood(self) -> float:
        """Of all rows so far."""
        return float(self.arithmetic.scores(np.array([self._call("log_likelihood")], self.arithmetic.score))[0])

    @property
    def nis(self) -> float:
        return float(self.arithmetic.scores(np.array([self._call("nis")], self.arithmetic.score))[0])

    @property
    def taken(self) -> int:
        return int(self._call("taken"))

    @property
    def events(self) -> int:
        return int(self._call("events"))

    def clear_events(self) -> None:
        self._call("events_clear")

    @property
    def memory(self) -> np.ndarray:
        """The words of mean and root, as the chip has them."""
        return self._memory.copy()

    def read_smoothed(self, run: Run, what: str, source: Any, covariance: bool, means_only: bool = False,
                      first: int = 0) -> None:
        """Into `run`: its rows of a history, or of a start, that has been smoothed; its first one is row `first`."""
        a, n, T = self.arithmetic, self.model.n, len(run)
        mean, low, sigma = (np.zeros((T, n), a.number) for _ in range(3))
        full = np.zeros((T, n, n), a.number_of_any_size) if covariance and not means_only else None
        variance = None if means_only else self._variances_of_any_size(T)
        require(a.function(f"{what}_read")(source, first, T, *map(self._pointer, (mean, low, sigma)),
                                           self._pointer(variance, self._any_size),
                                           self._pointer(full, self._any_size)), "smoother")
        run.smoothed = self._values(mean, low)
        run.smoothed_sigma = None if means_only else self._sigmas(sigma, variance)
        run.smoothed_covariance = None if full is None else a.numbers(full, self.parts.covariance_scale)
        run.words.update(smoothed=mean, smoothed_low=low, smoothed_sigma=sigma)

    def smoothing_events(self, history: Any) -> int:
        view = self.arithmetic.struct("filter")
        self.arithmetic.function("smoothed")(history, 0, view)
        return int(self.arithmetic.function("events")(view))

    def warn_of_wide(self) -> None:
        """A state that may be anywhere is hardly within the range that its word has."""
        if not self.arithmetic.is_fixed:
            return
        sigma = np.ldexp(np.sqrt(self._widest), -np.array(self.parts.fractions("states")))
        for i, state in enumerate(self.model.states):
            if state.range is not None and sigma[i] > state.range and not self._is_wide[i]:
                self._is_wide[i] = True
                warnings.warn(f"{self.model.name}, q31: before a measurement the sigma of {state.name} is {sigma[i]:.3g}, "
                              f"beyond its declared range of {state.range:g}: raise the range, or lower P0",
                              KalmanqWarning, stacklevel=3)

    def _tell(self, run: Run, out: Results) -> None:
        """What is told of a run beside the filter's results."""

    @property
    def _any_size(self) -> str:
        return "kq_scaled_q31" if self.arithmetic.is_fixed else ""

    def _call(self, stem: str, *arguments: Any) -> Any:
        return self.arithmetic.function(stem)(self._handle, *arguments)

    def _pointer(self, array: Optional[np.ndarray], kind: str = "") -> Any:
        return self.arithmetic.pointer(array, kind)

    def _scores(self, array: np.ndarray) -> Any:
        return self._pointer(array, "int64_t" if self.arithmetic.is_fixed else "")

    def _object(self, stem: str, *assign: Any, sizes: tuple[int, ...]) -> Any:
        made = self.arithmetic.struct(stem)
        memory = self._space(stem, self.arithmetic.length(stem, *sizes))
        status = self.arithmetic.function(f"{stem}_assign")(made, *assign, self._pointer(memory), memory.size)
        require(status, stem)
        self._kept.append(memory)
        return made

    def _attach(self, thing: Any, what: str) -> None:
        require(self.arithmetic.function("attach")(self._handle, ffi.addressof(thing[0], "attached")), what)

    def _space(self, stem: str, length: int) -> np.ndarray:
        return self.arithmetic.empty(length)

    def _words(self, name: str, source: Any = None) -> np.ndarray:
        """A reading of every state, of the filter or of a view"""
        read, source = self.arithmetic.function(name), source or self._handle
        return np.array([read(source, i) for i in range(self.model.n)], self.arithmetic.number)

    def _values(self, words: np.ndarray, low: Optional[np.ndarray] = None) -> np.ndarray:
        return self.arithmetic.values(words, self.parts.fractions("states"), low)

    def _variances_of_any_size(self, rows: int) -> Optional[np.ndarray]:
        """Where C writes the variances that words of sigma cannot say; None: they say them"""
        if not self.arithmetic.is_fixed:
            return None
        return np.zeros((rows, self.model.n), self.arithmetic.number_of_any_size)

    def _sigmas(self, words: np.ndarray, variance: Optional[np.ndarray]) -> np.ndarray:
        """Those of the variances, where there are any; otherwise those of the words"""
        made = self._values(words)
        if variance is None:
            return made
        exact = np.sqrt(self.arithmetic.numbers(variance, 2 * np.array(self.parts.fractions("states"))))
        return np.where(np.isnan(exact), made, exact)


class Results:
    """The arrays that C writes, and the Run that is made of them."""

    def __init__(self, filter_: Readable, T: int, covariance: bool):
        a, n, m = filter_.arithmetic, filter_.model.n, filter_.model.m
        self.filter = filter_
        names = ("mean", "mean_low", "sigma") if a.has_low_words else ("mean", "sigma")
        self.numbers = {name: np.zeros((T, n), a.number) for name in names}
        self.numbers["innovation"] = np.zeros((T, m), a.number)
        self.any_size = {"innovation_variance": np.zeros((T, m), a.number_of_any_size)}
        variance = filter_._variances_of_any_size(T)
        if variance is not None:
            self.any_size["variance"] = variance
        if covariance:
            self.any_size["covariance"] = np.zeros((T, n, n), a.number_of_any_size)
        self.scores = {name: np.zeros(T, a.score) for name in ("nis", "log_likelihood")}
        self.taken = np.zeros(T, np.int32)
        self.settled: Optional[np.ndarray] = None

    def add_states(self, name: str, mean: str) -> None:
        """Room for more of the states at every row: `mean`, NAME_low, NAME_sigma and what words of sigma cannot say"""
        f, T = self.filter, len(self.taken)
        for words in (mean, f"{name}_low", f"{name}_sigma"):
            self.numbers[words] = np.zeros((T, f.model.n), f.arithmetic.number)
        if f.arithmetic.is_fixed:
            self.any_size[f"{name}_variance"] = f._variances_of_any_size(T)

    def states(self, name: str, mean: str) -> tuple[np.ndarray, np.ndarray]:
        """Those that add_states has made room for: their values and sigmas"""
        f, words = self.filter, self.numbers
        return (f._values(words[mean], words[f"{name}_low"]),
                f._sigmas(words[f"{name}_sigma"], self.any_size.get(f"{name}_variance")))

    def ask(self, q: Any) -> None:
        """By the names of the fields of a kq_sequence"""
        a = self.filter.arithmetic
        for name, array in self.numbers.items():
            setattr(q, name, a.pointer(array))
        for name, array in self.any_size.items():
            setattr(q, name, a.pointer(array, self.filter._any_size))
        for name, array in self.scores.items():
            setattr(q, name, self.filter._scores(array))
        q.taken = a.pointer(self.taken, "int32_t")

    def run(self) -> Run:
        f, a, words = self.filter, self.filter.arithmetic, self.numbers
        states, measured = f.parts.fractions("states"), np.array(f.parts.fractions("measurements"))
        variance = a.numbers(self.any_size["innovation_variance"], 2 * measured)
        made = Run(
            f.model, a.name, mean=a.values(words["mean"], states, words.get("mean_low")),
            sigma=f._sigmas(words["sigma"], self.any_size.get("variance")), innovation=a.values(words["innovation"], measured),
            innovation_sigma=np.sqrt(variance, out=variance),
            nis=a.scores(self.scores["nis"]), taken=self.taken,
            log_likelihood=a.scores(self.scores["log_likelihood"]), events=f.events,
            words={**words, **self.scores})
        if "covariance" in self.any_size:
            made.covariance = a.numbers(self.any_size["covariance"], f.parts.covariance_scale)
        f._tell(made, self)
        return made
