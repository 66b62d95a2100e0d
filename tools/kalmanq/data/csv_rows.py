"""The header and the rows of a CSV text, as cells: what is between fields, lines above the header, rows of another width."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from itertools import chain
from typing import Collection, Iterator, Sequence, TextIO

from kalmanq.data.layouts import Source, TableError, has_decimal_comma, separator_of


class CsvRows:
    """A text that is read once from its beginning to its end.  header: its cells; line: the header's"""

    def __init__(self, source: Source, text: TextIO, names: Sequence[str]):
        self.source, self.line, self._is_at_end = source, 1, False
        header, rest = self._header(text)
        self._reader = csv.reader(chain([header], rest, self._end()), delimiter=separator_of(self.source, header, names, self.line))
        try:
            self.header = [cell.strip() for cell in next(self._reader, [])]
        except csv.Error as problem:
            raise TableError(source, f"{problem}: is a quote not closed?", self.line) from problem
        if self._is_at_end:
            self._refuse_open(self.line)
        if not any(self.header):
            raise TableError(source, "empty, or without a header of names", self.line)

    def _header(self, text: TextIO) -> tuple[str, Iterator[str]]:
        """Below lines that begin with '#', and one by which a spreadsheet tells its separator"""
        lines = iter(text)
        for line in lines:
            told = re.fullmatch(r"sep=(.)\s*", line)
            if told and not self.source.layout.separator:
                self.source = replace(self.source, layout=replace(self.source.layout, separator=told.group(1)))
            if not told and not line.startswith("#"):
                return line, lines
            self.line += 1
        return "", lines

    def _end(self) -> Iterator[str]:
        """A line without a cell, which is a row of its own unless a quote is open"""
        self._is_at_end = True
        yield "\n"

    def rows(self, _: Collection[int]) -> Iterator[list[str]]:
        line, blank, width = self.line, 0, len(self.header)  # rows without a cell: of one column, a missing number; at the end, nothing
        try:
            for row in self._reader:
                if not row:
                    blank += 1
                    continue
                if blank and width > 1:
                    raise TableError(self.source, "an empty row: leave it out", line + 1)
                for _ in range(blank):
                    yield [""]
                line, blank = line + blank + 1, 0
                if self._is_at_end:
                    self._refuse_open(line)
                if len(row) != width:
                    self._refuse_width(row, line)
                yield row
        except csv.Error as problem:
            raise TableError(self.source, f"{problem}: is a quote not closed?", line + blank + 1) from problem

    def _refuse_open(self, line: int) -> None:
        raise TableError(self.source, "a quote is open until the end of the file: close it, or leave it out", line)

    def _refuse_width(self, row: list[str], line: int) -> None:
        width, fields = len(self.header), "1 field" if len(row) == 1 else f"{len(row)} fields"
        is_decimal = any(has_decimal_comma([f"{whole},{part}"]) for whole, part in zip(row, row[1:]))
        hint = "" if len(row) > width else ": fill it in, or leave the row out"
        hint = "; if its comma is a decimal one: --decimal ," if len(row) > width and is_decimal else hint
        raise TableError(self.source, f"{fields}, not {width}{hint}", line)
