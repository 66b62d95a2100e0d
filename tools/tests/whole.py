"""Marks.  WHOLE: only tools/test.sh --all runs it; `first(2, VALUES)` are VALUES of which every day has the first two, `paired(VALUES, OTHERS)` all
pairs, of which every day has each of VALUES once, with OTHERS in turn.
MEASURED: it is of what C costs on cores, which is compiled and emulated for seconds; the others run as where no cross compiler is."""

from __future__ import annotations

from typing import Any, Iterable, Sequence

import pytest

WHOLE, MEASURED = pytest.mark.whole, pytest.mark.measured


def pytest_configure(config: pytest.Config) -> None:  # pytest -p whole
    config.addinivalue_line("markers", "whole: only with tools/test.sh --all")
    config.addinivalue_line("markers", "measured: of what C costs on cores")


@pytest.fixture(autouse=True)
def unmeasured(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if not request.node.get_closest_marker("measured"):
        monkeypatch.setattr("kalmanq.firmware.measured.missing", lambda *_: "not measured in this test")


def first(count: int, values: Iterable[Any]) -> list[Any]:  # values that are tuples are several parameters
    return [value if k < count else pytest.param(*value if isinstance(value, tuple) else (value,), marks=WHOLE)
            for k, value in enumerate(values)]


def paired(values: Iterable[Any], others: Sequence[Any]) -> list[Any]:
    given = [value if isinstance(value, tuple) else (value,) for value in values]
    return first(len(given), [(*value, others[(k + turn) % len(others)]) for turn in range(len(others)) for k, value in enumerate(given)])
