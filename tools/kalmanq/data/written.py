"""CSV files that are written: whole or not at all."""

from __future__ import annotations

import csv
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, NamedTuple, Sequence, TextIO

import numpy as np

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


def write_text(text: TextIO, names: Sequence[str], columns: Iterable[np.ndarray], form: Form = Form()) -> None:
    """Integers as they are, other numbers with as many digits as bring back the same bits."""
    writer = csv.writer(text, delimiter=form.separator, lineterminator="\n")
    writer.writerow(names)
    _write_rows(writer, form, columns)


def _write_rows(writer: "csv._writer", form: Form, columns: Iterable[np.ndarray]) -> None:
    writer.writerows(zip(*([_cell(value, form.decimal) for value in column.tolist()] for column in columns)))


def _cell(value: object, decimal: str) -> str:
    if isinstance(value, float):
        return "" if value != value else format(value, ".17g").replace(".", decimal)
    return str(value)


@contextmanager
def writing(path: Path, names: Sequence[str],
            inputs: Sequence[AnySource] = ()) -> Iterator[Callable[[Iterable[np.ndarray]], None]]:
    """`with writing(path, names, inputs) as write:` writes rows of columns; the file appears at the end."""
    with whole(path, inputs) as temporary, open(temporary, "w", newline="", encoding="utf-8") as text:
        write_text(text, names, [])
        yield partial(_write_rows, csv.writer(text, lineterminator="\n"), Form())
