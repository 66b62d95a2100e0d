"""The page of the studies, and the examples that their commands' help ends with."""

from __future__ import annotations

import pytest
from test_pages import ROOT, check_example, check_page
from whole import WHOLE

from kalmanq.commands import COMMANDS, STUDIES


@WHOLE
def test_the_page(tmp_path):
    check_page(ROOT / "tools/studies/README.md", tmp_path)


@WHOLE
@pytest.mark.parametrize("name", [name for name, row in COMMANDS.items() if row.module.startswith(STUDIES)])
def test_the_example_of_each_commands_help(name, tmp_path):
    check_example(name, COMMANDS[name].example, tmp_path)
