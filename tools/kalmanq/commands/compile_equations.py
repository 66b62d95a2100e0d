"""kalmanq compile MODEL.py: C of a nonlinear model, straight lines without a library or, with --library, a device over it."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Callable

from rich.console import Console

from kalmanq.commands.messages import print_json, tell_written
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import costs, equation_report, fixed_report, report
from kalmanq.compiler.report.described import described
from kalmanq.compiler.run.equation_records import drawn
from kalmanq.compiler.run.fixed_records import simulated
from kalmanq.compiler.run.fixed_run import FixedRun
from kalmanq.compiler.run.host import Host, Ran
from kalmanq.compiler.run.record import Record, in_whole_groups
from kalmanq.compiler.run.trial import ROWS, device_trial, trial
from kalmanq.compiler.text.equation_device_text import compiled_device
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.fixed_device_text import compiled_fixed
from kalmanq.compiler.text.product import Product, fingerprint
from kalmanq.errors import KalmanqError
from kalmanq.nonlinear import NonlinearModel, read


def compile_file(path: Path, name: str, wanted: Options, write: Callable[[dict[str, str]], list[Path]], as_json: bool,
                 console: Console) -> None:
    model, source = read(path), fingerprint(path)
    with console.status("compiling", spinner="line"):
        equation_report.refuse_wrong(model)
        product = compiled_equations(model, name, wanted, source)
        with Host(product) as host:
            found = equation_report.findings(model, product, host)
            record, _ = drawn(model, ROWS, equation_report.SEEDS[0])
            test = trial(product, host, record, found.first)
    told = report.lines(product, found, test)
    written = write(report.files(product, test, told, source))
    if as_json:
        print_json({**described(product), **costs.told(product, test), "observed": asdict(found), "files": written})
    else:
        for line in told:
            console.print(line)
        tell_written(written, console)


def compile_device(path: Path, name: str, wanted: Options, write: Callable[[dict[str, str]], list[Path]], as_json: bool,
                   console: Console) -> None:
    model, source, is_fixed = read(path), fingerprint(path), wanted.arithmetic == "q31"
    if model.is_late:
        raise KalmanqError("--library: and a sensor with a delay: a device takes all in time; leave --library out")
    with console.status("compiling", spinner="line"):
        tried = _fixed_tried if is_fixed else _device_tried
        product = compiled_fixed(model, name, simulated(model), wanted, source) if is_fixed else \
            compiled_device(model, name, wanted, source)
        equation_report.refuse_wrong(model)
        record = in_whole_groups(drawn(model, ROWS, equation_report.SEEDS[0])[0], product.given.together)
        ran, found = tried(model, product, record)
        told = report.lines(product, found)
        written = write(report.files(product, device_trial(product, record, ran), told, source))
    if as_json:
        print_json({"name": name, "arithmetic": wanted.arithmetic, "form": "library", "n": model.n, "m": model.m, "l": model.l,
                    "files": written})
    else:
        for line in told:
            console.print(line)
        tell_written(written, console)


def _device_tried(model: NonlinearModel, product: Product, record: Record) -> tuple[Ran, report.Found]:
    """What a record comes to, and what was found"""
    name, wanted = product.given.name, product.given.options
    straight = compiled_equations(model, name, wanted)
    with Host(straight) as host, Host(compiled_equations(model, name, replace(wanted, arithmetic="f64"))) as exact:
        found = equation_report.findings(model, straight, host)
        ran = exact.run_record(record)
    return ran, found


def _fixed_tried(model: NonlinearModel, product: Product, record: Record) -> tuple[Ran, report.Found]:
    found = fixed_report.tried(model, product)
    fixed_report.refuse_wrong(product, found)
    return FixedRun(product.arithmetic).run(record), found
