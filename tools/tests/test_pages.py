"""The code on the pages of the host tools (worked.py), and the examples that the commands' help ends with."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys

import pytest
from command import kalmanq
from library import ROOT
from whole import WHOLE
from worked import KNOWN, languages, skip_without_webassembly, work_through

from kalmanq.command_line import loaded
from kalmanq.commands import COMMANDS

PAGES = sorted((ROOT / "tools/docs").glob("[gr]*/*.md"))
EVERY_DAY = {"model_files", "tasks", "coming_from", "nonlinear"}  # the others take seconds of a processor


@pytest.mark.parametrize("page", [pytest.param(one, marks=() if one.stem in EVERY_DAY else WHOLE) for one in PAGES],
                         ids=lambda page: page.stem)
def test_the_page(page, tmp_path):
    work_through(page, tmp_path)


def test_every_block_of_commands_is_run():
    assert not [page for page in PAGES if not languages(page) <= KNOWN]


DAILY = ("check", "compile", "steady")


@pytest.mark.parametrize("name, example", [pytest.param(name, one, marks=() if name in DAILY else WHOLE, id=f"{name} {k}")
                                           for name, row in COMMANDS.items() for k, one in enumerate([row.example, *row.more])])
def test_the_examples_of_each_commands_help(name, example, tmp_path):
    for path in (ROOT / "tools/kalmanq/examples").glob("*.*"):
        shutil.copy(path, tmp_path)
    if "my.csv" in example and name != "simulate":
        assert kalmanq(*shlex.split(COMMANDS["simulate"].example)[1:], folder=tmp_path).returncode == 0
    done = kalmanq(*shlex.split(example)[1:], folder=tmp_path)
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
