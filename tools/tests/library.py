"""Programs around what the tools write, on this machine; of the library an object of each file, compiled once."""

from __future__ import annotations

import shutil
import subprocess
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Mapping, Optional, Sequence

import kalmanq

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = Path(kalmanq.__file__).parent / "examples"  # of the package that is installed
STRICT = ("-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror")
_FOLDER = TemporaryDirectory(prefix="kalmanq-library-")


@lru_cache(None)
def _object(part: str) -> str:
    made = f"{_FOLDER.name}/kq_{part}.o"
    subprocess.run(["cc", "-std=c11", "-O0", "-ffp-contract=off", "-fPIC", f"-I{ROOT / 'include'}", "-c",
                    str(ROOT / "src" / f"kq_{part}.c"), "-o", made], check=True)
    return made


def saved(path: Path, text: str | bytes) -> Path:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def text_in(folder: Path, text: str | bytes, name: str = "data.csv") -> Path:
    return saved(folder / name, text)


def written(folder: Path, files: Mapping[str, str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def cc(*command: object, folder: Optional[Path] = None) -> None:
    """A compiler that has nothing to say"""
    done = subprocess.run([str(one) for one in command], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr


def printed(program: Path) -> str:
    """What a program prints, which ends well"""
    done = subprocess.run([str(program)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def passes(folder: Path, name: str, *more: object, compiler: str = "cc", flags: Sequence[str] = STRICT) -> str:
    """What NAME_test prints at last is OK: of NAME.c and NAME_test.c in the folder, of which the compiler has nothing to say"""
    cc(compiler, *flags, f"{name}.c", f"{name}_test.c", *more, "-lm", "-o", "trial", folder=folder)
    said = printed(folder / "trial")
    assert said.endswith("OK\n"), said
    return said


def host_alone(folder: Path) -> str:
    """A PATH with the host's compiler and no other"""
    for name in ("cc", "as", "ld"):
        (folder / name).symlink_to(str(shutil.which("gcc" if name == "cc" else name)))
    return str(folder)


def failing_gcc(folder: Path) -> str:
    """A folder, for PATH, whose arm-none-eabi-gcc fails"""
    saved(folder / "arm-none-eabi-gcc", "#!/bin/sh\necho 'cannot find -lc' >&2\nexit 1\n").chmod(0o755)
    return str(folder)


def objects(*parts: str) -> list[str]:
    """Of src/kq_PART.c"""
    return [_object(part) for part in parts]
