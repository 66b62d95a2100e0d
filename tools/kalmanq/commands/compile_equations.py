"""kalmanq compile MODEL.py: C of a nonlinear model, straight lines without a library or, with --library, a device over it."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Optional

from kalmanq.commands.writing import Made
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


def made(path: Path, name: str, wanted: Options, over_library: bool, model: Optional[NonlinearModel] = None) -> Made:
    """model: that of the file, if it is a linear one as functions"""
    model, source = model or read(path), fingerprint(path)
    if over_library and model.is_late:
        raise KalmanqError("--library: and a sensor with a delay: a device takes all in time; leave --library out")
    product, found, test = (_device if over_library else _alone)(model, name, wanted, source)
    lines = report.lines(product, found, test)
    told = {"name": name, "arithmetic": wanted.arithmetic, "form": "library", "n": model.n, "m": model.m, "l": model.l} if over_library else \
        {**described(product), **costs.told(product, test), "observed": asdict(found)}
    return Made(report.files(product, test, lines, source), lines, told)


Tried = tuple[Product, report.Found, str]  # and NAME_test.c


def _alone(model: NonlinearModel, name: str, wanted: Options, source: str) -> Tried:
    equation_report.refuse_wrong(model)
    product = compiled_equations(model, name, wanted, source)
    with Host(product) as host:
        found = equation_report.findings(model, product, host)
        record = drawn(model, ROWS, equation_report.SEEDS[0])
        return product, found, trial(product, host, record, found.first)


def _device(model: NonlinearModel, name: str, wanted: Options, source: str) -> Tried:
    is_fixed = wanted.arithmetic == "q31"
    product = compiled_fixed(model, name, simulated(model), wanted, source) if is_fixed else compiled_device(model, name, wanted, source)
    equation_report.refuse_wrong(model)
    record = in_whole_groups(drawn(model, ROWS, equation_report.SEEDS[0]), product.given.together)
    ran, found = (_fixed_tried if is_fixed else _floats_tried)(model, product, record)
    return product, found, device_trial(product, record, ran)


def _floats_tried(model: NonlinearModel, product: Product, record: Record) -> tuple[Ran, report.Found]:
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
