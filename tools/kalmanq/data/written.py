"""CSV files that are written: whole or not at all."""

from __future__ import annotations

import csv
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, NamedTuple, Sequence, TextIO, Union

import numpy as np

from kalmanq.core import ffi, lib, pointer_of
from kalmanq.data.files import whole
from kalmanq.data.layouts import AnySource


class Form(NamedTuple):
    """What is between fields, and the decimal sign"""

    separator: str = ","
    decimal: str = "."

    @classmethod
    def of(cls, recording: Mapping[str, Any]) -> Form:
        """As a model file says it"""
        separator = recording.get("separator", ";" if recording.get("decimal") == "," else ",")
        return cls("\t" if separator == "tab" else separator, recording.get("decimal", "."))


Digits = Union[int, Sequence[int]]
ALL_DIGITS = 17  # significant ones that bring back the same bits
PRINTED = 4096  # rows at once


def write_text(text: TextIO, names: Sequence[str], columns: Iterable[np.ndarray], form: Form = Form(), digits: Digits = ALL_DIGITS) -> None:
    """Integers as they are, other numbers with so many digits, of all columns or of each."""
    csv.writer(text, delimiter=form.separator, lineterminator="\n").writerow(names)
    _write_rows(text, form, digits, columns)


def _write_rows(text: TextIO, form: Form, digits: Digits, columns: Iterable[np.ndarray]) -> None:
    given = list(columns)
    of_each = np.where([one.dtype.kind == "f" for one in given], digits, ALL_DIGITS).astype(np.int32)
    if form == Form() and all(one.dtype.kind in "fiu" for one in given):
        return _print_rows(text, of_each, given)
    writer = csv.writer(text, delimiter=form.separator, lineterminator="\n")
    writer.writerows(zip(*([_cell(value, int(count), form.decimal) for value in column.tolist()] for count, column in zip(of_each, given))))


def _print_rows(text: TextIO, digits: np.ndarray, columns: Sequence[np.ndarray]) -> None:
    """By C: most of the time of a long run"""
    for first in range(0, len(columns[0]) if columns else 0, PRINTED):
        values = np.column_stack([one[first : first + PRINTED].astype(np.float64) for one in columns])
        printed = ffi.new("char[]", values.size * lib.KQ_PRINTED_MOST)
        length = lib.kq_print_rows(*values.shape, pointer_of(values), ffi.cast("int32_t *", digits.ctypes.data), printed)
        text.write(ffi.buffer(printed, length)[:].decode("ascii"))


def _cell(value: object, digits: int, decimal: str) -> str:
    if isinstance(value, float):
        return "" if value != value else format(value, f".{digits}g").replace(".", decimal)
    return str(value)


@contextmanager
def writing(path: Path, names: Sequence[str],
            inputs: Sequence[AnySource] = (), digits: Digits = ALL_DIGITS) -> Iterator[Callable[[Iterable[np.ndarray]], None]]:
    """`with writing(path, names, inputs) as write:` writes rows of columns; the file appears at the end.  digits: significant ones"""
    with whole(path, inputs) as temporary, open(temporary, "w", newline="", encoding="utf-8") as text:
        write_text(text, names, [])
        yield partial(_write_rows, text, Form(), digits)
