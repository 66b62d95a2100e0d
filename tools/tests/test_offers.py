"""A compiled filter as a way to run: what design and report show is what kalmanq compile writes, runs and costs."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from compiled_models import kinematic
from library import EXAMPLES
from models import file_of
from products import PRODUCTS
from typer.testing import CliRunner

from kalmanq import Model, Quantity, command_line
from kalmanq.commands import design
from kalmanq.compiler.report import offers
from kalmanq.compiler.run.simulation import CompiledFilter
from kalmanq.pages import report
from kalmanq.run.filters import Filter
from kalmanq.run.simulation import simulate
from whole import MEASURED

pytestmark = MEASURED


def called(*arguments: object) -> str:
    done = CliRunner().invoke(command_line.app, [str(one) for one in arguments])
    assert done.exit_code == 0, done.output
    return done.stdout


def data_of(model: Model, folder: Path) -> Path:
    path, names = folder / "data.csv", [one.name for one in (*model.measurements, *model.controls)]
    rows = [names, *np.random.default_rng(1).standard_normal((40, len(names))).round(3).tolist()]
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n", encoding="utf-8")
    return path


def page_of(model: Model) -> str:
    """The report's part of it"""
    return " ".join(re.sub("<[^>]*>", " ", "".join(report._compiled(model, np.zeros((0, model.m))))).split())


@pytest.fixture(scope="module")
def ordinary() -> Model:
    states = [Quantity("position", "m", 1e6), Quantity("velocity", "m/s", 1e4)]
    return kinematic(1, 2, ranged=True).changed(states=states)


@pytest.fixture(scope="module")
def found(ordinary: Model) -> list[offers.Offer]:
    """Made once, for all that show it"""
    return offers.offers(ordinary)


@pytest.fixture
def given(found: list[offers.Offer], monkeypatch: pytest.MonkeyPatch) -> None:
    for command in (design, report):
        monkeypatch.setattr(command, "offers", lambda *_: found)


def test_design_and_report_show_it(ordinary: Model, found: list[offers.Offer], given: None, tmp_path: Path) -> None:
    path, data = file_of(ordinary, tmp_path), data_of(ordinary, tmp_path)
    told = json.loads(called("design", path, "--data", data, "--core", "m4f", "--json"))
    assert told["compiled"] == [json.loads(json.dumps(one.told("m4f"))) for one in found]
    assert told["chosen"] == {"arithmetic": "f32", "way": "compiled"}
    text = called("design", path, "--data", data, "--core", "m4f")
    shown = page_of(ordinary)
    for one in found:
        cells = one.cells("m4f")
        assert "" not in cells and " ".join(["Cortex-M4F", *cells]) in shown
        assert all(re.search(re.escape(cell.split()[0]), text) for cell in cells)
    assert "recommended: f32, compiled" in text


def test_the_cheapest_that_is_good_is_chosen(ordinary: Model, found: list[offers.Offer], given: None,
                                             tmp_path: Path) -> None:
    """A step of the library as published beside a row of the compiled form that has not settled"""
    path, data = file_of(ordinary, tmp_path), data_of(ordinary, tmp_path)
    for core in ("m3", "m4f"):
        told = json.loads(called("design", path, "--data", data, "--core", core, "--json"))
        ways = {(one["arithmetic"], one["way"]): one for one in told["ways"] if one["good"]}
        cheapest = min(ways.values(), key=lambda one: one["instructions"])
        factor = {one.arithmetic: one.costs[core] for one in found}
        assert (cheapest["arithmetic"], cheapest["way"]) == tuple(told["chosen"].values())
        for arithmetic, cost in factor.items():
            assert ways[arithmetic, "compiled"]["instructions"] == cost.of["two_calls"] > cost.of["step_settled"]


def test_it_is_written_as_compile_writes_it(ordinary: Model, found: list[offers.Offer], given: None,
                                            tmp_path: Path) -> None:
    path, data = file_of(ordinary, tmp_path), data_of(ordinary, tmp_path)
    name = found[0].product.given.name  # type: ignore[union-attr]
    called("design", path, "--data", data, "--core", "m4f", "--way", "compiled", "--arith", "f32", "--out", tmp_path)
    made = {file.name: file.read_text() for file in tmp_path.glob(f"{name}*")}
    (tmp_path / "again").mkdir()
    called("compile", path, "-o", tmp_path / "again" / f"{name}.c")
    assert made == {file.name: file.read_text() for file in (tmp_path / "again").glob("*")} and len(made) == 4


def test_without_a_compiler_it_is_not_recommended(ordinary: Model, monkeypatch: pytest.MonkeyPatch,
                                                  tmp_path: Path) -> None:
    path, data = file_of(ordinary, tmp_path), data_of(ordinary, tmp_path)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    told = json.loads(called("design", path, "--data", data, "--core", "m4f", "--json"))
    assert all(one["mean"] is None and "install gcc or clang" in one["remark"] for one in told["compiled"])
    assert "two_calls" not in told["compiled"][0] and told["chosen"]["way"] != "compiled"
    assert not any(one["good"] for one in told["ways"] if one["way"] == "compiled")


# ------------------------------------------------------------------------------ kalmanq run --compiled


@pytest.mark.parametrize("arithmetic, most", [("f64", 1e-6), ("f32", 1e-4), ("q31", 1e-4)])
def test_it_runs_as_the_filter_does(arithmetic: str, most: float) -> None:
    """With a gap, a component that is missing, and in two parts"""
    model = next(make for make in PRODUCTS if make.__name__ == "battery")()
    u = np.random.default_rng(1).uniform(-1, 1, (300, 1))
    z = simulate(model, 300, 1, u)[1]
    z[40:45] = z[99] = np.nan
    exact = Filter(model, "f64").run(z, u)
    with CompiledFilter(model, arithmetic) as one:
        parts = [one.run(z[:100], u[:100]), one.run(z[100:], u[100:])]
        ahead, digest = one.forecast(2), one.digest
    for name in ("mean", "innovation"):
        made = np.concatenate([getattr(part, name) for part in parts])
        scale = exact.sigma if name == "mean" else exact.innovation_sigma
        assert np.nanmax(np.abs(made - getattr(exact, name)) / scale) < most
    assert np.array_equal(np.concatenate([part.taken for part in parts]), exact.taken.clip(0))
    assert abs(sum(np.sum(part.log_likelihood) for part in parts) - np.sum(exact.log_likelihood)) < 300 * most
    assert digest and ahead.mean.shape == (2,)


def test_run_compiled_has_the_columns_of_run(tmp_path: Path) -> None:
    nile, data = EXAMPLES / "nile.toml", EXAMPLES / "nile.csv"
    made = []
    for extra in ([], ["--compiled"]):
        out = tmp_path / f"out{len(extra)}.csv"
        told = json.loads(called("run", nile, data, "--arith", "f32", "--out", out, "--json", *extra))
        made.append((out.read_text().splitlines()[0], told))
    (columns, plain), (compiled_columns, told) = made
    assert compiled_columns == columns
    assert told["way"] == "compiled" and re.fullmatch("[0-9a-f]{8}", told["digest"])
    assert abs(told["mean"][0] - plain["mean"][0]) < 1e-3 and told["taken"] == plain["taken"]


def test_check_has_the_formats_of_the_headers(tmp_path: Path) -> None:
    """Of compile, with the library and without; the last raw value of a format is within it"""
    quantities = 'states = {"names": ["x"], "units": ["m"], "ranges": [%s]}\nmeasurements = {"names": ["z1"], "units": ["m"], "ranges": [%s]}\n'
    for range_ in (1000.0, 1023.99999985):
        model = Model([[1.0]], H=[[1.0]], R=4.0, Q=1.0, P0=[100.0], states=[Quantity("x", "m", range_)], measurements=[Quantity("z1", "m", range_)])
        functions = tmp_path / "functions.py"
        functions.write_text(quantities % (range_, range_) + "x0, P0, R, Q = [0.0], [100.0], 4.0, [1.0]\ndef f(x): return [x[0]]\ndef h(x): return [x[0]]\n")
        path = file_of(model, tmp_path)
        called("compile", path, "--arith", "q31", "-o", tmp_path / "alone.c")
        called("compile", functions, "--library", "--arith", "q31", "-o", tmp_path / "on.c")
        formats = {name: re.findall(r" (x|z1) +m .* (Q\d+\.\d+)", (tmp_path / f"{name}.h").read_text()) for name in ("alone", "on")}
        assert f"the header's formats: {', '.join(map(' '.join, formats['alone']))}\n" in called("check", path)
        for one in (path, functions):
            assert re.search(rf" ranges: .*: x {formats['on'][0][1]}\b", called("check", one)), formats


def test_check_says_when_it_settles(tmp_path: Path) -> None:
    assert "compiled: the gain is constant after 51 full samples" in called("check", EXAMPLES / "cart.toml")
    never = file_of(Model([[1, 0], [0, 1]], H=[[1, 1]], R=1, Q=[0.1, 0], P0=[1, 1]), tmp_path)
    done = CliRunner().invoke(command_line.app, ["check", str(never)])
    assert re.search(r"worked out in each row: a direction with eigenvalue 1 (is never|has no)", done.output)
