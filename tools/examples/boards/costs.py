"""What an example costs in each way, by the emulators of tools/cost, and the tables of the pages."""
from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Sequence

from examples import BOARDS, EXAMPLES, HERE, NAMED
from job import ROOT, Job, counted_as
from texts import BoardError, table


@dataclass(frozen=True)
class Cost:
    """Bytes more than a program without a filter; instructions: of all calls, over the rows"""

    flash: int
    ram: int
    stack: int
    instructions: int


Libraries = dict[tuple[str, str], list[Path]]  # objects, by core and arithmetic


def cost_of(job: Job, libraries: Libraries) -> Cost:
    sys.path.insert(0, str(ROOT / "tools" / "cost"))
    import build
    from cores import BY_NAME
    from emulators import count_program
    from kalmanq.firmware.elf import flash_and_ram

    place, core = build.Place(ROOT, job.folder), BY_NAME[counted_as(job.core)]
    made = objects_of(job, place, core, libraries)
    program = build.linked(core, [*made["own"], *made["counted"]], job.folder / "cost.elf")
    if core.family == "avr":
        build.avr_counter(place)
    counted = count_program(core, program, {0: "example"}, place.avr_counter)[0]
    with_it, without = (flash_and_ram(build.linked(core, made[name], job.folder / f"{name}.elf", entry="example")) for name in ("own", "nothing"))
    rows = len(next(iter(table(job.data).values())))
    return Cost(with_it[0] - without[0], with_it[1] - without[1], counted.stack, round(counted.instructions / rows))


def objects_of(job: Job, place: Any, core: Any, libraries: Libraries) -> dict[str, list[Path]]:
    """Of the example with its filter; of the same program without one; of what counts"""
    import build

    flags = (f"-I{job.folder}", f"-I{HERE}", f"-I{ROOT / 'src' / 'fixed_size'}", "-ffp-contract=off", "-DCOUNTED", "-Dmain=example")

    def made(source: Path, *flags: str, is_user: bool = True) -> Path:
        target = job.folder / f"cost_{source.stem}.o"
        build.compiled(place, core, build.GCC, source, target, flags, is_user=is_user)
        return target

    key = (core.name, job.T)
    if job.library() and key not in libraries:
        libraries[key] = [made(source, "-ffp-contract=off", is_user=False) for source in job.library()]
    own = [made(HERE / job.name / "main.c", *flags), made(job.source, *flags), *(libraries[key] if job.library() else [])]
    return {"own": own, "nothing": [made(HERE / "nothing.c", *flags)], "counted": [made(HERE / "counted.c"), made(build.MARKS)]}


BEGIN, END = "<!-- costs: written by boards.py costs --write -->\n", "<!-- end of costs -->\n"


def page_of(costs: dict[Job, Cost]) -> str:
    """The table of an example's page"""
    lines = ["| board | filter | flash | RAM | stack | instructions a row |", "|---|---|--:|--:|--:|--:|"]
    for job, cost in costs.items():
        way, _, more = job.way.partition(" ")
        named = ", ".join([NAMED[way], *([more] if more not in ("", job.T) else []), job.T])
        lines.append(f"| {BOARDS[job.core]} | {named} | {cost.flash} | {cost.ram} | {cost.stack} | {cost.instructions} |")
    return "\n".join([*lines, ""])


def overview(costs: dict[Job, Cost], before: str) -> str:
    """Of the way that each example is written for; before: the table that is there, for those that are not measured now"""
    made = {(job.name, job.core): f"{NAMED[job.way]}, {job.T} | {cost.flash} | {cost.ram} | {cost.instructions} | [picture]({job.name}/picture.png) |"
            for job, cost in costs.items() if job.way == next(iter(job.example.ways))}
    lines = ["| example | board | filter | flash | RAM | instructions a row | picture |", "|---|---|---|--:|--:|--:|---|"]
    for name, example in EXAMPLES.items():
        for core in example.boards:
            begin = f"| [{name}]({name}/README.md) | {BOARDS[core]} | "
            kept = [line.removeprefix(begin) for line in before.splitlines() if line.startswith(begin)]
            lines += [begin + one for one in ([made[name, core]] if (name, core) in made else kept)]
    return "\n".join([*lines, ""])


def settle(page: Path, table_of: Callable[[str], str], check: bool, write: bool) -> None:
    """Writes the table to its page, or finds that it is there; table_of: by the one that is there"""
    text = page.read_text(encoding="utf-8")
    begin, end = text.find(BEGIN) + len(BEGIN), text.find(END)
    if end < begin:
        raise BoardError(f"{page}: has no place for the costs: {BEGIN.strip()}")
    made = table_of(text[begin:end])
    if check and text[begin:end] != made:
        raise BoardError(f"{page}: says other costs than are measured now: boards.py costs --write")
    if write:
        page.write_text(text[:begin] + made + text[end:], encoding="utf-8")


def unlike_the_pages(jobs: Sequence[Job]) -> str:
    """Why figures of their compilers are not compared here, if they are not: those of tools/cost.csv"""
    sys.path.insert(0, str(ROOT / "tools" / "cost"))
    import table as cost_table
    from cores import BY_NAME, incomparable

    cores = {counted_as(job.core): None for job in jobs}
    return incomparable(cost_table.read(ROOT / "tools" / "cost.csv").versions, [BY_NAME[core] for core in cores], with_clang=False)


def costs(jobs: Sequence[Job], check: bool, write: bool) -> None:
    if check and (reason := unlike_the_pages(jobs)):
        return print(reason)
    libraries: Libraries = {}
    every: dict[Job, Cost] = {}
    for name in dict.fromkeys(job.name for job in jobs):
        made = {}
        for job in (one for one in jobs if one.name == name):
            job.prepare()
            made[job] = cost_of(job, libraries)
        print(page_of(made), flush=True)
        settle(HERE / name / "README.md", lambda _: page_of(made), check, write)
        every.update(made)
    settle(HERE / "README.md", lambda before: overview(every, before), check, write)
