"""The code on the pages of the host tools, and the examples that the commands' help ends with: each page is worked through in a folder of its own, from its top to its end.

A block that names a file (```toml cart.toml) is written to it; a model file is read, Python and sh blocks run, C compiles.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from command import kalmanq
from whole import WHOLE

from kalmanq.command_line import loaded
from kalmanq.commands import COMMANDS, STUDIES
from kalmanq.model import model_file
from kalmanq.nonlinear import file as nonlinear_file

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted((ROOT / "tools/docs").glob("[gr]*/*.md"))
BLOCK = re.compile(r"^```(\w+) ?(\S*)\n(.*?)^```", re.S | re.M)
EVERY_DAY = {"model_files", "tasks", "coming_from", "nonlinear"}  # the others take seconds of a processor
ELSEWHERE = re.compile(r"^(tools/|pip)")  # what other tests run: they build, or install


@pytest.mark.parametrize("page", [pytest.param(one, marks=() if one.stem in EVERY_DAY else WHOLE) for one in PAGES],
                         ids=lambda page: page.stem)
def test_the_page(page, tmp_path):
    check_page(page, tmp_path)


def check_page(page: Path, folder: Path) -> None:
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


def test_every_block_of_commands_is_run():
    """None is of a language that no test knows; text is what a program prints, or columns"""
    known = {*RUN, "text", "eval"}
    for page in PAGES:
        assert {one[0] for one in BLOCK.findall(page.read_text(encoding="utf-8"))} <= known, page


DAILY = ("check", "compile", "steady")


@pytest.mark.parametrize("name, example", [pytest.param(name, one, marks=() if name in DAILY else WHOLE, id=f"{name} {k}")
                                           for name, row in COMMANDS.items() if not row.module.startswith(STUDIES)
                                           for k, one in enumerate([row.example, *row.more])])
def test_the_examples_of_each_commands_help(name, example, tmp_path):
    check_example(name, example, tmp_path)


def check_example(name: str, example: str, folder: Path) -> None:
    for path in (ROOT / "tools/kalmanq/examples").glob("*.*"):
        shutil.copy(path, folder)
    if "my.csv" in example and name != "simulate":
        assert kalmanq(*shlex.split(COMMANDS["simulate"].example)[1:], folder=folder).returncode == 0
    done = kalmanq(*shlex.split(example)[1:], folder=folder)
    skip_without_webassembly(done)
    assert done.returncode == 0, done.stderr


def test_each_option_of_compile_has_an_example():
    row = COMMANDS["compile"]
    given = {word for one in [row.example, *row.more] for word in shlex.split(one)}
    assert not [one.name for one in loaded("compile").params if one.name not in ("model", "help") and not given & {*one.opts, *one.secondary_opts}]
    assert all(one in " ".join(kalmanq("compile", "--help").stdout.split()) for one in row.more)


def test_help_ends_with_the_example():
    for name in ("run", "fit"):
        assert f"Example: {COMMANDS[name].example}" in " ".join(kalmanq(name, "--help").stdout.split())


@pytest.mark.parametrize("typed, wanted", [("kalmanq ru", ["run"]), ("kalmanq run --ar", ["--arith"]),
                                           ("kalmanq run --arith q", ["q31"])])
def test_the_shell_completes(typed, wanted):
    done = subprocess.run([sys.executable, "-m", "kalmanq.command_line"], capture_output=True, text=True, env={
        **os.environ, "_KALMANQ_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(typed.count(" "))})
    assert done.stdout.split() == wanted, done.stderr
