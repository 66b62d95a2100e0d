"""kalmanq compile: C for exactly this filter, without a library."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Optional

import typer
from rich.console import Console

from kalmanq.commands import compile_equations
from kalmanq.commands.messages import print_json, tell_written
from kalmanq.commands.options import ANY_MODEL, JSON, choices, command_of
from kalmanq.compiler.given.request import ARITHMETICS, MOST_STEPS, Options as Wanted
from kalmanq.compiler.report import costs, report
from kalmanq.compiler.report.described import described
from kalmanq.compiler.run.host import Host
from kalmanq.compiler.text.product import Product, compiled, fingerprint
from kalmanq.data.files import whole
from kalmanq.errors import KalmanqError
from kalmanq.firmware.c_source import WORDS, identifier
from kalmanq.model import model_file
from kalmanq.nonlinear import file as nonlinear_file
from kalmanq.run.filters import LOSSES

USUAL = {"gate": round(NormalDist().inv_cdf((1 + LOSSES["gate"]) / 2), 4), "student": LOSSES["student"]}  # as kalmanq run


@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    out: Path = typer.Option(..., "-o", "--out", metavar="NAME.c", help="The C file. NAME.h, NAME_test.c and NAME_report.txt are written next to it.")
    arithmetic: choices("Compiled", ARITHMETICS) = typer.Option("f32", "--arith", help="The arithmetic of the C file.")
    robust: Optional[str] = typer.Option(None, "--robust", metavar="gate[=K]|student[=NU]", help="Against outliers. gate: reject what is more than K sigma "
                                         "(3.8906) from its prediction; student: less weight, as Student's noise with NU (10) degrees of freedom gives it.")
    nis: bool = typer.Option(False, "--nis", help="Also compute NIS and the variances of innovations (f32, f64: the likelihood, too).")
    lag: int = typer.Option(0, "--lag", metavar="L", min=0, max=64, help="Also give the mean of L samples ago, once the gain is constant.")
    tunable: bool = typer.Option(False, "--tunable", help="f32, f64: a program may change A, Q and R while it runs; without the fast path.")
    every: str = typer.Option("", "--every", metavar="K,K,...", help="If rates differ: rows from one value to the next, for each measurement.")
    iterate: int = typer.Option(1, "--iterate", metavar="N", min=1, max=20, help="MODEL.py: linearise h N times in each update.")
    smooth: int = typer.Option(0, "--smooth", metavar="STEPS", min=0, max=MOST_STEPS, help="MODEL.py: write a smoother, too, with a history of STEPS steps.")
    library: bool = typer.Option(False, "--library", help="MODEL.py: write C that uses kalmanq's library: histories, smoothers.")
    loops: Optional[bool] = typer.Option(None, "--loops/--straight", help="The covariance in loops (small, slow) or in straight lines. "
                                         "By default loops only where straight lines take 20 kB (q31: 32 kB).")
    json: bool = JSON


def compile_file(options: Options, console: Console) -> None:
    name = name_of(options.out)
    is_nonlinear = options.model.suffix == nonlinear_file.SUFFIX
    gate, student = _robust(options.robust)
    wanted = Wanted(options.arithmetic, nis=options.nis, gate=gate, student=student, tunable=options.tunable, lag=options.lag,
                    loops=options.loops, every=_rates(options.every), iterate=options.iterate, smooth=options.smooth)
    if is_nonlinear:
        given = options.model, name, wanted, lambda texts: write(options, texts), options.json, console
        if options.library:
            compile_equations.compile_device(*given)
        else:
            compile_equations.compile_file(*given)
        return
    _refuse_of_functions(options)
    model = model_file.read(options.model)
    source = fingerprint(options.model)
    with console.status("compiling", spinner="line"):
        product = compiled(model, name, wanted, source)
        with Host(product) as host:
            found = report.findings(product, host)
            texts = report.files(product, host, found, source)
    written = write(options, texts)
    if options.json:
        print_json(_told(product, found, written))
    else:
        for line in report.lines(product, found):
            console.print(line)
        tell_written(written, console)


def _refuse_of_functions(options: Options) -> None:
    """What a constant model has not"""
    for name, value, other in (("--iterate", options.iterate > 1, ""), ("--smooth", options.smooth, "; --lag L is for a constant "
                                "model, and the library smooths all"),
                               ("--library", options.library, "; kalmanq design writes a constant model over the library")):
        if value:
            raise KalmanqError(f"{name}: is of nonlinear model files (MODEL.py){other}")


def _robust(given: Optional[str]) -> tuple[Optional[float], Optional[float]]:
    """K of a gate, or NU of Student"""
    loss, has_value, value = (given or "").partition("=")
    try:
        made = float(value) if has_value else USUAL.get(loss)
    except ValueError:
        raise KalmanqError(f"--robust {given}: {value} is not a number") from None
    if given is not None and loss not in USUAL:
        raise KalmanqError(f"--robust {given}: C of one model has gate or student; the library has huber and jump, too (kalmanq/robust.h)")
    return (made, None) if loss == "gate" else (None, made)


def _rates(given: str) -> tuple[int, ...]:
    try:
        return tuple(int(one) for one in given.split(",")) if given else ()
    except ValueError:
        raise KalmanqError(f"--every: {given} is not a list of whole numbers, such as 1,10") from None


def name_of(out: Path) -> str:
    if out.suffix == ".c" and out.stem in WORDS:
        raise KalmanqError(f"-o {out}: {out.stem} is a word or a header of C or C++; functions need another name")
    if out.suffix != ".c" or identifier(out.stem) != out.stem:
        raise KalmanqError(f"-o {out}: is called as its functions are: a name in small letters, digits and _, and .c")
    return out.stem


def write(options: Options, texts: dict[str, str]) -> list[Path]:
    paths = [options.out.with_name(name) for name in texts]
    with ExitStack() as stack:
        for path, text in zip(paths, texts.values()):
            stack.enter_context(whole(path, [options.model])).write_text(text, encoding="utf-8")
    return paths


def _told(product: Product, found: report.Findings, written: list[Path]) -> dict:
    given, steady = product.given, product.steady
    return {**described(product),
            "unresolved": {given.model.states[i].name: rows for i, rows in product.arithmetic.unresolved.items()},
            "settles": None if steady is None else {
                "samples": steady.samples, "after_gap": list(steady.after_gap), "tolerance": steady.tolerance},
            **costs.told(product), "observed": asdict(found), "resolution": report.resolution_of(product), "files": written}


command = command_of(Options, compile_file)
