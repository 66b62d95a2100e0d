"""Model files with numbers from columns and the commands that take them: fixes with their accuracy, a cell with R0, sensors in files of their own."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command import json_of, kalmanq, refused, succeeds
from library import saved
from test_columns import textbook

from kalmanq.model import model_file


GPS = """[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [0.0, 0.5]
dt = 1.0
H = [1.0, 0.0]
R = ["accuracy^2"]
P0 = [1000.0, 10.0]
[measurements]
names = ["position"]
"""


def gps(seed: int, folder: Path, text: str = GPS) -> tuple[Path, Path, np.ndarray, np.ndarray, np.ndarray]:
    draw = np.random.default_rng(seed)
    t, accuracy = np.round(np.cumsum(draw.uniform(0.3, 2.5, 120)), 3), np.round(draw.uniform(0.5, 20, 120), 3)
    z = np.cumsum(np.cumsum(draw.normal(size=120))) + accuracy * draw.normal(size=120)
    z[5::17] = np.nan
    model = saved(folder / "gps.toml", text)
    data = saved(folder / "gps.csv", "time,position,accuracy\n" + "".join(
        f"{a},,\n" if np.isnan(b) else f"{a},{b!r},{c}\n" for a, b, c in zip(t.tolist(), z.tolist(), accuracy.tolist())))
    return model, data, t, z, accuracy


@pytest.mark.parametrize("options", [(), ("--compiled",), ("--arith", "f32"), ("--compiled", "--arith", "f32")])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_accuracy_of_each_fix_at_irregular_times(options, seed, tmp_path):
    """An empty accuracy beside an empty position is none that is missing"""
    model, data, t, z, accuracy = gps(seed, tmp_path)
    dt = np.append(np.diff(t), 1.0)
    A = np.array([[[1, one], [0, 1]] for one in dt])
    Q = np.array([[[one**3 / 3, one**2 / 2], [one**2 / 2, one]] for one in dt]) / 2
    T, none = len(z), np.zeros((len(z), 1))
    right = textbook({"A": A, "B": np.zeros((T, 2, 1)), "Q": Q, "H": np.tile([[1.0, 0.0]], (T, 1, 1)), "R": accuracy[:, None, None] ** 2,
                      "D": np.zeros((T, 1, 1)), "d": none}, np.zeros(2), np.diag([1000.0, 10.0]), z[:, None], none)
    told = json_of("run", model, data, *options, folder=tmp_path)
    most = 1e-4 if "f32" in options else 1e-9
    assert np.all(np.abs(np.array(told["mean"]) - right[0][-1]) < most * np.sqrt(np.diag(right[1][-1])))
    assert abs(told["log_likelihood"] - right[2]) < most * abs(right[2])


READ = GPS + """[columns]
names = ["accuracy"]
columns = ["hAcc"]
factors = [0.001]
missing = [[4294967295]]
plausible = [[0.0, 100.0]]
[recording]
pause = 2.4
"""


@pytest.mark.parametrize("options", [(), ("--compiled",), ("--smooth",)])
def test_a_column_as_a_receiver_writes_it(options, tmp_path):
    """In mm, under its own name, with a word for none; what its file says is written again.  Pauses begin anew, as the times do"""
    for seed in range(3):
        model, data, t, z, accuracy = gps(seed, tmp_path, READ)
        cells = zip(t.tolist(), z.tolist(), np.rint(1000 * accuracy).astype(int).tolist())
        data.write_text("time,position,hAcc\n" + "".join(f"{a},,4294967295\n" if np.isnan(b) else f"{a},{b!r},{c}\n" for a, b, c in cells))
        (tmp_path / "again.toml").write_text(model_file.text_of(model_file.read(model)))
        told = [json_of("run", one, data, *options) for one in (model, tmp_path / "again.toml")]
        plain, metres, *_ = gps(seed, tmp_path, GPS + "[recording]\npause = 2.4\n")
        right = json_of("run", plain, metres, *options)
        assert told[0]["mean"] == told[1]["mean"] and np.allclose(told[0]["mean"], right["mean"], rtol=1e-12)
        assert abs(told[0]["log_likelihood"] - right["log_likelihood"]) < 1e-9 * abs(right["log_likelihood"])


BATTERY = """[model]
A = 1.0
B = -0.0003
H = 0.7
D = {D}
d = 3.2
R = 1e-4
Q = 1e-9
x0 = 0.9
P0 = 0.01
[states]
names = ["soc"]
ranges = [2.0]
[measurements]
names = ["voltage"]
ranges = [5.0]
[controls]
names = ["current"]
ranges = [10.0]
"""


def battery(seed: int, folder: Path, D: str = '"-R0"') -> tuple[Path, Path, float]:
    """Model, data, and the state of charge at the last row"""
    draw = np.random.default_rng(seed)
    current, R0 = 5 + 4 * np.sin(np.arange(200) / 9), 0.03 + 0.02 * draw.random(200)
    soc = 0.9 - 0.0003 * np.concatenate([[0], np.cumsum(current)[:-1]])
    voltage = 0.7 * soc + 3.2 - R0 * current + 0.01 * draw.normal(size=200)
    model, data = folder / "battery.toml", folder / "battery.csv"
    model.write_text(BATTERY.format(D=D) + ('[columns]\nnames = ["R0"]\nranges = [[0.01, 0.1]]\n' if '"' in D else ""))
    data.write_text("voltage,current,R0\n" + "".join(f"{a!r},{b!r},{c!r}\n" for a, b, c in zip(voltage.tolist(), current.tolist(), R0.tolist())))
    return model, data, float(soc[-1])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_cell_whose_resistance_is_measured_fits(seed, tmp_path):
    model, data, soc = battery(seed, tmp_path)
    for options in ((), ("--arith", "f32"), ("--arith", "q31"), ("--compiled",), ("--compiled", "--arith", "q31"), ("--smooth", "--plot", tmp_path / "a.png"),
                    ("--lag", 3, "--forecast", 2)):
        told = json_of("run", model, data, *options)
        assert 0.75 < told["nis_per_measurement"] < 1.3 and abs(told["mean"][0] - soc) < 0.005, options
    without, *_ = battery(seed, tmp_path, "0.0")
    assert json_of("run", without, data)["nis_per_measurement"] > 50


def test_commands_take_such_a_model(tmp_path):
    model, data, _ = battery(4, tmp_path)
    sim, out = tmp_path / "sim.csv", tmp_path / "cell.c"
    for command in (("report", model, data, "-o", tmp_path / "a.html"), ("check", model, data), ("compare", model, data), ("compile", model, "-o", out),
                    ("compile", model, "-o", tmp_path / "word.c", "--library", "--arith", "q31"), ("simulate", model, "--controls", data, "-o", sim),
                    ("run", model, sim), ("fit", model, data, "-o", tmp_path / "fitted.toml"), ("run", tmp_path / "fitted.toml", data)):
        succeeds(*command, folder=tmp_path)
    assert '"-R0"' in (tmp_path / "fitted.toml").read_text() and "-R0" in (tmp_path / "a.html").read_text()
    assert "R0" in out.with_suffix(".h").read_text()
    for command in (("tune", model, data, "-o", tmp_path / "t.html"), ("design", model, "--core", "m4f"), ("check", model), ("simulate", model),
                    ("run", model, data, "--as", "lean", "--arith", "f32"), ("run", model, data, "--smooth", "--robust", "jump"),
                    ("simulate", model, "--controls", data, "--runs", 2, "--compiled", "-o", sim), ("fit", model, data, "--method", "em")):
        done = kalmanq(*command, folder=tmp_path)
        assert done.returncode and len(done.stderr.strip().splitlines()) == 1 and done.stderr.startswith("kalmanq: "), (command, done.stderr)


@pytest.mark.parametrize("line, said", [
    ('R = ["accuracy^"]', "cannot be read"), ('R = ["__import__(0)"]', "calls __import__"), ('R = ["a.b"]', "no number and no column"),
    ('R = ["2"]', "names no column"), ('R = ["a if b else c"]', "no column"), ('R = ["a[0]"]', "no column"), ('R = ["max(a, b)"]', "calls max"),
    ('R = ["sqrt(a, b)"]', "sqrt"), ('R = ["x1"]', "is a state"), ('R = ["z1"]', "is a measurement"), ('R = ["a" , "b"]', "R"),
    ('G = ["a", 1.0]', "write Q"), ('R = [["a or b"]]', "no column"), ('R = ["(lambda: 0)()"]', "calls"), (f'R = ["{"-" * 200}a"]', "nested"),
    (f'R = ["a{" + a" * 99}"]', "nested"), (f'R = ["{"a - (" * 99}a{")" * 99}"]', "nested"), (f'R = ["{"abs(" * 99}a{")" * 99}"]', "nested"),
    (f'R = ["a{"+a" * 600}"]', "1000"), ('R = ["True*a"]', "no column"), ('R = ["1j*a"]', "no column"), ("R = [\"'a'\"]", "no column")])
def test_what_is_no_expression(line, said, tmp_path):
    path = saved(tmp_path / "model.toml", f"[model]\nA = [[1.0]]\nH = [1.0]\nQ = [1.0]\nP0 = [1.0]\n{line}\n")
    with pytest.raises(model_file.ModelFileError) as problem:
        model_file.read(path)
    assert said in str(problem.value) and "line 6" in str(problem.value) and "\n" not in str(problem.value)


@pytest.mark.parametrize("change, said", [
    (("3.5,2", "3.5,"), "row 4: accuracy is missing"), (("3.5,2", "3.5,-1"), "row 4: R[0,0] = log(accuracy) is nan"),
    (("3.5,2", "3.5,0.5"), "row 4: R[0,0] = log(accuracy) is -0.693147"), (("accuracy", "hAcc"), "there is no column accuracy"),
    (("3.5,2", "3.5,x"), "row 4")])
def test_what_the_data_lack(change, said, tmp_path):
    model, data = tmp_path / "a.toml", tmp_path / "a.csv"
    model.write_text('[model]\nA = [[1.0]]\nH = [1.0]\nQ = [1.0]\nP0 = [1.0]\nR = ["log(accuracy)"]\n[measurements]\nnames = ["z"]\n')
    data.write_text("z,accuracy\n1,3\n,\n3.5,2\n2,4\n".replace(*change))
    for command in (("run", model, data), ("run", model, data, "--smooth"), ("report", model, data, "-o", tmp_path / "a.html"), ("fit", model, data, "--free", "Q")):
        refused(kalmanq(*command), said)
    data.write_text("z,accuracy\n1,3\n,\n3.5,2\n2,4\n")
    succeeds("run", model, data)


SENSORS = """[model]
F = [[0.0, 1.0], [0.0, 0.0]]
Qc = [0.0, 1.0]
dt = 1.0
B = [0.0, 1.0]
P0 = [100.0, 10.0]
[controls]
names = ["push"]
[[sensors]]
name = "radar"
measurements = ["speed"]
H = [[0.0, 1.0]]
R = 0.25
[[sensors]]
name = "gps"
measurements = ["east"]
H = [["scale", 0.0]]
R = ["hacc^2"]
D = [["lever"]]
"""


@pytest.mark.parametrize("late", [0, 2])
def test_columns_of_a_sensor_come_with_its_measurements(late, tmp_path):
    """In a file of its own, and late"""
    draw, T = np.random.default_rng(late), 40
    speed, push = draw.normal(size=T), np.round(draw.normal(size=T), 3)
    east, hacc, scale, lever = (np.round(one, 4) for one in (draw.normal(size=T), draw.uniform(1, 5, T), draw.uniform(0.9, 1.1, T), draw.normal(size=T)))
    there = np.arange(3, T - 3, 4)
    (tmp_path / "m.toml").write_text(SENSORS + (f"delay = {late}\n" if late else ""))
    (tmp_path / "imu.csv").write_text("time,speed,push\n" + "".join(f"{t},{a!r},{b}\n" for t, (a, b) in enumerate(zip(speed.tolist(), push.tolist()))))
    (tmp_path / "gps.csv").write_text("time,east,hacc,scale,lever\n" + "".join(f"{t + late},{east[t]},{hacc[t]},{scale[t]},{lever[t]}\n" for t in there))
    done = succeeds("run", tmp_path / "m.toml", tmp_path / "imu.csv", tmp_path / "gps.csv", "--json")
    z, H = np.column_stack([speed, np.where(np.isin(np.arange(T), there), east, np.nan)]), np.zeros((T, 2, 2))
    H[:, 0, 1], H[:, 1, 0] = 1, scale
    of = {"A": np.tile([[1.0, 1.0], [0.0, 1.0]], (T, 1, 1)), "B": np.tile([[0.5], [1.0]], (T, 1, 1)), "Q": np.tile([[1 / 3, 0.5], [0.5, 1.0]], (T, 1, 1)),
          "H": H, "R": np.stack([np.diag([0.25, one**2]) for one in hacc]), "D": np.stack([[[0.0], [one]] for one in lever]), "d": np.zeros((T, 2))}
    right = textbook(of, np.zeros(2), np.diag([100.0, 10.0]), z, push[:, None])
    told = json.loads(done.stdout)
    assert np.allclose(told["mean"], right[0][-1], rtol=1e-9) and abs(told["log_likelihood"] - right[2]) < 1e-9 * abs(right[2])
