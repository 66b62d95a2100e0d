"""kalmanq compile, the command: what it refuses, what it leaves behind, what replaced an option that is gone."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from command import kalmanq, refused
from compiled_models import kinematic
from library import EXAMPLES, saved
from models import cart

from kalmanq import Model, Quantity
from kalmanq.commands import GONE
from kalmanq.compiler.given.names import named
from kalmanq.compiler.text.product import compiled
from kalmanq.model import model_file


def changed(**what: object) -> Model:
    return kinematic(1, 2, ranged=True).changed(**what)


@pytest.mark.parametrize("option, value", [("--form", "covariance"), ("--form", "factor"), ("--partial", ""), ("--bound", "1e-3"),
                                           ("--gate", "3"), ("--student", "4"), ("--settle", "1e-3"), ("--data", "rows.csv")])
@pytest.mark.parametrize("model", ["cart.toml", "attitude.py"])
def test_an_option_that_is_gone_says_what_replaced_it(option: str, value: str, model: str, tmp_path: Path) -> None:
    for words in ((option, value), (f"{option}={value}",)):
        done = kalmanq("compile", EXAMPLES / model, "-o", tmp_path / "flt.c", *words)
        assert done.returncode == 1 and not done.stdout and not list(tmp_path.iterdir())
        assert done.stderr == f"kalmanq: {option} is gone since 2.0: {GONE['compile'][option]}\n"


def test_the_command_refuses_in_one_line_and_leaves_no_file(tmp_path: Path) -> None:
    path = saved(tmp_path / "m.toml", model_file.text_of(changed(R=0.0)))
    for words, said in (((path, "-o", tmp_path / "cart.c"), "R: range has no noise"),
                        ((path, "-o", tmp_path / "Lift_P1.c"), f"write {tmp_path / 'lift_p1.c'}"),
                        ((path, "-o", tmp_path / "math.c"), "math is a word or a header of C"),
                        ((tmp_path / "no.toml", "-o", tmp_path / "cart.c"), "no such file")):
        refused(kalmanq("compile", *words), said)
    assert [one.name for one in tmp_path.iterdir()] == ["m.toml"]


@pytest.mark.skipif(os.name != "posix", reason="no signals")
@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_leaves_no_folder(number: int, code: int, tmp_path: Path) -> None:
    """While a compiler works on what is in it, which takes as long as the test waits"""
    path, folders = saved(tmp_path / "m.toml", model_file.text_of(kinematic(1, 2))), tmp_path / "folders"
    folders.mkdir()
    saved(tmp_path / "cc", "#!/bin/sh\nexec sleep 60\n").chmod(0o755)
    running = subprocess.Popen([sys.executable, "-m", "kalmanq.command_line", "compile", str(path), "-o",
                                str(tmp_path / "cart.c")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env={**os.environ, "TMPDIR": str(folders), "CC": str(tmp_path / "cc")})
    while running.poll() is None and not list(folders.glob("kalmanq-compile-*")):
        time.sleep(0.01)
    running.send_signal(number)
    _, said = running.communicate()
    assert running.returncode == code and said == "kalmanq: interrupted\n"
    assert not list(folders.glob("kalmanq-compile-*")) and not list(tmp_path.glob("*cart*"))


@pytest.mark.parametrize("words, module", [(["kalmanq"], "typer"), (["kalmanq", "steady", "m.toml"], "numpy")])
def test_an_interrupt_while_the_command_is_imported_is_no_traceback(words: list[str], module: str) -> None:
    program = f"""
import sys
sys.argv = {words}

class Interrupted:
    def find_spec(self, name, *_):
        if name == {module!r}:
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupted())
from kalmanq.__main__ import main
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 130 and done.stderr == "kalmanq: interrupted\n"


@pytest.mark.skipif(os.name != "posix", reason="no limits")
@pytest.mark.parametrize("command, named", [
    (["simulate", "MODEL", "-n", "5000", "--out", "out.csv"], "out.csv"),
    (["run", str(EXAMPLES / "nile.toml"), str(EXAMPLES / "nile.csv"), "--plot", "out.png"], "out.png"),
    (["design", "MODEL", "--core", "m4f", "-o", "."], ".h"),
    (["compile", "MODEL", "-o", "out.c"], "kalmanq-compile-")])
def test_a_file_that_does_not_fit_is_named(command: list[str], named: str, tmp_path: Path) -> None:
    """By a limit of a file's size, which is to a program what a full disk is"""
    states = [Quantity("position", "m", 100), Quantity("velocity", "m/s", 10)]
    (tmp_path / "m.toml").write_text(model_file.text_of(changed(states=states)))
    words = ["kalmanq", *(one.replace("MODEL", "m.toml") for one in command)]
    program = f"""
import resource, sys
from kalmanq.command_line import main
from kalmanq.commands import COMMANDS
import importlib; importlib.import_module(COMMANDS[{command[0]!r}][0])
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
sys.argv = {words}
main()
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path,
                          env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert re.fullmatch(rf"kalmanq: .*{re.escape(named)}.*: File too large\n", done.stderr), done.stderr
    assert [one.name for one in tmp_path.iterdir()] == ["m.toml"]


@pytest.mark.parametrize("name", ["z range", "u push", "s range", "nis", "variance velocity"])
def test_names_that_would_be_one_in_the_header(name: str) -> None:
    """A fraction of a state and that of a measurement, a control, a variance or NIS"""
    model = cart()
    states = [replace(model.states[0], name=name), model.states[1]]
    assert named(states, model.measurements, model.controls) == (["s0", "s1"], ["range"], ["push"])
    assert named(model.states, model.measurements, model.controls)[0] == ["position", "velocity"]


def test_a_range_of_two_ends_has_both_in_the_header() -> None:
    states = [Quantity("position", "m", [-5, 100]), Quantity("velocity", "m/s", 10)]
    header = compiled(changed(states=states), "cart").header
    assert re.search(r"state 0 +position +m +-5 to 100\n", header) and re.search(r"state 1 +velocity +m/s +10\n", header), header
