"""C that this machine's compiler makes a library of."""

from __future__ import annotations

import os
import shutil
import subprocess
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator, Mapping, Sequence

from kalmanq.data.files import own_folder, telling_where
from kalmanq.errors import KalmanqError

FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-w")


@contextmanager
def folder_of(texts: Mapping[str, str]) -> Iterator[Path]:
    """A folder with these files, by name, that is gone afterwards"""
    with own_folder("kalmanq-compile-") as folder:
        with telling_where(folder):
            for file, text in texts.items():
                (folder / file).write_text(text, encoding="utf-8")
        yield folder


def build(folder: Path, sources: Sequence[str], target: str, flags: Sequence[str]) -> Path:
    command = [compiler(), *FLAGS, *flags, *(str(folder / one) for one in sources), "-lm", "-o", str(folder / target)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["no reason given"]
        said = next((line for line in lines if "error" in line), lines[0])
        raise KalmanqError(f"this machine's C compiler refused the filter: {said}; set CC to gcc or clang, or report it with the model file")
    return folder / target


class NoCompiler(KalmanqError):
    """The emitted C cannot run here."""


def compiler(environment: Mapping[str, str] = os.environ) -> str:
    for name in (environment.get("CC", ""), "cc", "gcc", "clang"):
        if name and shutil.which(name):
            return name
    raise NoCompiler("the filter is tried on this machine, and that needs a C compiler: install gcc or clang, or set CC")
