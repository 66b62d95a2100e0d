"""The code on a page, worked through in a folder of its own, from the page's top to its end.

A block that names a file (```toml cart.toml) is written to it; a model file is read, Python and sh blocks run, C compiles.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from command import kalmanq
from library import ROOT

from kalmanq.model import model_file
from kalmanq.nonlinear import file as nonlinear_file

BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```", re.S | re.M)
ELSEWHERE = re.compile(r"^(tools/|pip)")  # what other tests run: they build, or install


def languages(page: Path) -> set[str]:
    return {one[0] for one in BLOCK.findall(page.read_text(encoding="utf-8"))}


def work_through(page: Path, folder: Path) -> None:
    for name in ("tools", "include"):
        (folder / name).symlink_to(ROOT / name)
    for language, name, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if name:
            (folder / name).write_text(text)
        RUN.get(language, lambda *_: None)(text, name, folder)


def python(text: str, name: str, folder: Path) -> None:
    if not name:
        done = subprocess.run([sys.executable, "-W", "ignore", "-c", text], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    elif "def h(" in text:
        nonlinear_file.read(folder / name)


def toml(text: str, name: str, folder: Path) -> None:
    assert name, "a model file has a name: ```toml NAME.toml"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model_file.read(folder / name)


def c(text: str, name: str, folder: Path) -> None:
    if name:  # the others are run by readme.program
        subprocess.run(["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-Iinclude", "-c", name, "-o", "part.o"], cwd=folder, check=True)


def sh(text: str, _: str, folder: Path) -> None:
    """A line of kalmanq in a process that has its modules already; other parts by the shell, a line each"""
    for line in re.sub(r"\\\n", " ", text).splitlines():
        if line.startswith("kalmanq "):
            done = kalmanq(*shlex.split(line, comments=True)[1:], folder=folder)
            skip_without_webassembly(done)
            assert done.returncode == 0, f"{line}\n{done.stdout}{done.stderr}"
        elif not ELSEWHERE.match(line):
            subprocess.run(["bash", "-euc", line], cwd=folder, check=True, capture_output=True)


def skip_without_webassembly(done: subprocess.CompletedProcess) -> None:
    """A package that was built without clang refuses tune, and nothing else"""
    if "is without WebAssembly" in done.stderr:
        pytest.skip(done.stderr)


RUN = {"python": python, "toml": toml, "c": c, "sh": sh}
KNOWN = {*RUN, "text", "eval"}  # text is what a program prints, or columns
