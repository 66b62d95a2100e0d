"""What is written appears whole or not at all."""

from __future__ import annotations

import os
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator, Sequence

from kalmanq.errors import KalmanqError


@contextmanager
def whole(path: Path, inputs: Sequence[Path] = ()) -> Iterator[Path]:
    """Where to write what will be called `path`; gone after an error.  An input is never overwritten."""
    if any(path.exists() and one.exists() and path.samefile(one) for one in inputs):
        raise KalmanqError(f"{path}: is an input; write to another file")
    temporary = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    except FileNotFoundError as problem:
        raise KalmanqError(f"{path}: there is no such folder") from problem
    finally:
        temporary.unlink(missing_ok=True)
