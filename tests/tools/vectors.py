"""The golden vectors of tests/vectors, replayed by the Python twin: the tables of a case are made into a
kalmanq.Model of float64 and back, words into float64 and back, and the package's classes do what they can."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import Any, Callable, Iterable, NamedTuple, Optional

import numpy as np

import kalmanq
from kalmanq import (
    AdaptiveFilter, Consistency, Filter, KalmanqError, LeastSquares, Quantity, Robust, FrozenGainFilter, SteadyFilter)
from kalmanq.core import arithmetic_of, ffi, lib
from kalmanq.run.filters import LEVELS
from kalmanq.run.parts import Parts, matrix

FOLDER = Path(__file__).resolve().parents[1] / "vectors"
Q31 = arithmetic_of("q31")
ALL = 0xFFFFFFFF
NOT_A_VALUE, NOT_A_SCORE = -(2**31), -(2**63)


class Operation(NamedTuple):
    name: str  # of vector.h, in small letters
    given: list[int]
    expected: list[int]  # its outputs; none where the case has their digest alone
    digest: int


# linearised steps in words: the nonlinear models of the package are functions, and make them
OF_THE_CORE_ALONE = {"extended"}


def cases() -> list[str]:
    return sorted(path.stem for path in (FOLDER / "cases").glob("*.inc") if path.stem not in OF_THE_CORE_ALONE)


def digest_of(words: Iterable[int]) -> int:
    """FNV-1a, by words, as in vector.h."""
    digest = 2166136261
    for word in words:
        digest = (digest ^ word & ALL) * 16777619 & ALL
    return digest - 2**32 if digest >> 31 else digest


def operations(case: str) -> list[Operation]:
    """Of a case, as the README there says: code, inputs, and outputs (layout 1) or their digest (layout 2)."""
    header = (FOLDER / "vector.h").read_text(encoding="utf-8")
    names = re.findall(r"\bVECTOR_(\w+)", header[header.index("    VECTOR_END,"):header.index("VECTOR_OPERATIONS\n")])
    text = (FOLDER / "cases" / f"{case}.inc").read_text(encoding="utf-8")
    words = [int(word) for word in re.sub(r"/\*.*?\*/", "", text, flags=re.S).split(",") if word.strip()]
    made, at = [], 1
    while words[0] in (1, 2) and words[at]:
        code, count = words[at], words[at + 1]
        given, at = words[at + 2 : at + 2 + count], at + 2 + count
        expected = words[at + 1 : at + 1 + words[at]] if words[0] == 1 else []
        digest = digest_of(expected) if words[0] == 1 else words[at]
        at += 1 + len(expected)
        made.append(Operation(names[code].lower(), given, expected, digest))
    if words[0] not in (1, 2) or at + 1 != len(words):
        raise ValueError(f"{case}: the words are not those of layout 1 or 2")
    return made


# ------------------------------------------------------------------------------ words into float64 and back


class Inputs:
    """What is left of an operation's inputs."""

    def __init__(self, words: list[int]):
        self.left = list(words)

    def word(self) -> int:
        return self.left.pop(0)

    def words(self, count: int) -> list[int]:
        taken, self.left = self.left[:count], self.left[count:]
        return taken

    def optional(self, count: int) -> Optional[list[int]]:
        return self.words(count) if self.word() else None

    def formats(self, count: int) -> list[tuple[int, int]]:
        return [(self.word(), self.word()) for _ in range(count)]

    def numbers(self, *shape: int) -> np.ndarray:
        words = np.array(self.words(2 * int(np.prod(shape))), dtype=object).reshape(*shape, 2)
        return np.ldexp(words[..., 0].astype(float), words[..., 1].astype(int))

    def number(self) -> float:
        return float(self.numbers(1)[0])


def scaled(numbers: Any, scale: Any = 0) -> list[int]:
    """Mantissas and exponents of float64 that are physical; scale as in Arithmetic.numbers."""
    mantissa, exponent = np.frexp(np.ldexp(np.asarray(numbers, float), np.asarray(scale)))
    pairs = zip(np.ravel(mantissa), np.ravel(exponent))
    return [word for m, e in pairs for word in ((int(m * 2.0**31), int(e) - 31) if m else (0, 0))]


def upper(numbers: np.ndarray) -> np.ndarray:
    return numbers[np.triu_indices(len(numbers))]


def score(value: int) -> list[int]:
    high, low = (value >> 32) & ALL, value & ALL
    return [word - 2**32 if word >> 31 else word for word in (high, low)]


def pairs(made: Any, count: int) -> list[int]:
    """Of an array of kq_scaled_q31."""
    return [word for k in range(count) for word in (made[k].mantissa, made[k].exponent)]


def matrix_of_root(root: list[int], n: int) -> np.ndarray:
    """S in words: the triangle by columns, then the exponents of the rows."""
    S = np.zeros((n, n))
    for j in range(n):
        for i in range(j + 1):
            S[i, j] = np.ldexp(float(root[j * (j + 1) // 2 + i]), root[n * (n + 1) // 2 + i])
    return S


def quantities(letter: str, formats: list[tuple[int, int]]) -> list[Quantity]:
    return [Quantity(f"{letter}{k}", "", float(np.ldexp(float(most), -fraction)), fraction)
            for k, (most, fraction) in enumerate(formats)]


def fractions_of(formats: list[tuple[int, int]]) -> np.ndarray:
    return np.array([fraction for _, fraction in formats], int)


class ProcessTable(NamedTuple):
    A: np.ndarray
    B: Optional[np.ndarray]
    G: np.ndarray
    controls: list[Quantity]


class SensorTable(NamedTuple):
    H: np.ndarray
    R: np.ndarray
    measurements: list[Quantity]


def covariance_of(given: Inputs, m: int, is_correlated: bool) -> np.ndarray:
    """R in words: its diagonal, or U D U' of the triangle by columns, with D in the diagonal's place."""
    if not is_correlated:
        return np.diag(given.numbers(m))
    U = np.zeros((m, m))
    for j in range(m):
        U[: j + 1, j] = given.numbers(j + 1)
    D = np.diag(U).copy()
    np.fill_diagonal(U, 1)
    R = U @ np.diag(D) @ U.T
    return (R + R.T) / 2


def status_of(call: Callable[[], Any]) -> int:
    """Of what a class does: KQ_OK, or what the C core refused it with."""
    try:
        call()
    except KalmanqError as refused:
        assert refused.status is not None, refused
        return refused.status
    return 0


class Replay:
    """The machine of tests/vectors/vector.c in Python: a method an operation, which answers its outputs.

    What a class of the package does is done by it, with float64 for data; what none does, by kalmanq.core.lib.
    `follow`, where it is given, hears of everything that happens to the filter.
    """

    def __init__(self, follow: Any = None):
        self.follow = follow
        self.kept: list[Any] = []  # what C refers to

    def act(self, operation: Operation) -> list[int]:
        given = Inputs(operation.given)
        made = getattr(self, operation.name)(given)
        assert not given.left, f"{operation.name} has more inputs than were read"
        return made

    # ------------------------------------------------------------------ models

    def states(self, given: Inputs) -> list[int]:
        self.n = given.word()
        formats = given.formats(self.n)
        self.states_, self.fractions = quantities("x", formats), fractions_of(formats)
        self.process_tables: dict[int, ProcessTable] = {}
        self.sensor_tables: dict[int, SensorTable] = {}
        self.processes: dict[int, Any] = {}
        self.sensors: dict[int, Any] = {}
        self.known: dict[str, Any] = {}
        self.combined: dict[tuple[int, int], Parts] = {}
        made = Parts(self.model(None, None), "q31").formats["states"]
        assert [(made[i].range, made[i].fraction) for i in range(self.n)] == formats
        return []

    def model(self, process: Optional[ProcessTable], sensor: Optional[SensorTable], **known: Any) -> kalmanq.Model:
        """Of what there is; what is not there does nothing."""
        n, units = self.n, [Quantity("z0", "", 1.0)]
        p = process or ProcessTable(np.eye(n), None, np.zeros((n, 1)), [])
        s = sensor or SensorTable(np.zeros((1, n)), np.eye(1), units)
        known = {"P0": np.zeros((n, n)), **known}
        return kalmanq.Model(p.A, s.H, s.R, G=p.G, B=p.B, states=self.states_, measurements=s.measurements,
                             controls=p.controls, **known)

    def parts(self, process: int, sensor: int) -> Parts:
        """The two slots as Parts that share the slots' C structs."""
        if (process, sensor) not in self.combined:
            tables = self.process_tables.get(process, self.process_tables[0]), self.sensor_tables[sensor]
            made = Parts(self.model(*tables, **self.known), "q31")
            made.process, made.sensor = self.processes[process], self.sensors[sensor]
            made.kept.append(self.kept)
            self.combined[process, sensor] = made
        return self.combined[process, sensor]

    def process(self, given: Inputs) -> list[int]:
        words = list(given.left)
        n, slot, l = self.n, given.word(), given.word()
        formats = given.formats(l)
        own, controls = self.fractions, fractions_of(formats)
        A = np.ldexp(given.numbers(n, n), own - own[:, None])
        B = np.ldexp(given.numbers(n, l), controls - own[:, None]) if l else None
        G = np.ldexp(matrix_of_root(given.words(n * (n + 1) // 2 + n), n), -own[:, None])
        table = ProcessTable(A, B, G, quantities("u", formats))
        parts = Parts(self.model(table, None), "q31")
        made = parts.process_table
        assert words == [slot, l, *(word for pair in formats for word in pair), *pairs(made.transition, n * n),
                         *pairs(made.control, n * l), *made.noise_root[0 : n * (n + 1) // 2 + n]]
        self.process_tables[slot], self.processes[slot] = table, parts.process
        self.kept.append(parts)
        self.combined.clear()
        return [0, lib.KQ_NO_RANGE_ERROR, 0, 0]

    def sensor(self, given: Inputs) -> list[int]:
        words = list(given.left)
        n, slot, m, is_correlated = self.n, given.word(), given.word(), given.word()
        formats = given.formats(m)
        own = fractions_of(formats)
        H = np.ldexp(given.numbers(m, n), self.fractions - own[:, None])
        R = np.ldexp(covariance_of(given, m, bool(is_correlated)), -own - own[:, None])
        table = SensorTable(H, R, quantities("z", formats))
        parts = Parts(self.model(None, table), "q31")
        made = parts.sensor_table
        assert words == [slot, m, made.correlated, *(word for pair in formats for word in pair),
                         *pairs(made.measurement, m * n),
                         *pairs(made.noise, m * (m + 1) // 2 if is_correlated else m)]
        self.sensor_tables[slot], self.sensors[slot] = table, parts.sensor
        self.kept.append(parts)
        self.combined.clear()
        return [0, lib.KQ_NO_RANGE_ERROR, 0, 0]

    def known_start(self, given: Inputs) -> dict[str, np.ndarray]:
        n = self.n
        mean = np.ldexp(np.array(given.words(n), float), -self.fractions)
        root = np.ldexp(matrix_of_root(given.words(n * (n + 1) // 2 + n), n), -self.fractions[:, None])
        P0 = root @ root.T
        return {"x0": mean, "P0": (P0 + P0.T) / 2}

    def prior_words(self, parts: Parts) -> list[int]:
        n = self.n
        return [*parts.prior.mean[0:n], *parts.prior.root[0 : n * (n + 1) // 2 + n]]

    def prior(self, given: Inputs) -> list[int]:
        words = list(given.left)
        self.known = self.known_start(given)
        self.combined.clear()
        parts = self.parts(0, 0)
        assert words == self.prior_words(parts)
        self.f = Filter(parts.model, "q31", parts=parts)
        made = [0, lib.KQ_NO_RANGE_ERROR, 0, 0, *self.filter_words()]
        self.tell("begins", parts.model, made[4:])
        return made

    def transition(self, given: Inputs) -> list[int]:
        """By a table that the twin makes of the matrix."""
        parts, own = self.parts(given.word(), 0), self.fractions
        words = list(given.left)
        A = np.ldexp(given.numbers(self.n, self.n), own - own[:, None])
        table = matrix(parts, "A", A, parts.formats["states"], parts.formats["states"])
        self.kept.append(table)
        assert words == pairs(table, self.n**2)
        self.tell("changes")
        return [lib.kq_process_change_transition_q31(parts.process, table, ffi.NULL)]

    def measurement(self, given: Inputs) -> list[int]:
        parts = self.parts(0, given.word())
        words, m = list(given.left), parts.model.m
        H = np.ldexp(given.numbers(m, self.n), self.fractions - np.array(parts.fractions("measurements"))[:, None])
        table = matrix(parts, "H", H, parts.formats["measurements"], parts.formats["states"])
        self.kept.append(table)
        assert words == pairs(table, m * self.n)
        self.tell("changes")
        return [lib.kq_sensor_change_measurement_q31(parts.sensor, table, ffi.NULL)]

    # ------------------------------------------------------------------ what goes in and what comes out

    def tell(self, what: str, *arguments: Any) -> None:
        if self.follow is not None:
            getattr(self.follow, what)(*arguments)

    def use(self, process: int, sensor: int) -> Parts:
        """The filter's next call is by these slots."""
        parts = self.parts(process, sensor)
        self.f.parts, self.f.model = parts, parts.model
        return parts

    def take_process(self, given: Inputs) -> int:
        slot = given.word()
        self.tell("uses", "process", slot)
        return slot

    def take_sensor(self, given: Inputs) -> int:
        slot = given.word()
        self.tell("uses", "sensor", slot)
        return slot

    def controls(self, given: Inputs, parts: Parts) -> Optional[np.ndarray]:
        return self.values(given.optional(parts.model.l), parts, "controls")

    @staticmethod
    def values(words: Optional[list[int]], parts: Parts, which: str, present: int = ALL) -> Optional[np.ndarray]:
        """float64 of words, which the twin makes the same words of unless they are out of range."""
        if words is None:
            return None
        fractions = np.array(parts.fractions(which), int)
        made = np.ldexp(np.array(words, float), -fractions)
        made[[not present >> c & 1 for c in range(len(words))]] = np.nan
        ranges = np.array([parts.formats[which][c].range for c in range(len(words))])
        there = ~np.isnan(made)
        if np.all(np.abs(np.array(words)) <= ranges):
            back = parts.words(made.reshape(1, -1), which)[0]
            assert np.array_equal(back[there], np.array(words)[there])
        return made

    def measured(self, given: Inputs, parts: Parts, present: int = ALL) -> np.ndarray:
        made = self.values(given.words(parts.model.m), parts, "measurements", present)
        assert made is not None
        return made

    def mean_words(self, f: Filter) -> list[int]:
        """Word and low of every state; the float64 that the twin shows is the nearest one."""
        word, low = f._words("mean").tolist(), f._words("mean_low").tolist()
        for i, shown in enumerate(f.mean):
            assert shown == float(Fraction(word[i] * 2**24 + low[i]) / Fraction(2) ** int(24 + self.fractions[i]))
        return word + low

    def filter_words(self, f: Optional[Filter] = None) -> list[int]:
        f = f or self.f
        nis = lib.kq_nis_q31(f._handle)
        assert f.nis == nis * 2.0**-24
        return [f.events, f.taken, *score(nis), *f._words("sigma").tolist(), *f.memory.tolist()]

    def reading(self, f: Filter) -> list[int]:
        covariance = scaled(upper(f.covariance), upper(f.parts.covariance_scale))
        last, whole = lib.kq_log_likelihood_last_q31(f._handle), lib.kq_log_likelihood_q31(f._handle)
        assert abs(f.log_likelihood - whole * 2.0**-24) <= max(2.0**-24, 2.0**-30 * abs(f.log_likelihood))
        return [*self.mean_words(f), *f._words("sigma").tolist(), 0, *covariance, *score(last), *score(whole)]

    def implied(self, f: Filter) -> list[int]:
        z, S = f.measurement()
        fractions = np.array(f.parts.fractions("measurements"))
        return [0, *(int(word) for word in np.ldexp(z, fractions)), *scaled(S, fractions[:, None] + fractions)]

    # ------------------------------------------------------------------ the filter

    def predict(self, given: Inputs) -> list[int]:
        parts = self.use(self.take_process(given), 0)
        u = self.controls(given, parts)
        status = status_of(lambda: self.f.predict(u))
        return self.moves(status, u)

    def moves(self, status: int, u: Optional[np.ndarray], before: tuple[int, ...] = ()) -> list[int]:
        words = self.filter_words()
        if status == 0:
            self.tell("moved", u, words)
        return [status, *before, *words]

    def takes(self, status: int, z: np.ndarray, way: Optional[Robust] = None,
              before: tuple[int, ...] = ()) -> list[int]:
        words = self.filter_words()
        if status == 0:
            self.tell("measured", z, way, words)
        return [status, *before, *words]

    def update(self, given: Inputs) -> list[int]:
        parts = self.use(0, self.take_sensor(given))
        z = self.measured(given, parts, given.word() & ALL)
        status = status_of(lambda: self.f.update(z))
        return self.takes(status, z)

    def step(self, given: Inputs) -> list[int]:
        parts = self.use(self.take_process(given), self.take_sensor(given))
        u = self.controls(given, parts)
        z = self.measured(given, parts)
        status = status_of(lambda: self.f.step(z, u))
        if status == 0:
            self.tell("moved", u, [])
        return self.takes(status, z)

    def read(self, given: Inputs) -> list[int]:
        return self.reading(self.f)

    def look(self, given: Inputs) -> list[int]:
        parts = self.use(0, given.word())
        m = parts.model.m
        words, e = ffi.new("int32_t[]", given.words(m)), ffi.new("int32_t[]", m)
        status = lib.kq_innovation_q31(self.f._handle, parts.sensor, words, e)
        scale = np.subtract.outer(self.fractions, parts.fractions("measurements"))
        return [*self.implied(self.f), status, *e, 0, *scaled(self.f.gain(), scale)]

    def forecast(self, given: Inputs) -> list[int]:
        parts = self.use(given.word(), given.word())
        steps = given.word()
        words = given.optional(steps * parts.model.l)
        u = None
        if words is not None:
            rows = np.array(words, float).reshape(steps, parts.model.l)
            u = np.ldexp(rows, -np.array(parts.fractions("controls"), int))
        ahead = self.f.forecast(steps, u)
        return [0, *self.filter_words(ahead), *self.reading(ahead), *self.implied(ahead)]

    def clear(self, given: Inputs) -> list[int]:
        self.f.clear_events()
        self.tell("clears")
        return [self.f.events]

    def run(self, given: Inputs) -> list[int]:
        """On data that both sides draw."""
        parts = self.use(self.take_process(given), self.take_sensor(given))
        steps, draw, shift = given.word(), given.word(), given.word()
        m, digest, status = parts.model.m, 2166136261, 0
        most = [parts.formats["measurements"][c].range for c in range(m)]
        fractions = np.array(parts.fractions("measurements"))
        scale, bits = np.ldexp(1.0, -fractions), np.arange(m)
        implied = ffi.new("int32_t[]", m)
        for _ in range(steps):
            self.f.predict()
            if self.follow is not None:
                self.follow.moved(None, [])
            lib.kq_measurement_q31(self.f._handle, parts.sensor, implied, ffi.NULL)
            words = list(implied)
            for c in range(m):
                draw = drawn(draw)
                noise = draw >> 1 >> shift
                words[c] = max(-most[c], min(most[c], words[c] + (-noise if draw & 1 else noise)))
            draw = drawn(draw)
            z = np.where((draw >> 16 >> bits) & 1, words * scale, np.nan)
            self.f.update(z)
            if self.follow is not None:
                self.follow.measured(z, None, [])
            for word in (*self.f.memory.tolist(), lib.kq_nis_q31(self.f._handle) & ALL):
                digest = ((digest ^ (word & ALL)) * 16777619) & ALL
        words = self.filter_words()
        self.tell("is_at", words)
        return [status, digest - 2**32 if digest >> 31 else digest, *words]

    # ------------------------------------------------------------------ the smoother

    def history(self, given: Inputs) -> list[int]:
        words = given.word()
        memory = self.f.arithmetic.empty(words)
        self.h = self.f.arithmetic.struct("history")
        self.kept.append((memory, self.h))
        status = lib.kq_history_assign_q31(self.h, self.n, Q31.pointer(memory), words)
        self.tell("records")
        return [status or attached(self.f, self.h)]

    start_history = history

    def smoothed_words(self, t: int, with_sigma: bool = True) -> list[int]:
        view = self.view(lib.kq_smoothed_q31, self.h, t)
        return [Q31.function(name)(view, i) for name in ["mean", "mean_low"] + ["sigma"] * with_sigma
                for i in range(self.n)]

    def view(self, show: Any, *of: Any) -> Any:
        """What a smoother shows, or nothing"""
        made = Q31.struct("filter")
        show(*of, made)
        return made

    def numbers(self, *shape: int) -> Any:
        return ffi.new("kq_scaled_q31[]", int(np.prod(shape)))

    def smooth(self, given: Inputs) -> list[int]:
        slot, what = given.word(), given.word()
        n, none = self.n, ffi.NULL
        P, lag_one, noise, spread = (self.numbers(n, n) for _ in range(4))
        extras = ffi.new("kq_smooth_extras_q31 *", [
            lag_one if what & 2 else none, noise if what & 4 else none, spread if what & 4 else none])
        status = lib.kq_smooth_step_q31(self.h, none if slot < 0 else self.processes[slot], extras)
        if status:
            return [status]
        t, made = self.h.step, [status, self.h.step]
        if t + 1 < lib.kq_history_steps_q31(self.h):
            made += pairs(lag_one, n * n) if what & 2 else []
            made += pairs(noise, n) + self.triangle(spread) if what & 4 else []
        smoothed = self.smoothed_words(t)
        self.tell("smooths", t, smoothed)
        made += smoothed
        if what & 1:
            made += [lib.kq_covariance_q31(self.view(lib.kq_smoothed_q31, self.h, t), P), *self.triangle(P)]
        return made + (self.measurement_noise() if what & 8 else [])

    def triangle(self, P: Any) -> list[int]:
        n = self.n
        return [word for i in range(n) for j in range(i, n) for word in (P[i * n + j].mantissa, P[i * n + j].exponent)]

    def measurement_noise(self) -> list[int]:
        made, k = [], 0
        while True:
            moments = self.numbers(2)
            status = lib.kq_smoothed_measurement_noise_q31(self.h, k, moments, moments + 1)
            made.append(status)
            if status:
                return made
            made, k = made + pairs(moments, 2), k + 1

    def smooth_all(self, given: Inputs) -> list[int]:
        states_only = given.word()
        status = (lib.kq_smooth_states_q31 if states_only else lib.kq_smooth_q31)(self.h)
        return [status] + ([] if status else self.all_smoothed(not states_only))

    def all_smoothed(self, with_sigma: bool = True, is_told: bool = True) -> list[int]:
        made = []
        for t in range(lib.kq_history_steps_q31(self.h)):
            words = self.smoothed_words(t, with_sigma)
            if is_told:
                self.tell("smooths", t, words)
            made += words
        return made

    def read_shown(self, status: int, view: Any) -> list[int]:
        """Mean, low and sigma of each state, then the covariance, of what a lag or an instant showed last."""
        if not status:
            self.shown = view
        made = [Q31.function(name)(self.shown, i) for i in range(self.n) for name in ("mean", "mean_low", "sigma")]
        P = self.numbers(self.n, self.n)
        unknown = lib.kq_covariance_q31(self.shown, P)
        return [*made, unknown, *([] if unknown else self.triangle(P))]

    def lag(self, given: Inputs) -> list[int]:
        m, longest = given.word(), given.word()
        self.lag_ = self.f._object("lag", self.n, m, longest, sizes=(self.n, m, longest))
        self.tell("is_followed", "lag", longest)
        self.shown = Q31.struct("filter")
        return [attached(self.f, self.lag_)]

    def lag_predict(self, given: Inputs) -> list[int]:
        parts = self.use(self.take_process(given), 0)
        u = self.controls(given, parts)
        longest = 2**64 - 1  # no lag has that: asking changes nothing, and says whether it follows
        view = Q31.struct("filter")
        status = lib.kq_lagged_q31(self.lag_, longest, view)
        if status == lib.KQ_ERR_SIZE:
            status = status_of(lambda: self.f.predict(u))
        follows = lib.kq_lagged_q31(self.lag_, longest, view) == lib.KQ_ERR_SIZE
        return self.moves(status, u, (lib.kq_lag_steps_q31(self.lag_) if follows else -1,))

    def lag_smooth(self, given: Inputs) -> list[int]:
        age, states_only = given.word(), given.word()
        show, view = lib.kq_lagged_states_q31 if states_only else lib.kq_lagged_q31, Q31.struct("filter")
        status = show(self.lag_, age & (2**64 - 1), view)
        words = self.read_shown(status, view)
        if not status:
            self.tell("lags", age, words)
        return [status, *words]

    def point(self, given: Inputs) -> list[int]:
        m = given.word()
        self.point_ = self.f._object("instant", self.n, m, sizes=(self.n, m))
        self.tell("is_followed", "instant", 0)
        self.shown = Q31.struct("filter")
        return [attached(self.f, self.point_)]

    def point_predict(self, given: Inputs) -> list[int]:
        return self.predict(given)

    def point_smooth(self, given: Inputs) -> list[int]:
        view = Q31.struct("filter")
        status = lib.kq_instant_smooth_q31(self.point_, view)
        words = self.read_shown(status, view)
        self.tell("refines", words)
        return [status, *words]

    # ------------------------------------------------------------------ steady state and freeze

    def gains(self, given: Inputs) -> list[int]:
        parts = self.use(given.word(), given.word())
        count, size = given.word(), self.n * parts.model.m
        self.gain_list, self.gain_count, status = self.numbers(count, size), count, 0
        z = ffi.new("int32_t[]", parts.model.m)
        for t in range(count):
            status = (status or lib.kq_gain_q31(self.f._handle, parts.sensor, self.gain_list + t * size)
                      or lib.kq_update_q31(self.f._handle, parts.sensor, z)
                      or lib.kq_predict_q31(self.f._handle, parts.process, ffi.NULL))
        return [status, *pairs(self.gain_list, count * size)]

    def gain_values(self, parts: Parts) -> np.ndarray:
        """The last gain in physical units."""
        n, m = self.n, parts.model.m
        words = np.array(pairs(self.gain_list + (self.gain_count - 1) * n * m, n * m), dtype=object).reshape(n, m, 2)
        scale = np.subtract.outer(self.fractions, parts.fractions("measurements"))
        return np.ldexp(words[..., 0].astype(float), words[..., 1].astype(int) - scale)

    def steady(self, given: Inputs) -> list[int]:
        """By the last gain alone as a SteadyFilter, by all of them as the C core has it."""
        parts = self.use(given.word(), given.word())
        last_alone, mean = given.word(), given.words(self.n)
        n, m = self.n, parts.model.m
        if last_alone:
            return self.steady_by_one(mean, self.gain_values(parts))
        memory = Q31.empty(2 * n)
        self.s = Q31.struct("steady")
        self.kept += [memory, self.s, self.gain_list]
        words = ffi.new("int32_t[]", mean)
        status = lib.kq_steady_assign_q31(self.s, n, m, Q31.pointer(memory), memory.size)
        status = status or lib.kq_steady_init_q31(self.s, parts.process, parts.sensor, words, self.gain_list,
                                                  self.gain_count)
        return [status, *self.steady_words()]

    def steady_by_one(self, mean: list[int], gain: np.ndarray) -> list[int]:
        known = {**self.known, "x0": np.ldexp(np.array(mean, float), -self.fractions)}
        model, made = self.model(self.process_tables[0], self.sensor_tables[0], **known), []
        status = status_of(lambda: made.append(SteadyFilter(model, "q31", gain)))
        if status:
            return [status, 0, *[NOT_A_VALUE] * (2 * self.n)]
        self.s = made[0]._handle
        self.kept += made
        self.tell("steadies", model, gain)
        return [status, *self.steady_words()]

    def steady_words(self) -> list[int]:
        mean = [Q31.function(f"steady_{name}")(self.s, i) for i in range(self.n) for name in ("mean", "mean_low")]
        return [lib.kq_steady_events_q31(self.s), *mean]

    def steady_step(self, given: Inputs) -> list[int]:
        parts = self.use(given.word(), given.word())
        what = given.word()
        u, m = given.optional(parts.model.l), parts.model.m
        z, e = ffi.new("int32_t[]", given.words(m)), ffi.new("int32_t[]", m)
        moved = ffi.NULL if u is None else ffi.new("int32_t[]", u)
        made = [lib.kq_steady_innovation_q31(self.s, z, e), *e]
        status = {1: lambda: lib.kq_steady_predict_q31(self.s, moved), 2: lambda: lib.kq_steady_update_q31(self.s, z),
                  3: lambda: lib.kq_steady_step_q31(self.s, moved, z)}[what]()
        if not status:
            rows = self.values(u, parts, "controls"), self.values(list(z), parts, "measurements")
            self.tell("steps_steadily", what, *rows, self.steady_words())
        return [*made, status, *self.steady_words()]

    def switch(self, given: Inputs) -> list[int]:
        parts = self.use(0, given.word())
        bits = given.word()
        self.f = FrozenGainFilter(parts.model, "q31", bits=bits, parts=parts)
        self.tell("is_made_by", lambda: FrozenGainFilter(parts.model, "q31", bits=bits))
        return [0]

    def switch_step(self, given: Inputs) -> list[int]:
        parts = self.use(self.take_process(given), self.take_sensor(given))
        u = self.controls(given, parts)
        words = given.optional(parts.model.m)
        z = self.values(words, parts, "measurements")
        status = status_of(lambda: self.f.predict(u) if z is None else self.f.step(z, u))
        self.tell("moved", u, self.filter_words())
        if z is not None:
            self.tell("measured", z, None, self.filter_words())
        return [status, int(self.f.is_settled), *self.filter_words()]

    def switch_release(self, given: Inputs) -> list[int]:
        self.tell("changes")
        return [status_of(self.f.release)]

    # ------------------------------------------------------------------ outliers and jumps

    def gate(self, given: Inputs) -> list[int]:
        m, level, run = given.word(), given.word(), given.word()
        limit = lib.kq_chi_square_limit_q31(m, level)
        self.robust = Robust("gate", {of: value for value, of in LEVELS.items()}[level], run)
        return score(limit)

    def gated(self, given: Inputs) -> list[int]:
        parts = self.use(0, self.take_sensor(given))
        z = self.measured(given, parts, given.word() & ALL)
        status = status_of(lambda: self.f.update(z, self.robust))
        return self.takes(status, z, self.robust, (self.f._gates[self.robust][0].rejected,))

    def weighted(self, given: Inputs) -> list[int]:
        """Weights are those of the C core on a copy of the filter."""
        way = ("huber", "student")[given.word()]
        parts = self.use(0, self.take_sensor(given))
        present, parameter = given.word() & ALL, given.number()
        words = ffi.new("int32_t[]", given.left[: parts.model.m])
        z = self.measured(given, parts, present)
        weights, other = self.numbers(parts.model.m), self.f.copy()
        loss = Q31.loss(way)
        loss.parameter, loss.weights = Q31.parameter(parameter), weights
        lib.kq_update_robust_q31(other._handle, parts.sensor, words, present, loss)
        robust = Robust(way, parameter)
        status = status_of(lambda: self.f.update(z, robust))
        return self.takes(status, z, robust, tuple(pairs(weights, parts.model.m)))

    def jump(self, given: Inputs) -> list[int]:
        parts = self.use(0, self.take_sensor(given))
        present, robust = given.word() & ALL, Robust("jump", given.number())
        z = self.measured(given, parts, present)
        status = status_of(lambda: self.f.update(z, robust))
        return self.takes(status, z, robust)

    def target(self, slot: int) -> list[int]:
        """The slot of a process whose noise is scaled: its root."""
        if slot not in self.processes:
            self.processes[slot] = Q31.struct("process")
            self.root = ffi.new("int32_t[]", self.n * (self.n + 1) // 2 + self.n)
            self.kept.append((self.root, self.processes[slot]))
        return self.root

    def scale(self, given: Inputs) -> list[int]:
        slot, source = given.word(), given.word()
        root = self.target(slot)
        status = lib.kq_process_scale_noise_q31(self.processes[slot], self.processes[source], root,
                                                Q31.parameter(given.number()))
        return [status, *root]

    def reweighted(self, given: Inputs) -> list[int]:
        slot, source = given.word(), given.word()
        nu, count = given.number(), given.word()
        words = given.words(2 * count)
        q = ffi.new("kq_scaled_q31[]", [[words[2 * k], words[2 * k + 1]] for k in range(count)])
        status = lib.kq_smooth_reweighted_q31(self.h, self.processes[slot], self.processes[source], self.target(slot),
                                              Q31.parameter(nu), q)
        return [status, *pairs(q, count), *([] if status else self.all_smoothed(is_told=False))]

    # ------------------------------------------------------------------ statistics

    def fade(self, given: Inputs) -> list[int]:
        self.tell("changes")
        forgetting = given.number()
        return [status_of(lambda: self.f.forget(forgetting)), *self.filter_words()]

    def fit(self, given: Inputs) -> list[int]:
        forgetting, formats = given.number(), given.formats(1)
        self.least_squares = LeastSquares(self.known["x0"], self.known["P0"], "q31", forgetting=forgetting,
                                          states=self.states_, measurement=quantities("z", formats)[0])
        self.f = self.least_squares.filter
        return [0, *self.fit_words()]

    def fit_words(self) -> list[int]:
        made = [Q31.function(f"least_squares_{name}")(self.least_squares._handle) for name in ("residual", "weight")]
        assert [self.least_squares.residual, self.least_squares.weight] == [value * 2.0**-24 for value in made]
        return [word for value in made for word in score(value)]

    def fit_add(self, given: Inputs) -> list[int]:
        count, own = given.word(), self.least_squares.filter.parts.fractions("measurements")[0]
        H = np.ldexp(given.numbers(count, self.n), self.fractions - own)
        z = np.ldexp(np.array(given.words(count), float), -own)
        r = np.ldexp(given.numbers(count), -2 * own)
        self.least_squares.run(H, z, r)
        return [0, *self.fit_words(), *self.filter_words()]

    def window(self, given: Inputs) -> list[int]:
        m, length = given.word(), given.word()
        model = self.parts(0, 0).model
        assert m == model.m
        self.watch = Consistency(model, length, "q31")
        return [0]

    def watched(self, given: Inputs) -> list[int]:
        parts = self.use(0, self.take_sensor(given))
        z = self.measured(given, parts, given.word() & ALL)
        status = status_of(lambda: self.f.update(z, watch=self.watch))
        made = self.takes(status, z)
        return [0, status, 0, len(self.watch), *made[1:]]

    def window_read(self, given: Inputs) -> list[int]:
        quantile = given.word() * 2.0**-24
        made = self.tests(lambda: self.watch.nis(quantile), 3)
        for c in range(self.watch.model.m):
            made += self.tests(lambda: self.watch.innovation(c, quantile), 4)
        return made

    @staticmethod
    def tests(call: Callable[[], tuple[float, ...]], count: int) -> list[int]:
        shown: list[float] = [0.0] * count
        status = status_of(lambda: shown.__setitem__(slice(None), call()))
        return [status, *(word for value in shown for word in score(int(value * 2.0**24)))]

    # ------------------------------------------------------------------ an unknown start

    def start(self, given: Inputs) -> list[int]:
        early, unknown = given.word(), given.word()
        words = list(given.left)
        self.known = self.known_start(given)
        self.known["unknown"] = [i for i in range(self.n) if unknown >> i & 1]
        self.combined.clear()
        parts = self.parts(0, 0)
        assert words[: self.n] == self.prior_words(parts)[: self.n]
        self.f = Filter(parts.model, "q31", parts=parts)
        self.f._start = self.f._object("diffuse", self.n, early, sizes=(self.n, early))
        parts.init_start(self.f._start, self.f._handle)
        made = self.start_words()
        self.tell("begins", parts.model, [])
        return [0, lib.KQ_NO_RANGE_ERROR, 0, 0, *made]

    def start_words(self) -> list[int]:
        s, f, n = self.f._start, self.f, self.n
        unknown = lib.kq_diffuse_count_q31(s)
        made = [unknown]
        for i in range(n):
            readings = [Q31.function(name)(f._handle, i) for name in ("mean", "mean_low", "sigma")]
            made += [int(readings[0] != NOT_A_VALUE), *readings]
        for name in ("log_likelihood_last", "log_likelihood"):
            made += score(Q31.function(name)(f._handle))
        first = ffi.new("size_t *")
        made += [lib.kq_diffuse_steps_q31(s, first), first[0]]
        if not unknown:
            return made + self.filter_words()
        return [*made, f.events, -1, *score(NOT_A_SCORE), *[NOT_A_VALUE] * n, *f.memory.tolist()]

    def words_if_known(self) -> list[int]:
        return [] if lib.kq_diffuse_count_q31(self.f._start) else self.filter_words()

    def start_predict(self, given: Inputs) -> list[int]:
        parts = self.use(self.take_process(given), 0)
        u = self.controls(given, parts)
        status = status_of(lambda: self.f.predict(u))
        self.tell("moved", u, self.words_if_known())
        return [status, *self.start_words()]

    def start_update(self, given: Inputs) -> list[int]:
        parts = self.use(0, self.take_sensor(given))
        z = self.measured(given, parts, given.word() & ALL)
        status = status_of(lambda: self.f.update(z))
        self.tell("measured", z, None, self.words_if_known())
        return [status, *self.start_words()]

    def start_smooth(self, given: Inputs) -> list[int]:
        s, steps, n = self.f._start, given.word(), self.n
        made = [lib.kq_diffuse_smooth_q31(s)]
        for t in range(steps):
            view, P = Q31.struct("filter"), self.numbers(n, n)
            status = lib.kq_diffuse_smoothed_q31(s, t, view)
            words = [Q31.function(name)(view, i) for i in range(n) for name in ("mean", "mean_low", "sigma")]
            status = status or lib.kq_covariance_q31(view, P)
            if not made[0]:
                self.tell("smooths", t, words[0::3] + words[1::3] + words[2::3])
            made += [*words, status, *([] if status else self.triangle(P))]
        return made

    # ------------------------------------------------------------------ adaptation

    def adaptation(self, given: Inputs) -> list[int]:
        parts = self.use(given.word(), given.word())
        scales, memory = ("both", "process", "sensor")[given.word()], given.word()
        step, *limits = (given.number() for _ in range(5))
        made: list[Filter] = []

        def adaptive() -> Filter:
            return AdaptiveFilter(parts.model, "q31", scales=scales, memory=memory, step=step, limits=tuple(limits[:2]),
                                  sensor_limits=tuple(limits[2:]), parts=parts)

        status = status_of(lambda: made.append(adaptive()))
        if made:
            self.f = made[0]
            self.tell("is_made_by", adaptive)
        return [0, status]

    def adapted_predict(self, given: Inputs) -> list[int]:
        return self.predict(given)

    def adapted_update(self, given: Inputs) -> list[int]:
        parts = self.use(0, self.take_sensor(given))
        z = self.measured(given, parts, given.word() & ALL)
        status = status_of(lambda: self.f.update(z))
        scales = scaled(self.f.scales)
        return self.takes(status, z, None, tuple(scales))


def attached(f: Filter, thing: Any) -> int:
    return lib.kq_attach_q31(f._handle, ffi.addressof(thing[0], "attached"))


def drawn(draw: int) -> int:
    """Marsaglia's xorshift of 32 bits"""
    draw ^= draw << 13 & ALL
    draw ^= draw >> 17
    return draw ^ (draw << 5 & ALL)
