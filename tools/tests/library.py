"""Programs around what the tools write, on this machine; of the library an object of each file, compiled once."""

from __future__ import annotations

import subprocess
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Mapping, Optional

ROOT = Path(__file__).resolve().parents[2]
STRICT = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror")
_FOLDER = TemporaryDirectory(prefix="kalmanq-library-")


@lru_cache(None)
def _object(part: str) -> str:
    made = f"{_FOLDER.name}/kq_{part}.o"
    subprocess.run(["cc", "-std=c11", "-O0", "-ffp-contract=off", "-fPIC", f"-I{ROOT / 'include'}", "-c",
                    str(ROOT / "src" / f"kq_{part}.c"), "-o", made], check=True)
    return made


def written(folder: Path, files: Mapping[str, str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def cc(*command: object, folder: Optional[Path] = None) -> None:
    """A compiler that has nothing to say"""
    done = subprocess.run([str(one) for one in command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr


def objects(*parts: str) -> list[str]:
    """Of src/kq_PART.c"""
    return [_object(part) for part in parts]
