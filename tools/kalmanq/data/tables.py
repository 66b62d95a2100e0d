"""CSV files: read in blocks, so that files of any length fit; written whole or not at all."""

from __future__ import annotations

import csv
import re
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Optional, Sequence, TextIO, Union

import numpy as np

from kalmanq.data.files import whole
from kalmanq.data.layouts import (
    AnySource, Numbers, Source, TableError, has_decimal_comma, opened, place_of, places_of, separator_of, source_of)
from kalmanq.data.time_columns import TimeColumn, judge_units
from kalmanq.data.times import CLOCK, DAY, Times, date_and_clock, place_of_clock, time_column, unnamed_times
from kalmanq.errors import KalmanqError, KalmanqWarning
from kalmanq.model import Model, Quantity


@dataclass(frozen=True)
class Block:
    """Some rows of a file; first_row: the line in the file of the first of them; lines: of each, where rows were sorted;
    times: of each, in seconds since the first row of all, or in the model's unit; is_joined: of several files"""

    first_row: int
    columns: dict[str, np.ndarray]
    times: Optional[np.ndarray] = None
    lines: Optional[np.ndarray] = None
    is_joined: bool = False
    unit: str = "s"

    @property
    def length(self) -> int:
        return len(next(iter(self.columns.values()))) if self.columns else len(self.times)

    def line(self, row: int) -> int:
        return self.first_row + row if self.lines is None else int(self.lines[row])

    def place(self, row: int) -> str:
        """How a message names it"""
        return f"at {self.times[row]:.9g} {self.unit}" if self.is_joined else f"row {self.line(row)}"


RESAMPLE = "resample the data, with empty rows where there are none"  # where rows are steps, and their times irregular
BY_STEP = f"let f and Q take dt, as f(x, t, u, dt) does, or {RESAMPLE}"
CONTINUOUS = f"give F, Qc and dt in the place of A and Q, or {RESAMPLE}"


def read(data: AnySource, wanted: Sequence[Union[str, Quantity]], rows: int = 65536, *, optional: Sequence[str] = (),
         has_to_fit: bool = False, dt: Optional[float] = None, cure: str = RESAMPLE) -> Iterator[Block]:
    """The columns `wanted`, in blocks of so many rows.  An empty cell is NaN; other columns are left out.

    optional    columns that are read, too, where all of them are there
    has_to_fit  a value beyond the range that its quantity declares is refused; otherwise it is warned of
    dt          of a model in continuous time: a column of times is read, too; otherwise it is warned of where it is irregular
    cure        of that; of a model in continuous time none, but where rows have times and steps are all alike
    """
    with opened_table(source_of(data), wanted, optional, has_to_fit, dt, cure) as table:
        yield from table.all_blocks(rows)


@contextmanager
def opened_table(source: Source, wanted: Sequence[Union[str, Quantity]], optional: Sequence[str] = (), has_to_fit: bool = False,
                 dt: Optional[float] = None, cure: str = RESAMPLE, may_lack: bool = False,
                 is_alone: bool = True, stamps: Sequence[str] = ()) -> Iterator[Table]:
    """As `read`; may_lack: it has some of the columns; is_alone: not one of several files that are joined; stamps: columns of
    times beside those of the rows, where they are there"""
    for option, is_given in (("--sort", source.layout.sort), ("--jitter", source.layout.jitter is not None)):
        if is_given and dt is None:
            raise KalmanqError(f"{option}: where rows are at their times: of a linear model with F, Qc and dt, or functions of t or dt")
    with opened(source) as text:
        yield Table(source, text, [_quantity(one) for one in wanted], optional, has_to_fit, dt, cure, may_lack, is_alone, stamps)


def _quantity(one: Union[str, Quantity]) -> Quantity:
    return Quantity(one) if isinstance(one, str) else one


class Table:
    """A text that is read once from its beginning to its end.  times: its column of times, if it is read"""

    def __init__(self, source: Source, text: TextIO, wanted: Sequence[Quantity], optional: Sequence[str],
                 has_to_fit: bool, dt: Optional[float], cure: str, may_lack: bool, is_alone: bool, stamps: Sequence[str] = ()):
        self.source, self._has_to_fit, self._cure, self._is_alone = source, has_to_fit, cure, is_alone
        self._beyond: dict[str, tuple[str, int, int]] = {}  # of a quantity: why, the first row, how many
        self._numbers = Numbers(source.layout)
        self._wanted = list(wanted)
        self._line = 1  # of the header, then of the next row
        header, rest = self._header(text)
        self._reader, cells = self._begun(header, rest)
        self._width = len(cells)
        if may_lack:
            self._wanted = [one for one in wanted if places_of(source, cells, one.name)]
        self._places = [place_of(source, cells, one.name, one.unit, self._line) for one in self._wanted]
        if optional and set(optional) <= set(cells):
            self._wanted += map(_quantity, optional)
            self._places += [place_of(source, cells, name, "", self._line) for name in optional]
        stamped = {name: place_of(source, cells, name, "", self._line) for name in stamps if name in cells}
        place = time_column(source, cells, [*self._places, *stamped.values()], [one.name for one in wanted] if dt is None or cure else ())
        self._clock = None if place is None or source.layout.time else place_of_clock(cells, place)
        self._unnamed = cells if place is None and dt is not None and is_alone and not source.layout.time else None
        self.times = None if dt is None or place is None else TimeColumn(source, cells[place], place, dt)
        self._stamps = {name: TimeColumn(source, name, where, dt) for name, where in stamped.items()} if self.times else {}
        self._judged = None if place is None or self.times and not cure else Times(cells[place], place)
        self._line += 1
        self._begun_at = self._line

    @property
    def names(self) -> list[str]:
        return [one.name for one in self._wanted]

    def all_blocks(self, rows: int) -> Iterator[Block]:
        return iter([self.sorted(rows)]) if self.source.layout.sort else self.blocks(rows)

    def _header(self, text: TextIO) -> tuple[str, Iterator[str]]:
        """Below lines that begin with '#', and one by which a spreadsheet tells its separator"""
        lines = iter(text)
        for line in lines:
            told = re.fullmatch(r"sep=(.)\s*", line)
            if told and not self.source.layout.separator:
                self.source = replace(self.source, layout=replace(self.source.layout, separator=told.group(1)))
            if not told and not line.startswith("#"):
                return line, lines
            self._line += 1
        return "", lines

    def _begun(self, header: str, rest: Iterator[str]) -> tuple["csv._reader", list[str]]:
        names = [one.name for one in self._wanted]
        for name in self.source.layout.rename:
            if name not in names:
                raise KalmanqError(f"--rename: there is no {name}; there are {', '.join(names)}")
        separator = separator_of(self.source, header, names, self._line)
        reader = csv.reader(chain([header], rest), delimiter=separator)
        try:
            cells = [cell.strip() for cell in next(reader, [])]
        except csv.Error as problem:
            raise TableError(self.source, str(problem), self._line) from problem
        if not any(cells):
            raise TableError(self.source, "empty, or without a header of names", self._line)
        return reader, cells

    def blocks(self, rows: int) -> Iterator[Block]:
        block, blank = [], 0  # rows without a cell: of one column, a missing number; at the end, nothing
        try:
            for row in self._reader:
                if not row:
                    blank += 1
                    continue
                if blank and self._width > 1:
                    raise TableError(self.source, "an empty row: leave it out", self._line + len(block))
                block += [[""]] * blank
                blank = 0
                if len(row) != self._width:
                    self._refuse_width(row, self._line + len(block))
                block.append(row)
                if len(block) >= rows:
                    yield self._block(block)
                    block = []
        except csv.Error as problem:
            raise TableError(self.source, str(problem), self._begun_at - 2 + self._reader.line_num) from problem
        if not block and self._line == self._begun_at:
            raise TableError(self.source, "no data below the header")
        if block:
            yield self._block(block)
        for why, line, count in self._beyond.values():
            more = f" (and {count - 1} more)" if count > 1 else ""
            warnings.warn(f"{self.source}: row {line}: {why}{more}", KalmanqWarning, stacklevel=2)
        if self._judged:
            self._judged.warn(str(self.source), self._cure)

    def sorted(self, rows: int) -> Block:
        """All of it, by the times"""
        block = joined(list(self.blocks(rows)))
        if block.times is None:
            raise TableError(self.source, "--sort: there is no column of times; --time says which it is")
        order = np.argsort(block.times, kind="stable")
        lines = block.first_row + order
        twice = np.flatnonzero(np.diff(block.times[order]) == 0)
        if len(twice):
            raise TableError(self.source, f"has the time of row {lines[twice[0]]}, too: join the two, or leave one out",
                             int(lines[twice[0] + 1]))
        return Block(block.first_row, {name: one[order] for name, one in block.columns.items()}, block.times[order], lines)

    def _refuse_width(self, row: list[str], line: int) -> None:
        fields = "1 field" if len(row) == 1 else f"{len(row)} fields"
        is_decimal = any(has_decimal_comma([f"{whole},{part}"]) for whole, part in zip(row, row[1:]))
        hint = "" if len(row) > self._width else ": fill it in, or leave the row out"
        hint = "; if its comma is a decimal one: --decimal ," if len(row) > self._width and is_decimal else hint
        raise TableError(self.source, f"{fields}, not {self._width}{hint}", line)

    def _block(self, block: list[list[str]]) -> Block:
        columns = [[row[place].strip() for row in block] for place in self._places]
        self._numbers.look(columns)
        made = {one.name: self._values(one, cells) for one, cells in zip(self._wanted, columns)}
        column = self.times or self._judged
        cells = self._cells_of_times(column.place, block) if column else []
        times = self.times.read(cells, self._line) if self.times else None
        for name, one in self._stamps.items():
            made[name] = one.stamps([row[one.place].strip() for row in block], self._line, self.times)
        if self.times and self._is_alone and self._line == self._begun_at:
            judge_units([self.times])
        if self._judged:
            self._judged.look(cells, self._line)
        if self._unnamed:
            self._warn_of_unnamed_times(self._unnamed, block)
        first, self._line = self._line, self._line + len(block)
        return Block(first, made, times)

    def _cells_of_times(self, place: int, block: list[list[str]]) -> list[str]:
        cells = [row[place].strip() for row in block]
        if self._clock is None:
            return cells
        both = [[row[place].strip() for row in block] for place in self._clock]
        are_both = all(not one[0] or form.fullmatch(one[0]) for form, one in zip((DAY, CLOCK), both))  # a hole is told of later
        if self._line == self._begun_at and not are_both:
            self._clock = None  # one of them has all
            return cells
        return list(map(date_and_clock, *both))

    def _warn_of_unnamed_times(self, header: list[str], block: list[list[str]]) -> None:
        self._unnamed = None
        name = unnamed_times(header, block, self._places)
        if name is not None:
            warnings.warn(f"{self.source}: column {name} rises like a clock, and each row is taken for one step of dt: --time "
                          f"'{name} [ms]', or [s], takes it for times; --time none says that rows are steps", KalmanqWarning, stacklevel=2)

    def _values(self, one: Quantity, cells: list[str]) -> np.ndarray:
        try:
            values = np.array(self._numbers.plain(cells), dtype=np.float64)
            if values.shape != (len(cells),):
                raise ValueError
        except (TypeError, ValueError):
            values = np.array([self._number(self._line + k, one.name, cell) for k, cell in enumerate(cells)])
        for missing in self._numbers.numbers_missing:
            values[values == missing] = np.nan
        wrong = np.isinf(values)
        if np.any(wrong):
            raise TableError(self.source, "is not representable: take other units", self._line + int(np.argmax(wrong)), one.name)
        if one.range is not None:
            self._look_at_range(one, values, one.range)
        return values

    def _look_at_range(self, one: Quantity, values: np.ndarray, span: float) -> None:
        wrong = np.abs(values) > span
        count = int(np.sum(wrong))
        if not count:
            return
        row = int(np.argmax(wrong))
        value = f"{values[row]:g}"
        why = f"{one.name} = {value} is beyond its declared range of {span:g}: --missing {value} if that stands for " \
              "nothing, otherwise a wider range in the model"
        if self._has_to_fit:
            raise TableError(self.source, why, self._line + row)
        before = self._beyond.get(one.name, (why, self._line + row, 0))
        self._beyond[one.name] = (*before[:2], before[2] + count)

    def _number(self, line: int, name: str, cell: str) -> float:
        try:
            return self._numbers.number(cell)
        except ValueError:
            raise TableError(self.source, f"{cell[:40]!r} is not a number{self._numbers.hint(cell)}", line,
                             name) from None


def joined(blocks: Sequence[Block]) -> Block:
    return Block(blocks[0].first_row, {name: np.concatenate([one.columns[name] for one in blocks])
                                       for name in blocks[0].columns}, *(
        None if blocks[0].times is None else np.concatenate([one.times for one in blocks]),
        None if blocks[0].lines is None else np.concatenate([one.lines for one in blocks])), blocks[0].is_joined, blocks[0].unit)


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


def measurements_and_controls(data: AnySource, model: Any, *,
                              has_to_fit: bool = False) -> tuple[np.ndarray, Optional[np.ndarray]]:
    """z and u alone, of rows that are steps, whenever they are"""
    return record_and(data, model, (), has_to_fit=has_to_fit)[:2]


def record_and(data: AnySource, model: Any, others: Sequence[str], **how: Any
               ) -> tuple[np.ndarray, Optional[np.ndarray], Optional[np.ndarray], Optional[np.ndarray]]:
    """z, u, the other columns, and where `how` has dt and cure, the times"""
    block = joined(list(read(data, [*model.measurements, *model.inputs], optional=others, **how)))
    z, u = split(block, model, data)
    is_there = bool(others) and all(name in block.columns for name in others)
    return z, u, np.column_stack([block.columns[name] for name in others]) if is_there else None, block.times


def split(block: Block, model: Any, data: Any) -> tuple[np.ndarray, Optional[np.ndarray]]:
    z = np.column_stack([block.columns[one.name] for one in model.measurements])
    return z, controls_in(block, model.inputs, data) if model.inputs else None


def controls_in(block: Block, controls: Sequence[Quantity], data: Any) -> np.ndarray:
    u = np.column_stack([block.columns[one.name] for one in controls])
    if np.any(np.isnan(u)):
        row, column = map(int, np.argwhere(np.isnan(u))[0])
        source = source_of(data[0] if isinstance(data, (list, tuple)) else data)
        raise TableError(source, "a control is missing: fill it in, or leave the row out; only measurements may be missing", block.line(row), controls[column].name)
    return u


def write_text(text: TextIO, names: Sequence[str], columns: Sequence[np.ndarray]) -> None:
    """Integers as they are, other numbers with as many digits as bring back the same bits."""
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    _write_rows(writer, columns)


def _write_rows(writer: "csv._writer", columns: Iterable[np.ndarray]) -> None:
    writer.writerows(zip(*([_cell(value) for value in column.tolist()] for column in columns)))


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "" if value != value else format(value, ".17g")
    return str(value)


@contextmanager
def writing(path: Path, names: Sequence[str],
            inputs: Sequence[AnySource] = ()) -> Iterator[Callable[[Iterable[np.ndarray]], None]]:
    """`with writing(path, names, inputs) as write:` writes rows of columns; the file appears at the end."""
    with whole(path, inputs) as temporary, open(temporary, "w", newline="", encoding="utf-8") as text:
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(names)
        yield partial(_write_rows, writer)
