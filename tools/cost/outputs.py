"""A file that appears whole or not at all."""

from __future__ import annotations

import os
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator


@contextmanager
def staged(final: Path) -> Iterator[Path]:
    """Where to write what will be called `final` once it is complete."""
    temporary = final.with_name(f".{final.name}.{os.getpid()}.tmp")
    try:
        yield temporary
        os.replace(temporary, final)
    finally:
        temporary.unlink(missing_ok=True)


def write(final: Path, text: str) -> None:
    with staged(final) as temporary:
        temporary.write_text(text, encoding="utf-8")
