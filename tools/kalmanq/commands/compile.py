"""kalmanq compile: C for exactly this filter, without a library."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Optional

import typer
from rich.console import Console

from kalmanq.commands import compile_equations
from kalmanq.commands.messages import print_json, tell_written
from kalmanq.commands.options import ANY_MODEL, JSON, choices, command_of, forms_of, robust_of
from kalmanq.commands.writing import Made, alone, over_library, remarks_of, write
from kalmanq.compiler.given.names import WORDS, identifier
from kalmanq.compiler.given.request import ARITHMETICS, Options as Wanted, refuse_over_library
from kalmanq.compiler.report import costs, report
from kalmanq.compiler.report.described import described
from kalmanq.compiler.text.product import Product, compiled, fingerprint
from kalmanq.errors import KalmanqError
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.steps_kept import MOST_STEPS
from kalmanq.model import model_file
from kalmanq.model.column_model import row_needs
from kalmanq.nonlinear import NonlinearModel, file as nonlinear_file
from kalmanq.nonlinear.of_columns import equations_of
from kalmanq.run.parts import WAYS, ways_of
from kalmanq.run.robust import ALONE, LOSSES, Robust



@dataclass(frozen=True)
class Options:
    model: Path = ANY_MODEL
    out: Path = typer.Option(..., "-o", "--out", metavar="NAME.c", help="The C file. NAME.h, NAME_test.c and NAME_report.txt are written next to it.")
    arithmetic: choices("Compiled", ARITHMETICS) = typer.Option("f32", "--arith", help="The arithmetic of the C file.")
    robust: Optional[str] = typer.Option(None, "--robust", metavar=forms_of(ALONE), help="Against outliers. gate: reject what is more than K sigma "
                                         "(3.8906) from its prediction; student: less weight, as Student's noise with NU (10) degrees of freedom gives it. "
                                         "--library: huber[=K] and jump[=G], too.")
    nis: bool = typer.Option(False, "--nis", help="Also compute NIS and the variances of innovations (f32, f64: the likelihood, too).")
    lag: int = typer.Option(0, "--lag", metavar="L", min=0, max=64, help="Also give the mean of L samples ago, once the gain is constant.")
    tunable: bool = typer.Option(False, "--tunable", help="f32, f64: a program may change A, Q and R while it runs; without the fast path.")
    every: str = typer.Option("", "--every", metavar="K,K,...", help="If rates differ: rows from one value to the next, for each measurement.")
    iterate: int = typer.Option(1, "--iterate", metavar="N", min=1, max=20, help="MODEL.py: linearise h N times in each update.")
    smooth: int = typer.Option(0, "--smooth", metavar="STEPS", min=0, max=MOST_STEPS, help="MODEL.py: write a smoother, too, with a history of STEPS steps.")
    library: bool = typer.Option(False, "--library", help="Write C that uses kalmanq's library, which has histories and smoothers, too.")
    loops: Optional[bool] = typer.Option(None, "--loops/--straight", help="The covariance in loops (small, slow) or in straight lines. "
                                         "By default loops only where straight lines take 20 kB (q31: 32 kB).")
    json: bool = JSON


def compile_file(options: Options, console: Console) -> None:
    name, robust = name_of(options.out), robust_of(options.robust, LOSSES if options.library else ALONE)
    losses = {robust.way: robust.sigmas if robust.way == "gate" else robust.value} if robust and robust.way in ALONE else {}
    wanted = Wanted(options.arithmetic, nis=options.nis, **losses, tunable=options.tunable, lag=options.lag, loops=options.loops,
                    every=_rates(options.every), iterate=options.iterate, smooth=options.smooth)
    functions = _functions_of(options)
    is_nonlinear = options.model.suffix == nonlinear_file.SUFFIX or functions is not None
    if is_nonlinear and options.library and robust:
        raise KalmanqError(f"--library and --robust {robust.way}: leave --robust out; over the library it is kq_update_robust with "
                           f"kq_loss_{robust.way} (kalmanq/robust.h)")
    if not is_nonlinear:
        _refuse_of_functions(options)
    with console.status("compiling", spinner="line"):
        made = compile_equations.made(options.model, name, wanted, options.library, functions) if is_nonlinear else \
            _over_library(options, name, wanted, robust) if options.library else _alone(options, name, wanted)
    written = write(options.out.parent, made.texts, options.model)
    if options.json:
        print_json({**made.told, "files": written})
    else:
        for line in made.lines:
            console.print(line)
        tell_written(written, console)


def _functions_of(options: Options) -> Optional[NonlinearModel]:
    """A linear model whose rows have numbers of their own, as functions of these"""
    model = None if options.model.suffix == nonlinear_file.SUFFIX else model_file.read(options.model)
    return equations_of(model, options.arithmetic) if model and row_needs(model) else None


def _alone(options: Options, name: str, wanted: Wanted) -> Made:
    model, source = model_file.read(options.model), fingerprint(options.model)
    product = compiled(model, name, wanted, source)
    found, lines, texts = alone(product, source)
    return Made(texts, lines, _told(product, found))


def _over_library(options: Options, name: str, wanted: Wanted, robust: Optional[Robust]) -> Made:
    """With the full sensor, as it takes all that a model may have; of q31 with the ranges that design chooses"""
    refuse_over_library(wanted, ("nis", "lag", "every", "tunable", "loops"))
    model, notes = model_file.read(options.model), []
    if wanted.arithmetic == "q31":
        model, notes = with_ranges(model, [])
    way = next(one for one in ("tables", "init") if one in ways_of(model))
    remarks = [fingerprint(options.model), *([f"Updates: --robust {options.robust} (kalmanq/robust.h)."] if robust else []), *remarks_of(notes)]
    lines = [f"{name}: {wanted.arithmetic}, over the library; {WAYS[way]}", *(f"  {note}" for note in notes),
             "  kalmanq design tries it, and has its costs on a core and other forms of it"]
    return Made(over_library(model, wanted.arithmetic, way, name, remarks, robust=robust), lines, {
        "name": name, "arithmetic": wanted.arithmetic, "form": "library", "way": way, "n": model.n, "m": model.m, "l": len(model.inputs),
        "chosen_ranges": [asdict(one) for one in notes]})


def _refuse_of_functions(options: Options) -> None:
    """What a constant model has not"""
    for name, value, other in (("--iterate", options.iterate > 1, ""), ("--smooth", options.smooth, "; --lag L is for a constant "
                                                                        "model, and kalmanq run smooths all rows")):
        if value:
            raise KalmanqError(f"{name}: is of nonlinear model files (MODEL.py): leave {name} out{other}")


def _rates(given: str) -> tuple[int, ...]:
    try:
        return tuple(int(one) for one in given.split(",")) if given else ()
    except ValueError:
        raise KalmanqError(f"--every: {given} is not a list of whole numbers: give one, such as 1,10") from None


def name_of(out: Path) -> str:
    if out.suffix == ".c" and out.stem in WORDS:
        raise KalmanqError(f"-o {out}: {out.stem} is a word or a header of C or C++: give another name")
    if out.suffix != ".c" or identifier(out.stem) != out.stem:
        raise KalmanqError(f"-o {out}: its functions are called so, in small letters, digits and _: write {out.with_name(identifier(out.stem) + '.c')}")
    return out.stem


def _told(product: Product, found: report.Findings) -> dict:
    given, steady = product.given, product.steady
    return {**described(product),
            "unresolved": {given.model.states[i].name: rows for i, rows in product.arithmetic.unresolved.items()},
            "settles": None if steady is None else {
                "samples": steady.samples, "after_gap": list(steady.after_gap), "tolerance": steady.tolerance},
            **costs.told(product), "observed": asdict(found), "resolution": report.resolution_of(product)}


command = command_of(Options, compile_file)
