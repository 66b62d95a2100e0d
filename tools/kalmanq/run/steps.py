"""Processes and sensors that are others from row to row: of matrices that vary, or of the times of a continuous model."""

from __future__ import annotations

from typing import Any, Callable, Optional

import numpy as np

from kalmanq.core import ffi, require
from kalmanq.data.rows import Rows
from kalmanq.errors import KalmanqError
from kalmanq.run.parts import Parts

MOST = 65536  # processes that are kept for their dt to come again
Addresses = np.ndarray  # of structs in C, one a row


class Steps:
    """What a filter's rows have in the place of the model's own process and sensor, as C reads it.

    keeps   all that was made stays: a history refers to it.  Otherwise of processes and of sensors what the last two calls have made does:
            the last process of the one leads to the first row of the other
    """

    def __init__(self, parts: Parts, keeps: bool = False):
        self.parts, self.keeps = parts, keeps
        self.is_upper = True  # is all of A that was made?
        self._forget_over()
        self._kept: dict[str, list[Any]] = {"ABQ": [], "HR": []}

    def copy(self) -> Steps:
        """For a filter that goes on from the same row: what moves it to the next one stays"""
        made = Steps(self.parts)
        made._kept = {names: list(one) for names, one in self._kept.items()}
        return made

    def _forget_over(self) -> None:
        """All processes that were made of a dt, but for the model's own"""
        of = self.parts.model.continuous
        self._over = np.array([] if of is None else [of.dt]), np.array([] if of is None else [self.own], np.uintp)  # dt, rising
        self._kept_over: list[Any] = []

    @property
    def own(self) -> int:
        """The model's process"""
        return int(ffi.cast("uintptr_t", self.parts.process))

    def process_at(self, address: int) -> Any:
        """As a call of C takes it"""
        return ffi.cast(f"kq_process_{self.parts.arithmetic.name} *", int(address))

    def over(self, dt: np.ndarray) -> Addresses:
        """Of the process over each dt, which is made once"""
        distinct, which = np.unique(dt, return_inverse=True)
        if len(self._over[0]) + len(distinct) > MOST and not self.keeps:
            self._forget_over()
        new = np.setdiff1d(distinct, self._over[0], assume_unique=True)
        if len(new):
            self.know(new, *self.parts.model.continuous.steps(new))
        return self._over[1][np.searchsorted(self._over[0], distinct)][which]

    def know(self, dt: np.ndarray, A: np.ndarray, Q: np.ndarray, B: Optional[np.ndarray]) -> None:
        """Steps over each dt, which is not known, and the model's own goes before"""
        if not (np.all(np.isfinite(A)) and np.all(np.isfinite(Q))):
            raise KalmanqError(f"a step of {dt[-1]:g} is so long that the model is not representable: give rows in between, or take other units")
        made, kept = self._processes(A, B, Q)
        self._kept_over.append(kept)
        known, at = np.unique(np.concatenate([self._over[0], dt]), return_index=True)
        self._over = known, np.concatenate([self._over[1], made])[at]

    def processes(self, rows: Rows) -> Addresses:
        """Of the process of each row's A, B and Q"""
        return self._of_rows(rows, "ABQ", self._processes)

    def sensors(self, rows: Rows) -> Addresses:
        """Of the sensor of each row's H and R"""
        return self._of_rows(rows, "HR", self._sensors)

    def _of_rows(self, rows: Rows, names: str, make: Callable[..., tuple[Addresses, Any]]) -> Addresses:
        """Rows in a row that are alike have one"""
        given = [rows.matrices.get(name, self._alike(name, len(rows))) for name in names]
        is_new = np.ones(len(rows), bool)
        is_new[1:] = np.any([np.any(one[1:] != one[:-1], axis=(1, 2)) for one in given if one is not None], axis=0)
        first = np.flatnonzero(is_new)
        try:
            made, kept = make(*(None if one is None else one[first] for one in given))
        except KalmanqError as problem:
            at = None if problem.row is None else int(first[problem.row])
            raise KalmanqError(problem.text, problem.status, at) from None
        self._kept[names] = [*(self._kept[names] if self.keeps else self._kept[names][-1:]), kept]
        return made[np.cumsum(is_new) - 1]

    def _alike(self, name: str, rows: int) -> Optional[np.ndarray]:
        """Of the model at each row; None: it has none, or of Q a factor, which is more accurate"""
        model = self.parts.model
        of = None if name == "Q" and model.G is not None else getattr(model, name)
        return None if of is None else np.broadcast_to(of, (rows, *of.shape))

    def _processes(self, A: np.ndarray, B: Optional[np.ndarray], Q: Optional[np.ndarray]) -> tuple[Addresses, Any]:
        self.is_upper = self.is_upper and not np.any(np.tril(A, -1))
        a, model = self.parts.arithmetic, self.parts.model
        if a.is_fixed:
            return self._made("process", {name: one for name, one in (("A", A), ("B", B), ("Q", Q)) if one is not None})
        F = None if Q is not None else np.broadcast_to(model.G, (len(A), *model.G.shape))
        given = [self._numbers(one) for one in (A, B, Q, F)]
        structs, memory = self._room("process", len(A), a.length("process", model.n))
        self._require(a.function("processes_init"), "A, B, Q", len(A), structs, model.n, model.l, a.pointer(memory),
                      *map(a.pointer, given), 0 if F is None else F.shape[2])
        return self._addresses(structs, len(A)), (structs, memory, given[:2])  # Q is in the memory

    def _sensors(self, H: np.ndarray, R: np.ndarray) -> tuple[Addresses, Any]:
        a, model = self.parts.arithmetic, self.parts.model
        if a.is_fixed:
            return self._made("sensor", {"H": H, "R": R})
        variances = np.diagonal(R, axis1=1, axis2=2)
        is_independent = np.array_equal(R, variances[:, :, None] * np.eye(model.m))
        given = [self._numbers(one) for one in (H, None if is_independent else R, variances if is_independent else None)]
        structs, memory = self._room("sensor", len(H), a.length("sensor", model.m))
        self._require(a.function("sensors_init"), "H, R", len(H), structs, model.n, model.m, a.pointer(memory),
                      *map(a.pointer, given))
        return self._addresses(structs, len(H)), (structs, memory, given)

    def _numbers(self, given: Optional[np.ndarray]) -> Optional[np.ndarray]:
        if given is None:
            return None
        with np.errstate(over="ignore"):
            made = np.ascontiguousarray(given, self.parts.arithmetic.number)
        if not np.all(np.isfinite(made)):
            raise KalmanqError(f"a number is beyond {self.parts.arithmetic}: take other units", row=int(np.argwhere(~np.isfinite(made))[0][0]))
        return made

    def _room(self, stem: str, count: int, length: int) -> tuple[Any, np.ndarray]:
        a = self.parts.arithmetic
        return ffi.new(f"kq_{stem}_{a.name}[]", max(count, 1)), a.empty(max(count * length, 1))

    def _require(self, call: Any, what: str, *given: Any) -> None:
        done = ffi.new("size_t *")
        require(call(*given, done), what, int(done[0]))

    def _addresses(self, structs: Any, count: int) -> Addresses:
        first = int(ffi.cast("uintptr_t", structs))
        return first + np.arange(count, dtype=np.uintp) * np.uintp(ffi.sizeof(ffi.typeof(structs).item))

    def _made(self, stem: str, given: dict[str, np.ndarray]) -> tuple[Addresses, Any]:
        """Of q31: its tables are those of a model each"""
        made: list[Parts] = []
        for row in range(len(next(iter(given.values())))):
            try:
                made.append(Parts(self.parts.model.changed(**{name: one[row] for name, one in given.items()}), "q31"))
            except KalmanqError as problem:
                raise KalmanqError(problem.text, problem.status, row) from None
        return np.array([int(ffi.cast("uintptr_t", getattr(one, stem))) for one in made], np.uintp), made
