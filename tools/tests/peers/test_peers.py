"""The tests that other Kalman libraries carry, run on kalmanq's numbers: with their own data, models and assertions.

    test_peers.py PEERS_PYTHON

Counts are of tests that pass and, once kalmanq's numbers are spoilt by a factor, fail.
"""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from fnmatch import fnmatch
from typing import Any

import pytest


class Outcomes:
    """Of each test that is run: passed, failed or skipped; those that are left out with their pattern"""

    def __init__(self, left_out: dict[str, str]):
        self.left_out, self.of, self.left, self.texts = left_out, {}, Counter(), {}

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        kept = []
        for item in items:
            pattern = next((one for one in self.left_out if fnmatch(item.nodeid.split("::", 1)[1], one)), None)
            if pattern is None:
                kept.append(item)
            else:
                self.left[pattern] += 1
        items[:] = kept

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.when == "call" or report.outcome != "passed":
            self.of[report.nodeid] = report.outcome
            self.texts[report.nodeid] = report.longreprtext.splitlines()[-12:]


def outcomes(adapter: Any, spoil: Any) -> Outcomes:
    made, stop = Outcomes(adapter.LEFT_OUT), adapter.put_into(spoil)
    try:
        pytest.main(["-p", "no:cacheprovider", "-p", "no:terminal", "-c", "/dev/null", "-W", "ignore", "--pyargs",
                     *adapter.TESTS], plugins=[made])
    finally:
        stop()
    return made


class Spoilt:
    """By 1 + 1e-3 and 1 - 1e-3 in turn: two runs that are wrong alike would agree (a run has an odd number of arrays)."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, array: Any) -> Any:
        self.calls += 1
        return array * (1 + 1e-3 * (-1) ** self.calls)


def judged(name: str, adapter: Any) -> int:
    right, spoilt = outcomes(adapter, lambda array: array), outcomes(adapter, Spoilt())
    wrong = [one for one, outcome in right.of.items() if outcome == "failed"]
    passed = [one for one, outcome in right.of.items() if outcome == "passed"]
    heard = [one for one in passed if spoilt.of[one] == "failed"]
    for one in wrong:
        print(one, *right.texts[one], sep="\n    ")
    if "-v" in sys.argv:
        print(*(one for one in passed if one not in heard), sep="\n")
    for pattern, reason in adapter.LEFT_OUT.items():
        print(f"    left out {right.left[pattern]:3}  {pattern}: {reason}")
    print(f"{name}: {len(heard)} tests passed, {len(wrong)} failed, {len(passed) - len(heard)} say nothing of numbers, "
          f"{sum(right.left.values())} left out, {sum(one == 'skipped' for one in right.of.values())} skipped by themselves")
    return len(wrong) + (not heard)


if __name__ == "__main__":
    sys.path.append(subprocess.run([sys.argv[1], "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], check=True,
                                   capture_output=True, text=True).stdout.strip())
    import on_statsmodels

    sys.exit(bool(judged("statsmodels", on_statsmodels)))
