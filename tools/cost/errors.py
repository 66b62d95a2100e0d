"""What the user can put right: told in one line, with an exit status that is not 0."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator, Sequence


class UserError(Exception):
    """Something the user can put right; its text is the one line to be shown."""


class FileError(UserError):
    """A file that cannot be used: says which file, which row and why."""

    def __init__(self, path: Path, reason: str, row: int | None = None):
        super().__init__(": ".join([one_line(str(path)), *([] if row is None else [f"row {row}"]), reason]))


def one_line(text: str, longest: int = 200) -> str:
    """The text without line breaks and other control characters, and not too long."""
    shown = "".join(c if c.isprintable() else "?" for c in text)
    return shown if len(shown) <= longest else shown[: longest - 3] + "..."


@contextmanager
def told_in_one_line(tool: str) -> Iterator[None]:
    """Ends the program with that line where what is inside cannot go on."""
    try:
        yield
    except UserError as problem:
        stop(tool, str(problem))
    except OSError as problem:
        name = one_line(str(problem.filename)) if problem.filename else "file"
        stop(tool, f"{name}: {problem.strerror or problem}")


def stop(tool: str, line: str) -> None:
    print(f"{tool}: {line}", file=sys.stderr)
    sys.exit(1)


# For what hangs alone: no machine is too slow.
TIME_LIMIT = float(os.environ.get("KQ_TIME_LIMIT", "1800"))  # seconds


def run_program(command: Sequence[str], hint: str) -> subprocess.CompletedProcess[str]:
    """Runs a compiler, an emulator or the like to its end; the hint says where to get it."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=TIME_LIMIT, check=False)
    except OSError as problem:
        raise UserError(f"{command[0]}: {problem.strerror}; {hint}") from problem
    except subprocess.TimeoutExpired as problem:
        raise UserError(f"{command[0]}: no answer within {TIME_LIMIT:g} s") from problem
