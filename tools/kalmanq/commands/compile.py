"""kalmanq compile: C for exactly this filter, proven over every covariance that it can have."""

from __future__ import annotations

import hashlib
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from pathlib import Path

import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, tell_written
from kalmanq.commands.options import JSON, MODEL, ChipArithmetic, choices, command_of
from kalmanq.compiler.proven.costs import estimates
from kalmanq.compiler.proven.files import texts_of
from kalmanq.compiler.proven.product import KINDS, Product, Wanted, compiled, fractions_of, ram_of
from kalmanq.compiler.proven.proof_file import lines_of_class, losses, narrow_ranges, of_means
from kalmanq.data.files import whole
from kalmanq.errors import KalmanqError
from kalmanq.firmware.c_source import WORDS, identifier
from kalmanq.model import model_file


@dataclass(frozen=True)
class Options:
    model: Path = MODEL
    out: Path = typer.Option(..., "-o", "--out", metavar="NAME.c", help="NAME.h, NAME_test.c and NAME_proof.txt go beside it.")
    arithmetic: ChipArithmetic = typer.Option("f32", "--arith", help="The numbers that the chip will have.")
    form: choices("Form", KINDS) = typer.Option("covariance", "--form", help="gain: constant, where no sample is ever missing.")
    partial: bool = typer.Option(False, "--partial", help="Samples of which some components are missing, too.")
    nis: bool = typer.Option(False, "--nis", help="Keep NIS and the variances of innovations; f32: the likelihood.")
    lag: int = typer.Option(0, "--lag", metavar="L", min=0, max=64, help="The mean L samples ago, too, once settled.")
    bound: float = typer.Option(1e-4, "--bound", min=0, help="Of a covariance's error, in sigma_i sigma_j.")
    json: bool = JSON


def compile_file(options: Options, console: Console) -> None:
    name = _name(options.out)
    model = model_file.read(options.model)
    with console.status("proving", spinner="line"):
        product = compiled(model, Wanted(options.arithmetic, name, options.form, options.partial, options.nis,
                                         options.lag, options.bound))
        texts = texts_of(product, hashlib.sha256(options.model.read_bytes()).hexdigest())
    written = _write(options, texts)
    if options.json:
        print_json(_told(product, written))
    else:
        _tell(product, written, console)


def _name(out: Path) -> str:
    if out.suffix == ".c" and out.stem in WORDS:
        raise KalmanqError(f"-o {out}: {out.stem} is a word or a header of C or C++; functions need another name")
    if out.suffix != ".c" or identifier(out.stem) != out.stem:
        raise KalmanqError(f"-o {out}: is called as its functions are: a name in small letters, digits and _, and .c")
    return out.stem


def _write(options: Options, texts: dict[str, str]) -> list[Path]:
    paths = [options.out.with_name(name) for name in texts]
    with ExitStack() as stack:
        for path, text in zip(paths, texts.values()):
            stack.enter_context(whole(path, [options.model])).write_text(text, encoding="utf-8")
    return paths


def _told(product: Product, written: list[Path]) -> dict:
    plan, proof = product.plan, product.proof
    return {
        "name": plan.name, "arithmetic": product.wanted.arithmetic, "form": plan.form.name, "n": plan.model.n,
        "m": plan.model.m, "l": plan.model.l, "rows": plan.rows, "max_gap": plan.max_gap, "min_run": plan.min_run,
        "ram": ram_of(plan), "fractions": fractions_of(plan), "bounds": list(plan.bounds),
        "losses": proof.losses,
        "proof": {how or "words": {"covariances": one.count, "error": one.error, "pivot": one.pivot}
                  for how, one in proof.found.items()},
        "rounding": proof.rounding, "ends": proof.ends.worst if proof.ends else None,
        "warnings": narrow_ranges(product),
        "means": {"worst": proof.mean.worst, "settled": proof.mean.last, "damped": proof.track.worst,
                  "damped_settled": proof.track.last, "covariance": proof.track.covariance},
        "costs": {f"{core} {level}": asdict(cost) for (core, level), cost in estimates(plan).items()},
        "refused": [{"form": one.form, "reason": one.reason} for one in product.refused],
        "files": written}


def _tell(product: Product, written: list[Path], console: Console) -> None:
    plan, proof = product.plan, product.proof
    console.print(f"{plan.name}: {plan.form.name}, {product.wanted.arithmetic}, {ram_of(plan)} bytes of RAM")
    if proof.losses:
        console.print(f"  {losses(product)[0].rstrip('.')}")
    for line in lines_of_class(product):
        console.print(f"  {line}")
    for how, one in proof.found.items():
        console.print(f"  {one.count} covariances, and no more{f' ({how})' if how else ''}: all positive definite, "
                      f"least pivot {one.pivot:.1e}, within {one.error:.1e} sigma_i sigma_j of the exact ones")
    for what, said in of_means(product):
        console.print(f"  {what}: {said}")
    for line in narrow_ranges(product):
        console.print(f"  {line}")
    for one in product.refused:
        console.print(f"  not {one.form}: {one.reason}")
    tell_written(written, console)


command = command_of(Options, compile_file)
