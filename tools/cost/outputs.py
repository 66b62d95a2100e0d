"""What the tools write: files that appear whole or not at all, CSVs, the terminal."""

from __future__ import annotations

import csv
import io
import os
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Iterable, Iterator, Sequence

from rich.console import Console


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Where to write what will be called `path`, which appears at the end, or after an error does not"""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        yield temporary
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write(path: Path, text: str) -> None:
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def terminal(width: int) -> Console:
    """What is no terminal is so wide that every table fits, whatever reads it."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else width)


def shown(path: Path) -> str:
    """The path as seen from here, if that is shorter."""
    return min(str(path), os.path.relpath(path), key=len)
