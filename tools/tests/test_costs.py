"""What a compiled filter costs is what is counted of its C on the emulated core, or "-"."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import five
import pytest
from command import in_two_processes, json_of, kalmanq, succeeds
from equations import path_of
from library import EXAMPLES, ROOT, failing_gcc, host_alone
from models import file_of
from products import PRODUCTS
from whole import MEASURED, WHOLE, first

from kalmanq import Model
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import costs
from kalmanq.compiler.text.product import compiled
from kalmanq.firmware import measured
from kalmanq.firmware.cores import BY_NAME, CORES

pytestmark = MEASURED

TWO = ("m3", "m4f")
NAME = "compiled"  # as a file of the package is
LINEAR = [(name, arithmetic) for arithmetic in ("f32", "q31") for name in ("fridge", "press", "tilt", "battery")]


def product(name: str) -> Model:
    return next(make for make in PRODUCTS if make.__name__ == name)()


def written(path: Path, folder: Path, *options: object) -> dict:
    """The files, and what was told of them beside them"""
    folder.mkdir()
    done = succeeds("compile", path, "-o", folder / f"{NAME}.c", "--json", *options)
    (folder / "compiled.json").write_text(done.stdout)
    return json.loads(done.stdout)


def counted(folder: Path, core: str) -> dict[str, str]:
    """By the tool, in a process of its own"""
    done = subprocess.run([sys.executable, "-B", str(Path(__file__).with_name("compiled_costs.py")), str(folder), "--core", core], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return dict(re.findall(r"(\S+) (\S+)(?:  |\n)", done.stdout.splitlines(keepends=True)[0]))


def is_counted(told: dict, folder: Path) -> None:
    for core in TWO:
        cost, found = told["costs"][f"{core} O2"], counted(folder, core)
        assert len(cost) >= 5 and {one: str(value) for one, value in cost.items()} == {one: found[one] for one in cost}
        assert min(value for one, value in cost.items() if one not in ("stack", "two_calls_settled", "step_settled")) > 0


@pytest.mark.parametrize("name, arithmetic", first(2, [LINEAR[0], LINEAR[-1], *LINEAR[1:-1]]))
def test_what_is_told_is_what_the_tool_counts(name: str, arithmetic: str, tmp_path: Path) -> None:
    is_counted(written(file_of(product(name), tmp_path), tmp_path / "x", "--arith", arithmetic), tmp_path / "x")


@WHOLE  # half a minute
def test_the_readme_has_what_design_prints() -> None:
    """Of the two ways to use the library, the same model"""
    told = json_of("design", EXAMPLES / "track.toml", "--core", "m4f", "--arith", "f32")
    compiled, lean = told["compiled"][0], next(one for one in told["ways"] if (one["arithmetic"], one["way"]) == ("f32", "lean"))
    said = re.search(r"(\d+) bytes of flash; (\d+) instructions a row, (\d+) once .* (\d+) bytes of flash; (\d+) instructions a row",
                     (ROOT / "README.md").read_text(encoding="utf-8"))
    assert said and [*map(int, said.groups())] == [*(compiled[one] for one in ("program", "two_calls", "two_calls_settled")), lean["flash"], lean["instructions"]]


@pytest.mark.parametrize("name", first(1, ("bioreactor", "cell")))
def test_of_a_nonlinear_model_as_well(name: str, tmp_path: Path) -> None:
    told = written(path_of(name), tmp_path / "x")
    is_counted(told, tmp_path / "x")
    calls = ["predict", *(f"update_{one['name']}" if one["name"] else "update" for one in told["sensors"])]
    assert {*calls, "flash", "program", "stack"} == {*told["costs"]["m3 O2"]}


@pytest.mark.parametrize("core", CORES, ids=lambda core: core.name)
def test_the_compiler_is_the_one_of_the_tests(core) -> None:
    of = "atmega328p" if core.name == "avr" else core.name
    said = subprocess.run(["sh", str(ROOT / "tests/target/cores.sh"), "describe", of, "gcc"], check=True, capture_output=True, text=True).stdout
    assert re.search(r"^gcc=(.*)$", said, re.M)[1].split() == list(core.gcc)
    assert core.has_fpu == ("-mfpu" in said)


def test_figures_are_the_same_twice(tmp_path: Path) -> None:
    made = [one["costs"] for one in in_two_processes("compile", file_of(product("tank"), tmp_path), "-o", tmp_path / "tank.c")]
    assert made[0] == made[1] and {one.split()[0] for one in made[0]} == {*costs.USUAL}


def test_the_report_has_them(tmp_path: Path) -> None:
    told = written(file_of(product("tank"), tmp_path), tmp_path / "x")
    text = (tmp_path / "x" / f"{NAME}_report.txt").read_text()
    rows = {line.split()[0]: line.split()[1:] for line in text.splitlines() if line.startswith("    ")}
    assert rows.pop("core") == "two calls settled settled step flash stack".split()
    for core in costs.USUAL:
        of = told["costs"][f"{core} O2"]
        assert rows[core] == [str(of[one]) for one in ("two_calls", "two_calls_settled", "step_settled", "flash", "stack")]
    assert measured.compiler(BY_NAME["m4f"]) in " ".join(text.split()) and "-ffp-contract=fast (m4f)" in " ".join(text.split())


def test_a_gain_that_never_settles_has_no_settled_cost() -> None:
    made = costs.costs_of(compiled(Model([[1, 0], [0, 1]], H=[[1, 1]], R=1, Q=[0.1, 0], P0=[1, 1]), "never"), ["m4f"])["m4f"]
    assert made.of["two_calls"] and made.cell("step_settled") == "never"


@pytest.mark.parametrize("options", [
    Options("f64"), Options(nis=True), Options(gate=4.0), Options(student=5.0), Options(loops=True), Options(tunable=True), Options(lag=2),
    Options(every=(1, 2)), Options("q31", gate=4.0, nis=True), Options("q31", loops=True)], ids=str)
def test_every_option_is_counted(options: Options) -> None:
    made = costs.costs_of(compiled(product("press"), "made", options), ["m4f"])["m4f"]
    assert made.of["two_calls"] > 20 and made.of["program"] > 200, made.why_not


@pytest.mark.parametrize("missing, said", [
    ("compiler", "arm-none-eabi-gcc was not found: `kalmanq doctor` says how to get it"),
    ("unicorn", "unicorn cannot be imported: pip install './tools[costs]'")])
def test_without_a_tool_there_are_no_figures(missing: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if missing == "compiler":
        monkeypatch.setenv("PATH", host_alone(tmp_path))
    else:
        found = measured.find_spec
        monkeypatch.setattr(measured, "find_spec", lambda name: None if name == missing else found(name))
    path = file_of(five.level(), tmp_path)
    told = written(path, tmp_path / "x")
    assert told["costs"] == {} and told["not_measured"]["m3"] == said
    text = " ".join((tmp_path / "x" / f"{NAME}_report.txt").read_text().split())
    assert re.search(rf"Costs on m0, m3, m4f(, rv32)?: -\. {re.escape(said)}\.", text)
    done = kalmanq("design", path, "--core", "m3", "--json")
    made = json.loads(done.stdout)
    assert [one["instructions"] for one in made["ways"] if one["way"] == "compiled"] == [None, None] and made["chosen"]["way"] != "compiled"
    shown = " ".join(kalmanq("design", path, "--core", "m3", "--way", "compiled", "-o", tmp_path).stdout.split())
    assert f"Costs on m3: -. {said}." in shown and (tmp_path / "level.c").exists()
    assert re.search(r"│ \* │ f32 │ compiled │ - │ - │ - │ - │ - │", shown)


def test_a_compiler_that_fails_is_told_in_a_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", failing_gcc(tmp_path), prepend=":")
    made = costs.costs_of(compiled(product("tilt"), "failed"), ["m3"])["m3"]
    assert made == costs.Cost({}, "arm-none-eabi-gcc: cannot find -lc")
