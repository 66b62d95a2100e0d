"""Several files of data, joined by their times: a row for each time, with what is there of it in each file.

What a sensor tells late is in the row of the time that it was measured at.
"""

from __future__ import annotations

import warnings
from contextlib import ExitStack
from dataclasses import replace
from itertools import groupby
from typing import Any, ContextManager, Iterable, Iterator, Optional, Sequence

import numpy as np

from kalmanq.data.blocks import Block, joined, part_of
from kalmanq.data.layouts import Source, TableError, first_of, source_of
from kalmanq.data.tables import Table, dt_of, opened_table, read, split, wanted_of
from kalmanq.data.time_columns import judge_units
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import ColumnModel, Model
from kalmanq.model.model import Sensor

SAME = 1e-6  # of dt, between times of two files that are one


def blocks_of(data: Any, model: Any, rows: int = 65536, has_to_fit: bool = False) -> Iterator[Block]:
    """A model's columns of a file, or of several, and where the model is in continuous time, the times in its unit"""
    of = model.continuous if isinstance(model, Model) else None
    for block in _in_seconds(data, model, rows, has_to_fit):
        is_other = of is not None and of.unit != "s" and block.times is not None
        yield replace(block, times=block.times / of.seconds, unit=of.unit) if is_other else block


def _in_seconds(data: Any, model: Any, rows: int, has_to_fit: bool) -> Iterator[Block]:
    sources = list(map(source_of, data if isinstance(data, (list, tuple)) else [data]))
    if len(sources) == 1 and not _sensors_of(model):
        yield from read(sources[0], wanted_of(model, has_to_fit=has_to_fit), rows)
        return
    refuse_several(sources, model)
    yield from _joined(sources, model, rows, has_to_fit)


def refuse_several(sources: Sequence[Source], model: Any) -> None:
    if len(sources) > 1 and dt_of(model) is None:
        raise KalmanqError(f"{sources[1]}: several files are joined by their times: of a linear model with F, Qc and dt, or a nonlinear one "
                           "whose functions take t or dt")


def record(data: Any, model: Any, has_to_fit: bool = False) -> tuple[np.ndarray, Optional[np.ndarray], Optional[np.ndarray]]:
    """All rows of a model's columns: z (T x m), u (T x l) or None, and times (T) or None.  With pauses the longest record between them"""
    found = records_between(data, model, has_to_fit)
    longest = max(found, key=lambda one: one.length)
    if len(found) > 1:
        where = " to ".join(longest.place(row) for row in (0, longest.length - 1))
        warnings.warn(f"{', '.join(map(str, data)) if isinstance(data, (list, tuple)) else data}: there are {len(found)} records, and the longest is "
                      f"taken, {where}: run and fit take all", KalmanqWarning, stacklevel=2)
    return *split(longest, model, data), longest.times


def records_between(data: Any, model: Any, has_to_fit: bool = False) -> list[Block]:
    """All rows; where there is a pause, a record for each part"""
    made = groupby(cut(blocks_of(data, model, has_to_fit=has_to_fit), data, model), key=lambda one: one[0])
    return [joined([block for _, block in part]) for _, part in made]


def cut(blocks: Iterable[Block], data: Any, model: Any) -> Iterator[tuple[int, Block]]:
    """Blocks and the number of their record: a pause begins a new one"""
    layout = first_of(data).said(model.recording).layout
    of = getattr(model, "continuous", None)
    pause = np.inf if layout.pause is None else layout.pause / (of.seconds if of else 1.0)
    number, last = 0, np.nan
    for block in blocks:
        if block.times is None:
            yield 0, block
            continue
        begins = np.flatnonzero(np.diff(block.times, prepend=last) > pause)
        last = block.times[-1]
        for first, end in zip([0, *begins], [*begins, block.length]):
            number += first in begins
            if end > first:
                yield number, part_of(block, slice(int(first), int(end)))


def records_of(data: Sequence[Any], model: Any) -> list[list[Source]]:
    """The files of each record: those that follow each other without a column in common are one, joined by their times"""
    sources = list(map(source_of, data))
    if len(sources) == 1 or dt_of(model) is None:  # steps have no times
        return [[one] for one in sources]
    made: list[list[Source]] = []
    taken: set[str] = set()
    for source in sources:
        names = _columns_of(source, model)
        if made and not taken & names:
            made[-1].append(source)
            taken |= names
        else:
            made.append([source])
            taken = names
    return made


def _columns_of(source: Source, model: Any) -> set[str]:
    if source.is_standard_input or source.path.is_fifo():
        raise TableError(source, "is one of several, which are read twice: write it to a file")
    with _opened(source, model) as table:
        return set(table.names)


def _opened(source: Source, model: Any, **how: Any) -> ContextManager[Table]:
    """One of several files: a column may be in another one"""
    return opened_table(source, wanted_of(model, may_lack=True, stamps=[one.measured for one in _sensors_of(model) if one.measured], **how))


def _sensors_of(model: Any) -> Sequence[Sensor]:
    """Of a model file: their columns come and go together"""
    return model.sensors if isinstance(model, Model) else getattr(model, "late_sensors", ())


def _columns_with(model: Any, sensor: Sensor) -> list[str]:
    """Columns that are of this sensor's measurements, and are as late as these"""
    own = model.measured_with() if isinstance(model, ColumnModel) else {}
    made = [name for name, of in own.items() if of & set(sensor.measurements)]
    for name in made:
        if own[name] - set(sensor.measurements):
            raise KalmanqError(f"{name}: is of {sensor.name}, which is late, and of {min(own[name] - set(sensor.measurements))}: give each a column of its own")
    return made


def _joined(sources: Sequence[Source], model: Any, rows: int, has_to_fit: bool) -> Iterator[Block]:
    """In the order of time.  A measurement that is not there is missing; a control stays until the next one."""
    names = [one.name for one in (*model.measurements, *model.inputs)]
    with ExitStack() as stack:
        made = [stack.enter_context(_opened(source, model, has_to_fit=has_to_fit, is_alone=len(sources) == 1)) for source in sources]
        _require_columns(made, model)
        unit = model.continuous.seconds if getattr(model, "continuous", None) else 1.0
        late = [([*one.measurements, *_columns_with(model, one)], unit * one.delay, one.measured) for one in _sensors_of(model) if one.delay]
        if len(made) == 1 and not late:
            yield from (_completed(block, names) for block in made[0].all_blocks(rows))
            return _tell_of_absent(made, model)
        held = _Held(model, made)
        of_rows = [name for name in held.names if len(made) == 1]
        for block in _merged([_File(one, rows, late, of_rows) for one in made], names, dt_of(model)):
            yield replace(held.filled(block), begun=next((one.begun for one in made if one.begun.place), None))
        _tell_of_absent(made, model)


def _require_columns(tables: Sequence[Table], model: Any) -> None:
    """Each column is in one file; a sensor may be in none, as a whole"""
    said, names = ", ".join(str(one.source) for one in tables), [one.name for one in (*model.measurements, *model.inputs)]
    own = model.measured_with() if isinstance(model, ColumnModel) else {}
    for one in tables:
        if len(tables) > 1 and one.times is None:
            raise TableError(one.source, "there is no column of times, by which files are joined; --time says which it is")
        if len(tables) > 1 and not one.names:
            raise TableError(one.source, f"there is no column of the model, {', '.join(names)} (--rename {names[0]}=... says which it is)")
    for name in names:
        there = [one for one in tables if name in one.names]
        if len(there) > 1:
            raise KalmanqError(f"{said}: column {name} is in {there[0].source} and in {there[1].source}: leave one out")
        sensor = next((one for one in _sensors_of(model) if name in one.measurements), None)
        of = sensor.measurements if sensor else own.get(name)
        is_alone = of is None or any(other in table.names for other in of for table in tables)
        if not there and is_alone:
            raise KalmanqError(f"{said}: there is no column {name}" + (f" of the sensor {sensor.name}" if sensor else "")
                               + f" (--rename {name}=... says which it is)")
    if not any(one.name in table.names for one in model.measurements for table in tables):
        raise KalmanqError(f"{said}: there is no column of any sensor: {', '.join(one.name for one in model.measurements)} (--rename NAME=COLUMN)")


def _tell_of_absent(tables: Sequence[Table], model: Any) -> None:
    """At the end: what goes wrong before is an error of one line"""
    said = ", ".join(str(one.source) for one in tables)
    for sensor in _sensors_of(model):
        if not any(name in one.names for name in sensor.measurements for one in tables):
            columns = [one.reading.column or one.name for one in model.measurements if one.name in sensor.measurements]
            warnings.warn(f"{said}: there is no column {' or '.join(columns)}: {sensor.name or 'the sensor'} is never measured", KalmanqWarning, stacklevel=2)


def _completed(block: Block, names: Sequence[str]) -> Block:
    nothing = np.full(block.length, np.nan)
    return replace(block, columns={name: block.columns.get(name, nothing) for name in names})


class _File:
    """A file that is being read: its columns by how late they are (names, delay, the column of their own times).  A table without times has a row each dt, or, of steps,
    each 1.  complete: columns that each row has"""

    def __init__(self, table: Table, rows: int, late: Sequence[tuple[list[str], float, str]], complete: Sequence[str]):
        self.table, self._blocks, self._count, self._complete = table, table.all_blocks(rows), 0, complete
        self.known, self.first_row, self.first = -np.inf, 2, np.inf  # up to where; its line; the time of its first row
        delayed = [(delay, names, measured) for names, delay, measured in late if set(names) & set(table.names)]
        in_time = [name for name in table.names if not any(name in names for _, names, _ in delayed)]
        self.parts = [_Waiting(self, 0, in_time), *(_Waiting(self, *one) for one in delayed)]

    def read(self, dt: float) -> None:
        block = next(self._blocks, None)
        if block is None:
            self.known = np.inf
            return
        for name in self._complete:
            if np.any(np.isnan(block.columns[name])):
                raise TableError(self.table.source, "a control is missing", block.line(int(np.argmax(np.isnan(block.columns[name])))),
                                 name)
        self.first_row = self.first_row if self._count else block.first_row
        times = dt * np.arange(self._count, self._count + block.length) if block.times is None else block.times
        self.first = min(self.first, float(times[0])) if len(times) else self.first
        self._count += block.length
        self.known = times[-1]
        for part in self.parts:
            part.add(times, block)


class _Waiting:
    """Rows that have been read, and wait for those of other files.  measured: a column of their own times, `delay` before the
    row's at most"""

    def __init__(self, file: _File, delay: float, names: Sequence[str], measured: str = ""):
        self.file, self._delay, self._measured = file, delay, measured
        self.times, self.columns, self._begin = np.zeros(0), {name: np.zeros(0) for name in names}, -np.inf

    def begin(self, first: float) -> None:
        """Drops what was measured before the first row: no step has it."""
        if self._delay:
            self._begin, is_there = first, self.times >= first
            self.times, self.columns = self.times[is_there], {name: one[is_there] for name, one in self.columns.items()}

    @property
    def known(self) -> float:
        return self.file.known - self._delay

    def add(self, times: np.ndarray, block: Block) -> None:
        columns, is_there, own = block.columns, np.ones(len(times), bool), times - self._delay
        if self._delay:
            is_there = np.any([~np.isnan(columns[name]) for name in self.columns], axis=0)
        if self._measured:
            own = self._own(times, is_there, block)
        is_there &= own >= self._begin
        own = np.concatenate([self.times, own[is_there]])
        order = np.argsort(own, kind="stable")
        self.times = own[order]
        self.columns = {name: np.concatenate([one, columns[name][is_there]])[order] for name, one in self.columns.items()}

    def _own(self, times: np.ndarray, is_there: np.ndarray, block: Block) -> np.ndarray:
        """When the measurements of each row were made"""
        source, name, near = self.file.table.source, self._measured, 1e-9 * self._delay + 4 * np.spacing(np.abs(times))
        if name not in block.columns:
            raise TableError(source, f"there is no column {name}, or no times of rows beside it")
        own = np.where(is_there, block.columns[name], np.nan)
        for wrong, said in ((np.isnan(own), "the time that it was measured at is missing"), (own > times + near, "is after the row's time"),
                            (times - own > self._delay + near, f"is more than {self._delay:g} s before the row's: make the sensor's delay longer")):
            if np.any(wrong & is_there):
                raise TableError(source, said, block.line(int(np.argmax(wrong & is_there))), name)
        return np.where(is_there, own, -1.0)

    def taken(self, until: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        count = int(np.searchsorted(self.times, until, side="right"))
        made = self.times[:count], {name: one[:count] for name, one in self.columns.items()}
        self.times, self.columns = self.times[count:], {name: one[count:] for name, one in self.columns.items()}
        return made


def _merged(files: Sequence[_File], names: Sequence[str], time_of_row: Optional[float]) -> Iterator[Block]:
    dt = float(np.nan_to_num(1.0 if time_of_row is None else time_of_row))  # NaN: none is known
    columns = [one.table.times for one in files if one.table.times]
    for one in files:
        if one.table.times:
            one.table.times.origin = columns[0].origin
        one.read(dt)
    if len(files) > 1:
        judge_units(columns)
    parts, line = [part for one in files for part in one.parts], files[0].first_row
    for part in parts:
        part.begin(min(one.first for one in files) - SAME * dt)
    while True:
        until = min(one.known for one in parts)
        block = _rows([one.taken(until - dt) for one in parts], names, dt)  # what is as good as at `until` may come yet
        if time_of_row is None:
            block = Block(line, block.columns)
            line += block.length
        if block.length:
            yield block
        if until == np.inf:
            return
        min(parts, key=lambda one: one.known).file.read(dt)


def _rows(parts: Sequence[tuple[np.ndarray, dict[str, np.ndarray]]], names: Sequence[str], dt: float) -> Block:
    """A row for each time; times of two files that are nearly one are one"""
    times = np.concatenate([own for own, _ in parts])
    of = np.repeat(np.arange(len(parts)), [len(own) for own, _ in parts])
    order = np.argsort(times, kind="stable")
    is_new = np.ones(len(times), bool)
    near = SAME * dt + 4 * np.spacing(np.abs(times[order][1:]))
    is_new[1:] = (np.diff(times[order]) > near) | (np.diff(of[order]) == 0)
    row = np.empty(len(times), int)
    row[order] = np.cumsum(is_new) - 1
    made, begin = {name: np.full(int(is_new.sum()), np.nan) for name in names}, 0
    for own, given in parts:
        for name, values in given.items():
            made[name][row[begin : begin + len(own)]] = values
        begin += len(own)
    return Block(0, made, times[order][is_new], is_joined=True)


class _Held:
    """Controls, each as it was last"""

    def __init__(self, model: Any, tables: Sequence[Table]):
        own = model.measured_with() if isinstance(model, ColumnModel) else {}
        beside = {name for name, of in own.items() for table in tables if name in table.names and of & set(table.names)}
        self._sources = {name: table.source for table in tables for name in table.names}
        self.names = [one.name for one in model.inputs if one.name not in beside and one.name in self._sources]  # beside a measurement: of its row alone
        self._last = {name: np.nan for name in self.names}

    def filled(self, block: Block) -> Block:
        for name in self.names:
            values = np.concatenate([[self._last[name]], block.columns[name]])
            latest = np.maximum.accumulate(np.where(np.isnan(values), 0, np.arange(len(values))))
            made = values[latest][1:]
            if np.isnan(made[0]):
                raise TableError(self._sources[name], f"has no {name} at {block.times[0]:.9g} s, where the first file's first row "
                                 f"is 0 s: a control is there from the first row of all on")
            block.columns[name], self._last[name] = made, float(made[-1])
        return block
