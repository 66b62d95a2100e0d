"""A compiled filter as one of the ways to run: design and report show what kalmanq compile proves, or why it does not."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from compiled_models import kinematic
from test_commands import EXAMPLES
from test_report import reported
from typer.testing import CliRunner

from kalmanq import Model, command_line, model_file
from kalmanq.compiler import offers
from kalmanq.model import Gaps

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
    path, z = folder / "data.csv", np.random.default_rng(1).standard_normal((40, model.m)).round(3)
    rows = [[one.name for one in model.measurements], *z.tolist()]
    path.write_text("\n".join(",".join(map(str, row)) for row in rows) + "\n", encoding="utf-8")
    return path


def row_of(text: str, first: str) -> list[str]:
    """Of a table in text: the cells of the row that begins so"""
    found = [re.split(r"\s*│\s*", line.strip("│ ")) for line in text.splitlines() if re.match(rf"│\s*{first}\b", line)]
    assert len(found) == 1, text
    return found[0]


@pytest.fixture(scope="module")
def ordinary() -> Model:
    return kinematic(1, 2, ranged=True)


def test_design_and_report_show_what_the_proof_says(ordinary: Model, tmp_path: Path) -> None:
    path, data = file_of(ordinary, tmp_path), data_of(ordinary, tmp_path)
    told = json.loads(called("design", path, "--data", data, "--core", "m4f", "--json"))["compiled"]
    text = called("design", path, "--data", data, "--core", "m4f")
    text = text[text.index("compiled for this model alone"):]
    page = reported(path, data, tmp_path).text
    for arithmetic in ARITHMETICS:
        called("compile", path, "-o", tmp_path / "one.c", "--arith", arithmetic)
        costs, *others = figures_of(tmp_path / "one_proof.txt")
        one = told[arithmetic]
        assert costs == [f"{one[measure]} ±{100 * one['off'][measure]:.0f} %" for measure in MEASURES]
        assert others == [str(one["ram"]), f"{one['mean']:.1e}", f"{one['covariance']:.1e}"]
        assert 0 < one["covariance"] < 1e-4 and 0 < one["mean"] < 1e-4
        cells = [arithmetic, "covariance", *costs, *others]
        assert row_of(text, arithmetic) == cells
        assert " ".join(["Cortex-M4F", *cells]) in page


def figures_of(proof: Path) -> list:
    """Costs on M4F, RAM, errors of means and of the covariance, as they stand there"""
    said = proof.read_text(encoding="utf-8")
    patterns = (r"^    Cortex-M4F +-O2 +(.*)$", r"^RAM +(\d+) bytes", r"^means +(\S+) sigma", r"^promise +(\S+) ")
    costs, *others = [re.search(pattern, said, re.M)[1] for pattern in patterns]  # type: ignore[index]
    return [re.split(r"  +", costs.strip()), *others]


def test_what_is_refused_says_why(tmp_path: Path) -> None:
    cart = EXAMPLES / "cart.toml"
    reason = "refused: P0: nothing is known of velocity at first"
    text = called("design", cart, "--core", "m3")
    for arithmetic in ARITHMETICS:
        assert f"compiled in {arithmetic}: {reason}" in text
        assert row_of(text[text.index("compiled for this model alone"):], arithmetic)[1] == "refused"
    unranged = kinematic(1, 2)
    page = reported(file_of(unranged, tmp_path), data_of(unranged, tmp_path), tmp_path)
    assert "q31 refused refused: measurements: range has no range; q31 needs one, f32 does not" in page.text


def test_chosen_ranges_are_said(tmp_path: Path) -> None:
    """design chooses ranges where there are none; only with them in the file kalmanq compile comes to the same"""
    one = kinematic(1, 2)
    text = called("design", file_of(one, tmp_path), "--data", data_of(one, tmp_path), "--core", "m3")
    assert "compiled in q31: with the chosen ranges in the model file" in text


def test_a_search_that_is_too_long_is_not_made(ordinary: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    """Counted, not timed: the same everywhere.  The cost is known, the errors are not."""
    monkeypatch.setattr(offers, "MOST", 100)
    for one in offers.offers(ordinary):
        assert one.remark == "errors not searched: more than 100 covariances; run kalmanq compile"
        assert one.error is None and one.costs["m4f"].two_calls > one.costs["m4f"].step_settled > 20
        assert one.cells("m4f")[-2:] == ["", ""] and "mean" not in one.told("m4f")


def test_without_a_compiler_there_is_a_cost(ordinary: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    for one in offers.offers(ordinary):
        assert one.costs and one.error is None and "needs a C compiler" in one.remark


def test_the_same_figures_each_time() -> None:
    model = kinematic(1, 1, ranged=True, gaps=Gaps(3, 30))
    first, second = ([one.told("m3") for one in offers.offers(model)] for _ in range(2))
    assert first == second and all(one["covariance"] > 0 for one in first)
