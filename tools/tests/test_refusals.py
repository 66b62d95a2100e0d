"""What kalmanq compile refuses: of any two options together it says which one to leave out, of all else what to do."""

from __future__ import annotations

import ast
import re
from itertools import combinations
from pathlib import Path
from typing import Iterator, Sequence

import numpy as np
import pytest
from equations import FOLDER
from library import EXAMPLES
from models import LATE
from whole import WHOLE

from kalmanq import Model, Quantity
from kalmanq.command_line import loaded
from kalmanq.commands import compile as command, compile_equations
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import settling
from kalmanq.compiler.text.product import compiled, settling as settling_of
from kalmanq.errors import KalmanqError
from kalmanq.run import checks

FILES = {
    "drifts.toml": "[model]\nA = [[1, 1], [0, 1]]\nH = [1, 0]\nR = 1.0\nQ = [0.1, 0]\nP0 = [1, 1]\n",
    "late.toml": LATE,
    "late.py": """
states, measurements, x0, P0, Q = ["a", "b"], ["quick", "slow"], [0, 0], [4, 1], [0.01, 0.02]
sensors = {"quick": (lambda x: [x[0] + x[0]**3], [0.25]), "slow": (lambda x: [x[1]**2 + x[0]], [0.1])}
delays = {"slow": 3}

def f(x):
    return [0.98 * x[0] + 0.05 * x[1], 0.9 * x[1]]
"""}
MODELS = ("track.toml", "constant_velocity.toml", "late.toml", "late.py", "range_bearing.py", pytest.param("attitude.py", marks=WHOLE))
OPTIONS = ("--arith=f64", "--arith=q31", "--robust=gate=4", "--robust=student", "--robust=jump", "--nis", "--lag=3", "--tunable", "--every=1,2",
           "--iterate=3", "--smooth=9", "--library", "--loops", "--straight")
CURE = re.compile(r"\b(leave|give|take|use|write|add|declare|correct|install|set)\b")


class Compiled(BaseException):
    """No more is wanted"""


@pytest.fixture
def refused(monkeypatch, capsys, tmp_path):
    def stop(*_: object) -> None:
        raise Compiled

    for module, name in ((command, "alone"), (command, "write"), (compile_equations, "Host"), (compile_equations, "in_whole_groups")):
        monkeypatch.setattr(module, name, stop)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    compiler = loaded("compile")

    def of(model: str, options: Sequence[str]) -> str:
        """The message; empty: it is compiled"""
        path = next(one for one in (tmp_path / model, EXAMPLES / model, FOLDER / model) if one.exists())
        try:
            compiler.main([str(path), "-o", str(tmp_path / "own.c"), *options], standalone_mode=False)
        except Compiled:
            return ""
        except SystemExit:
            said = capsys.readouterr().err
            assert said.count("\n") == 1 and not list(tmp_path.glob("own*")), said
            return said
        raise AssertionError("neither compiled nor refused")

    return of


def texts_of(path: Path) -> Iterator[str]:
    """What a file's KalmanqErrors say, {...} for what is put in"""
    for one in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(one, ast.Call) and getattr(one.func, "id", "") == "KalmanqError" and isinstance(one.args[0], (ast.Constant, ast.JoinedStr)):
            parts = getattr(one.args[0], "values", [one.args[0]])
            yield "".join(part.value if isinstance(part, ast.Constant) else "{...}" for part in parts)


def test_each_message_says_what_to_do() -> None:
    """Of those whose end is not put in"""
    package = EXAMPLES.parent
    of = [text for path in (*package.glob("compiler/**/*.py"), *package.glob("commands/compile*.py")) for text in texts_of(path)]
    assert len(of) > 40 and not [text for text in of if not CURE.search(text) and not text.endswith("{...}")]


@pytest.mark.parametrize("model, options, said", [
    *((model, options, said) for model in ("track.toml", "battery.py") for options, said in (
        (["--library", "--nis"], "kq_nis"), (["--robust=gate=x"], "x is not a number"), (["--robust=huber"], "give one of gate, student; "),
        *(([f"--robust={one}"], f"--robust {one}") for one in ("gate=0", "gate=-3", "gate=nan", "gate=1", "student=0", "student=inf")))),
    *(("battery.py", [f"--robust={one}", "--library"], call) for one, call in (("gate=3", "kq_loss_gate"), ("student", "kq_loss_student"),
                                                                               ("huber=2", "kq_loss_huber"))),
    *(("battery.py", [one], one.split("=")[0]) for one in ("--lag=2", "--tunable", "--every=2", "--loops")),
    ("battery.py", ["--library", "--smooth=9"], "kq_smooth"), ("battery.py", ["--arith=q31"], "add --library"),
    ("battery.py", ["--arith=q31", "--library", "--robust=gate=3"], "kq_loss_gate"), ("battery.py", ["--arith=q31", "--library", "--iterate=3"], "--iterate"),
    *(("track.toml", ["--library", *options], said) for options, said in (
        (["--lag=3"], "kq_lag"), (["--tunable"], "leave --library out instead"), (["--every=1,2"], "NAME_update"), (["--loops"], "loops in any case"),
        (["--straight"], "loops in any case"), (["--smooth=9"], "kalmanq run"), (["--iterate=2"], "leave --iterate out"),
        (["--robust=median"], "one of gate, huber, student, jump"))),
    *(("track.toml", [f"--every={given}", *more], said) for given, more, said in (
        ("2,2", [], "longer step"), ("1", [], "give 2 whole numbers"), ("1,997", [], "997 rows"), ("1,4", ["--nis"], "--nis"), ("a", [], "such as 1,10"))),
    ("track.toml", ["--arith=q31", "--tunable"], "compile one filter for each"), ("drifts.toml", ["--lag=2"], "kalmanq check says why"),
    ("late.toml", ["--lag=3"], "--lag: and a sensor with a delay"), ("late.toml", ["--tunable"], "--tunable: and a sensor with a delay"),
    ("late.toml", ["--library", "--robust=gate"], "--robust: and a sensor with a delay"),
    ("late.py", ["--library"], "--library: and a sensor with a delay"), ("late.py", ["--smooth=9"], "--smooth: and a sensor with a delay")])
def test_an_option_that_is_refused(model: str, options: Sequence[str], said: str, refused) -> None:
    assert said in refused(model, options)


@pytest.mark.parametrize("model", MODELS)
def test_two_options(model: str, refused) -> None:
    alone = {one: refused(model, [one]) for one in OPTIONS}
    wrong = [f"{one}: {said}" for one, said in alone.items() if said and not CURE.search(said)]
    for one, other in combinations(OPTIONS, 2):
        names = [name.split("=")[0] for name in (one, other)]
        if names[0] == names[1]:
            continue
        said = refused(model, [one, other])
        is_of_both = "kalmanq: --" in said and not alone[one] and not alone[other]
        leaves = re.search(rf"leave [^;:,.]*(?:{'|'.join(names)})\b[^;:,.]* out", said)
        if said and not (leaves if is_of_both else CURE.search(said)):
            wrong.append(f"{one} {other}: {said}")
    assert not wrong, "\n".join(wrong)


def odd(name: str, at: int | tuple[int, int], value: float, **fractions: int) -> Model:
    """A cart with one number in another size; its ranges are `states`, `measurements` and `controls`"""
    of = {"A": np.array([[1.0, 0.1], [0.0, 1.0]]), "B": np.array([0.005, 0.1]), "H": np.array([[1.0, 0.0]]), "Q": np.array([1e-4, 1e-2]),
          "R": np.array([0.04]), "x0": np.zeros(2), "P0": np.array([4.0, 1.0]), "states": np.array([100.0, 20.0]),
          "measurements": np.array([100.0]), "controls": np.array([50.0])}
    of[name][at] = value
    names = {"states": ("position", "velocity"), "measurements": ("range",), "controls": ("push",)}
    of.update({which: [Quantity(name, "", float(span), fractions.get(name)) for name, span in zip(names[which], of[which])] for which in names})
    return Model(of.pop("A"), **of)


FAR = (1e-300, 1e-30, 1e-12, 1e12, 1e30, 1e300)


@pytest.mark.parametrize("name, at, values", [
    ("states", 0, FAR), ("states", 1, FAR), ("measurements", 0, FAR), ("controls", 0, FAR), ("A", (0, 0), FAR[3:5]), ("A", (0, 1), FAR[3:5]),
    ("B", 0, FAR[3:]), ("H", (0, 0), FAR[3:]), ("H", (0, 1), FAR[3:]), ("Q", 0, FAR[3:]), ("P0", 0, FAR[3:]), ("R", 0, (1e12, 1e18)), ("x0", 0, FAR[3:])])
def test_a_size_far_from_the_others_is_refused_or_right(name: str, at: int | tuple[int, int], values: Sequence[float]) -> None:
    """No C with a shift that C does not define, a raw value beyond 32 bits, or `inf`"""
    for value in values:
        for arithmetic in ("f32", "q31"):
            try:
                c = compiled(odd(name, at, value), "odd", Options(arithmetic)).code
            except KalmanqError as problem:
                assert CURE.search(str(problem)) or "use other units" in str(problem), problem
                continue
            assert not re.search(r"(?:<<|>>) (?:-|6[3-9]|[7-9]\d|\d{3})|[^a-z]inf\b", c)
            tables = re.findall(r"^    +(?:static .*= \{)?(\{[-\d, {}]+\}),?;?$", c, re.M)
            assert all(abs(int(word)) <= 2**31 for table in tables for word in re.findall(r"\d+", table))


@pytest.mark.parametrize("name, at, value, arithmetic, said", [
    ("states", 0, 1e-30, "q31", "position: its range or x0 is 1e-30, and one sigma of it"), ("controls", 0, 1e30, "q31", "push: its range is 1e+30"),
    ("A", (0, 0), 1e39, "q31", "A[0,0]: is 1e+39"), ("A", (0, 0), 1e30, "f32", "a float cannot hold it"), ("Q", 1, 1e-300, "f32", "Q[1,1]: 1e-300 is below"),
    ("measurements", 0, 1e39, "f32", "the range of range: 1e+39 is above")])
def test_a_size_that_is_refused_is_named(name: str, at: int | tuple[int, int], value: float, arithmetic: str, said: str) -> None:
    with pytest.raises(KalmanqError, match=re.escape(said)):
        compiled(odd(name, at, value), "odd", Options(arithmetic))


@pytest.mark.parametrize("of", ("position", "range", "push"))
@pytest.mark.parametrize("bits, said", [(30, "integer"), (-40, "fraction")])
def test_fractions_that_do_not_hold_the_range(of: str, bits: int, said: str) -> None:
    with pytest.raises(KalmanqError, match=f"^{of}: .*{said}"):
        compiled(odd("states", 0, 100.0, **{of: bits}), "odd", Options("q31"))


@pytest.mark.parametrize("model, options", [("late.toml", ()), ("late.toml", ("--arith=q31",)), ("late.toml", ("--library",)), ("late.py", ())])
def test_a_delay_that_no_history_holds(model: str, options: Sequence[str], refused, tmp_path: Path) -> None:
    text = (tmp_path / model).read_text()
    (tmp_path / model).write_text(text.replace("delay = 3", "delay = 21845").replace('"slow": 3}', '"slow": 21845}'))
    assert "delay: 21845 steps, and a filter keeps 32767" in refused(model, options)
    (tmp_path / model).write_text(text.replace("delay = 3", "delay = 21844").replace('"slow": 3}', '"slow": 21844}'))
    assert not refused(model, options) or "--library" in options


@pytest.mark.parametrize("name, at, value, subject, mark, said", [
    ("R", 0, 0.0, "compiled", "(!)", "refused: R: range has no noise"), ("Q", 0, 1e-300, "compiled", "(!)", "refused: Q[0,0]: 1e-300"),
    ("P0", 0, 2500.0, "prior", "(!)", "3 sigma reach beyond"), ("P0", 0, 4.0, "prior", "ok ", "within"), ("P0", 0, 1e6, "prior", "NO ", "beyond its range"),
    ("A", (0, 1), 1e-9, "conditioning", "(!)", "hardly distinguished"), ("A", (0, 1), 0.1, "conditioning", "ok ", "observability"),
    ("A", (0, 1), 0.0, "steady state", "(!)", "none: a lasting state is not measured"), ("Q", 0, 1e-13, "steady state", "ok ", "forgets by 0.8535 a row")])
def test_check_marks_what_is_no_good_news(name: str, at: int | tuple[int, int], value: float, subject: str, mark: str, said: str) -> None:
    model = odd(name, at, value)
    found = {one.subject: one for one in [*checks.findings(model), settling.finding(model)]}[subject]
    assert found.mark == mark and said in found.said and found.said.count("steady state") == 0


@pytest.mark.parametrize("noise, forgets, why", [(0.0, "none", "has no process noise"), (1e-13, "forgets by 1 - ", "more than 131072 full samples"),
                                                 (1e-4, "forgets by 0.9", "constant")])
def test_check_and_the_report_agree_on_what_settles(noise: float, forgets: str, why: str) -> None:
    model = Model(1, H=1, R=1, Q=noise, P0=1)
    steady = {one.subject: one for one in checks.findings(model)}["steady state"]
    product = compiled(model, "level")
    said = " ".join(settling_of(product.given, product.steady, None))
    assert steady.said.startswith(forgets) and why in settling.finding(model).said
    assert ("no steady state that every start" in said) == (noise == 0) and ("131072" in said) == (noise == 1e-13)
