"""kalmanq study: a study of many runs, and its page of findings."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Optional

import numpy as np
import typer
from PIL import Image
from rich.console import Console

from kalmanq.commands.messages import print_json
from kalmanq.commands.options import FRESH, JSON, WORKERS, choices, command_of
from kalmanq.data.files import require_folder, telling_where, whole
from kalmanq.data.written import write_text
from kalmanq.pages.pictures import save
from kalmanq.run.campaigns import journal_of, progress_bar, run_campaign, versions
from kalmanq_studies.heavy_tails import claims
from kalmanq_studies.heavy_tails.collected import HEADER, Collected
from kalmanq_studies.heavy_tails.figures import figures
from kalmanq_studies.heavy_tails.page import page
from kalmanq_studies.heavy_tails.perform import perform
from kalmanq_studies.heavy_tails.settings import FULL, QUICK, tasks_of

PAGE, TABLE = "README.md", "heavy_tails.csv"
COLOURS = 256  # of a picture: of fewer, some curves come out in one colour


@dataclass(frozen=True)
class Options:
    name: choices("Study", ["heavy-tails"]) = typer.Argument(..., metavar="NAME", help="heavy-tails: where the state jumps.")
    out: Path = typer.Option(..., "-o", "--out", metavar="FOLDER", help="Write the page to this folder, which must exist.")
    quick: bool = typer.Option(False, "--quick", help="Few runs, in less than a minute.")
    seed: int = typer.Option(1, "--seed", min=0, help="The same seed gives the same page.")
    workers: Optional[int] = WORKERS
    fresh: bool = FRESH
    json: bool = JSON


def run_study(options: Options, console: Console) -> None:
    require_folder(options.out)
    journal = journal_of(options.out / options.name)
    collected = collect(options, journal)
    written = write(collected, options)
    journal.unlink(missing_ok=True)
    found = list(claims.claims(collected))
    if options.json:
        return print_json({"study": options.name, "quick": options.quick, "seed": options.seed, "files": written,
                           "claims": [vars(claim) for claim in found]})
    for claim in found:
        console.print(f"{claim.said}\n  {claim.verdict}")
    console.print(f"wrote {', '.join(written)} in {options.out}")


def collect(options: Options, journal: Path) -> Collected:
    plan = QUICK if options.quick else FULL
    tasks = tasks_of(plan, options.seed)
    fingerprint = {"study": options.name, "seed": options.seed, **plan.fingerprint()}
    with progress_bar(options.name) as progress:
        results = run_campaign(perform, tasks, fingerprint=fingerprint, journal=journal, workers=options.workers,
                               progress=progress, fresh=options.fresh)
        return Collected(tasks, list(results))  # all of the work is in the campaign, which tells how to go on


def write(collected: Collected, options: Options) -> list[str]:
    """All files, or none: they are made elsewhere first."""
    with tempfile.TemporaryDirectory() as folder, telling_where(Path(folder)):
        made = Path(folder)
        for name, draw in figures().items():
            save(draw(collected), made / f"{name}.png")
            shrink(made / f"{name}.png")
        rows = list(collected.table())
        with open(made / TABLE, "w", newline="", encoding="utf-8") as text:
            write_text(text, HEADER, [np.array(column, object) for column in zip(*rows)])
        (made / PAGE).write_text(page(collected, written_by(options), versions()), encoding="utf-8")
        for path in sorted(made.iterdir()):
            with whole(options.out / path.name) as temporary:
                temporary.write_bytes(path.read_bytes())
        return sorted(path.name for path in made.iterdir())


def shrink(picture: Path) -> None:
    """To a palette: pages of a repository have small pictures."""
    Image.open(picture).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)


def written_by(options: Options) -> str:
    return f"kalmanq study {options.name}{' --quick' if options.quick else ''} --seed {options.seed} --out FOLDER"


command = command_of(Options, run_study)
