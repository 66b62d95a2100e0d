"""What the golden vectors do to a filter one call at a time, done again by the package's classes with a whole
sequence in one call: the conventions of rows, controls and gaps."""

from __future__ import annotations

from typing import Any, Callable, Iterator, NamedTuple, Optional

import numpy as np

import kalmanq
from kalmanq import Filter, LagSmoother, InstantSmoother, Robust, Run, Smoother, SteadyFilter
from kalmanq.core import ARITHMETICS, ffi, lib
from kalmanq.run.filters import LEVELS

NOT_A_VALUE = -(2**31)


class Row(NamedTuple):
    u: Optional[np.ndarray]  # what moved the state to this row
    z: np.ndarray
    way: Optional[Robust]
    expected: list[int]  # of the filter, after the row; empty: not known


class Sequence:
    """Rows from a prior on, for as long as one process and one sensor do what a class does."""

    def __init__(self, model: kalmanq.Model, expected: list[int]):
        self.model = model
        self.make: Callable[[], Any] = lambda: Filter(model, "q31")
        self.rows = [Row(None, self.nothing, None, expected)]
        self.taken = self.ended = self.cleared = self.recorded = False
        self.smoothed: dict[int, list[int]] = {}
        self.smoothed_rows = 0
        self.follower = ""  # a lag or a point, and how long it is or where it is
        self.size = 0
        self.followed: dict[int, list[int]] = {}  # what it says after a row

    @property
    def nothing(self) -> np.ndarray:
        return np.full(self.model.m, np.nan)

    def moved(self, u: Optional[np.ndarray], expected: list[int]) -> None:
        if not self.ended:
            self.rows.append(Row(u, self.nothing, None, expected))
            self.taken = False

    def measured(self, z: np.ndarray, way: Optional[Robust], expected: list[int]) -> None:
        self.ended |= self.taken
        if not self.ended:
            self.rows[-1] = Row(self.rows[-1].u, z, way, expected)
            self.taken = True
            self.followed.pop(len(self.rows) - 1, None)

    def blocks(self) -> Iterator[tuple[Optional[Robust], int, int]]:
        """Way, first row and end of what one call does; rows without a measurement go with those before them."""
        first, way = 0, self.rows[0].way
        for t, row in enumerate(self.rows):
            if row.way != way and not np.all(np.isnan(row.z)):
                if t > first:
                    yield way, first, t
                first, way = t, row.way
        yield way, first, len(self.rows)

    def data(self, first: int, end: int) -> tuple[np.ndarray, Optional[np.ndarray]]:
        """z and u, where row t of u is what moves the state from row t on."""
        z = np.array([row.z for row in self.rows[first:end]])
        if not self.model.l:
            return z, None
        later = [row.u for row in self.rows[first + 1 : end + 1]] + [None]
        return z, np.array([np.zeros(self.model.l) if u is None else u for u in later[: end - first]])

    # ------------------------------------------------------------------ in floating point, by calls of C alone

    def check_floating(self, arithmetic: str) -> int:
        """A class beside the library's functions over the model's arrays; words compared."""
        f = Filter(self.model, arithmetic)
        runs = [f.run(*self.data(first, end), robust=way) for way, first, end in self.blocks()]
        memory, mean, sigma = Calls(self.model, arithmetic).run(self.rows)
        assert f.memory.tobytes() == memory.tobytes()
        for name, made in (("mean", mean), ("sigma", sigma)):
            assert np.array_equal(np.vstack([run.words[name] for run in runs]), made, equal_nan=True)
        return memory.size + mean.size + sigma.size

    # ------------------------------------------------------------------ by the classes

    def check(self) -> int:
        """Words compared."""
        count = self.filtered()
        if self.smoothed and self.recorded:
            count += self.smoothes()
        if self.followed:
            count += self.follows()
        return count

    def kinds(self) -> set[str]:
        """By what it is done"""
        ways = {row.way.way for row in self.rows if row.way}
        smoother = {"Smoother"} if self.smoothed and self.recorded else set()
        follower = {"lag": "LagSmoother", "instant": "InstantSmoother"}
        return {type(self.make()).__name__} | ways | smoother | ({follower[self.follower]} if self.followed else set())

    def filtered(self) -> int:
        f, count = self.make(), 0
        for way, first, end in self.blocks():
            z, u = self.data(first, end)
            # a freeze has one way
            run = f.run(z, u) if way is None else f.run(z, u, robust=way)
            count += sum(self.is_row(run, t, self.rows[first + t]) for t in range(end - first))
        last = self.rows[-1].expected
        if last:
            n = self.model.n
            assert f.memory.tolist() == last[4 + n :]
            assert self.cleared or f.events == last[0]
            count += len(last) - 4 - n
        return count

    def is_row(self, run: Run, t: int, row: Row) -> int:
        if not row.expected:
            return 0
        n = self.model.n
        taken, high, low = row.expected[1:4]
        sigma, mean, rest = (row.expected[4 + k * n : 4 + (k + 1) * n] for k in range(3))
        assert run.words["sigma"][t].tolist() == sigma
        assert whole(run.words["mean"][t], run.words["mean_low"][t]) == whole(mean, rest)
        if np.all(np.isnan(row.z)):
            return 3 * n
        assert run.taken[t] == taken and run.words["nis"][t] == high * 2**32 + (low & 0xFFFFFFFF)
        return 3 * n + 3

    def smoothes(self) -> int:
        run = Smoother(self.model, "q31").run(*self.data(0, self.smoothed_rows))
        for t, words in self.smoothed.items():
            made = [run.words[f"smoothed{part}"][t].tolist() for part in ("", "_low", "_sigma")]
            assert sum(made, [])[: len(words)] == words  # of the means alone there is no sigma
        return sum(len(words) for words in self.smoothed.values())

    def follows(self) -> int:
        """A lag is the longest one; a point is that of its row."""
        if self.follower == "lag":
            run, name = LagSmoother(self.model, self.size, "q31").run(*self.data(0, len(self.rows))), "lagged"
        else:
            run, name = InstantSmoother(self.model, self.size, "q31").run(*self.data(0, len(self.rows))), "instant"
        n = self.model.n
        for t, words in self.followed.items():
            for k, part in enumerate(("", "_low", "_sigma")):
                said = words[k : 3 * n : 3]  # of the means alone there is no sigma
                assert said in (run.words[f"{name}{part}"][t].tolist(), [NOT_A_VALUE] * n)
        return 3 * n * len(self.followed)


class Calls:
    """A filter by the library's functions: nothing of it is the package's but `ffi` and `lib`."""

    def __init__(self, model: kalmanq.Model, arithmetic: str):
        self.model, self.name = model, arithmetic
        self.kind, self.number = {"f32": ("float", np.float32), "f64": ("double", np.float64)}[arithmetic]
        self.kept: list[Any] = []
        n, m, l = model.n, model.m, model.l
        self.process = self.made("process", n, n, l)
        self.sensor, self.filter = self.made("sensor", m, n, m), self.made("filter", n, n)
        B = ffi.NULL if model.B is None else self.array(model.B)
        self.call("process_init_factor", self.process, self.array(model.A), B, self.array(model.G), model.G.shape[1])
        independent = np.array_equal(model.R, np.diag(np.diag(model.R)))
        R = self.array(np.diag(model.R) if independent else model.R)
        self.call("sensor_init_diagonal" if independent else "sensor_init", self.sensor, self.array(model.H), R)
        x0, P0 = self.array(model.x0), self.array(model.P0)
        if np.any(model.unknown):
            start = self.new("diffuse")
            self.call("diffuse_assign", start, n, 0, *self.memory("diffuse", n, 0))
            mask = sum(1 << int(i) for i in np.flatnonzero(model.unknown))
            self.call("diffuse_init", start, self.filter, x0, P0, mask)
        else:
            self.call("filter_init", self.filter, x0, P0)
        self.losses: dict[str, Any] = {}

    def call(self, stem: str, *arguments: Any) -> Any:
        status = getattr(lib, f"kq_{stem}_{self.name}")(*arguments)
        assert status == 0, f"{stem}: {status}"

    def read(self, stem: str) -> list[float]:
        return [getattr(lib, f"kq_{stem}_{self.name}")(self.filter, i) for i in range(self.model.n)]

    def new(self, stem: str) -> Any:
        self.kept.append(ffi.new(f"kq_{stem}_{self.name} *"))
        return self.kept[-1]

    def array(self, values: Any) -> Any:
        self.kept.append(np.ascontiguousarray(values, self.number))
        return ffi.cast(f"{self.kind} *", self.kept[-1].ctypes.data)

    def memory(self, stem: str, *sizes: int) -> tuple[Any, int]:
        length = ARITHMETICS[self.name].length(stem, *sizes)
        return self.array(np.zeros(length)), length

    def made(self, stem: str, size: int, *sizes: int) -> Any:
        thing = self.new(stem)
        self.call(f"{stem}_assign", thing, *sizes, *self.memory(stem, size))
        if stem == "filter":
            self.words = self.kept[-1]
        return thing

    def run(self, rows: list[Row]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        mean, sigma = [], []
        for t, row in enumerate(rows):
            there = ~np.isnan(row.z)
            if t:
                self.call("predict", self.filter, self.process, ffi.NULL if row.u is None else self.array(row.u))
            if np.any(there):
                self.take(row, self.array(np.where(there, row.z, 7.0)), sum(1 << int(c) for c in np.flatnonzero(there)))
            mean.append(self.read("mean")), sigma.append(self.read("sigma"))
        return self.words, np.array(mean, self.number), np.array(sigma, self.number)

    def take(self, row: Row, z: Any, present: int) -> None:
        way, f, s = row.way, self.filter, self.sensor
        if way is None:
            self.call("update_subset", f, s, z, present)
        else:
            self.call("update_robust", f, s, z, present, self.loss(way, present))

    def loss(self, way: Robust, present: int) -> Any:
        """Of each way one, as a gate counts its rejections."""
        if way.way not in self.losses:
            self.losses[way.way] = self.new("loss")
            self.losses[way.way].kind = getattr(lib, f"kq_loss_{way.way}_{self.name}_address")()
        loss = self.losses[way.way]
        if way.way == "gate":
            limit = getattr(lib, f"kq_chi_square_limit_{self.name}")
            loss.limit, loss.run = limit(bin(present).count("1"), LEVELS[way.value]), way.run
        else:
            loss.parameter = way.value
        return loss


def whole(word: Any, low: Any) -> list[int]:
    """Of a word and what is behind it, however it is rounded."""
    return [int(w) * 2**24 + int(rest) for w, rest in zip(word, low)]


class SteadySequence:
    """Rows of a filter of constant gain."""

    def __init__(self, model: kalmanq.Model, gain: np.ndarray):
        self.model, self.gain = model, gain
        self.rows = [Row(None, np.full(model.m, np.nan), None, [])]

    def step(self, what: int, u: Optional[np.ndarray], z: np.ndarray, expected: list[int]) -> None:
        if what & 1:
            self.rows.append(Row(u, np.full(self.model.m, np.nan), None, expected))
        if what & 2:
            self.rows[-1] = Row(self.rows[-1].u, z, None, expected)

    def kinds(self) -> set[str]:
        return {"SteadyFilter"}

    def check(self) -> int:
        none = np.zeros(self.model.l)
        u = np.array([none if row.u is None else row.u for row in [*self.rows[1:], self.rows[0]]])
        run = SteadyFilter(self.model, "q31", self.gain).run(
            np.array([row.z for row in self.rows]), u if self.model.l else None)
        known = [t for t, row in enumerate(self.rows) if row.expected]
        for t in known:
            assert run.words["mean"][t].tolist() == self.rows[t].expected[1::2]
        return len(known) * self.model.n


class Sequences:
    """Hears of what a Replay does."""

    def __init__(self) -> None:
        self.all: list[Any] = []
        self.now = Sequence(kalmanq.Model([[1]], [1], 1, 1), [])

    def begins(self, model: kalmanq.Model, expected: list[int]) -> None:
        self.now = Sequence(model, expected)
        self.all.append(self.now)

    def is_made_by(self, make: Callable[[], Any]) -> None:
        self.now.make = make

    def uses(self, kind: str, slot: int) -> None:
        self.now.ended |= slot != 0

    def moved(self, u: Optional[np.ndarray], expected: list[int]) -> None:
        self.now.moved(u, expected)

    def measured(self, z: np.ndarray, way: Optional[Robust], expected: list[int]) -> None:
        self.now.measured(z, way, expected)

    def is_at(self, expected: list[int]) -> None:
        if not self.now.ended:
            self.now.rows[-1] = self.now.rows[-1]._replace(expected=expected)

    def changes(self) -> None:
        self.now.ended = True

    def clears(self) -> None:
        self.now.cleared = True

    def records(self) -> None:
        self.now.recorded = len(self.now.rows) == 1 and not self.now.taken

    def smooths(self, t: int, words: list[int]) -> None:
        if not self.now.ended:
            self.now.smoothed_rows = len(self.now.rows) if not self.now.smoothed else self.now.smoothed_rows
            self.now.smoothed[t] = words

    def is_followed(self, by: str, size: int) -> None:
        self.now.follower, self.now.size = by, size if by == "lag" else len(self.now.rows) - 1
        self.now.ended |= by == "lag" and len(self.now.rows) > 1

    def lags(self, age: int, words: list[int]) -> None:
        if not self.now.ended and age == self.now.size:
            self.now.followed[len(self.now.rows) - 1] = words

    def refines(self, words: list[int]) -> None:
        if not self.now.ended:
            self.now.followed[len(self.now.rows) - 1] = words

    def steadies(self, model: kalmanq.Model, gain: np.ndarray) -> None:
        self.all.append(SteadySequence(model, gain))

    def steps_steadily(self, what: int, u: Optional[np.ndarray], z: np.ndarray, words: list[int]) -> None:
        if self.all and isinstance(self.all[-1], SteadySequence):
            self.all[-1].step(what, u, z, words)
