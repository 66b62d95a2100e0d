"""What is written appears whole or not at all."""

from __future__ import annotations

import os
import secrets
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Optional, Sequence

from kalmanq.errors import KalmanqError


@contextmanager
def telling_where(path: Path) -> Iterator[None]:
    """An error of what is written there names it: a full disk says nothing of whose file it was."""
    try:
        yield
    except OSError as problem:
        if problem.filename is not None or not problem.strerror:
            raise
        raise KalmanqError(f"{path}: {problem.strerror}") from None


def require_folder(folder: Path) -> None:
    if not folder.is_dir():
        raise KalmanqError(f"{folder}: there is no such folder: make it")


def refuse_output(path: Path, inputs: Sequence[Any] = ()) -> None:
    """What writing would refuse in the end"""
    if not path.parent.is_dir():
        raise KalmanqError(f"{path}: there is no such folder: make it")
    _refuse_input(path, inputs)


def _refuse_input(path: Path, inputs: Sequence[Any]) -> None:
    if any(path.exists() and one.exists() and path.samefile(one) for one in inputs):
        raise KalmanqError(f"{path}: is an input; write to another file")


@contextmanager
def own_folder(prefix: str) -> Iterator[Path]:
    """A folder that is gone afterwards.  It has its name before it is made: an interrupt in between leaves none."""
    path = Path(tempfile.gettempdir()) / f"{prefix}{secrets.token_hex(8)}"
    try:
        path.mkdir(mode=0o700)
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)


@contextmanager
def whole(path: Path, inputs: Sequence[Any] = ()) -> Iterator[Path]:
    """Where to write what will be called `path`; gone after an error.  An input is never overwritten.  A link is
    followed, a file's mode stays; to a device or a pipe what was written is copied."""
    _refuse_input(path, inputs)
    if path.is_dir():
        raise KalmanqError(f"{path}: is a folder")
    if path.exists() and not path.is_file():
        with tempfile.TemporaryDirectory() as folder:
            with telling_where(Path(folder)):
                yield Path(folder) / f"copy{path.suffix}"
            _copy(Path(folder) / f"copy{path.suffix}", path)
        return
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        with telling_where(path):
            yield temporary
        if target.exists():
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except FileNotFoundError as problem:
        raise KalmanqError(f"{path}: there is no such folder: make it") from problem
    finally:
        temporary.unlink(missing_ok=True)


def refuse_one_output(out: Optional[Path], plot: Optional[Path]) -> None:
    if out and plot and os.path.realpath(out) == os.path.realpath(plot):
        raise KalmanqError(f"{out}: --out and --plot are one file; give two names")


def _copy(source: Path, device: Path) -> None:
    try:
        with open(source, "rb") as made, open(device, "wb") as to:
            shutil.copyfileobj(made, to)
    except OSError as problem:
        raise KalmanqError(f"{device}: {problem.strerror}") from None
