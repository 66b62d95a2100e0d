"""A compiled filter as a way to run: design and report show what kalmanq compile proves, or why it refuses."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from compiled_models import kinematic
from products import PRODUCTS
from test_commands import EXAMPLES
from typer.testing import CliRunner
from whole import first

from kalmanq import Model, Quantity, command_line
from kalmanq.commands import design
from kalmanq.compiler.proven import costs, forms, offers
from kalmanq.compiler.proven.product import Wanted, compiled
from kalmanq.compiler.proven.proof_file import no_less
from kalmanq.compiler.proven.structure import Structure
from kalmanq.errors import KalmanqError
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record
from kalmanq.model import model_file
from kalmanq.pages import report
from kalmanq.run.simulation import simulate

ARITHMETICS = ("f32", "q31")
MEASURES = ("two_calls", "step_settled", "flash")


def called(*arguments: object) -> str:
    done = CliRunner().invoke(command_line.app, [str(one) for one in arguments])
    assert done.exit_code == 0, done.output
    return done.stdout


def file_of(model: Model, folder: Path) -> Path:
    path = folder / "model.toml"
    path.write_text(model_file.text_of(model), encoding="utf-8")
    return path


def data_of(model: Model, folder: Path) -> Path:
    path, names = folder / "data.csv", [one.name for one in (*model.measurements, *model.controls)]
    rows = [names, *np.random.default_rng(1).standard_normal((40, len(names))).round(3).tolist()]
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n", encoding="utf-8")
    return path


def row_of(text: str, first: str) -> list[str]:
    """Of a table in text: the cells of the row that begins so"""
    found = [re.split(r"\s*│\s*", line.strip("│ ")) for line in text.splitlines() if re.match(rf"│\s*{first}\b", line)]
    assert len(found) == 1, text
    return found[0]


@pytest.fixture(scope="module")
def ordinary() -> Model:
    """Of states that may be large: what that does to floats is said"""
    states = [Quantity("position", "m", 1e6), Quantity("velocity", "m/s", 1e4)]
    return kinematic(1, 2, ranged=True).changed(states=states)


@pytest.fixture(scope="module")
def found(ordinary: Model) -> list[offers.Offer]:
    """Searched once, for all that show it"""
    return offers.offers(ordinary)


@pytest.fixture
def given(found: list[offers.Offer], monkeypatch: pytest.MonkeyPatch) -> None:
    for command in (design, report):
        monkeypatch.setattr(command, "offers", lambda *_: found)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_it_is_what_compile_proves(ordinary: Model, found: list[offers.Offer], tmp_path: Path, arithmetic: str) -> None:
    called("compile", file_of(ordinary, tmp_path), "-o", tmp_path / "one.c", "--arith", arithmetic)
    paid, *others = figures_of(tmp_path / "one_proof.txt")
    told = found[ARITHMETICS.index(arithmetic)].told("m4f")
    assert paid == [f"{told[measure]} ±{100 * told['off'][measure]:.0f} %" for measure in MEASURES]
    assert others == [str(told["ram"]), f"{told['mean']:.1e}", no_less(told["covariance"])]
    assert 0 < told["covariance"] < 1e-4 and 0 < told["mean"] < 1e-4


def figures_of(proof: Path) -> list:
    """Costs on M4F, RAM, errors of means and of the covariance, as they stand there"""
    said = proof.read_text(encoding="utf-8")
    patterns = (r"^    Cortex-M4F +-O2 +(.*)$", r"^RAM +(\d+) bytes", r"^means +(\S+) sigma", r"^promise +(\S+) ")
    paid, *others = [re.search(pattern, said, re.M)[1] for pattern in patterns]  # type: ignore[index]
    return [re.split(r"  +", paid.strip()), *others]


def test_design_and_report_show_it(ordinary: Model, found: list[offers.Offer], given: None, tmp_path: Path) -> None:
    path, data = file_of(ordinary, tmp_path), data_of(ordinary, tmp_path)
    told = json.loads(called("design", path, "--data", data, "--core", "m4f", "--json"))["compiled"]
    assert told == {one.arithmetic: json.loads(json.dumps(one.told("m4f"))) for one in found}
    text = called("design", path, "--data", data, "--core", "m4f")
    text = text[text.index("compiled for this model alone"):]
    shown = page_of(ordinary)
    for one in found:
        cells = one.cells("m4f")
        assert "" not in cells and row_of(text, one.arithmetic) == cells
        assert " ".join(["Cortex-M4F", *cells]) in shown
        assert (f"Compiled in {one.arithmetic}: {one.remark}." in shown) == bool(one.remark)
    assert f"compiled in f32: {found[0].remark}" in " ".join(text.split()) and found[1].remark == ""
    assert re.fullmatch(r"a float has 24 bits: \S+ sigma of a settled mean at most, states and innovations at their "
                        r"ranges; more than 1e-03: smaller ranges, or q31", found[0].remark)


def page_of(model: Model) -> str:
    """The report's part of it"""
    return " ".join(re.sub("<[^>]*>", " ", "".join(report._compiled(model))).split())


def test_what_is_refused_says_why() -> None:
    cart = EXAMPLES / "cart.toml"
    reason = "refused: P0: nothing is known of velocity at first"
    text = called("design", cart, "--core", "m3")
    for arithmetic in ARITHMETICS:
        assert f"compiled in {arithmetic}: {reason}" in text
        assert row_of(text[text.index("compiled for this model alone"):], arithmetic)[1] == "refused"
    shown = page_of(model_file.read(cart))
    assert all(f"Compiled in {arithmetic}: {reason}" in shown for arithmetic in ARITHMETICS)
    assert "<table" not in "".join(report._compiled(model_file.read(cart)))  # there is nothing to be compared


def test_a_search_that_is_too_long_is_not_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Counted, not timed: the same everywhere.  Nothing is listed that kalmanq compile may refuse.  design chooses
    ranges where there are none; only with them in the file kalmanq compile comes to the same, and that is said, too."""
    monkeypatch.setattr(offers, "MOST", 100)
    one = kinematic(1, 1)
    told = json.loads(called("design", file_of(one, tmp_path), "--data", data_of(one, tmp_path), "--core", "m4f",
                             "--json"))["compiled"]
    said = "not tried: more than 100 covariances; run kalmanq compile"
    assert told["f32"] == {"form": "not tried", "remark": said}
    assert told["q31"] == {"form": "not tried", "remark": f"{said} with the chosen ranges in the model file"}


@pytest.mark.parametrize("make", first(5, PRODUCTS))
def test_what_is_listed_of_a_product_is_compiled(make) -> None:
    """And what is refused is refused: of each arithmetic, with the ranges that design chooses"""
    model = make()
    u = np.zeros((500, model.l)) if model.l else None
    ranged, _ = with_ranges(model, [Record(simulate(model, 500, 1, u)[1], u)])
    for one in offers.offers(model, ranged):
        of = ranged if one.arithmetic == "q31" else model
        try:
            form = compiled(of, Wanted(one.arithmetic, "x")).plan.form.name
        except KalmanqError:
            form = "refused"
        assert one.state in (form, "not tried") and bool(one.plan or one.costs) == (one.state == form != "refused")
        assert one.state != "not tried" or "run kalmanq compile" in one.remark


def test_without_a_compiler_nothing_is_listed(ordinary: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    for one in offers.offers(ordinary):
        assert not one.costs and one.error is None and "needs a C compiler" in one.remark
        assert one.cells("m4f")[1:] == ["not tried", *[""] * 6]
    refused = "refused: measurements: range has no range; q31 needs one, f32 does not"
    assert offers.offers(kinematic(1, 2))[1].remark == refused


def test_what_is_not_estimated_has_no_figure(ordinary: Model, found: list[offers.Offer],
                                             monkeypatch: pytest.MonkeyPatch) -> None:
    """As where costs.csv has no row of a measure; whole cores and levels without any are not named at all"""
    known = {key: factor for key, factor in costs.factors().items()
             if key != ("m3", "f32", "O2", "step_settled") and key[2:] != ("O2", "flash") and key[0] != "m33"}
    monkeypatch.setattr(costs, "factors", lambda: known)
    plan = found[0].plan
    assert plan
    made = costs.estimates(plan)
    assert made["m3", "O2"].cells[1:] == ["not estimated", "not estimated"]
    assert made["m3", "O2"].cells[0] == found[0].costs["m3"].cells[0]
    assert made["m3", "O2"].step_settled is None and set(made["m3", "O2"].off) == {"two_calls"}
    assert "not estimated" not in made["m3", "Os"].cells
    assert {core for core, _ in made} == {core for core, arithmetic, *_ in known if arithmetic == "f32"}


def test_options_are_not_estimated(found: list[offers.Offer]) -> None:
    """None was measured with them; what they add is a fifth to a half"""
    for one in found:
        assert one.plan and costs.estimates(one.plan)
        gain = {"form": forms.ConstantGain(), "structure": Structure({})}
        for option in ({"nis": True}, {"lag": 2}, {"partial": True}, gain):
            assert costs.estimates(replace(one.plan, **option)) == {}
