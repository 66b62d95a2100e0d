"""The runner of tools/examples/boards finds what is wrong; the boards themselves run in tools.boards.NAME."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[1] / "boards"
sys.path.insert(0, str(FOLDER))
import boards  # noqa: E402
import costs  # noqa: E402
import data  # noqa: E402
import texts  # noqa: E402

HEADER = """\
 *     measurement 0  count  count  1023   Q31.0
enum {
    ADC_LEVEL_FRACTION = 3,
    ADC_Z_COUNT_FRACTION = 0
};
"""


class Printed(boards.Job):
    """A job whose board and host say what a test has them say"""

    def __init__(self, name: str, way: str, shown: np.ndarray, host: dict[str, np.ndarray]):
        example = boards.EXAMPLES[name]
        super().__init__(name, example, way, example.boards[0], [], Path())
        self.shown, self.told = shown, host

    def printed(self) -> np.ndarray:
        return self.shown

    def host(self) -> dict[str, np.ndarray]:
        return self.told

    def scales(self) -> np.ndarray:
        return np.full(len(self.example.shown), 2.0**-3)


def level(*words: float) -> np.ndarray:
    return np.array(words)[:, None]


HOST = {"level_mean": np.array([1.0, 2.0, 2.5625]), "level_sigma": np.ones(3)}


def test_equal_to_the_last_bit() -> None:
    shown, line = boards.compared(Printed("adc", "compiled", level(8, 16, 20), HOST))  # 20.5 is rounded to one of two
    assert shown[:, 0].tolist() == [1.0, 2.0, 2.5] and "3 rows, 3 of 3 numbers equal" in line


@pytest.mark.parametrize("words", [(8, 17, 20), (8, 16, 22)])
def test_a_bit_that_differs(words: tuple[float, ...]) -> None:
    with pytest.raises(boards.BoardError, match="2 of 3 .*kalmanq run"):
        boards.compared(Printed("adc", "compiled", level(*words), HOST))


def test_rows_that_are_missing() -> None:
    with pytest.raises(boards.BoardError, match="has printed"):
        boards.compared(Printed("adc", "compiled", level(8, 16), HOST))


def test_a_column_that_is_missing() -> None:
    with pytest.raises(boards.BoardError, match="no level_mean"):
        boards.compared(Printed("adc", "compiled", level(8, 16, 20), {"level_sigma": np.ones(3)}))


@pytest.mark.parametrize("name, way, off, is_right", [
    ("altitude", "compiled", 5e-4, True), ("altitude", "compiled", 2e-3, False), ("altitude", "compiled", np.nan, False),
    ("gps", "compiled", 0, True), ("gps", "compiled", 1e-6, False)])
def test_numbers_in_float(name: str, way: str, off: float, is_right: bool) -> None:
    """Near, or equal; of the late position nothing is compared in the rows in which it is on its way"""
    names, late = boards.EXAMPLES[name].shown, 15 if name == "gps" else 0
    host = {one: np.ones(100) for one in (*names, *(f"{one.removesuffix('_mean')}_sigma" for one in names))}
    shown = np.ones((100, len(names)))
    shown[np.arange(100) % 50 < late] += 1
    shown[20, 0] += off
    job = Printed(name, way, shown, host)
    if is_right:
        assert f"{100 - 2 * late} rows" in boards.compared(job)[1]
    else:
        with pytest.raises(boards.BoardError, match="kalmanq run"):
            boards.compared(job)


def test_a_recording_in_raw_values() -> None:
    columns = {"count": np.array([205, np.nan, 3.6]), "other": np.zeros(3)}
    assert "{{205}, 1},\n    {{0}, 0},\n    {{4}, 1},\n" in texts.recording("adc", True, HEADER, columns)
    assert "{{205.0f}, 1},\n    {{0.0f}, 0},\n    {{3.5999999f}, 1},\n" in texts.recording("adc", False, HEADER, columns)
    with pytest.raises(boards.BoardError, match="ADC_Z_COUNT_FRACTION"):
        texts.recording("adc", True, HEADER.replace("COUNT_FRACTION", "OTHER_FRACTION"), columns)


@pytest.mark.parametrize("name", data.NAMES)
def test_a_page_shows_rows_of_its_recording(name: str) -> None:
    """In the last digit a sine of another library may differ"""
    drawn = data.drawn(name, [sys.executable, "-m", "kalmanq"]).splitlines()
    told, shown = re.search(rf"`tools/examples/boards/data.py {name}` draws the recording, (.*?) as `data.csv`.*```text\n(.*?)```",
                            (FOLDER / name / "README.md").read_text(encoding="utf-8"), re.S).groups()
    head, *rows = [line for line in shown.splitlines() if line != "..."]
    table = [[float(one or "nan") for one in row.split(",")] for row in (*rows, *drawn[1:])]
    first, every = np.array(table[:len(rows)]), np.array(table[len(rows):])
    assert head == drawn[0] and told.startswith(f"{len(every)} ") and told.endswith(f" the seed {data.ALL.get(name, (None, 1))[1]},")
    assert any(np.allclose(every[k:k + len(rows)], first, rtol=2e-4, atol=1e-9, equal_nan=True) for k in range(len(every))), shown


def test_costs_that_a_page_does_not_say(tmp_path: Path) -> None:
    page = tmp_path / "README.md"
    page.write_text(f"a\n{costs.BEGIN}old\n{costs.END}b\n", encoding="utf-8")
    costs.settle(page, lambda old: old, check=True, write=False)
    with pytest.raises(boards.BoardError, match="other costs"):
        costs.settle(page, lambda _: "new\n", check=True, write=False)
    costs.settle(page, lambda _: "new\n", check=False, write=True)
    assert page.read_text(encoding="utf-8") == f"a\n{costs.BEGIN}new\n{costs.END}b\n"
    page.write_text("a\n", encoding="utf-8")
    with pytest.raises(boards.BoardError, match="no place"):
        costs.settle(page, lambda _: "new\n", check=True, write=False)


def test_the_overview_keeps_what_is_not_measured() -> None:
    job = Printed("wheel", "compiled", level(), {})
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    before = page[page.index(costs.BEGIN) + len(costs.BEGIN):page.index(costs.END)]
    assert costs.overview({}, before) == before
    after = costs.overview({job: costs.Cost(1, 2, 3, 4)}, before)
    changed = [new for old, new in zip(before.splitlines(), after.splitlines(), strict=True) if old != new]
    assert changed == ["| [wheel](wheel/README.md) | RISC-V RV32IMAC | compiled, q31 | 1 | 2 | 4 | [picture](wheel/picture.png) |"]


@pytest.mark.parametrize("arguments, told", [(["run", "adcx"], "adcx: is no example; there are adc"),
                                             (["run", "adc", "--kalmanq", "no_such_kalmanq"], "no_such_kalmanq: is not there"),
                                             (["run", "adc", "--kalmanq", "false"], "false compile")])
def test_refusals_are_one_line(arguments: list[str], told: str, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-B", str(FOLDER / "boards.py"), *arguments, "--work", str(tmp_path)],
                          capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and done.stderr.startswith(f"boards: {told}"), done.stderr
