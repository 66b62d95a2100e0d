"""kalmanq design: formats, accuracy and costs of a filter on a core, and the C file."""

from __future__ import annotations

import decimal
import math
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Optional, Sequence

import typer
from rich.console import Console

from kalmanq.commands.messages import print_json, table, tell_written
from kalmanq.commands.options import JSON, MODEL, ChipArithmetic, choices, command_of
from kalmanq.commands.writing import alone, in_lines, over_library, remarks_of, write
from kalmanq.compiler.given.names import identifier
from kalmanq.compiler.report import offers as compiled_offers
from kalmanq.compiler.report.costs import UNKNOWN, built, reasons
from kalmanq.compiler.report.design_costs import costs_of
from kalmanq.compiler.report.offers import COLUMNS, Offer, add_ways, offers
from kalmanq.compiler.text.over_library import bytes_of_delays
from kalmanq.compiler.text.product import fingerprint, remarked
from kalmanq.data import joining, rows as given_rows
from kalmanq.data.files import require_folder
from kalmanq.errors import KalmanqError
from kalmanq.firmware.cores import BY_NAME
from kalmanq.firmware.costs import COMPACT, CORES, Cost, flags, include_path
from kalmanq.firmware.designs import PARTS, Designs, Part, Trial, Way, design, offered
from kalmanq.firmware.measured import compiler
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import Record, draw
from kalmanq.firmware.steps_kept import latest_of
from kalmanq.model import Model, model_file
from kalmanq.model.column_model import refuse_rows
from kalmanq.run.parts import WAYS, Parts, not_lean

COMPILED = compiled_offers.WAY
ALL_WAYS = {**WAYS, COMPILED: compiled_offers.SAID}


@dataclass(frozen=True)
class Options:
    model: Path = MODEL
    core: choices("Core", CORES) = typer.Option(..., "--core", help="The processor core that the filter will run on.")
    data: Optional[Path] = typer.Option(None, "--data", metavar="DATA.csv", help="Data that the filter will get; simulated by default.")
    arithmetic: Optional[ChipArithmetic] = typer.Option(None, "--arith", help="Look at this arithmetic only; by default the best one is chosen.")
    way: Optional[choices("Way", ALL_WAYS)] = typer.Option(None, "--way", help="Look at this form only; by default the cheapest that fits is chosen. Lean does, unless R is 0 or rows of H repeat exactly.")
    flash: Optional[float] = typer.Option(None, "--flash", metavar="KB", min=0, help="Flash of the part, in kB.")
    ram: Optional[float] = typer.Option(None, "--ram", metavar="KB", min=0, help="RAM of the part, in kB.")
    name: str = typer.Option("", "--name", metavar="NAME", help="Name of the files and functions; the model's by default.")
    out: Optional[Path] = typer.Option(None, "--out", "-o", metavar="FOLDER", help="Write NAME.c and NAME.h to this folder, which must exist, as compile --library does.")
    any_dt: bool = typer.Option(False, "--any-dt", help="Model with F, Qc and dt: predict in the C file takes dt as an argument (f32, form init).")
    steps: int = typer.Option(1, "--steps", metavar="N", min=1, max=64, help="Model with F, Qc and dt: predict in the C file goes 1 to N dt (q31).")
    json: bool = JSON


def design_file(options: Options, console: Console) -> None:
    model = model_file.read(options.model)
    refuse_rows(model, "design", "kalmanq compile writes its C, and over the library with --library")
    if options.any_dt:
        options = _of_any_dt(options, model)
    if options.steps > 1:
        if model.continuous is None or options.any_dt or options.arithmetic not in (None, "q31") or options.way in ("sizes", COMPILED):
            raise KalmanqError("--steps: of a model with F, Qc and dt, in q31, and as lean, tables or init; f32 has --any-dt")
        options = replace(options, arithmetic="q31", way=options.way or "tables")
    if options.out:
        require_folder(options.out)
    with console.status("trying, compiling and measuring", spinner="line"):
        made, records = _designs(options, model)
        arithmetics = [one for one in compiled_offers.ARITHMETICS if options.arithmetic in (None, one)] if _asked(options, made.model)[1] else []
        compiled = offers(model, made.model, options.name or identifier(made.model.name), [options.core], arithmetics)
        add_ways(made, compiled, records)
    chosen = made.chosen(options.arithmetic, options.way)
    written = _write(options, made, chosen, compiled) if chosen and options.out else []
    if options.json:
        print_json(_told(made, compiled, chosen, written))
    else:
        _tell(made, compiled, chosen, written, console)
    if not chosen:
        raise KalmanqError(f"{made.model.name}: nothing was written: {_reason(options, made)}")


ANY_DT = "Steps are of the model's dt there. Another dt than the last one takes the instructions of kq_process_init_continuous " \
         "(process.h) besides."
LATE = "Of the RAM up to {} bytes are for what comes late."
DELAY = "A late measurement takes the instructions of kq_update_delayed (lag.h)."
REPLAY = "A late measurement works out up to {} steps."


def _of_any_dt(options: Options, model: Model) -> Options:
    if model.continuous is None:
        raise KalmanqError(f"--any-dt: {model.name} is of steps that are all alike: give F, Qc and dt in the place of A and Q")
    if options.arithmetic not in (None, "f32") or options.way not in (None, "init"):
        raise KalmanqError("--any-dt: in f32 and as init alone; q31's tables are of one dt, and kalmanq compile --tunable has "
                           "NAME_move")
    return replace(options, arithmetic="f32", way="init")


def _designs(options: Options, model: Model) -> tuple[Designs, list[Record]]:
    flash, ram = PARTS[options.core]
    part = Part(options.core, int(1024 * (options.flash or flash)), int(1024 * (options.ram or ram)))
    records = []
    if options.data:
        z, u, _ = joining.record(options.data, model)
        records = [Record(z, given_rows.controls_of(u, model, len(z)))]
    ranged, notes = with_ranges(model, records)
    records = records or [one for one in draw(ranged) if len(one.z)]
    if not records:
        raise KalmanqError(f"{model.name}: each record that is drawn of the model begins outside the declared ranges: widen them, make P0 "
                           "smaller, or give --data")
    prices = partial(costs_of, ranged, options.core, any_dt=options.any_dt, steps=options.steps)
    return design(ranged, part, records, notes, prices, _asked(options, ranged)[0]), records


def _asked(options: Options, model: Model) -> tuple[Sequence[tuple[str, str]], bool]:
    """Of the library the arithmetics and ways to look at, and whether compiled is; where there is no such way, all: the refusal names them"""
    if options.way == COMPILED:
        return [], True
    ways = offered(model, options.core, options.arithmetic, options.way)
    return (ways, options.way is None) if ways else (offered(model, options.core, options.arithmetic), True)


def _reason(options: Options, made: Designs) -> str:
    ways = [one for one in made.ways if options.arithmetic in (None, one.arithmetic) and options.way in (None, one.way)]
    if not ways:
        refused = [trial.refused for trial in made.trials.values() if trial.refused]
        lean = not_lean(made.model) if options.way == "lean" else ""
        return f"lean: {lean}" if lean else (refused or [_no_such_way(options, made)])[0]
    fitting = [one for one in ways if one.fits is not False]
    if not fitting:
        least = min(one.cost.flash for one in ways if one.cost.flash is not None)
        late = bytes_of_delays(made.model, options.arithmetic or "f32", options.any_dt)
        of_late = f", of which {late} bytes are for what comes late " if late else " "
        return f"no way fits {made.part.flash // 1024} kB of flash and {made.part.ram / 1024:g} kB of RAM{of_late}" \
               f"(the least takes {least} bytes of flash)"
    return fitting[0].trial.warnings[0]


def _no_such_way(options: Options, made: Designs) -> str:
    """Of --way"""
    others = dict.fromkeys(one.way for one in made.ways if options.arithmetic in (None, one.arithmetic))
    return f"{options.way} is not offered for this model on {CORES[made.part.core]}: here --way is one of {', '.join(others)}"


# ------------------------------------------------------------------------------ the files


def _write(options: Options, made: Designs, chosen: Way, compiled: Sequence[Offer]) -> list[Path]:
    if chosen.way == COMPILED:
        texts = _compiled(options, made, next(one for one in compiled if one.arithmetic == chosen.arithmetic))
    else:
        texts = over_library(made.model, chosen.arithmetic, chosen.way, options.name or identifier(made.model.name),
                             _remarks(made, chosen, options.any_dt), any_dt=options.any_dt, steps=options.steps)
    return write(options.out, texts, options.model)


def _compiled(options: Options, made: Designs, one: Offer) -> dict[str, str]:
    """What kalmanq compile writes; of q31 the report says which ranges were chosen"""
    said = fingerprint(options.model)
    notes = remarks_of(made.notes) if one.arithmetic == "q31" else []
    return alone(remarked(one.product, said), "\n".join([said, *notes]))[2]


def _remarks(made: Designs, chosen: Way, any_dt: bool) -> list[str]:
    late = _late(made.model, chosen.arithmetic, any_dt)
    return [*_measured(made.part.core, chosen), *(in_lines(ANY_DT) if any_dt else []), *(in_lines(late) if late else []), *in_lines(_accuracy(chosen)), *remarks_of(made.notes)]


def _late(model: Model, arithmetic: str, any_dt: bool) -> str:
    """What delays cost; empty: there are none"""
    size = bytes_of_delays(model, arithmetic, any_dt)
    return f"{LATE.format(size)} {DELAY if any_dt else REPLAY.format(latest_of(model) + 1)}" if size else ""


def _accuracy(chosen: Way) -> str:
    """Of the very reading that the header names"""
    reading = chosen.trial.reading
    T, times = chosen.arithmetic, f"{math.ceil(10 * reading.times) / 10:g}"
    return f"kq_mean_{T} alone is within {no_less(reading.within)} sigma of double's mean while states are within " \
           f"their ranges. Its 32 bits lose {no_less(reading.low)} at most, which kq_mean_low_{T} has. The rest is {times} " \
           f"times the largest error of {reading.rows} rows, {no_less(reading.seen)}: the ranges are up to {times} times as far as states went there."


def no_less(value: float) -> str:
    """Two digits that are not below the value"""
    rounded = decimal.Context(prec=2, rounding=decimal.ROUND_CEILING).create_decimal_from_float(1.0005 * value)
    return f"{float(rounded):.1e}"


def _measured(core: str, chosen: Way) -> list[str]:
    """In lines for a comment"""
    cost = [UNKNOWN if one is None else str(one) for one in asdict(chosen.cost).values()]
    why_not = f" {UNKNOWN}: {chosen.why_not}." if chosen.why_not else ""
    return in_lines("On {}: {} instructions a step, {} bytes of flash and {} of RAM beside a program without a filter, {} of stack.".format(
        CORES[core], *cost) + f"{why_not} With {_flags_said(core, include_path(core, chosen.way), chosen.cost != Cost())}")


def _flags_said(core: str, include: str, is_measured: bool) -> str:
    by = compiler(BY_NAME[core]) if is_measured else "gcc"
    return f"{by} {flags(core)} (the library's files: {COMPACT}, too) and the include path {include} in this order. Other flags, or another path, cost more."


# ------------------------------------------------------------------------------ what is told


def _told(made: Designs, compiled: Sequence[Offer], chosen: Optional[Way], written: list[Path]) -> dict:
    return {
        "model": made.model.name, "core": made.part.core, "flash": made.part.flash, "ram": made.part.ram,
        "ranges": {one.name: one.range for which in (made.model.states, made.model.measurements, made.model.inputs)
                   for one in which}, "notes": [str(one) for one in made.notes],
        "chosen_ranges": [asdict(one) for one in made.notes],
        "formats": [dict(zip(("name", "format", "headroom_bits", "last_bit"), row)) for row in _formats(made)],
        "trials": {name: {"worst": trial.worst, "rms": trial.rms, "warnings": trial.warnings,
                          "kq_mean": _reading(trial)}
                   for name, trial in made.trials.items()},
        "ways": [{"arithmetic": one.arithmetic, "way": one.way, "fits": one.fits, "good": one.is_good,
                  **asdict(one.cost), "not_measured": one.why_not, **_flags(made.part.core, one)} for one in made.ways],
        "no_lean": not_lean(made.model),
        "compiled": [one.told(made.part.core) for one in compiled],
        "chosen": {"arithmetic": chosen.arithmetic, "way": chosen.way} if chosen else None,
        "files": written}


def _flags(core: str, one: Way) -> dict[str, str]:
    if one.way == COMPILED:
        return {"flags": built([core])} if one.cost.flash else {}
    return {"flags": flags(core), "library_flags": COMPACT, "include": include_path(core, one.way)}


def _reading(trial: Trial) -> Optional[dict]:
    return {"within": trial.reading.within, **asdict(trial.reading)} if trial.reading else None


def _formats(made: Designs) -> list[tuple[str, str, float, float]]:
    """Of each state: bits between what it reaches and the end of its word, and what its last bit is worth."""
    if made.trials["q31"].refused:
        return []
    parts = Parts(made.model, "q31")
    rows = []
    for one, bits, span in zip(made.model.states, parts.fractions("states"), made.reached.states):
        headroom = math.log2(2.0**31 / max(span * 2.0**bits, 1.0))
        rows.append((one.name, f"Q{31 - bits}.{bits}", round(headroom, 1), 2.0**-bits))
    return rows


def _tell(made: Designs, compiled: Sequence[Offer], chosen: Optional[Way], written: list[Path],
          console: Console) -> None:
    console.print(f"{made.model.name} on {CORES[made.part.core]}, {made.part.flash // 1024} kB of flash and "
                  f"{made.part.ram / 1024:g} kB of RAM")
    for note in made.notes:
        console.print(f"  {note}")
    _tell_formats(made, console)
    _tell_ways(made, chosen, console)
    if compiled:
        _tell_compiled(made, compiled, console)
    for trial in [*made.trials.values(), *(one.trial for one in made.ways if one.trial.arithmetic not in made.trials)]:
        for warning in trial.warnings:
            console.print(f"  warning: {warning}")
    if chosen:
        console.print(f"recommended: {chosen.arithmetic}, {chosen.way}: {ALL_WAYS[chosen.way]}")
        for one in (one for one in compiled if chosen.way == COMPILED and not chosen.why_not and one.arithmetic == chosen.arithmetic):
            console.print(f"  {_settles(one, made.part.core)}")
    tell_written(written, console)


def _settles(one: Offer, core: str) -> str:
    cost = one.costs[core]
    if not one.samples:
        return f"{cost.cell('two_calls')} instructions in each row: its gain does not settle (kalmanq check says why)"
    return f"{cost.cell('two_calls')} instructions a row until {one.samples} full samples are in, and after each gap until it has " \
           f"settled again; {cost.cell('two_calls_settled')} then"


def _tell_formats(made: Designs, console: Console) -> None:
    rows = _formats(made)
    if not rows:
        return
    shown = table("state", "largest |mean|", "range", "format", "headroom, bits", "last bit", title="formats of q31")
    for one, span, row in zip(made.model.states, made.reached.states, rows):
        shown.add_row(one.label, f"{span:.3g}", f"{one.range:g}", row[1], f"{row[2]:g}", f"{row[3]:.2g}")
    console.print(shown)


def _tell_ways(made: Designs, chosen: Optional[Way], console: Console) -> None:
    shown = table("", "arithmetic", "way", "instructions a step", "flash", "RAM", "stack", "fits", "worst error, sigma",
                  title="ways to run it (bytes beside a program without a filter; compiled: a row that has not settled)")
    for one in made.ways:
        shown.add_row("*" if one is chosen else "", one.arithmetic, one.way, *(UNKNOWN if cell is None else str(cell) for cell in asdict(one.cost).values()),
                      UNKNOWN if one.fits is None else "yes" if one.fits else "no", f"{one.trial.worst.max(initial=0):.1e}")
    console.print(shown)
    sizes = " (sizes: -Isrc/fixed_size, too)" if any(one.way == "sizes" for one in made.ways) else ""
    library = [one for one in made.ways if one.way != COMPILED]
    console.print(f"  with {_flags_said(made.part.core, include_path(made.part.core, 'init') + sizes, any(one.cost != Cost() for one in library))}")
    for line in dict.fromkeys(f"{UNKNOWN}: {one.why_not}" for one in library if one.why_not):
        console.print(f"  {line}")
    if chosen and chosen.trial.reading:
        console.print(f"  {_accuracy(chosen)}")
    if why := not_lean(made.model):
        console.print(f"  no lean: {why}")


def _tell_compiled(made: Designs, compiled: Sequence[Offer], console: Console) -> None:
    shown = table(*COLUMNS, title="compiled for this model alone (kalmanq compile)")
    shown.columns[0].no_wrap = True  # numbers may take two lines
    for one in compiled:
        shown.add_row(*one.cells(made.part.core))
    console.print(shown)
    console.print(f"  {compiled_offers.EXPLAINED}")
    for one in compiled:
        if one.remark:
            console.print(f"  compiled in {one.arithmetic}: {one.remark}")
    core, costs = made.part.core, [one.costs for one in compiled if one.product]
    counted = [f"compiled by {built([core])}"] if any(one[core].of for one in costs) else []
    for line in dict.fromkeys([*counted, *(line for one in costs for line in reasons(one))]):
        console.print(f"  {line}")


command = command_of(Options, design_file)
