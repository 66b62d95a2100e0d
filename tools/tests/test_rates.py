"""Sensors of different rates in one table: what is said of full samples, which never come."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command import kalmanq

from kalmanq.compiler.given.rates import rates_of

MODEL = """
[model]
name = "speedometer"
A = [[1.0, 0.005], [0.0, 1.0]]
H = [[0.0, 1.0], [1.0, 0.0]]
R = [0.01, 4.0]
Q = [1e-6, 1e-5]
P0 = [100.0, 4.0]

[states]
names = ["place", "speed"]

[measurements]
names = ["wheel", "gnss"]
"""


def table(rows: int, every: tuple, first: int = 0, lost: float = 0.0) -> np.ndarray:
    draws, t = np.random.default_rng(1), np.arange(rows)
    z = draws.standard_normal((rows, len(every)))
    for j, k in enumerate(every):
        z[((t - first) % k != 0) | (draws.random(rows) < lost), j] = np.nan
    return z


@pytest.mark.parametrize("every", [(1, 8), (8, 1), (1, 4, 10), (2, 1, 1)])
@pytest.mark.parametrize("first, lost", [(0, 0.0), (3, 0.0), (5, 0.05)])
def test_rates_are_seen_in_rows(every: tuple, first: int, lost: float) -> None:
    assert rates_of(table(2000, every, first, lost)) == every


@pytest.mark.parametrize("z", [table(500, (1, 1)), table(500, (1, 1), lost=0.2), table(500, (2, 3)), table(500, (1, 101)), np.full((9, 2), np.nan),
                               np.zeros((0, 2)), np.where(np.random.default_rng(1).random((500, 2)) < 0.3, np.nan, 1.0)],
                         ids=("all", "some are lost", "none in each row", "too long", "nothing", "no rows", "no rhythm"))
def test_what_is_no_rhythm(z: np.ndarray) -> None:
    assert rates_of(z) == ()


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    (tmp_path / "model.toml").write_text(MODEL)
    rows = ["wheel,gnss", *(",".join("" if np.isnan(one) else f"{one:.4f}" for one in row) for row in table(1600, (1, 8)))]
    (tmp_path / "data.csv").write_text("\n".join(rows) + "\n")
    return tmp_path / "model.toml", tmp_path / "data.csv"


def test_check_names_the_option_and_when_it_settles(files: tuple[Path, Path]) -> None:
    alone, known = (kalmanq("check", *some) for some in (files[:1], files))
    assert "full samples" in alone.stdout and "--every" not in alone.stdout
    said = " ".join(known.stdout.split())
    assert "gnss every 8 rows" in said and "compile --every 1,8" in said and "cycles of 8 rows" in said
    assert "constant after" not in said.split("with kalmanq compile")[0]


def test_that_is_when_the_c_settles(files: tuple[Path, Path], tmp_path: Path) -> None:
    said = kalmanq("check", *files).stdout
    cycles = int(said.split("gain after ")[1].split()[0])
    kalmanq("compile", files[0], "--every", "1,8", "-o", tmp_path / "out.c")
    assert f"{cycles} cycles of" in (tmp_path / "out.c").read_text()


@pytest.mark.usefixtures("no_offers")
def test_the_page_says_it_beside_the_costs(files: tuple[Path, Path], tmp_path: Path) -> None:
    kalmanq("report", *files, "-o", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "--every 1,8" in page and "gnss every 8 rows" in page


def test_compile_says_what_a_full_sample_is(files: tuple[Path, Path], tmp_path: Path) -> None:
    kalmanq("compile", files[0], "-o", tmp_path / "out.c")
    assert "If they come at different rates, --every" in (tmp_path / "out_report.txt").read_text()
