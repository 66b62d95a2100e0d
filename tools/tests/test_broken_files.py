"""Broken bytes of valid files: readers of data and of model files answer a result or a refusal of one line, and no other error."""

from __future__ import annotations

import random
import warnings
from pathlib import Path

import numpy as np
import pytest
from library import saved
from test_readers import JUNK, MAKE, WALK, walk
from whole import first

from kalmanq import Filter
from kalmanq.data import joining
from kalmanq.data.layouts import Source
from kalmanq.errors import KalmanqError
from kalmanq.model import model_file

EXAMPLES = sorted((Path(model_file.__file__).parents[1] / "examples").glob("*.toml"))
PIECES = [b"", b"\n", b",", b"=", b"[", b"]", b'"', b"nan", b"inf", b"-1e400", b"1e-400", b"0", b"9" * 40, b"\0", b"\xff", b"true", b"[[]]", b"{}",
          b"1979-05-27T07:32:00Z", JUNK[:9]]


def broken(data: bytes, draw: random.Random) -> bytes:
    """One to four places: bits, a piece, a part that goes, comes twice or moves, an end"""
    made = bytearray(data)
    for _ in range(draw.randint(1, 4)):
        at, to = sorted(draw.randrange(len(made) + 1) for _ in range(2))
        to = min(to, at + draw.choice((1, 2, 8, 40, 4000)))
        how = draw.randrange(6)
        if how == 0 and at < len(made):
            made[at] ^= 1 << draw.randrange(8)
        elif how == 1:
            made[at:to] = draw.choice(PIECES)
        elif how == 2:
            del made[at:to]
        elif how == 3:
            made[at:at] = made[at:to]
        elif how == 4:
            other = draw.randrange(len(made) + 1)
            made[other:other] = made[at:to]
        elif draw.random() < 0.2:
            del made[at:]
    return bytes(made)


def refused_or_read(read):
    """Is it read?  If not, what is said is one line."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read()
        except KalmanqError as problem:
            assert str(problem) and "\n" not in str(problem), repr(problem)
            return False
    return True


@pytest.mark.parametrize("suffix", MAKE)
@pytest.mark.parametrize("seed", first(1, range(20)))
def test_broken_data(suffix, seed, tmp_path):
    model = model_file.read(saved(tmp_path / "walk.toml", WALK))
    data, draw = MAKE[suffix](tmp_path / f"track.{suffix}", *walk(1, 10)).read_bytes(), random.Random(f"{suffix}{seed}")
    path = tmp_path / f"broken.{suffix}"
    for _ in range(40):
        refused_or_read(lambda: joining.record(Source(saved(path, broken(data, draw))), model))


@pytest.mark.parametrize("seed", first(8, range(80)))
def test_broken_models(seed, tmp_path):
    draw, read = random.Random(seed), []
    for example in EXAMPLES:
        path = saved(tmp_path / example.name, broken(example.read_bytes(), draw))
        read.append(refused_or_read(lambda: Filter(model_file.read(path))))
    assert any(read) and not all(read)


def test_junk_is_neither(tmp_path):
    draw = np.random.default_rng(1)
    for size in draw.integers(0, 300, 60):
        path = saved(tmp_path / "a", draw.integers(0, 256, size, dtype=np.uint8).tobytes())
        assert not refused_or_read(lambda: model_file.read(path))
        assert not refused_or_read(lambda: joining.record(Source(path), model_file.read(saved(tmp_path / "walk.toml", WALK))))
