"""kalmanq compile MODEL.py: C of a nonlinear model, straight lines without a library or, with --library, a device over it."""

from __future__ import annotations

import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Callable

from rich.console import Console

from kalmanq.commands.messages import print_json, tell_written
from kalmanq.compiler.given.request import Options
from kalmanq.compiler.report import equation_costs, equation_report, fixed_report, report
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
            written = write(report.files(product, trial(product, host, record, found.first), found, source))
    if as_json:
        print_json({**described(product), "observed": asdict(found), "instructions": equation_costs.estimates(product), "files": written})
    else:
        for line in report.lines(product, found):
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
        written = write(report.files(product, device_trial(product, record, ran), found, source))
    if as_json:
        print_json({"name": name, "arithmetic": wanted.arithmetic, "form": "library", "n": model.n, "m": model.m, "l": model.l,
                    "files": written})
    else:
        for line in report.lines(product, found):
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
    return FixedRun(product.arithmetic).run(record), found


def described(product: Any) -> dict[str, Any]:
    """What there is to call"""
    given, text = product.given, product.text
    smooths = {"step": text.smoother.record_size, "history": text.smoother.history_size} if text.smoother else None
    sensors = [{"name": one.name, "m": one.m, "arguments": _arguments(text.update_arguments(one))} for one in product.arithmetic.sensors]
    return {"name": given.name, "arithmetic": given.options.arithmetic, "form": "equations", "n": given.of.n, "m": given.of.m,
            "l": given.of.l, "ram": product.ram, "ram_delayed": product.ram_delayed, "smooth": smooths, "entries": len(product.arithmetic.live),
            "predict": _arguments(text.predict_arguments()), "sensors": sensors}


def _arguments(text: str) -> list[str]:
    """z, u, t and dt, as far as they are there"""
    return re.findall(r"\b(?:[zut]|dt)\b", text)
