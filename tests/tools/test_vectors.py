"""The twin is the chip, bit for bit: every golden vector of tests/vectors, by the package's classes."""

from __future__ import annotations

import functools
import re

import pytest

import vectors
from sequences import Sequences


pytestmark = pytest.mark.filterwarnings("ignore::kalmanq.KalmanqWarning")  # a saturation is meant


@functools.lru_cache(maxsize=None)
def replayed(case: str) -> tuple[int, list]:
    """A case operation by operation: how many words of output were compared, and the sequences in it."""
    sequences = Sequences()
    replay, compared = vectors.Replay(sequences), 0
    for k, operation in enumerate(vectors.operations(case)):
        made = replay.act(operation)
        assert made == (operation.expected or made), f"operation {k}, {operation.name}"
        assert vectors.digest_of(made) == operation.digest, f"operation {k}, {operation.name}: {made}"
        compared += len(made)
    return compared, sequences.all


@pytest.mark.parametrize("case", vectors.cases())
def test_every_word_of_a_case_is_that_of_the_chip(case):
    compared, _ = replayed(case)
    assert compared >= sum(len(operation.expected) for operation in vectors.operations(case))
    assert compared > 0


@pytest.mark.parametrize("case", vectors.cases())
def test_whole_sequences_are_the_calls_one_by_one(case):
    _, sequences = replayed(case)
    assert sum(sequence.check() for sequence in sequences) > 0


@pytest.mark.parametrize("arithmetic", ["f32", "f64"])
@pytest.mark.parametrize("case", vectors.cases())
def test_the_same_models_and_data_in_floating_point(case, arithmetic):
    """There are no golden vectors of these: the classes beside the library's functions, row by row."""
    _, sequences = replayed(case)
    filtered = [sequence for sequence in sequences if "SteadyFilter" not in sequence.kinds()]
    assert sum(sequence.check_floating(arithmetic) for sequence in filtered) > 0


def test_no_vector_is_left_out():
    """The cases here are those of the folder, and those that the cores replay; each operation is in one of them, and
    each class has sequences."""
    listed = re.findall(r'#include "cases/(\w+)\.inc"', (vectors.FOLDER / "cases.c").read_text(encoding="utf-8"))
    assert sorted([*vectors.cases(), *vectors.OF_THE_CORE_ALONE]) == sorted(listed) and len(vectors.cases()) >= 17
    assert len(list((vectors.FOLDER / "cases").iterdir())) == len(listed)
    header = (vectors.FOLDER / "vector.h").read_text(encoding="utf-8")
    known = re.search(r"VECTOR_END,(.*?)VECTOR_OPERATIONS", header, re.S)
    names = {name.lower() for name in re.findall(r"VECTOR_(\w+)", known[1])}
    used = {operation.name for case in listed for operation in vectors.operations(case)}
    assert used == names
    kinds = set().union(*(sequence.kinds() for case in vectors.cases() for sequence in replayed(case)[1]))
    assert kinds == {"Filter", "Smoother", "LagSmoother", "InstantSmoother", "AdaptiveFilter", "FrozenGainFilter",
                     "SteadyFilter", "gate", "huber", "student", "jump"}
    compared = sum(replayed(case)[0] for case in vectors.cases())
    again = sum(sequence.check() for case in vectors.cases() for sequence in replayed(case)[1])
    print(f"q31: {len(vectors.cases())} cases, {compared} words by calls, {again} of them again by sequences")


def test_a_wrong_word_changes_the_digest():
    words = [2619442, 0, -14, -(2**31)]
    wrong = [[word ^ 1 if k == at else word for k, word in enumerate(words)] for at in range(len(words))]
    digests = {vectors.digest_of(given) for given in [words, words[:-1], [*words, 0], *wrong]}
    assert len(digests) == 7


def test_inputs_of_another_layout_are_refused(tmp_path, monkeypatch):
    (tmp_path / "cases").mkdir()
    (tmp_path / "vector.h").write_bytes((vectors.FOLDER / "vector.h").read_bytes())
    monkeypatch.setattr(vectors, "FOLDER", tmp_path)
    for text in ("3, 1,1,0,0, 0", "1, 1,1,0,0, 0, 0", "2, 1,1,0,0, 0, 0"):
        (tmp_path / "cases" / "other.inc").write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match="layout 1"):
            vectors.operations("other")
