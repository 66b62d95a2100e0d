"""What the tools write: files that appear whole or not at all, CSVs, the terminal.

A file is written under a temporary name beside its place, and renamed once all that belong together
are complete.
"""

from __future__ import annotations

import csv
import io
import os
import sys
from pathlib import Path
from types import TracebackType
from typing import Iterable, Sequence

from rich.console import Console

from errors import FileError


class Outputs:
    """`with Outputs(directory) as outputs:` renames at the end, or cleans up after an error."""

    def __init__(self, directory: Path, inputs: Sequence[Path] = ()):
        self.directory = directory
        self.inputs = inputs  # never overwritten
        self.staged: list[tuple[Path, Path]] = []

    @property
    def files(self) -> list[Path]:
        return [final for _, final in self.staged]

    def stage(self, name: str) -> Path:
        """Where to write the file that will be called `name`."""
        final = self.directory / name
        if any(same_file(final, path) for path in self.inputs):
            raise FileError(final, "is the input; choose another --out")
        temporary = self.directory / f".{name}.{os.getpid()}.tmp"
        self.staged.append((temporary, final))
        return temporary

    def write(self, name: str, text: str) -> None:
        self.stage(name).write_text(text, encoding="utf-8")

    def __enter__(self) -> Outputs:
        self.directory.mkdir(parents=True, exist_ok=True)
        return self

    def __exit__(self, kind: type[BaseException] | None, problem: BaseException | None,
                 trace: TracebackType | None) -> None:
        try:
            if kind is None:
                for temporary, final in self.staged:
                    os.replace(temporary, final)
        finally:
            for temporary, _ in self.staged:
                temporary.unlink(missing_ok=True)


def write(path: Path, text: str) -> None:
    with Outputs(path.parent) as outputs:
        outputs.write(path.name, text)


def same_file(a: Path, b: Path) -> bool:
    return a.exists() and b.exists() and a.samefile(b)


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


def end_of(what: str, count: int, broken: Sequence[str]) -> None:
    """How many were measured, and which promises do not hold: then the script has failed."""
    for line in broken:
        print(line, file=sys.stderr)
    print(f"{count} {what} measured, {len(broken)} promises broken")
    if broken:
        raise SystemExit(1)
