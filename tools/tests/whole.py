"""Marks what only tools/test.sh --all runs: `first(2, VALUES)` are VALUES of which every day has the first two."""

from __future__ import annotations

from typing import Any, Iterable

import pytest

WHOLE = pytest.mark.whole


def pytest_configure(config: pytest.Config) -> None:  # pytest -p whole
    config.addinivalue_line("markers", "whole: only with tools/test.sh --all")


def first(count: int, values: Iterable[Any]) -> list[Any]:  # values that are tuples are several parameters
    return [value if k < count else pytest.param(*value if isinstance(value, tuple) else (value,), marks=WHOLE)
            for k, value in enumerate(values)]
