"""Parquet, Feather and Excel: the columns of a table of pandas; its index too, if it has a name or times."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pandas

from kalmanq.data.layouts import Source, TableError
from kalmanq.data.readers import Recorded

READ = {".feather": "read_feather", ".arrow": "read_feather", ".xlsx": "read_excel", ".xls": "read_excel"}


def opened(source: Source) -> Recorded:
    suffix = source.path.suffix.lower()
    with open(source.path, "rb") as file:
        is_sheet = suffix in (".xlsx", ".xls") or file.read(2) in (b"PK", b"\xd0\xcf")
    table, line = _sheet(source) if is_sheet else (getattr(pandas, READ.get(suffix, "read_parquet"))(source.path), 1)
    if table.index.name is not None or not isinstance(table.index, pandas.RangeIndex) and table.index.nlevels == 1:
        table = table.reset_index()
    if not len(table):
        raise TableError(source, "no data below the header")
    names = [str(name).strip() for name in table.columns]
    return Recorded(source, names, lambda _: zip(*(_cells(table.iloc[:, k]) for k in range(len(names)))), line)


def _sheet(source: Source) -> tuple[Any, int]:
    """The first sheet with rows, and the line of its header: the first row that is full of texts"""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of styles that openpyxl does not know
        sheets = pandas.read_excel(source.path, sheet_name=None, header=None)
    for sheet in sheets.values():
        sheet = sheet.dropna(axis=1, how="all")
        for k, row in enumerate(sheet.itertuples(index=False)):
            if all(isinstance(cell, str) for cell in row) and len(row) and k + 1 < len(sheet):
                return sheet.iloc[k + 1:].set_axis(list(row), axis=1).reset_index(drop=True), k + 1
    raise TableError(source, "no sheet has a row of names, and rows of numbers below it")


def _cells(column: Any) -> list[str]:
    if column.dtype.kind in "iu" and not column.hasnans:
        return list(map(str, column.tolist()))
    if column.dtype.kind in "fiub":
        return ["" if one != one else repr(one) for one in column.to_numpy(np.float64, na_value=np.nan).tolist()]
    cells = ["" if one is None or pandas.isna(one) else one.isoformat() if hasattr(one, "isoformat") else str(one) for one in column.tolist()]
    return [cell[:10] for cell in cells] if all(cell[10:] == "T00:00:00" for cell in cells if cell) else cells  # days
