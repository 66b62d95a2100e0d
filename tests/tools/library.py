"""The library on this machine, for programs around what the tools write: an object of each file, compiled once."""

from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]
_FOLDER = TemporaryDirectory(prefix="kalmanq-library-")


@lru_cache(None)
def _object(part: str) -> str:
    made = f"{_FOLDER.name}/kq_{part}.o"
    subprocess.run(["cc", "-std=c11", "-O0", "-ffp-contract=off", "-fPIC", f"-I{ROOT / 'include'}", "-c",
                    str(ROOT / "src" / f"kq_{part}.c"), "-o", made], check=True)
    return made


def objects(*parts: str) -> list[str]:
    """Of src/kq_PART.c"""
    return [_object(part) for part in parts]
