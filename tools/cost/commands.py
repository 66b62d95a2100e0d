"""Runs compilers and the like."""

from __future__ import annotations

import subprocess
from typing import Sequence

from errors import CostError, one_line

TIME_LIMIT = 300  # seconds
TELLING = ("error: ", "undefined reference", "cannot find", "will not fit")


def run(command: Sequence[str]) -> str:
    """What the command prints, or a CostError with the first line of its complaint."""
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
        )
    except FileNotFoundError as problem:
        hint = "bash -c '. tools/setup.sh && kq_setup cost' installs it"
        raise CostError(f"{command[0]}: not found; {hint}") from problem
    except subprocess.TimeoutExpired as problem:
        raise CostError(f"{command[0]}: no end within {TIME_LIMIT} s") from problem
    if done.returncode:
        raise CostError(f"{command[0]}: {complaint(done.stderr or done.stdout)}")
    return done.stdout


def complaint(text: str) -> str:
    """The line that matters most."""
    lines = [line for line in text.splitlines() if line.strip()] or ["failed"]
    errors = [line for line in lines if any(word in line for word in TELLING)]
    return one_line((errors or lines)[0])
