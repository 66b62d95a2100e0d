"""Model files: what is written reads back to the same bits, and what is wrong is told with its line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from library import saved

from kalmanq import Model, Quantity
from kalmanq.errors import ModelError
from kalmanq.model import builders, model_file
from kalmanq.model.model_file import ModelFileError

EXAMPLES = sorted((Path(model_file.__file__).parents[1] / "examples").glob("*.toml"))
FIELDS = ("A", "B", "H", "Q", "G", "R", "x0", "P0", "unknown")


def same(a: Model, b: Model) -> bool:
    arrays = all(np.array_equal(getattr(a, name), getattr(b, name)) for name in FIELDS if getattr(a, name) is not None)
    return arrays and (a.states, a.measurements, a.controls, a.gaps, a.name) == (
        b.states, b.measurements, b.controls, b.gaps, b.name)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_read_and_come_back(path, tmp_path):
    model = model_file.read(path)
    copy = saved(tmp_path / "copy.toml", model_file.text_of(model))
    assert same(model, model_file.read(copy))


@pytest.mark.parametrize("seed", range(10))
def test_random_models_come_back_bit_for_bit(seed, tmp_path):
    draw = np.random.default_rng(seed)
    n, m = draw.integers(1, 6, 2)
    root = draw.normal(size=(n, n)) * 10.0 ** draw.integers(-9, 9, (n, 1))
    model = Model(draw.normal(size=(n, n)), H=draw.normal(size=(m, n)), R=draw.random(m), Q=root @ root.T,
                  x0=draw.normal(size=n), P0=draw.random(n), name='a "name" \\ and é')
    path = saved(tmp_path / "model.toml", model_file.text_of(model))
    assert same(model, model_file.read(path))


def test_a_range_may_have_two_ends(tmp_path):
    path = saved(tmp_path / "model.toml", LEVEL + "[states]\nranges = [[-5, 2]]\n[measurements]\nranges = [7]\n")
    model = model_file.read(path)
    assert (model.states[0].range, model.states[0].ends) == (5, (-5, 2)) and model.measurements[0].ends is None
    path.write_text(model_file.text_of(model), encoding="utf-8")
    assert model_file.read(path).states == model.states
    for wrong in ((1, 2, 3), (-np.inf, 2)):
        with pytest.raises(ModelError, match="larger"):
            Quantity("a", range=wrong)
    other = replace(Quantity("a", range=(1, 2)), range=50.0)
    assert other.range == 50 and other.ends is None and replace(other, ends=(-3.0, 50.0)).ends == (-3, 50)
    with pytest.raises(ModelError, match="larger"):
        Quantity("charge", range=(1, 1))


LEVEL = '[model]\nA = [[1.0]]\nH = [[1.0]]\nQ = [[1.0]]\nR = [[1.0]]\nP0 = [[1.0]]\n'


@pytest.mark.parametrize("text, said", [
    ("", "no section [model]"),
    (LEVEL.replace("[model]", ""), "line 2: A: is a key of [model]: put a line [model] before it"),
    ("[model]\nA = [[1.0\n", "line "),
    (LEVEL.replace("A = [[1.0]]", "A = [[1.0, 2.0]]"), "line 2: A: is 1 x 2, not square"),
    (LEVEL.replace("R = [[1.0]]", "R = [[-1.0]]"), "line 5: R: has a negative variance: R[0,0] = -1"),
    (LEVEL.replace("Q = [[1.0]]", "Q = one"), "line 4: Invalid value: Q = one"),
    (LEVEL + "B = [[1.0], [2.0]]\n[controls]\nnames = ['push']\n", "line 7: B: is 2 x 1: it has a row for each of 1 state"),
    (LEVEL.replace("H = [[1.0]]", "H = [[1.0, 0.0]]") + "[measurements]\nnames = ['a', 'b']\n", "line 3: H: is 1 x 2: it has a column for each of 1 state"),
    ("[model]\nF = [[0.0, 1.0]]\nQc = [1, 1]\ndt = 1\nH = [1, 0]\nR = 1\nP0 = [1, 1]\n[states]\nnames = ['a', 'b']\n", "line 2: F: is 1 x 2, not square"),
    ("[model]\nF = [[0, -1], [0, 0]]\nQc = [[1, 9], [9, 1]]\ndt = 1\nH = [1, 0]\nR = 1\nP0 = [1, 1]\n", "line 3: Qc: is no covariance"),
    (LEVEL.replace("Q = [[1.0]]", 'Q = "one two"'), "line 4: Q: 'one two' cannot be read"),
    (LEVEL.replace("Q = [[1.0]]", "Q = [[nan]]"), "line 4: Q: has an entry that is not finite: Q[0,0] is nan"),
    (LEVEL.replace("[[1.0]]", "[[1.0, 0], [0, inf]]", 1), "line 2: A: has an entry that is not finite: A[1,1] is inf"),
    (LEVEL.replace("P0", "p0"), "line 6: p0: no such key in [model]; P0?"), (LEVEL + "d = [1, 2]\n", "line 7: d: is 2, not 1 number"),
    (LEVEL + "delay = 3\n", "line 7: delay: is of a sensor: put it below [[sensors]]"),
    (LEVEL.replace("A = ", "F = ").replace("Q = ", "Qc = ") + "dt = '20 ms'\n", "line 7: dt: is not a number; time_unit has the unit"),
    (LEVEL.replace("Q = [[1.0]]", "Q = [[1.0], 2]"), "line 4: Q: is not an array"),
    (LEVEL.replace("P0", "PO"), "line 6: PO: no such key in [model]; P0?"),
    (LEVEL.replace("P0 = [[1.0]]\n", ""), "P0: is missing"),
    (LEVEL.replace("[[1.0]]\n", "[[1.0]]\n", 1) + "[state]\nnames = ['a']\n", "line 7: state: no such section; states?"),
    (LEVEL + "[states]\nnames = ['a', 'b']\n", "line 7: states: names has 2 names; there is 1 state"),
    (LEVEL + "[states]\nranges = [-1]\n", "line 7: states: ranges: -1 is not above 0"),
    (LEVEL + "[states]\nranges = [[1, 0]]\n", "line 7: states: ranges: [1, 0] is not a least"),
    (LEVEL + "[states]\nranges = [[0, inf]]\n", "line 7: states: ranges: [0, inf] is not a least"),
    (LEVEL + "[states]\nranges = [[0, 1, 2]]\n", "line 7: states: ranges: [0, 1, 2] is not a least"),
    (LEVEL + "[states]\nranges = ['wide']\n", "line 7: states: ranges is not a list of numbers"),
    (LEVEL + "[gaps]\nmax_gap = -1\n", "gaps: max_gap is at least 0"),
    ('[model]\nbuilder = "levle"\n', "line 2: builder: there is no 'levle'; level?"),
    ('[model]\nbuilder = "level"\ndrift = 1\nnoise = 1\n', "variance: is missing: a number"),
    ('[model]\nbuilder = "level"\ndrift = 1\nnoize = 1\nvariance = 1\n', "line 4: noize: level has no such parameter; noise?"),
    ('[model]\nbuilder = "level"\ndrift = -1\nnoise = 1\nvariance = 1\n',
     "line 2: builder: level: a covariance is not positive semi-definite"),
    ('[model]\nbuilder = "trend"\ndrift = [1]\nnoise = 1\nvariance = [1, 1]\n', "line 3: drift: has 1 numbers, not 2"),
    ('[model]\nbuilder = "ar"\nphi = [1.1]\nvariance = 1\n', "stationary"),
])
def test_what_is_wrong_is_one_line(text, said, tmp_path):
    path = saved(tmp_path / "model.toml", text)
    with pytest.raises(ModelFileError) as refused:
        model_file.read(path)
    assert said in str(refused.value) and "\n" not in str(refused.value)
    assert str(refused.value).startswith(f"{path}: ")


def test_data_in_the_place_of_the_model(tmp_path):
    path = saved(tmp_path / "data.csv", "t,level\n1,2\n")
    with pytest.raises(ModelFileError, match="line 1: .*: t,level; .*first"):
        model_file.read(path)


def test_files_that_are_none(tmp_path):
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(ModelFileError):
            model_file.read(path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelFileError, match="UTF-8"):
        model_file.read(binary)


def test_a_start_that_is_in_part_unknown(tmp_path):
    path = saved(tmp_path / "model.toml", '[model]\nA=[[1.0,1.0],[0.0,1.0]]\nH=[1.0,0.0]\nQ=[1.0,1.0]\nR=1.0\nP0=[4.0,"unknown"]\n')
    model = model_file.read(path)
    assert model.unknown.tolist() == [False, True] and model.P0[0, 0] == 4


# ------------------------------------------------------------------------------ builders, and numbers of any length

LONG = "1" * 400
ODD = {
    f"P0 = {LONG}": "line 6: P0: has a number with too many digits", f"P0 = {'1' * 5000}": "a number has too many digits",
    f"P0 = {'[' * 5000}1{']' * 5000}": "nested too deeply", f"P0 = {'[' * 900}1{']' * 900}": "",
    f"P0 = 1\n[states]\nranges = [{LONG}]": "states: ranges: one is not representable",
    f"P0 = 1\n[states]\nranges = [9]\nfractions = [{LONG}]": "states: fractions: ",
    "P0 = 1\n[gaps]\nmax_gap = 100000000000000000000": "line 7: gaps: max_gap is at most 100000000",
    "P0 = 1\n[gaps]\nmax_gap = 1e20": "right: max_gap is a whole number",
    f"P0 = 1\n[gaps]\nmin_run = {LONG}": "gaps: min_run is at most 100000000",
}


@pytest.mark.parametrize("text", ODD, ids=range(len(ODD)))
def test_numbers_of_any_length_are_one_line(text, tmp_path):
    test_what_is_wrong_is_one_line(f"[model]\nA = 1\nH = 1\nQ = 1\nR = 1\n{text}\n", ODD[text], tmp_path)


@pytest.mark.parametrize("text", [f"seasons = {LONG}", "seasons = 1000000000", f"seasons = 4\nmean = [{LONG}]"])
def test_a_builder_s_numbers_of_any_length_are_one_line(text, tmp_path):
    test_what_is_wrong_is_one_line(f'[model]\nbuilder = "season"\ndrift = 1\nnoise = 1\nP0 = "unknown"\n{text}\n', "", tmp_path)


PRIORS = {"variance = [1, 4]": np.diag([1.0, 4.0]), "P0 = [2, 3]": np.diag([2.0, 3.0]), 'P0 = "unknown"': None,
          "P0 = [[2, 1], [1, 3]]": np.array([[2.0, 1], [1, 3]]), "": "variance: is missing"}


@pytest.mark.parametrize("prior", PRIORS)
def test_a_new_builder_is_one_row_of_the_table(prior, tmp_path, monkeypatch):
    """Its prior may come from its variances, or from the file's P0, which then needs none"""
    Parameter = builders.Parameter
    row = builders.Builder((Parameter("drift", "number"), Parameter("variance", "vector", is_prior=True)), lambda of: {
        "A": np.eye(2), "H": np.ones((1, 2)), "R": np.ones(1), "Q": of["drift"] * np.eye(2),
        "P0": np.diag(of["variance"]), "states": ["left", "right"]})
    monkeypatch.setitem(builders.BUILDERS, "pair", row)
    path = saved(tmp_path / "pair.toml", f'[model]\nbuilder = "pair"\ndrift = 0.5\n{prior}\n')
    if isinstance(PRIORS[prior], str):
        with pytest.raises(ModelFileError, match=PRIORS[prior]):
            model_file.read(path)
        return
    model = model_file.read(path)
    assert [one.name for one in model.states] == ["left", "right"] and model.Q[1, 1] == 0.5
    assert np.all(model.unknown) if PRIORS[prior] is None else np.array_equal(model.P0, PRIORS[prior])
    again = model_file.text_of_builder("pair", {"drift": 0.5, "variance": [1, 4]}, model)
    path.write_text(again)
    assert np.array_equal(model_file.read(path).unknown, model.unknown)


@pytest.mark.parametrize("name", builders.BUILDERS)
def test_every_builder_takes_a_prior_of_its_own(name, tmp_path):
    """From its annotated example, without the variances, and with nothing known"""
    text = next(path for path in EXAMPLES if path.stem == name).read_text()
    priors = [one.name for one in builders.BUILDERS[name].parameters if one.is_prior]
    lines = [line for line in text.splitlines() if line.split("=")[0].strip() not in (*priors, "P0")]
    end = next((k for k, line in enumerate(lines[1:], 1) if line.startswith("[") and line != "[model]"), len(lines))
    path = saved(tmp_path / "model.toml", "\n".join([*lines[:end], 'P0 = "unknown"', *lines[end:]]))
    assert np.all(model_file.read(path).unknown)


@pytest.mark.parametrize("name, content, said", [
    ("m.toml", "[model]\nname = 'Gr\u00f6\u00dfe'\n".encode("latin-1"), "UTF-8"), ("m.toml", LEVEL.encode("utf-16"), "UTF-8"),
    ("m.png", b"\x89PNG\r\n\xff", "TOML"), ("m.json", b'{"A": 1}\n', "TOML"),
    ("m.yaml", b"A: 1\n", "TOML"), ("m.toml", b"", "no line"),
    ("m.toml", None, "folder")])
def test_what_is_no_model_file_says_so(name, content, said, tmp_path):
    path = tmp_path / name
    path.mkdir() if content is None else path.write_bytes(content)
    with pytest.raises(ModelFileError, match=said):
        model_file.read(path)


def test_names_that_are_there_twice_are_named():
    with pytest.raises(ModelError, match="states: .*twice, b"):
        Model(np.eye(3), H=[1, 0, 0], R=1, Q=[1, 1, 1], states=["a", "b", "b"])


@pytest.mark.parametrize("range_, said", [(None, ""), (7, "7"), ((-5, 2), "-5 to 2")])
def test_a_range_is_written_as_it_was_given(range_, said):
    assert Quantity("a", range=range_).span == said
