"""A smoother of any number of rows: what it keeps of them is in files without a name, not in memory."""

from __future__ import annotations

import mmap
import os
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import IO, Any, Iterator, Optional

import numpy as np

from kalmanq.core import require
from kalmanq.data.files import telling_where
from kalmanq.data.rows import Rows
from kalmanq.model import Model
from kalmanq.run.filters import EARLY_MAX, _Recording
from kalmanq.run.parts import Parts
from kalmanq.run.results import Run
from kalmanq.run.robust import Robust

KEPT = ("mean", "sigma", "innovation", "innovation_sigma", "nis", "log_likelihood")  # of the filter, at every row


class StreamedSmoother:
    """As Smoother, to the bit, in blocks:

        with StreamedSmoother(model, "f32", folder) as smoother:
            for rows in blocks: smoother.add(rows)
            for first, rows in smoother.rows(): smoother.take(rows)     the filter's Run of these rows
            for first, rows, run in smoother.smoothed(): ...            and all of it

    `filter` is the filter at the end; the files are in `folder`, and gone with this object.
    """

    def __init__(self, model: Model, arithmetic: str, folder: Path, block: int, robust: Optional[Robust] = None):
        self.model, self.parts, self.block, self.robust = model, Parts(model.frame, arithmetic), block, robust
        self.filter: Optional[_Streamed] = None
        self._folder, self._stack = folder, ExitStack()
        self._count, self._inputs, self._has_times = 0, 0, False

    def __enter__(self) -> StreamedSmoother:
        self._rows, self._results, self._tape = (self._file() for _ in range(3))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _file(self) -> IO[bytes]:
        with telling_where(self._folder):
            return self._stack.enter_context(tempfile.TemporaryFile(dir=self._folder))

    def add(self, rows: Rows) -> None:
        """rows: u as a file has it"""
        self._has_times, self._inputs = rows.times is not None, 0 if rows.u is None else rows.u.shape[1]
        self._write(self._rows, np.column_stack([one for one in (rows.z, rows.u, rows.times) if one is not None]))
        self._count += len(rows)

    @property
    def _width(self) -> int:
        return self.model.m + self._inputs + self._has_times

    def _rows_of(self, made: np.ndarray) -> Rows:
        m, l = self.model.m, self._inputs
        return Rows(made[:, :m], made[:, m : m + l] if l else None, made[:, m + l] if self._has_times else None)

    def rows(self) -> Iterator[tuple[int, Rows]]:
        """The number of the first of them, and the rows"""
        for first, made in self._read(self._rows, self._width):
            yield first, self._rows_of(made)

    def take(self, rows: Rows) -> Run:
        if self.filter is None:
            self.filter = self._begun()
        run = self.filter.run(rows.z, rows.u, times=rows.times, robust=self.robust)
        self._write(self._results, np.column_stack([getattr(run, name) for name in KEPT]))
        self.filter.tape.drop()
        return run

    def _begun(self) -> _Streamed:
        """Rows until the start is known are counted in them all"""
        self._rows.flush()
        whole = np.memmap(self._rows, np.float64, "r", shape=(self._count, self._width))
        rows = self._rows_of(whole[:EARLY_MAX])
        with telling_where(self._folder):
            return _Streamed(self.model, self.parts, Rows.of(self.model, rows.z, rows.u, rows.times), self._count, self._tape)

    def smoothed(self) -> Iterator[tuple[int, Rows, Run]]:
        if self.filter is None:
            return
        self.filter._smooth(means_only=False)
        n, m = self.model.n, self.model.m
        ends = np.cumsum([n, n, m, m, 1])
        for (first, made), (_, rows) in zip(self._read(self._results, int(ends[-1]) + 1), self.rows()):
            mean, sigma, innovation, spread, nis, likelihood = np.split(made, ends, axis=1)
            run = Run(self.model, self.parts.arithmetic.name, mean=mean, sigma=sigma, innovation=innovation,
                      innovation_sigma=spread, nis=nis[:, 0], log_likelihood=likelihood[:, 0], events=self.filter.events)
            self.filter.read(run, first)
            run.fed = Rows.of(self.model, rows.z, rows.u, rows.times).fed if self.filter.has_rows else None
            yield first, rows, run

    def _write(self, file: IO[bytes], rows: np.ndarray) -> None:
        with telling_where(self._folder):
            file.write(np.ascontiguousarray(rows, np.float64).tobytes())

    def _read(self, file: IO[bytes], columns: int) -> Iterator[tuple[int, np.ndarray]]:
        for first in range(0, self._count, self.block):
            file.seek(8 * columns * first)
            made = np.frombuffer(file.read(8 * columns * self.block), np.float64)
            yield first, made.reshape(-1, columns)


class _Streamed(_Recording):
    """Its history is in a file: what is not at work is not in memory."""

    def __init__(self, model: Model, parts: Parts, rows: Rows, count: int, file: IO[bytes]):
        self.tape = _Tape(file)
        super().__init__(model, parts, rows, count)

    def _space(self, stem: str, length: int) -> np.ndarray:
        return self.tape.array(self.arithmetic.number, length) if stem == "history" else super()._space(stem, length)

    def _smooth(self, means_only: bool) -> None:
        """kq_smooth, a step at a time"""
        step, steps = self.arithmetic.function("smooth_step"), self.arithmetic.function("history_steps")(self._history)
        null = self._pointer(None)
        for k in range(int(steps)):
            require(step(self._history, null, null), "smoother")
            if k % 65536 == 65535:
                self.tape.drop()
        if self.is_unknown:
            require(self.arithmetic.function("diffuse_smooth")(self._start), "smoother")

    def read(self, run: Run, first: int) -> None:
        what, source = ("diffuse", self._start) if self.is_unknown else ("history", self._history)
        self.read_smoothed(run, what, source, False, first=first)
        run.events |= self.smoothing_events(self._history) | self.events
        self.tape.drop()


class _Tape:
    """A file that is an array"""

    def __init__(self, file: IO[bytes]):
        self._file = file
        self._map: Any = None

    def array(self, number: np.dtype, length: int) -> np.ndarray:
        size = max(length, 1) * number.itemsize
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(self._file.fileno(), 0, size)  # a full disk is told here, and not by a signal
        else:
            self._file.truncate(size)
        self._map = mmap.mmap(self._file.fileno(), size)
        return np.frombuffer(self._map, number, length)

    def drop(self) -> None:
        """Out of memory; the file has it"""
        if hasattr(mmap, "MADV_DONTNEED"):
            self._map.madvise(mmap.MADV_DONTNEED)
