"""Files that appear whole or not at all: written under a temporary name beside their place, and
renamed once all of them are complete."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

from errors import DemoError, one_line


class Outputs:
    """`with Outputs(directory) as outputs:` renames at the end, or cleans up after an error."""

    def __init__(self, directory: Path, inputs: list[Path]):
        self.directory = directory
        self.inputs = inputs
        self.staged: list[tuple[Path, Path]] = []

    @property
    def files(self) -> list[Path]:
        return [final for _, final in self.staged]

    def stage(self, name: str) -> Path:
        """Where to write the file that will be called `name`."""
        final = self.directory / name
        if any(same_file(final, path) for path in self.inputs):
            raise DemoError(f"{one_line(str(final))}: is the input; choose another --out")
        temporary = self.directory / f".{name}.{os.getpid()}.tmp"
        self.staged.append((temporary, final))
        return temporary

    def write(self, name: str, text: str) -> None:
        self.stage(name).write_text(text, encoding="utf-8")

    def __enter__(self) -> Outputs:
        self.directory.mkdir(parents=True, exist_ok=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        problem: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if kind is None:
                for temporary, final in self.staged:
                    os.replace(temporary, final)
        finally:
            for temporary, _ in self.staged:
                temporary.unlink(missing_ok=True)


def same_file(a: Path, b: Path) -> bool:
    return a.exists() and b.exists() and a.samefile(b)
