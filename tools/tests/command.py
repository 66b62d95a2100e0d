"""The command line in a process of its own, in which the modules are that the command and those before it needed: `python -m kalmanq`
would spend most of a short command's time on them.  Streams, exit code, signals and working directory are that process's."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
import tempfile
import threading
import traceback
import warnings
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from kalmanq import command_line
from kalmanq.commands import commands
from kalmanq.compiler.templates import engine

SLOW = ("matplotlib.pyplot", "scipy.optimize", "scipy.special", "numpy.ma", "numpy.random", "typer._adapters", "rich.status", "jinja2",
        "kalmanq.firmware.emulated", "joblib.externals.loky.reusable_executor")  # to import, which commands do late


def kalmanq(*arguments: object, folder: object = None, input: str | None = None) -> subprocess.CompletedProcess:
    """What subprocess.run of `python -m kalmanq ARGUMENTS` answers, with text captured"""
    said = [str(one) for one in arguments]
    _prepare(said[0] if said else "")
    with tempfile.TemporaryFile("w+b") as out, tempfile.TemporaryFile("w+b") as error, tempfile.TemporaryFile("w+b") as needed:
        reads, writes = os.pipe()
        sys.stdout.flush(), sys.stderr.flush()
        child = os.fork()
        if child == 0:
            os.close(writes)
            _run(said, folder, needed.fileno(), reads, out.fileno(), error.fileno())  # never returns
        os.close(reads)
        feeder = threading.Thread(target=_feed, args=(writes, (input or "").encode()))
        feeder.start()
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        feeder.join()
        for name in _text(needed).split():
            import_module(name)
        return subprocess.CompletedProcess(said, code, *(_text(stream) for stream in (out, error)))


@lru_cache(maxsize=None)
def _prepare(command: str) -> None:
    """What each process of the command would do again"""
    if command in commands():
        was, sys.argv = sys.argv, ["kalmanq"]
        command_line.loaded(command)
        sys.argv = was
    if command in ("compile", "design", "report", "tune"):
        for name in (environment := engine._environment()).list_templates(extensions=["j2"]):
            environment.get_template(name)


def succeeds(*arguments: object, **given: Any) -> subprocess.CompletedProcess:
    """A command that has to end well"""
    done = kalmanq(*arguments, **given)
    assert done.returncode == 0, done.stderr
    return done


def json_of(*arguments: object, **given: Any) -> Any:
    """What a command says with --json, which has to end well"""
    return json.loads(succeeds(*arguments, "--json", **given).stdout)


def rows_of(path: Path) -> list[dict[str, str]]:
    with open(path, newline="") as text:
        return list(csv.DictReader(text))


def refused(done: subprocess.CompletedProcess, said: str | tuple[str, ...], folder: Path | None = None, told: int = 0) -> None:
    """A command has refused in one line, behind `told` lines of what else it had to say, which has each text of `said`, and has left no
    output (named out or .out) in the folder"""
    assert done.returncode == 1 and done.stdout == "", done.stdout
    assert done.stderr.count("\n") == 1 + told and done.stderr.startswith("kalmanq: "), done.stderr
    assert all(one in done.stderr for one in ([said] if isinstance(said, str) else said)), done.stderr
    assert folder is None or [path.name for path in folder.iterdir() if path.name.startswith((".", "out"))] == []


def twice(folder: Path, *arguments: object) -> dict[str, bytes]:
    """The files that `kalmanq compile ... -o cart.c` writes: the same by two new processes, with other hashes of texts"""
    made = []
    for seed in ("0", "1"):
        (place := folder / seed).mkdir()
        done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", "compile", *map(str, arguments), "-o",
                               str(place / "cart.c")], capture_output=True, text=True, env={**os.environ, "PYTHONHASHSEED": seed})
        assert done.returncode == 0, done.stderr
        made.append({one.name: one.read_bytes() for one in place.iterdir()})
    assert made[0] == made[1] and str(folder).encode() not in b"".join(made[0].values())
    return made[0]


def in_two_processes(*arguments: object) -> list[Any]:
    """What --json says in two new processes, with other hashes of texts, of which the second one is disturbed"""
    made = []
    for seed in ("0", "1"):
        other = subprocess.Popen([sys.executable, "-c", "for _ in range(30_000_000): pass"]) if seed == "1" else None
        done = subprocess.run([sys.executable, "-m", "kalmanq.command_line", *map(str, arguments), "--json"], capture_output=True, text=True,
                              env={**os.environ, "PYTHONHASHSEED": seed})
        if other:
            other.kill(), other.wait()
        made.append(json.loads(done.stdout))
    return made


def _text(stream: object) -> str:
    stream.seek(0)  # type: ignore[attr-defined]
    return stream.read().decode().replace("\r\n", "\n")  # type: ignore[attr-defined]


def _feed(pipe: int, data: bytes) -> None:
    try:
        with os.fdopen(pipe, "wb") as stream:
            stream.write(data)
    except BrokenPipeError:
        pass


def _run(arguments: list[str], folder: object, needed: int, *streams: int) -> None:
    code, had = 1, {one for one in SLOW if one in sys.modules}
    try:
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
        sys.stdin, sys.stdout, sys.stderr = (open(number, mode, encoding="utf-8", closefd=False, buffering=buffering)
                                             for number, mode, buffering in ((0, "r", -1), (1, "w", -1), (2, "w", 1)))
        sys.__stdout__, sys.__stderr__, sys.__stdin__ = sys.stdout, sys.stderr, sys.stdin
        if folder is not None:
            os.chdir(str(folder))
        warnings.resetwarnings()  # pytest's are others
        for silent in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", silent)
        sys.argv = ["kalmanq", *arguments]
        sys.modules["__main__"] = command_line  # what workers import
        if SLOW[-1] in sys.modules:
            sys.modules[SLOW[-1]]._executor = None  # those of the parent do not hear this process
        command_line.main()
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
    except BaseException:
        traceback.print_exc()
    finally:
        try:
            sys.stdout.flush()
        except BrokenPipeError:
            pass
        os.write(needed, " ".join(one for one in SLOW if one in sys.modules and one not in had).encode())
        os._exit(code)
