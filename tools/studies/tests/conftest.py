"""Tests of the studies: with what tests/tools has to run commands by, and its mark."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "tests/tools"))

from kalmanq_studies.commands import examples, gallery, study  # noqa: E402, F401  loaded once, not by each command


def pytest_configure(config):
    config.addinivalue_line("markers", "whole: only with tools/test.sh --all")
