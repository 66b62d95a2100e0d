"""The code on the pages of the studies, and the examples that their commands' help ends with"""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from command import kalmanq
from whole import WHOLE
from worked import KNOWN, languages, work_through

from kalmanq_studies.commands import COMMANDS

PAGES = sorted(Path(__file__).resolve().parents[1].glob("*.md"))


@WHOLE
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_page(page, tmp_path):
    work_through(page, tmp_path)


def test_every_block_of_commands_is_run():
    assert PAGES and not [page for page in PAGES if not languages(page) <= KNOWN]


@WHOLE
@pytest.mark.parametrize("name", COMMANDS)
def test_the_examples_of_each_commands_help(name, tmp_path):
    done = kalmanq(*shlex.split(COMMANDS[name].example)[1:], folder=tmp_path)
    assert done.returncode == 0, done.stderr


def test_the_command_has_them():
    told = kalmanq("--help").stdout
    assert COMMANDS and all(f" {name} " in told for name in COMMANDS)
