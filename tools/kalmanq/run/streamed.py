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
from kalmanq.run.filters import _Recording
from kalmanq.run.parts import Parts
from kalmanq.run.results import Run

KEPT = ("mean", "sigma", "innovation", "innovation_sigma", "nis", "log_likelihood")  # of the filter, at every row


class StreamedSmoother:
    """As Smoother, to the bit, in blocks:

        with StreamedSmoother(model, "f32", folder) as smoother:
            for z, u in blocks: smoother.add(z, u)
            for first, z, u in smoother.rows(): smoother.take(z, u)     the filter's Run of these rows
            for first, z, run in smoother.smoothed(): ...               and all of it

    `filter` is the filter at the end; the files are in `folder`, and gone with this object.
    """

    def __init__(self, model: Model, arithmetic: str, folder: Path, block: int):
        self.model, self.parts, self.block = model, Parts(model, arithmetic), block
        self.filter: Optional[_Streamed] = None
        self._folder, self._stack = folder, ExitStack()
        self._count = 0

    def __enter__(self) -> StreamedSmoother:
        self._rows, self._results, self._tape = (self._file() for _ in range(3))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _file(self) -> IO[bytes]:
        with telling_where(self._folder):
            return self._stack.enter_context(tempfile.TemporaryFile(dir=self._folder))

    def add(self, z: np.ndarray, u: Optional[np.ndarray]) -> None:
        self._write(self._rows, z if u is None else np.column_stack([z, u]))
        self._count += len(z)

    def rows(self) -> Iterator[tuple[int, np.ndarray, Optional[np.ndarray]]]:
        """The number of the first of them, z and u"""
        m = self.model.m
        for first, made in self._read(self._rows, m + self.model.l):
            yield first, made[:, :m], made[:, m:] if self.model.l else None

    def take(self, z: np.ndarray, u: Optional[np.ndarray]) -> Run:
        if self.filter is None:
            self.filter = self._begun()
        run = self.filter.run(z, u)
        self._write(self._results, np.column_stack([getattr(run, name) for name in KEPT]))
        self.filter.tape.drop()
        return run

    def _begun(self) -> _Streamed:
        """Rows until the start is known are counted in them all"""
        self._rows.flush()
        whole = np.memmap(self._rows, np.float64, "r", shape=(self._count, self.model.m + self.model.l))
        z, u = whole[:, : self.model.m], whole[:, self.model.m :] if self.model.l else None
        with telling_where(self._folder):
            return _Streamed(self.model, self.parts, Rows(z, u), self._tape)

    def smoothed(self) -> Iterator[tuple[int, np.ndarray, Run]]:
        if self.filter is None:
            return
        self.filter._smooth(means_only=False)
        n, m = self.model.n, self.model.m
        ends = np.cumsum([n, n, m, m, 1])
        rows = self._read(self._rows, m + self.model.l)
        for (first, made), (_, given) in zip(self._read(self._results, int(ends[-1]) + 1), rows):
            mean, sigma, innovation, spread, nis, likelihood = np.split(made, ends, axis=1)
            run = Run(self.model, self.parts.arithmetic.name, mean=mean, sigma=sigma, innovation=innovation,
                      innovation_sigma=spread, nis=nis[:, 0], log_likelihood=likelihood[:, 0], events=self.filter.events)
            self.filter.read(run, first)
            yield first, given[:, :m], run

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

    def __init__(self, model: Model, parts: Parts, rows: Rows, file: IO[bytes]):
        self.tape = _Tape(file)
        super().__init__(model, parts, rows)

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
