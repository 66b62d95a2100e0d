"""Campaigns: many independent tasks, on all cores or a cluster, that can be interrupted and go on.

    for result in run_campaign(function, tasks, fingerprint={"seed": 1}, journal=journal_of(out)):
        ...                                    in the order of the tasks
    journal_of(out).unlink()                   when what was to be written is written

Results are the same, bit for bit, whatever the number of workers, the order in which they end and however often
it was interrupted: a task knows nothing of the others, and each result goes through the journal's text.
"""

from __future__ import annotations

import importlib.metadata
import json
import logging
import os
import signal
import threading
import time
import warnings
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing import active_children, connection, get_context, parent_process
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence

import numpy as np

from kalmanq.data.files import telling_where
from kalmanq.errors import KalmanqError, KalmanqWarning

try:
    import fcntl
except ImportError:  # not a POSIX system: two campaigns of one journal are not told apart
    fcntl = None  # type: ignore[assignment]

KEY = "kalmanq_campaign"  # the first line of a journal has it
AHEAD = 2  # batches that are given out for each worker, so that none waits for the next one
BATCH_SECONDS = 0.2  # of short tasks, what goes out at once: less is spent on the way than on the work
CONNECT_SECONDS = 5  # to reach a Dask scheduler
ALONE_SECONDS = 30  # that a Dask cluster may be without a worker
HEARD_SECONDS = 0.2  # until Ctrl-C is heard, at most
TERMINATED = 143  # how a worker ends whose campaign was killed
SHOWN = 40  # longer values are not shown in a line

Told = Optional[Callable[[int, int], None]]


class CampaignInterrupted(KeyboardInterrupt):
    """Its text says how much is done."""


def journal_of(out: Path) -> Path:
    return out.with_name(out.name + ".journal")


def run_campaign(function: Callable[[Any], Any], tasks: Sequence[Any], *, fingerprint: Mapping[str, Any], journal: Path,
                 workers: Optional[int] = None, dask: Optional[str] = None, progress: Told = None,
                 fresh: bool = False) -> Iterator[Any]:
    """The results function(task), in the order of the tasks.

    function     of a module, so that other processes find it; its result is what JSON can say
    fingerprint  all that determines the result of task k, for JSON; the number of tasks does not
    journal      the file with the results so far; who calls deletes it when they are no longer needed
    workers      processes; 1: this one; None: as many as there are cores
    dask         the address of a scheduler, whose cluster does the work
    progress     called with how many are done and how many there are
    fresh        results in the journal are forgotten; otherwise those of another campaign are an error
    """
    book = Journal(journal, {**fingerprint, **versions()}, fresh)
    try:
        with book:
            left = [k for k in range(len(tasks)) if k not in book.results]
            done = len(tasks) - len(left)
            _tell(progress, done, len(tasks))
            made = _made(function, tasks, left, workers, dask)
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


def _perform(function: Callable[[Any], Any], task: Any, wanted: Mapping[str, str]) -> str:
    if versions() != wanted:
        raise KalmanqError(f"a worker has other versions: {versions()}, not {dict(wanted)}: install the same ones")
    try:
        return json.dumps(function(task))
    except KalmanqError as problem:
        raise KalmanqError(str(problem)) from None  # not every error of its kind can be sent


@dataclass(frozen=True)
class _Batch:
    """What comes back of some tasks: the results of the first of them, and why it ended before the last one"""

    results: list[str]
    seconds: float
    refused: str = ""


def _perform_all(function: Callable[[Any], Any], tasks: Sequence[Any], wanted: Mapping[str, str]) -> _Batch:
    """This is what runs in another process, or on another machine."""
    results: list[str] = []
    begun = time.monotonic()
    try:
        for task in tasks:
            results.append(_perform(function, task, wanted))
    except KalmanqError as problem:
        return _Batch(results, time.monotonic() - begun, str(problem))
    return _Batch(results, time.monotonic() - begun)


def _made(function: Callable[[Any], Any], tasks: Sequence[Any], left: Sequence[int], workers: Optional[int],
          dask: Optional[str]) -> Iterator[tuple[int, str]]:
    """Tasks that are left, as they end, with their results."""
    count = min(workers or cores(), len(left))
    if not left:
        return
    if dask is not None:
        with _cluster(dask) as (executor, width, has_workers):
            yield from _as_they_end(executor, width, function, tasks, left, _Watch(dask, has_workers))
    elif count > 1:
        with _processes(count) as executor:
            yield from _as_they_end(executor, count, function, tasks, left)
    else:
        for k in left:
            yield k, _perform(function, tasks[k], versions())


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _as_they_end(executor: Executor, width: int, function: Callable[[Any], Any], tasks: Sequence[Any],
                 left: Sequence[int], watch: Optional[_Watch] = None) -> Iterator[tuple[int, str]]:
    given: dict[Future[_Batch], list[int]] = {}
    lost: set[int] = set()
    position, size = 0, 1

    def give(batch: Sequence[int]) -> None:
        given[executor.submit(_perform_all, function, [tasks[k] for k in batch], versions())] = list(batch)

    while True:
        with _interrupts_held():
            while len(given) < AHEAD * width and position < len(left):
                fair = -(-(len(left) - position) // (AHEAD * width))  # all workers end at one time
                batch = left[position : position + min(size, fair)]
                position += len(batch)
                give(batch)
        if not given:
            return
        with _interrupts_held():
            ended = sorted(wait(given, HEARD_SECONDS, FIRST_COMPLETED).done, key=_has_failed)
            outcomes = [(given.pop(future), future) for future in ended]
            if watch:
                watch.look(bool(ended))
        for batch, future in outcomes:  # what is done is kept before an error ends all
            if watch and batch[0] not in lost and not future.cancelled() and isinstance(future.exception(), TypeError):
                lost.add(batch[0])  # Dask's own error, where a worker goes while its result comes: given once more
                give(batch)
                continue
            made = future.result()
            yield from zip(batch, made.results)
            if made.refused:
                raise KalmanqError(made.refused)
            size = min(2 * size, max(1, int(BATCH_SECONDS * len(batch) / max(made.seconds, 1e-6))))


class _Watch:
    """Is anybody there to work?  A cluster whose last worker has gone would be waited for without an end."""

    def __init__(self, address: str, has_workers: Callable[[], bool]):
        self._address, self._has_workers = address, has_workers
        self._looked = time.monotonic()
        self._alone: Optional[float] = None

    def look(self, has_ended: bool) -> None:
        now = time.monotonic()
        if has_ended:
            self._looked, self._alone = now, None
        if now - self._looked < CONNECT_SECONDS:
            return
        self._looked = now
        if self._has_workers():
            self._alone = None
        elif self._alone is None:
            self._alone = now
            warnings.warn(f"the Dask cluster at {self._address} has no workers: {ALONE_SECONDS} s are waited for one",
                          KalmanqWarning, stacklevel=2)
        elif now - self._alone >= ALONE_SECONDS:
            raise KalmanqError(f"the Dask cluster at {self._address} has no workers any more; the same command goes on "
                               "from there")


def _has_failed(future: Future[_Batch]) -> bool:
    return future.cancelled() or future.exception() is not None or bool(future.result().refused)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C is heard when this is over, and never by a process that begins in it: this one ends the others.

    An interrupt while a process begins would leave one that nobody knows of, and one within a lock that other
    threads wait for would leave it locked.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard: list[Any] = []
    before = signal.signal(signal.SIGINT, lambda *given: heard.append(given))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if hasattr(signal, "pthread_sigmask") else None
    try:
        yield
    finally:
        if mask is not None:  # a new process has the mask of its parent
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, before)
        if heard and callable(before):
            before(*heard[-1])


def _end_with_the_parent() -> None:
    """Of a worker: what is killed says nothing to its workers, which would wait for ever."""
    parent = parent_process()

    def watch() -> None:
        connection.wait([parent.sentinel])  # type: ignore[union-attr]
        os._exit(TERMINATED)

    if parent is not None:
        threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _processes(count: int) -> Iterator[Executor]:
    others = set(active_children())
    executor = ProcessPoolExecutor(count, mp_context=get_context("spawn"), initializer=_end_with_the_parent)
    try:
        yield executor
    except BaseException as problem:
        _give_up(executor, others)
        if isinstance(problem, BrokenProcessPool):
            raise KalmanqError("a worker process ended by itself, out of memory perhaps; the same command goes on "
                               "from there") from None
        raise
    executor.shutdown()


def _give_up(executor: Executor, others: set[BaseProcess]) -> None:
    """Ends what is under way.  All processes are ended: one that is not would wait for what another one held."""
    with _interrupts_held():
        executor.shutdown(wait=False, cancel_futures=True)
        for child in set(active_children()) - others:
            child.terminate()


@contextmanager
def _cluster(address: str) -> Iterator[tuple[Executor, int, Callable[[], bool]]]:
    """An executor of a Dask cluster, how many threads that has, and whether it has any still."""
    try:
        from distributed import Client
    except ImportError:
        raise KalmanqError("--dask: needs dask[distributed]: pip install 'kalmanq[dask]'") from None
    for handler in logging.getLogger("distributed").handlers:
        handler.setLevel(logging.CRITICAL + 1)  # what goes wrong is said in one line
    try:
        with _interrupts_held():
            client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise KalmanqError(f"there is no Dask scheduler at {address}: start one (dask scheduler), or leave --dask out") from problem
    try:
        width = sum(client.nthreads().values())
        if not width:
            raise KalmanqError(f"the Dask cluster at {address} has no workers")
        executor = client.get_executor()
        try:
            yield executor, width, lambda: bool(client.nthreads())
        finally:
            with _interrupts_held():
                executor.shutdown(wait=False)
    except CancelledError:
        raise KalmanqError(f"the Dask cluster at {address} was lost; the same command goes on from there") from None
    except (ImportError, AttributeError) as problem:  # a worker without what the task is made of
        raise KalmanqError(f"the Dask cluster at {address}: {_line(problem)}") from problem
    except Exception as problem:
        if type(problem).__module__.startswith("distributed"):
            raise KalmanqError(f"the Dask cluster at {address}: {_line(problem)}") from problem
        raise
    finally:
        with _interrupts_held():
            client.close(timeout=2)


def _line(problem: BaseException) -> str:
    return (str(problem).splitlines() or [type(problem).__name__])[0]
