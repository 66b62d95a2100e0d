"""What the user can put right: told in one line, with an exit status that is not 0."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # of the package, what needs nothing but Unicorn and pyelftools

from kalmanq.firmware.cores import NotMeasured as UserError, one_line  # noqa: E402  its text is the one line to be shown


class FileError(UserError):
    """A file that cannot be used: says which file, which row and why."""

    def __init__(self, path: Path, reason: str, row: int | None = None):
        super().__init__(": ".join([one_line(str(path)), *([] if row is None else [f"row {row}"]), reason]))


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
