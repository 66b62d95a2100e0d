"""kalmanq compile --library of a constant model: the C that design writes, built with the library, is the filter of kalmanq.run bit for bit."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any, Optional

import numpy as np
import pytest
from command import json_of, kalmanq, succeeds
from firmware_here import Firmware
from library import EXAMPLES, ROOT, STRICT, cc, saved
from models import LATE
from whole import paired

from kalmanq import Filter, Robust
from kalmanq.firmware.ranges import with_ranges
from kalmanq.model import model_file
from kalmanq.run.simulation import simulate

LOSSES = (None, ("gate", 2.5), ("student", 4.0), ("huber", 1.5), ("jump", 6.0))
ROWS = 150
KNOWN = """
[model]
A = [[1.0, 0.5], [0.0, 1.0]]
Q = [[0.02, 0.05], [0.05, 0.3]]
P0 = [50.0, 10.0]
[states]
ranges = [4000.0, 4000.0]
[[sensors]]
name = "place"
H = [1.0, 0.0]
R = 1.0
ranges = [8000.0]
[[sensors]]
name = "wheel"
measurements = ["left", "right"]
H = [[0.0, 1.0], [1.0, 0.0]]
R = [[2.0, 0.5], [0.5, 4.0]]
ranges = [8000.0, 8000.0]
[[sensors]]
name = "other"
H = [1.0, 0.0]
R = 1.0
ranges = [8000.0]
"""
SENSORS = {"sensors": KNOWN, "unknown": KNOWN.replace("P0 = [50.0, 10.0]", 'P0 = "unknown"')}


def compiled(folder: Path, model: Path, *options: Any) -> dict[str, Any]:
    return json_of("compile", model, "-o", folder / "own.c", "--library", *options)


@pytest.mark.parametrize("name, loss, arithmetic", [
    *paired(((name, loss) for name in ("cart", "track", "factor", "oscillator") for loss in LOSSES), ("f32", "f64", "q31")),
    *((name, LOSSES[1], arithmetic) for name in ("sensors", "unknown") for arithmetic in ("f32", "f64", "q31"))])
def test_it_is_the_filter_of_the_host(name: str, loss: Optional[tuple[str, float]], arithmetic: str, tmp_path: Path) -> None:
    """With outliers and rows that are missing in part or whole: its memory after each row"""
    path = saved(tmp_path / f"{name}.toml", SENSORS[name]) if name in SENSORS else EXAMPLES / f"{name}.toml"
    model = model_file.read(path)
    told = compiled(tmp_path, path, "--arith", arithmetic, *([] if loss is None else ["--robust", f"{loss[0]}={loss[1]}"]))
    if arithmetic == "q31":
        model, notes = with_ranges(model, [])
        assert [one["range"] for one in told["chosen_ranges"]] == [one.range for one in notes]
    f, robust = Filter(model, arithmetic, way=told["way"]), None if loss is None else Robust(*loss)
    firmware = Firmware(tmp_path, "own", arithmetic)
    draw = np.random.default_rng(1)
    u = draw.uniform(-1, 1, (ROWS, len(model.inputs))) if model.inputs else None
    z = simulate(model, ROWS, 1, u)[1]
    z += np.sqrt(np.diag(model.R)) * np.where(draw.random(z.shape) < 0.1, draw.normal(size=z.shape) * 12, 0)
    z[draw.random(z.shape) < 0.2], z[40:50] = np.nan, np.nan
    z[100:, -1] += 40 * (name in SENSORS)  # a sensor that jumps for good
    for t in range(ROWS):
        if t:
            f.predict(None if u is None else u[t - 1])
        f.update(z[t], robust)
        words = f.parts.words(np.nan_to_num(z[t:t + 1]), "measurements")[0]
        moved = [] if u is None or not t else [f.parts.words(u[t - 1:t], "controls")[0]]
        assert firmware.call("step" if t else "update", *moved, words, int((~np.isnan(z[t])) @ (1 << np.arange(model.m)))) == 0
        assert np.array_equal(firmware.memory(len(f.memory)), f.memory), t


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_compilers_have_nothing_to_say(compiler: str, tmp_path: Path) -> None:
    if not shutil.which(compiler):
        pytest.skip(f"no {compiler}")
    for arithmetic, loss in (("f32", "gate=4"), ("f64", "student"), ("q31", "gate"), ("q31", "jump=12")):
        for path in (EXAMPLES / "track.toml", saved(tmp_path / "unknown.toml", SENSORS["unknown"])):
            compiled(tmp_path, path, "--arith", arithmetic, "--robust", loss)
            cc(compiler, *STRICT, f"-I{ROOT / 'include'}", "-fsyntax-only", "own.c", folder=tmp_path)


def test_design_writes_the_same(tmp_path: Path) -> None:
    """But for what it says of a core"""
    for arithmetic in ("f32", "q31"):
        told = compiled(tmp_path, EXAMPLES / "track.toml", "--arith", arithmetic)
        done = kalmanq("design", EXAMPLES / "track.toml", "--core", "m3", "--arith", arithmetic, "--way", told["way"], "--name", "own", "-o", tmp_path / "..")
        assert done.returncode == 0 and (tmp_path / "own.c").read_bytes() == (tmp_path / ".." / "own.c").read_bytes()


@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_what_comes_late_is_taken(arithmetic: str, tmp_path: Path) -> None:
    """As if it had come in time"""
    (tmp_path / "late.toml").write_text(LATE)
    compiled(tmp_path, tmp_path / "late.toml", "--arith", arithmetic)
    model, firmware = model_file.read(tmp_path / "late.toml"), Firmware(tmp_path, "own", arithmetic)
    f, draw = Filter(model, arithmetic, way="tables"), np.random.default_rng(2)
    z, u = draw.normal(size=(30, 2)), draw.normal(size=(30, 1))
    for t in range(30):
        words, moved = f.parts.words(z[t:t + 1], "measurements")[0], f.parts.words(u[t:t + 1], "controls")[0]
        if t:
            f.predict(u[t])
            assert firmware.call("predict", moved) == 0
        f.update([np.nan if t > 26 else z[t, 0], np.nan if t > 26 else z[t, 1]])
        assert firmware.call("update_quick", words[:1], 0 if t > 26 else 1) == 0
        if 3 <= t:
            late = f.parts.words(z[t - 3:t - 2], "measurements")[0]
            assert firmware.call("update_late", late[1:], 1, 3) == 0
    assert np.array_equal(firmware.memory(len(f.memory)), f.memory)


@pytest.mark.parametrize("model", ["track.toml", "battery.py", "attitude.py"])
@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_the_header_names_the_files_that_it_links_with(model: str, arithmetic: str, tmp_path: Path) -> None:
    """Those of src/, as they stand, and no other"""
    succeeds("compile", EXAMPLES / model, "-o", tmp_path / "own.c", "--library", "--arith", arithmetic)
    named = re.search(r"add of its src/ alone (kq_\w+\.c) and (kq_\w+\.c)", (tmp_path / "own.h").read_text())
    assert named
    (tmp_path / "main.c").write_text('#include "own.h"\nint main(void) { return 0; }\n')
    cc("gcc", "-std=c11", "-O0", f"-I{ROOT / 'include'}", "main.c", "own.c", *(str(ROOT / "src" / one) for one in named.groups()), "-lm", "-o", "own", folder=tmp_path)
