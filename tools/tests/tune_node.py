"""What tests of the page of `kalmanq tune` share: its engine in Node, and the page in a browser."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import browser
from kalmanq.tune import page

needs_node = pytest.mark.skipif(not shutil.which("node"), reason="node is not installed: tools/setup.sh, kq_setup browser")
needs_browser = pytest.mark.skipif(not browser.found(), reason="chromium is not installed: tools/setup.sh, kq_setup browser")


def ran(core: bytes, cases: list[dict[str, Any]]) -> list[dict[str, Any]]:
    given = json.dumps({"core": base64.b64encode(core).decode(), "cases": cases})
    made = subprocess.run(["node", Path(__file__).with_name("tune_bits.js"), page.HERE], input=given, capture_output=True, text=True, check=True)
    return json.loads(made.stdout)


def numbers(text: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), "<f8")


def ready(chromium: browser.Browser, path: Path, **look: Any) -> None:
    chromium.errors.clear()
    chromium.open(path, **look)
    chromium.wait("document.body.dataset.took !== undefined")
    settled(chromium)


def settled(chromium: browser.Browser) -> None:
    chromium.wait("!filterRuns.busy && !smoothRuns.busy && !queued && !second.waiting.size")


def shown(chromium: browser.Browser, what: str) -> tuple[np.ndarray, np.ndarray]:
    return np.array(chromium.run(f"Array.from(drawn.{what}.low)"), float), np.array(chromium.run(f"Array.from(drawn.{what}.high)"), float)


def nameless(chromium: browser.Browser) -> list[str]:
    """Roles of what a reader of the screen has no name for"""
    roles = {"button", "slider", "textbox", "combobox", "spinbutton", "checkbox", "radio", "group"}
    return [one["role"]["value"] for one in chromium.accessible()
            if not one.get("ignored") and one.get("role", {}).get("value") in roles and not one.get("name", {}).get("value")]


def come_by(z: np.ndarray, late: dict[int, int], t: int) -> np.ndarray:
    """Rows 0 to t with what has come by then; late: of a cell, by how many rows"""
    there = z[:t + 1].copy()
    for cell, by in late.items():
        row, component = divmod(cell, z.shape[1])
        if row <= t < row + by:
            there[row, component] = np.nan
    return there
