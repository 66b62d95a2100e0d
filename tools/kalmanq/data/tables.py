"""Tables: read in blocks, so that files of any length fit."""

from __future__ import annotations

import warnings
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any, Iterator, Mapping, Optional, Sequence, Union

import numpy as np

from kalmanq.data.blocks import Block, joined
from kalmanq.data.csv_rows import CsvRows
from kalmanq.data.ground import AXES, Begun, Ground
from kalmanq.data.instants import Instants
from kalmanq.data.layouts import MISSING, AnySource, Source, TableError, column_of, first_of, place_of, places_of, source_of
from kalmanq.data.letters import opened
from kalmanq.data.moments import DATE, Together, iso_of, places_said
from kalmanq.data.readers import KNOWN, Recorded, Row, reader_of, recorded
from kalmanq.data.time_columns import TimeColumn, judge_units
from kalmanq.data.times import Times, time_column, unnamed_times
from kalmanq.data.values import Values, more
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import ColumnModel, Model, Quantity


NO_NAMES = ("", "index", "Unnamed: 0")  # of a column of which its table says nothing
RESAMPLE = "resample the data, with empty rows where there are none"  # where rows are steps, and their times irregular
BY_STEP = f"let f and Q take dt, as f(x, t, u, dt) does, or {RESAMPLE}"
CONTINUOUS = f"give F, Qc and dt in the place of A and Q, or {RESAMPLE}"


@dataclass(frozen=True)
class Wanted:
    """What is read of a table.

    quantities  columns; an empty cell is NaN, other columns are left out
    optional    columns that are read, too, where all of them are there
    has_to_fit  a value beyond the range that its quantity declares is refused; otherwise it is warned of
    dt          of a model in continuous time: a column of times is read, too; otherwise it is warned of where it is irregular
    cure        of that; of a model in continuous time none, but where rows have times and steps are all alike
    repeats     rows may be of one time: steps of no length are none
    controls    columns whose last cell at a time holds
    may_lack    some of the columns are in another file; is_alone: it is not one of several files that are joined
    stamps      columns of times beside those of the rows, where they are there
    recording   what the model file says of the table
    """

    quantities: Sequence[Union[str, Quantity]]
    optional: Sequence[str] = ()
    has_to_fit: bool = False
    dt: Optional[float] = None
    cure: str = RESAMPLE
    repeats: bool = False
    controls: Sequence[str] = ()
    may_lack: bool = False
    is_alone: bool = True
    stamps: Sequence[str] = ()
    recording: Mapping[str, Any] = field(default_factory=dict)


def wanted_of(model: Any, **more: Any) -> Wanted:
    """A model's measurements and controls, and times where it takes rows at their times"""
    return Wanted(**{
        "quantities": [*model.measurements, *model.inputs], "dt": dt_of(model), "cure": cure_of(model), "repeats": may_repeat(model), "controls": [one.name for one in model.inputs],
        "recording": model.recording, **more})


def read(data: AnySource, wanted: Union[Wanted, Sequence[Union[str, Quantity]]], rows: int = 65536, **how: Any) -> Iterator[Block]:
    """In blocks of so many rows; how: of Wanted, where `wanted` are columns"""
    with opened_table(source_of(data), wanted if isinstance(wanted, Wanted) else Wanted(wanted, **how)) as table:
        yield from table.all_blocks(rows)


@contextmanager
def opened_table(source: Source, wanted: Wanted) -> Iterator[Table]:
    source = source.said(wanted.recording)
    for option, is_given in (("--sort", source.layout.sort), ("--skip-untimed", source.layout.skip_untimed),
                             ("--pause", source.layout.pause is not None), ("--jitter", source.layout.jitter is not None)):
        if is_given and wanted.dt is None:
            raise KalmanqError(f"{option}: where rows are at their times: of a linear model with F, Qc and dt, or functions of t or dt")
    reader = reader_of(source)
    if reader:
        yield Table(recorded(source, reader), wanted)
        return
    with opened(source, KNOWN) as text:
        yield Table(CsvRows(source, text, [column_of(source, _quantity(one)) for one in wanted.quantities]), wanted)


def _quantity(one: Union[str, Quantity]) -> Quantity:
    return Quantity(one) if isinstance(one, str) else one


class Table:
    """Rows that are read once from the first to the last.  times: its column of times, if it is read"""

    def __init__(self, of: Union[CsvRows, Recorded], wanted: Wanted):
        self.source, self._of, self._how = of.source, of, wanted
        self._ground = Ground(of.source, of.header)
        cells = [*of.header, *(f"{axis} [m]" for axis in self._ground.axes)]  # which are made of latitude and longitude
        self._is_first = True
        self._untimed = (0, 0)  # rows that were left out: the first one, and how many
        self._values = Values(self.source, wanted.has_to_fit)
        self._wanted = list(map(_quantity, wanted.quantities))
        self._refuse_names([one.name for one in self._wanted])
        if wanted.may_lack:
            self._wanted = [one for one in self._wanted if places_of(self.source, cells, one)]
        self._places = [place_of(self.source, cells, one, of.line) for one in self._wanted]
        if not any(place >= len(of.header) for place in self._places):
            self._ground.axes = ()
        if wanted.optional and set(wanted.optional) <= set(cells):
            self._wanted += map(_quantity, wanted.optional)
            self._places += [place_of(self.source, cells, _quantity(name), of.line) for name in wanted.optional]
        self._line = self._begun_at = of.line + 1  # of the next row
        self._find_times(of.header)

    def _find_times(self, cells: list[str]) -> None:
        source, dt, cure = self.source, self._how.dt, self._how.cure
        stamped = {name: place_of(source, cells, _quantity(name), self._of.line) for name in self._how.stamps if name in cells}
        names = [_quantity(one).name for one in self._how.quantities] if dt is None or cure else ()
        taken = [*(place for place in self._places if place < len(cells)), *stamped.values(), *(self._ground.places if self._ground.axes else ())]
        self._rows = self._of.rows(taken)
        first = self._first_row()
        place = None if places_said(source, cells) else time_column(source, cells, taken, names)
        if place is None and not source.layout.time and cells[0] in NO_NAMES and 0 not in taken and first and DATE.match(iso_of(first[0].strip())):
            place = 0  # the index of a table of pandas
        self._clock = Together(source, cells, first, place, taken)
        place = min(self._clock.places.values(), default=place)
        self._unnamed = cells if place is None and dt is not None and self._how.is_alone and not source.layout.time else None
        self.times = None if dt is None or place is None else TimeColumn(source, cells[place], place, dt, self._how.repeats)
        self._stamps = {name: TimeColumn(source, name, where, dt) for name, where in stamped.items()} if self.times else {}
        self._judged = None if place is None or self.times and not cure else Times(cells[place], place)

    def _refuse_names(self, names: Sequence[str]) -> None:
        for name in self.source.layout.rename:
            if name not in names:
                raise KalmanqError(f"--rename: there is no {name}; there are {', '.join(names)}")

    @property
    def names(self) -> list[str]:
        return [one.name for one in self._wanted]

    @property
    def begun(self) -> Begun:
        return Begun(self._ground.origin, self.times.date if self.times else None)

    def all_blocks(self, rows: int) -> Iterator[Block]:
        made = iter([self.sorted(rows)]) if self.source.layout.sort else self.blocks(rows)
        return Instants(self.source, self._how.controls).of(made) if self.times and self._how.repeats else made

    def blocks(self, rows: int) -> Iterator[Block]:
        cells: list[Row] = []
        for row in self._rows:
            cells.append(row)
            if len(cells) >= rows:
                yield from self._block(cells)
                cells = []
        if not cells and self._line == self._begun_at:
            raise TableError(self.source, "no data below the header")
        if cells:
            yield from self._block(cells)
        self._values.warn()
        if self._untimed[1]:
            warnings.warn(f"{self.source}: row {self._untimed[0]}: has no time, and is left out{more(self._untimed[1])}", KalmanqWarning, stacklevel=2)
        if self._judged:
            self._judged.warn(str(self.source), self._how.cure)

    def sorted(self, rows: int) -> Block:
        """All of it, by the times"""
        block = joined(list(self.blocks(rows)))
        if block.times is None:
            raise TableError(self.source, "--sort: there is no column of times; --time says which it is")
        order = np.argsort(block.times, kind="stable")
        lines = np.array([block.line(int(k)) for k in order])
        twice = np.flatnonzero(np.diff(block.times[order]) == 0)
        if len(twice) and not self._how.repeats:
            raise TableError(self.source, f"has the time of row {lines[twice[0]]}, too: join the two, or leave one out",
                             int(lines[twice[0] + 1]))
        return replace(block, columns={name: one[order] for name, one in block.columns.items()}, times=block.times[order], lines=lines)

    def _block(self, rows: list[Row]) -> Iterator[Block]:
        """None where no row is left of them"""
        lines, self._line = range(self._line, self._line + len(rows)), self._line + len(rows)
        if self.times and self.source.layout.skip_untimed:
            rows, lines = self._timed(rows, lines)
        if rows:
            yield self._made(rows, lines)

    def _timed(self, rows: list[Row], lines: range) -> tuple[list[Row], Sequence[int]]:
        """Without rows that have no time"""
        is_timed = [cell.lower() not in MISSING for cell in self._cells_of_times(self.times.place, rows)]
        left_out = [line for line, is_there in zip(lines, is_timed) if not is_there]
        if not left_out:
            return rows, lines
        self._untimed = self._untimed[0] or left_out[0], self._untimed[1] + len(left_out)
        return [row for row, is_there in zip(rows, is_timed) if is_there], [line for line, is_there in zip(lines, is_timed) if is_there]

    def _made(self, rows: list[Row], lines: Sequence[int]) -> Block:
        width = len(self._of.header)
        columns = [[row[place].strip() for row in rows] if place < width else [] for place in self._places]
        self._values.look(columns)
        ground = self._on_ground(rows, lines)
        made = {one.name: self._values.take(one, self._values.numbers(one, cells, lines) if place < width else ground[AXES[place - width]], lines)
                for one, cells, place in zip(self._wanted, columns, self._places)}
        column = self.times or self._judged
        cells = self._cells_of_times(column.place, rows) if column else []
        times = self.times.read(cells, lines) if self.times else None
        for name, one in self._stamps.items():
            made[name] = one.stamps([row[one.place].strip() for row in rows], lines, self.times)
        if self.times and self._is_first and self._how.is_alone:
            judge_units([self.times])
        self._is_first = False
        if self._judged:
            self._judged.look(cells, lines[0])
        if self._unnamed:
            self._warn_of_unnamed_times(self._unnamed, rows)
        return Block(lines[0], made, times, None if isinstance(lines, range) else np.array(lines),
                     begun=self.begun)

    def _on_ground(self, rows: list[Row], lines: Sequence[int]) -> dict[str, np.ndarray]:
        if not self._ground.axes:
            return {}
        columns = [[row[place].strip() for row in rows] for place in self._ground.places]
        self._values.look(columns)
        return self._ground.metres([self._values.numbers(Quantity(self._of.header[place]), cells, lines)
                                    for place, cells in zip(self._ground.places, columns)], lines)

    def _cells_of_times(self, place: int, block: list[Row]) -> list[str]:
        return list(map(self._clock.cell, block)) if self._clock.places else [row[place].strip() for row in block]

    def _first_row(self) -> Row:
        first = next(self._rows, [])
        self._rows = chain([first] if first else [], self._rows)
        return first

    def _warn_of_unnamed_times(self, header: list[str], block: list[Row]) -> None:
        self._unnamed = None
        name = unnamed_times(header, block, self._places)
        if name is not None:
            warnings.warn(f"{self.source}: column {name} rises like a clock, and each row is taken for one step of dt: --time "
                          f"'{name} [ms]', or [s], takes it for times; --time none says that rows are steps", KalmanqWarning, stacklevel=2)


def dt_of(model: Any) -> Optional[float]:
    """In seconds, of a model whose rows may be at their times; NaN: not known; None: they are steps"""
    if not isinstance(model, Model):
        return model.dt_of_rows
    return model.continuous.dt * model.continuous.seconds if model.continuous else None


def time_name(model: Any) -> str:
    """Of a column that is written of its times"""
    return "time" if not isinstance(model, Model) or model.continuous.unit == "s" else f"time [{model.continuous.unit}]"


def cure_of(model: Any) -> str:
    """Where its rows are at irregular times, and are steps all the same"""
    if isinstance(model, Model):
        return "" if model.continuous else CONTINUOUS
    return "" if model.takes_step else BY_STEP


def may_repeat(model: Any) -> bool:
    """Of one time: is a step of no length none?"""
    return bool(model.continuous) if isinstance(model, Model) else model.has_empty_steps


def record_and(data: AnySource, model: Any, others: Sequence[str]
               ) -> tuple[np.ndarray, Optional[np.ndarray], Optional[np.ndarray], Optional[np.ndarray]]:
    """z, u, the other columns, and the times, if rows are at theirs"""
    block = joined(list(read(data, wanted_of(model, optional=others))))
    z, u = split(block, model, data)
    is_there = bool(others) and all(name in block.columns for name in others)
    return z, u, np.column_stack([block.columns[name] for name in others]) if is_there else None, block.times


def split(block: Block, model: Any, data: Any) -> tuple[np.ndarray, Optional[np.ndarray]]:
    z = np.column_stack([block.columns[one.name] for one in model.measurements])
    own = getattr(model, "linear", None) or model  # of a linear model as functions, that
    if isinstance(own, ColumnModel):
        made = inputs_in(block, own, z, data)
        return z, made if own is model else _filled(made)
    return z, controls_in(block, model.inputs, data) if model.inputs else None


def _filled(inputs: np.ndarray) -> np.ndarray:
    """With a value from another row where a row needs none: functions have one of each column"""
    for column in inputs.T:
        there = np.flatnonzero(~np.isnan(column))
        column[:] = column[there[np.clip(np.searchsorted(there, np.arange(len(column)), "right") - 1, 0, None)]] if len(there) else 1.0
    return inputs


def inputs_in(block: Block, model: ColumnModel, z: np.ndarray, data: Any) -> np.ndarray:
    """Controls, and columns of which what a row needs is there"""
    own = model.inputs[: len(model.inputs) - len(model.columns)]
    parts = [controls_in(block, own, data)] if own else []
    made = np.column_stack([*parts, *(block.columns[one.name] for one in model.columns)])
    try:
        model.matrices(made, z)
    except KalmanqError as problem:
        raise KalmanqError(f"{first_of(data)}: {block.place(problem.row or 0)}: {problem.text}") from problem
    return made


def controls_in(block: Block, controls: Sequence[Quantity], data: Any) -> np.ndarray:
    u = np.column_stack([block.columns[one.name] for one in controls])
    if np.any(np.isnan(u)):
        row, column = map(int, np.argwhere(np.isnan(u))[0])
        raise TableError(first_of(data), "a control is missing: fill it in, or leave the row out; only measurements may be missing", block.line(row), controls[column].name)
    return u
