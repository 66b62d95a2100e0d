"""A range of a least and a largest value: what is below the least is told, and C of a control takes the nearer end."""

from __future__ import annotations

import pytest
from command import succeeds

LINEAR = """[model]
A = 0.9
B = 1.0
H = 1.0
R = 0.1
Q = 0.1
P0 = 1.0
[states]
names = ["x"]
ranges = [1000]
[measurements]
names = ["z"]
ranges = [1000]
[controls]
names = ["u"]
ranges = [%s]
"""
COLUMN = """[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [0.0, 0.5]
dt = 1.0
H = [1.0, 0.0]
R = ["u^2"]
d = ["0.5 * u"]
P0 = [1e4, 100.0]
[measurements]
names = ["z"]
[columns]
names = ["u"]
ranges = [%s]
"""


@pytest.mark.parametrize("text, ends, given, taken", [
    (LINEAR, "[0.0, 1.0]", (-5, 0.5, 3, -0.01), (0, 0.5, 1, 0)), (LINEAR, "[-3.0, -1.0]", (-2, 5, -9, -1), (-2, -1, -3, -1)),
    (LINEAR, "[2.0, 5.0]", (1, 0, 9, 3), (2, 2, 5, 3)), (LINEAR, "2.0", (-5, 1, 5, 0), (-2, 1, 2, 0)),
    (COLUMN, "[0.5, 100.0]", (0.1, 1, -1000, 0), (0.5, 1, 0.5, 0.5))], ids=["holds", "below", "above", "one", "column"])
@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_the_nearer_end_is_taken(text, ends, given, taken, arithmetic, tmp_path):
    if arithmetic == "q31" and (text is COLUMN or ends != "[2.0, 5.0]"):
        pytest.skip("a noise from a column, or what a format has no word for, is refused")
    if arithmetic == "q31":
        given, taken = (1, 0, 5, 3), (2, 2, 5, 3)
    model, out = tmp_path / "m.toml", {}
    model.write_text(text % ends)
    for name, values in (("given", given), ("taken", taken)):
        data = tmp_path / f"{name}.csv"
        data.write_text("time,z,u\n" + "".join(f"{t},{t + 1},{u}\n" for t, u in enumerate(values)))
        done = succeeds("run", model, data, "--compiled", "--arith", arithmetic, "-o", tmp_path / "out.csv")
        rows = [line.split(",") for line in (tmp_path / "out.csv").read_text().splitlines()]
        out[name] = [[one for one, column in zip(row, rows[0]) if column.endswith(("_mean", "_sigma"))] for row in rows]
        assert ("beyond its declared range" in done.stderr) == (name == "given"), done.stderr
    assert out["given"] == out["taken"]
