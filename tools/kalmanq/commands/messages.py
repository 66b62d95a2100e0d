"""How a command speaks: what ends it, and what it warns of, in one line each."""

from __future__ import annotations

import json
import math
import os
import sys
import warnings
from contextlib import contextmanager
from typing import Any, Iterable, Iterator, Optional

from rich.console import Console
from rich.table import Table

from kalmanq.errors import KalmanqError, KalmanqWarning

# What some commands need beside NumPy: the extra of the package that has it
EXTRAS = {**dict.fromkeys(("gpxpy", "pyulog", "pynmea2", "pyubx2", "can", "cantools", "pyarrow", "openpyxl", "pymap3d"), "logs"), "matplotlib": "plots", "PIL": "plots", "scipy": "fitting", "joblib": "campaigns", "pandas": "pandas", "jinja2": "cli", "rich": "cli", "typer": "cli", "unicorn": "costs", "elftools": "costs"}
REFUSED, NO_MAXIMUM, INTERRUPTED, PIPE_CLOSED = 1, 3, 130, 141


@contextmanager
def told_in_one_line(model: Optional[Any] = None, *others: Optional[Any]) -> Iterator[None]:
    """Ends the program with one line where it cannot go on, and shows warnings as one line each.  What names no
    file is about the model."""
    warnings.simplefilter("ignore", RuntimeWarning)  # of numbers that are NaN, which is what they are to say
    warnings.simplefilter("always", KalmanqWarning)
    said: set[str] = set()
    warnings.showwarning = lambda message, *_: _say_once(str(message), said)  # type: ignore
    try:
        yield
    except KalmanqError as problem:
        named = str(problem).startswith("--") or any(str(path) in str(problem) for path in (model, *others) if path)
        stop(str(problem) if named or model is None else f"{model}: {problem}")
    except BrokenPipeError as problem:
        if problem.filename is not None:
            stop(f"{problem.filename}: {problem.strerror}")
        _leave_the_output()
        raise SystemExit(PIPE_CLOSED) from None
    except ModuleNotFoundError as problem:
        missing = str(problem.name).split(".")[0]
        if missing not in EXTRAS:
            raise
        stop(f"this needs {missing}, which is not installed: pip install './tools[{EXTRAS[missing]}]'")
    except MemoryError:
        stop("not enough memory for all rows at once: leave --smooth, --plot and --sort out, which keep them")
    except OSError as problem:
        stop(f"{problem.filename}: {problem.strerror}" if problem.filename else str(problem))
    except KeyboardInterrupt as interrupt:
        print(f"kalmanq: {interrupt if str(interrupt) else 'interrupted'}", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None


def _leave_the_output() -> None:
    """Nobody reads it any more, `head` for one: what is left of it goes nowhere, without a word."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _say_once(line: str, said: set[str]) -> None:
    """Blocks of rows repeat what is said of the whole run."""
    if line not in said:
        print(f"kalmanq: {_shown(line)}", file=sys.stderr)
    said.add(line)


def stop(line: str, code: int = REFUSED) -> None:
    print(f"kalmanq: {_shown(line)}", file=sys.stderr)
    raise SystemExit(code)


def _shown(line: str) -> str:
    return "".join(c if c.isprintable() else " " for c in line)


def print_json(told: Any) -> None:
    """For machines; what is NaN or infinite, which JSON has no word for, is null."""
    print(json.dumps(_plain(told), indent=2))


def _plain(told: Any) -> Any:
    """In words of JSON: arrays, their numbers and paths, too"""
    if isinstance(told, dict):
        return {key: _plain(one) for key, one in told.items()}
    told = os.fspath(told) if isinstance(told, os.PathLike) else told.tolist() if hasattr(told, "tolist") else told
    if isinstance(told, (list, tuple)):
        return [_plain(one) for one in told]
    return None if isinstance(told, float) and not math.isfinite(told) else told


def table(*columns: str, title: str) -> Table:
    return Table(*columns, title=title, title_justify="left")


def tell_written(paths: Iterable[Any], console: Console) -> None:
    for path in filter(None, paths):
        console.print(f"wrote {path}")


def console() -> Console:
    return Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else 120)
