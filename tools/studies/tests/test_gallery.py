"""The gallery: what is fitted is the optimum, what is written reads back.

gallery.sh has every log-likelihood beside statsmodels'.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from functools import lru_cache

import numpy as np
import pytest
from command import kalmanq as command
from models import filtered

from kalmanq import Filter, Smoother
from kalmanq.commands.messages import console
from kalmanq.data import joining
from kalmanq.fitting import likelihood
from kalmanq.model import model_file
from kalmanq_studies.commands.gallery import Options, show
from kalmanq_studies.gallery import ENTRIES, sources
from kalmanq_studies.gallery.fitted import fit, log_likelihood

PNG = b"\x89PNG\r\n\x1a\n"
RECORDED = [name for name, entry in ENTRIES.items() if entry.data().regressors is None]


@lru_cache(None)
def fitted(name):
    return fit(ENTRIES[name], name)


@pytest.mark.parametrize("name", ENTRIES)
def test_no_parameter_leads_uphill(name):
    """Moved by 2 % of its size, either way; and where fitting began was lower"""
    entry, made, data = ENTRIES[name], fitted(name), ENTRIES[name].data()
    assert made.converged and made.log_likelihood > log_likelihood(entry.model(), data) + 0.1
    for parameter in entry.free:
        value = np.array(made.parameters[parameter], float)
        for k in np.ndindex(value.shape):
            for factor in (0.98, 1.02):
                moved = value.copy()
                moved[k] *= factor
                if entry.Q_form == "multiple" and parameter == "density":
                    moved = value * factor
                changed = entry.model({**made.parameters, parameter: moved.tolist()})
                assert log_likelihood(changed, data) < made.log_likelihood + 1e-4, (parameter, k, factor)


@pytest.mark.parametrize("name", [name for name in RECORDED if not ENTRIES[name].is_unknown])
def test_the_likelihood_is_the_textbooks(name):
    made, data = fitted(name), ENTRIES[name].data()
    exact = np.sum(filtered(made.model, data.z, None)[-1])
    assert abs(made.log_likelihood - exact) < 1e-9 * abs(exact)


@pytest.mark.parametrize("name", ["season", "ar-noise", "ma", "constant-velocity", "constant-acceleration"])
def test_drawn_data_are_more_likely_where_they_are_fitted_than_by_their_truth(name):
    """By half of chi-square with a degree of freedom a parameter: 12 is beyond 1e-3 of 6 of them"""
    entry = ENTRIES[name]
    truth = {key: value for key, value in entry.data.keywords.items() if key in entry.free}
    assert set(truth) == set(entry.free)
    gain = fitted(name).log_likelihood - log_likelihood(entry.model({**entry.start, **truth}), entry.data())
    assert 0 <= gain < 12


@pytest.mark.parametrize("name", RECORDED)
def test_files_read_back(name, tmp_path, capsys):
    show(Options(name, tmp_path, True), console())
    said = json.loads(capsys.readouterr().out)
    stems = [f"{name}{end}" for end in (".toml", "_fitted.toml", ".csv", "_smoothed.csv", ".png")]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(stems)
    assert sorted(said["files"]) == sorted(str(tmp_path / stem) for stem in stems)
    assert (tmp_path / f"{name}.png").read_bytes()[:8] == PNG
    model = model_file.read(tmp_path / f"{name}_fitted.toml")
    z = joining.record(tmp_path / f"{name}.csv", model)[0]
    run = Smoother(model).run(z)
    assert likelihood(model, [z]) == pytest.approx(said["log_likelihood"], rel=1e-12)
    assert np.sum(run.log_likelihood) == pytest.approx(said["log_likelihood"], rel=1e-9)  # roots round at an unknown start
    with open(tmp_path / f"{name}_smoothed.csv", newline="") as text:
        rows = list(csv.DictReader(text))
    first = model.states[0].name
    assert [float(row[f"{first}_smoothed"]) for row in rows] == run.smoothed[:, 0].tolist()
    assert model_file.read(tmp_path / f"{name}.toml").n == model.n
    # in fixed point by the ranges that are in the file, and in floats: a row's term rests on an innovation, which is
    # the difference of numbers as large as z
    for arithmetic, eps in (("q31", 2.0**-30), ("f32", 2.0**-24)):
        other = Filter(model, arithmetic).run(z)
        assert not other.events
        most = 32 * eps * np.nanmax(np.abs(z)) / np.nanmin(run.innovation_sigma)
        error = other.log_likelihood - run.log_likelihood
        known = int(np.argmax(np.all(np.isfinite(run.mean), axis=1)))  # q31 counts in ranges before: their sum is right
        assert abs(np.mean(error[:known + 1])) < most, arithmetic
        assert np.max(np.abs(error[known + 1:])) < most, arithmetic
        assert arithmetic == "q31" or np.max(np.abs(error)) < most, arithmetic


def test_files_of_a_regression(tmp_path):
    done = kalmanq("regression-drifting", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        f"regression-drifting{end}" for end in (".csv", ".png", "_smoothed.csv")]


@pytest.mark.parametrize("path", [sources.NILE, *sorted(sources.HERE.glob("*.csv"))], ids=lambda path: path.name)
def test_public_data_name_their_source_and_terms(path):
    said = sources.source_of(path)
    assert "Source: " in said and "public domain" in said.lower()


# ------------------------------------------------------------------------------ the command


def kalmanq(*arguments):
    return command("gallery", *arguments)


def test_without_the_studies_kalmanq_has_its_own_commands():
    program = ("import sys; sys.modules['kalmanq_studies'] = None\n"
               "from kalmanq.__main__ import main\nsys.argv = ['kalmanq', *sys.argv[1:]]\nmain()")
    done, other = (subprocess.run([sys.executable, "-c", program, *said], capture_output=True, text=True) for said in (["gallery", "level"], ["--help"]))
    assert done.returncode == 2 and "No such command" in done.stderr and "Traceback" not in done.stderr
    assert other.returncode == 0 and "gallery" not in other.stdout and "compile" in other.stdout


def test_the_command():
    assert len(ENTRIES) >= 12
    listed = kalmanq("--json")
    assert listed.returncode == 0 and list(json.loads(listed.stdout)) == list(ENTRIES)
    done = kalmanq("level")
    assert done.returncode == 0 and "1469.18" in done.stdout and "log-likelihood -633.46" in done.stdout


@pytest.mark.parametrize("arguments, code, reason", [
    (["levels"], 2, "levels"), (["--out", "."], 1, "of which model?"),
    (["level", "--out", "none"], 1, "no such folder")])
def test_wrong_input(arguments, code, reason):
    done = kalmanq(*arguments)
    assert done.returncode == code and reason in done.stderr and "Traceback" not in done.stderr
    if code == 1:
        assert done.stderr.count("\n") == 1
