"""Which compilers made the figures."""

from __future__ import annotations

from commands import run
from cores import CORES


def compilers() -> tuple[str, ...]:
    """The first line that each compiler says of itself."""
    prefixes = dict.fromkeys(core.prefix for core in CORES)
    return tuple(run([f"{prefix}gcc", "--version"]).splitlines()[0] for prefix in prefixes)
