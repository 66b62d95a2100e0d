"""Campaigns: many independent tasks, on all cores or a cluster, that can be interrupted and go on.

    for result in run_campaign(function, tasks, fingerprint={"seed": 1}, journal=journal_of(out)):
        ...                                    in the order of the tasks
    journal_of(out).unlink()                   when what was to be written is written

Joblib does the tasks, on what its parallel_config says: with parallel_config(backend="dask") on the cluster of a Dask client.
Results are the same, bit for bit, whatever the number of workers, the order in which they end and however often
it was interrupted: a task knows nothing of the others, and each result goes through the journal's text.
"""

from __future__ import annotations

import importlib.metadata
import json
import os
import threading
import time
import warnings
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from functools import lru_cache
from multiprocessing import parent_process
from pathlib import Path
from typing import Any, Callable, Generator, Iterator, Mapping, Optional, Sequence

import numpy as np

from kalmanq.data.files import telling_where
from kalmanq.errors import KalmanqError

try:
    import fcntl
except ImportError:  # not a POSIX system: two campaigns of one journal are not told apart
    fcntl = None  # type: ignore[assignment]

KEY = "kalmanq_campaign"  # the first line of a journal has it
HEARD_SECONDS = 0.2  # until a worker hears that its campaign was killed, at most
TERMINATED = 143  # how a worker ends whose campaign was killed
SHOWN = 40  # longer values are not shown in a line

Told = Optional[Callable[[int, int], None]]


class CampaignInterrupted(KeyboardInterrupt):
    """Its text says how much is done."""


def journal_of(out: Path) -> Path:
    return out.with_name(out.name + ".journal")


def run_campaign(function: Callable[[Any], Any], tasks: Sequence[Any], *, fingerprint: Mapping[str, Any], journal: Path,
                 workers: Optional[int] = None, progress: Told = None, fresh: bool = False) -> Iterator[Any]:
    """The results function(task), in the order of the tasks.

    function     of a module, so that other processes find it; its result is what JSON can say
    fingerprint  all that determines the result of task k, for JSON; the number of tasks does not
    journal      the file with the results so far; who calls deletes it when they are no longer needed
    workers      processes; 1: this one; None: as many as there are cores, or all of the cluster
    progress     called with how many are done and how many there are
    fresh        results in the journal are forgotten; otherwise those of another campaign are an error
    """
    book = Journal(journal, {**fingerprint, **versions()}, fresh)
    try:
        with book:
            left = [k for k in range(len(tasks)) if k not in book.results]
            done = len(tasks) - len(left)
            _tell(progress, done, len(tasks))
            with closing(_made(function, tasks, left, workers)) as made:
                for k in range(len(tasks)):
                    while k not in book.results:
                        book.add(*next(made))
                        done += 1
                        _tell(progress, done, len(tasks))
                    yield book.results.pop(k)
    except KeyboardInterrupt:
        done = sum(task < len(tasks) for task in book.kept)
        raise CampaignInterrupted(
            f"interrupted: {done} of {len(tasks)} are done; the same command goes on from there") from None


def _tell(progress: Told, done: int, total: int) -> None:
    if progress:
        progress(done, total)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """What `progress` of a campaign can be: a bar on the error output, if that is a terminal.  It needs rich."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal) as shown:
        task = shown.add_task(what, total=None)

        def tell(done: int, total: int) -> None:
            if shown.tasks[0].total is None:  # what was done before says nothing of the speed
                shown.reset(task, total=total, completed=done)
            shown.update(task, completed=done)

        yield tell


# ------------------------------------------------------------------------------ the journal


class Journal:
    """A line that says of which campaign, then a line a result, [task, result], in the order in which they came.

    A last line that was cut off is dropped.  A journal without results does not stay.
    """

    def __init__(self, path: Path, fingerprint: Mapping[str, Any], fresh: bool):
        self.path = path
        self.fingerprint = json.loads(json.dumps(fingerprint))
        self.fresh = fresh
        self.results: dict[int, Any] = {}
        self.kept: set[int] = set()  # the tasks whose results the file held when it was closed

    def __enter__(self) -> Journal:
        try:
            self._file = open(self.path, "a+b", buffering=0)
        except FileNotFoundError:
            raise KalmanqError(f"{self.path}: there is no such folder: make it") from None
        try:
            self._lock()
            with telling_where(self.path):
                self._begin()
        except BaseException:
            self._file.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """An interrupt can come between a line and what is noted of it, so the file is asked."""
        self._file.seek(0)
        _, *lines = self._file.readall().split(b"\n")
        self._file.close()
        self.kept = {json.loads(line)[0] for line in lines[:-1]}
        if not self.kept:
            self.path.unlink(missing_ok=True)

    def add(self, task: int, result: str) -> None:
        with telling_where(self.path):
            self._file.write(f"[{task}, {result}]\n".encode())
        self.results[task] = json.loads(result)

    def _lock(self) -> None:
        try:
            if fcntl:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise KalmanqError(f"{self.path}: another campaign is at work on it") from None

    def _begin(self) -> None:
        self._file.seek(0)
        content = self._file.readall()
        header, *lines = content.split(b"\n")
        if not lines and header.startswith(f'{{"{KEY}'.encode()):  # cut off within its first line
            header = b""
        if header:
            self._refuse_other(header)
        if not header or self.fresh:
            self._file.truncate(0)
            self._file.write(json.dumps({KEY: self.fingerprint}).encode() + b"\n")
            return
        self._read(lines[:-1])
        self._file.truncate(len(content) - len(lines[-1]))

    def _refuse_other(self, header: bytes) -> None:
        try:
            found = json.loads(header)[KEY]
            names = sorted({*found, *self.fingerprint})
        except (ValueError, KeyError, TypeError):
            raise KalmanqError(f"{self.path}: is no journal of a campaign: give --out another name") from None
        differing = [_difference(name, found.get(name), self.fingerprint.get(name)) for name in names
                     if found.get(name) != self.fingerprint.get(name)]
        if differing and not self.fresh:
            raise KalmanqError(f"{self.path}: is of another campaign ({', '.join(differing)}); --fresh begins anew")

    def _read(self, lines: Sequence[bytes]) -> None:
        for number, line in enumerate(lines, 2):
            try:
                task, result = json.loads(line)
            except ValueError:
                raise KalmanqError(f"{self.path}: line {number} is damaged; --fresh begins anew") from None
            self.results[task] = result


def _difference(name: str, found: Any, wanted: Any) -> str:
    pair = f"{found!r}, not {wanted!r}"
    return f"{name} {pair}" if len(pair) <= SHOWN else name


# ------------------------------------------------------------------------------ the workers


@lru_cache(maxsize=None)
def _version() -> str:
    try:
        return importlib.metadata.version("kalmanq")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def versions() -> dict[str, str]:
    """What, beside the fingerprint, the numbers come from."""
    return {"kalmanq": _version(), "numpy": np.__version__}


def _made(function: Callable[[Any], Any], tasks: Sequence[Any], left: Sequence[int],
          workers: Optional[int]) -> Generator[tuple[int, str], None, None]:
    """Tasks that are left, as they end, with their results."""
    if not left:
        return
    from joblib import Parallel, delayed, effective_n_jobs  # an extra, which nothing else needs

    count = min(effective_n_jobs(workers or -1), len(left))
    ended = Parallel(count, return_as="generator_unordered", max_nbytes=None, initializer=_end_with_the_parent)(
        delayed(_perform)(function, k, tasks[k], versions()) for k in left)
    try:
        for k, result, refused in ended:
            if refused:
                raise KalmanqError(refused)
            yield k, result
    except BrokenProcessPool:
        raise KalmanqError("a worker process ended by itself, out of memory perhaps; the same command goes on from there") from None
    finally:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # of tasks that were given up
            ended.close()


def _perform(function: Callable[[Any], Any], k: int, task: Any, wanted: Mapping[str, str]) -> tuple[int, str, str]:
    """The number of a task, its result, and why it has none.  This is what runs in another process, or on another machine."""
    if versions() != wanted:
        return k, "", f"a worker has other versions: {versions()}, not {dict(wanted)}: install the same ones"
    try:
        return k, json.dumps(function(task)), ""
    except KalmanqError as problem:  # its text: not every error of its kind can be sent
        return k, "", str(problem)


@lru_cache(maxsize=None)
def _end_with_the_parent() -> None:
    """Of a worker, before its first task: what is killed says nothing to its workers, which would go on, or wait for minutes."""
    parent = parent_process()

    def watch(pid: Optional[int]) -> None:
        while os.getppid() == pid:
            time.sleep(HEARD_SECONDS)
        os._exit(TERMINATED)

    if parent is not None:
        threading.Thread(target=watch, args=[parent.pid], daemon=True).start()
