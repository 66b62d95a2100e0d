"""kalmanq compile --form covariance: a form that is proven over every covariance that it can have."""

from __future__ import annotations

import hashlib
from dataclasses import asdict
from pathlib import Path
from typing import Any, Callable

from rich.console import Console

from kalmanq.commands.messages import print_json, tell_written
from kalmanq.compiler.proven.costs import estimates
from kalmanq.compiler.proven.files import texts_of
from kalmanq.compiler.proven.product import Product, Wanted, compiled, fractions_of, ram_of
from kalmanq.compiler.proven.proof_file import lines_of_class, losses, of_measurements, of_means
from kalmanq.errors import KalmanqError
from kalmanq.model import model_file
from kalmanq.run.resolution import told_of


def compile_file(options: Any, name: str, write: Callable[[Any, dict[str, str]], list[Path]], console: Console) -> None:
    """options: of kalmanq compile; write: the texts, by the names of their files"""
    if options.arithmetic == "f64":
        raise KalmanqError(f"--form {options.form}: is for f32 and q31")
    model = model_file.read_in_time(options.model)
    with console.status("proving", spinner="line"):
        try:
            product = compiled(model, Wanted(options.arithmetic, name, options.form, options.partial, options.nis,
                                             options.lag, options.bound))
        except KalmanqError as problem:
            coarse = told_of(model, options.arithmetic)
            raise KalmanqError(f"{problem}; {coarse}") if coarse else problem
        texts = texts_of(product, hashlib.sha256(options.model.read_bytes()).hexdigest())
    written = write(options, texts)
    if options.json:
        print_json(_told(product, written))
    else:
        _tell(product, written, console)


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
        "warnings": of_measurements(product),
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
    for line in of_measurements(product):
        console.print(f"  {line}")
    for one in product.refused:
        console.print(f"  not {one.form}: {one.reason}")
    tell_written(written, console)
