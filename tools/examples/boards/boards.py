#!/usr/bin/env python3
"""Runs the examples for boards: writes the filter, builds it, runs the recording on the emulated board, compares.

    boards.py run [NAME...]       each row that the board prints beside the row of `kalmanq run`; --ways: in every way;
                                  --pictures: draws NAME/picture.png of what the board has printed
    boards.py costs [NAME...]     what each way costs; --check: that the pages say so, --write: writes it there

--kalmanq COMMAND: how to call it, "kalmanq" if left out; --work FOLDER: for what is made, kept; NAME: a folder here.
"""
from __future__ import annotations

import argparse
import json
import re
import shlex
import sys
import tempfile
from pathlib import Path
from typing import Sequence

try:
    import numpy as np
except ImportError:
    sys.exit("boards: NumPy is not there: run it by the Python that has kalmanq, as after pip install './tools[all]'")

from costs import costs
from examples import EXAMPLES, HERE
from job import ROOT, Job
from texts import BoardError, run, table

LAST_BIT = 0.5 + 1e-9


def compared(job: Job) -> tuple[np.ndarray, str]:
    """What the board has printed, in units, and a line about it; a BoardError where it is something else"""
    example, way, host = job.example, job.example.ways[job.way], job.host()
    missing = [one for one in example.shown if one not in host]
    if missing:
        raise BoardError(f"{job.title}: kalmanq run has no {', '.join(missing)}")
    wanted, shown = np.column_stack([host[one] for one in example.shown]), job.printed()
    if shown.shape != wanted.shape:
        raise BoardError(f"{job.title}: the board has printed {shown.shape} numbers, the host {wanted.shape}")
    last = np.broadcast_to(job.scales(), shown.shape) if job.T == "q31" else np.spacing(np.abs(wanted).astype(np.float32)).astype(float)
    shown = shown * last if job.T == "q31" else shown
    apart = np.abs(shown - wanted)
    first, second = example.first
    rows = np.arange(len(wanted)) % second >= first
    same = (apart <= LAST_BIT * last)[rows]
    worst = float((apart / sigmas(host, example.shown))[rows].max())
    line = f"{job.title}: {rows.sum()} rows, {same.sum()} of {same.size} numbers equal, worst {worst:.1e} sigma"
    if not np.isfinite(shown).all() or (worst > way.near if way.near else not same.all()):
        raise BoardError(f"{line}: not what kalmanq run says")
    return shown, line


def errors(job: Job, shown: np.ndarray) -> list[str]:
    """RMS, of what the recording has the truth of; of a smoother the filter's, too"""
    data, host, said = table(job.data), table(job.folder / "host.csv"), []
    for k, one in enumerate(job.example.shown):
        name = re.sub("(_mean|_smoothed)$", "", one)
        if f"{name}_true" in data:
            of = {"RMS error": shown[:, k], **({"filtered": host[f"{name}_mean"]} if one.endswith("_smoothed") else {})}
            said.append(f"{name}: " + ", ".join(f"{what} {np.sqrt(np.mean((values - data[f'{name}_true']) ** 2)):.3g}" for what, values in of.items()))
    return said


def sigmas(host: dict[str, np.ndarray], shown: Sequence[str]) -> np.ndarray:
    """Of each number; where a number has none (of a quaternion), the least of the row"""
    every = np.column_stack([values for name, values in host.items() if name.endswith("_sigma")])
    least = every.min(axis=1)
    names = [re.sub("(_mean|_smoothed)?(_sigma)?$", "", one) for one in shown]
    return np.column_stack([host.get(f"{name}_smoothed_sigma", host.get(f"{name}_sigma", least)) for name in names])


# ------------------------------------------------------------------------------ the pictures


def drawn(job: Job, shown: np.ndarray) -> None:
    from pictures import draw

    example, path = job.example, HERE / job.name / "picture.png"
    host = table(job.folder / "host.csv")
    if job.name == "gps":  # what happens to those who do not say that it is late
        host["position_in_time"] = in_time(job)
    if job.name == "room":
        host["forecast_sigma"] = forecast_sigma(job)
    named = {one.replace("_mean", "").replace("_smoothed", ""): shown[:, k] for k, one in enumerate(example.shown)}
    draw(job.name, named, host, table(job.data), path)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size} bytes")


def forecast_sigma(job: Job) -> np.ndarray:
    """Of the temperature, in the rows that are forecast"""
    measured = table(job.data)["thermometer"]
    known = int(np.sum(np.isfinite(measured)))
    data = job.folder / "known.csv"
    data.write_text("\n".join(["thermometer", *map(str, measured[:known]), ""]), encoding="utf-8")
    told = json.loads(run([*job.kalmanq, "run", str(job.example.model_of(job.name)), str(data), "--json", "--forecast",
                           str(len(measured) - known)]))
    H = np.isin(told["states"], ("level", "day", "half_day")).astype(float)
    return np.concatenate([np.full(known, np.nan), [np.sqrt(H @ np.array(one["covariance"]) @ H) for one in told["forecast"]]])


def in_time(job: Job) -> np.ndarray:
    model, out = job.folder / "in_time.toml", job.folder / "in_time.csv"
    model.write_text(re.sub("^delay = .*$", "", job.example.model_of(job.name).read_text(encoding="utf-8"), flags=re.M), encoding="utf-8")
    run([*job.kalmanq, "run", str(model), str(job.data), "--arith", job.T, "--out", str(out)])
    return table(out)["position_mean"]


# ------------------------------------------------------------------------------ the command line


def jobs(names: Sequence[str], given: argparse.Namespace, work: Path) -> list[Job]:
    made = []
    for name in names or EXAMPLES:
        if name not in EXAMPLES:
            raise BoardError(f"{name}: is no example; there are {', '.join(EXAMPLES)}; tools/docs/start.md has the commands for a program of yours")
        example = EXAMPLES[name]
        ways = list(example.ways) if given.ways or given.what == "costs" else list(example.ways)[:1]
        for core in example.boards:
            made += [Job(name, example, way, core, shlex.split(given.kalmanq), work / name / f"{core}-{way.replace(' ', '_')}")
                     for way in ways]
    return made


def runs(made: Sequence[Job], pictures: bool) -> None:
    for job in made:
        job.prepare()
        shown, line = compared(job)
        print(line, flush=True)
        for said in errors(job, shown):
            print(f"    {said}", flush=True)
        if pictures:
            drawn(job, shown)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("run", "costs"))
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--kalmanq", default="kalmanq")
    parser.add_argument("--work", type=Path)
    for flag in ("--ways", "--pictures", "--check", "--write"):
        parser.add_argument(flag, action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kalmanq-boards-") as own:
        try:
            made = jobs(given.names, given, given.work or Path(own))
            if given.what == "run":
                runs(made, given.pictures)
            else:
                costs(made, given.check, given.write)
        except BoardError as problem:
            sys.exit(f"boards: {problem}")


if __name__ == "__main__":
    main()
