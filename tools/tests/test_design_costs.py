"""What a design costs on a core is what was counted of its C there, whose words are the twin's; or "-", with the reason."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Optional, Sequence

import five
import numpy as np
import pytest
from command import in_two_processes, json_of, kalmanq
from library import EXAMPLES, ROOT, failing_gcc, host_alone, saved
from models import LATE
from random_models import random_model
from whole import MEASURED, WHOLE, first

from kalmanq import Model, Quantity
from kalmanq.compiler.report.design_costs import costs_of, design_of
from kalmanq.compiler.text.over_library import bytes_of_delays, source, ways_of
from kalmanq.firmware import costs
from kalmanq.firmware.cores import BY_NAME, Core
from kalmanq.firmware.costs import Cost, Design, is_offered
from kalmanq.firmware.designs import PARTS, Part, design
from kalmanq.firmware.elf import Elf
from kalmanq.firmware.measured import NO_EMULATOR, compiler
from kalmanq.firmware.ranges import with_ranges
from kalmanq.firmware.reach import draw
from kalmanq.model import Gaps, model_file
from kalmanq.run.parts import Parts

pytestmark = MEASURED

CORES = ("m3", "m0", "m4f", "m7", "m33", "rv32")
LARGE = replace(BY_NAME["avr"], gcc=("avr-gcc", "-mmcu=atmega1284p"),  # which simavr runs, with all RAM that AVR has
                link_flags=("-Wl,--defsym=__DATA_REGION_LENGTH__=0xFF00,--defsym=__stack=0xFFFF",))


def designs_of(model: Model, core: str, most: Optional[int] = None) -> list[Design]:
    """In each way, or so many of each arithmetic"""
    record = draw(model.changed(gaps=Gaps()), 32, seeds=[1])[0]
    made = []
    for arithmetic in ("f32", "q31"):
        for way in [one for one in ways_of(model) if is_offered(core, arithmetic, one)][:most]:
            parts = Parts(model, arithmetic, way)
            made.append(design_of(parts, way, source(parts, way, "made"), record))
    return made


def is_whole(found: Sequence[tuple[Cost, str]]) -> None:
    assert found and all(not why and min(one.instructions, one.flash, one.ram, one.stack) > 0 for one, why in found), found


# ------------------------------------------------------------------------------ the words


@pytest.mark.parametrize("make", five.FIVE)
@pytest.mark.parametrize("core, most", [("m4f", 1), *(pytest.param(core, None, marks=WHOLE) for core in CORES)])
def test_a_design_comes_to_the_twin_s_words_on_its_core(make, core: str, most: Optional[int]) -> None:
    """target/design.c compares them, or there is no cost"""
    is_whole(costs.costs(BY_NAME[core], designs_of(make(), core, most)))


def test_other_words_are_no_cost() -> None:
    (one, *_) = designs_of(five.level(), "m4f", 1)
    head, mark, words = one.texts["cost-calls.h"].partition("expected[ROWS][N] = {{")
    assert mark
    ((cost, why),) = costs.costs(BY_NAME["m4f"], [replace(one, texts={**one.texts, "cost-calls.h": f"{head}{mark}0.5f}}, {{1.5f}}, {{{words}"})])
    assert cost == Cost() and why == "main.elf: a call answered -100"


@WHOLE
@pytest.mark.parametrize("make", five.FIVE)
def test_on_avr_as_well(make, tmp_path: Path) -> None:
    counter = tmp_path / "avr_count"
    subprocess.run(["cc", "-std=gnu11", "-O2", str(ROOT / "port/boards/avr_count.c"), "-lsimavr", "-o", str(counter)], check=True)
    for one in designs_of(make(), "avr"):
        program = costs.Programs(LARGE, tmp_path, one, library_of(LARGE, tmp_path, one.arithmetic)).linked("main")
        places = [Elf(program).address(name) for name in ("_end", "cost_region", "cost_failed", "cost_end", *costs.regions(one).values())]
        done = subprocess.run([str(counter), str(program), *map(str, places)], capture_output=True, text=True)
        assert done.stdout.splitlines()[-1:] == ["end"], (one.way, done.stdout[-200:], done.stderr)


def library_of(core: Core, folder: Path, arithmetic: str) -> list[Path]:
    made = sorted((folder / arithmetic).glob("*.o")) if (folder / arithmetic).exists() else []
    return made or costs.compiled_library(core, folder, arithmetic)


# ------------------------------------------------------------------------------ the figures


def test_an_avr_has_flash_and_ram() -> None:
    found = costs.costs(BY_NAME["avr"], designs_of(five.attitude(), "avr"))
    assert len(found) == 6 and all(why == NO_EMULATOR and cost.instructions is cost.stack is None for cost, why in found)
    for lean, tables, init in (found[:3], found[3:]):  # of f32, of q31
        assert 8000 < lean[0].flash < tables[0].flash < init[0].flash < 60_000 and 500 < lean[0].ram <= init[0].ram < 2500, found


@pytest.mark.parametrize("seed", first(1, range(20)))
def test_figures_come_for_models_of_any_kind(seed: int) -> None:
    random = np.random.default_rng(seed)
    model = random_model(random, seed % 8 + 1, int(random.integers(1, min(seed % 8 + 1, 4) + 1)))
    bounded = model.changed(controls=[Quantity(one.name, range=1.0) for one in model.controls]) if model.l else model
    ranged = with_ranges(bounded, draw(bounded))[0]
    is_whole(costs_of(ranged, "m4f", [(arithmetic, way) for arithmetic in ("f32", "q31") for way in ways_of(ranged)]))


def test_what_comes_late_is_counted(tmp_path: Path) -> None:
    for name, text in {"late": LATE, "timely": LATE.replace("delay = 3", "")}.items():
        (tmp_path / f"{name}.toml").write_text(text)
    late, timely = (with_ranges(model_file.read(tmp_path / f"{name}.toml"), [])[0] for name in ("late", "timely"))
    for way in (("f32", "lean"), ("q31", "lean")):
        ((more, _), (less, _)) = (costs_of(model, "m4f", [way])[0] for model in (late, timely))
        assert 0 <= less.ram + bytes_of_delays(late, way[0]) - more.ram <= 24 and more.instructions > 1.4 * less.instructions
        assert more.flash > less.flash + 300
        assert more.stack > less.stack or way[0] == "q31"  # there the timely one's deepest call is a measurement that says little


@pytest.mark.parametrize("more, way", [({"any_dt": True}, ("f32", "init")), ({"steps": 4}, ("q31", "tables"))])
def test_longer_steps_are_counted(more: dict, way: tuple[str, str], tmp_path: Path) -> None:
    path = saved(tmp_path / "cart.toml",
                 "[model]\nF = [[0.0, 1.0], [0.0, -0.5]]\nQc = [0.0, 0.3]\ndt = 0.1\nH = [1.0, 0.0]\nR = 0.04\nP0 = [4.0, 1.0]\n"
                 "[states]\nranges = [100, 10]\n[measurements]\nranges = [100]\n")
    model = with_ranges(model_file.read(path), [])[0]
    (plain, longer) = (costs_of(model, "m4f", [way], **one)[0] for one in ({}, more))
    is_whole([plain, longer])
    assert longer[0].flash > plain[0].flash + 50


@pytest.mark.parametrize("core", first(2, ("m4f", "avr", "m0", *sorted({*PARTS} - {"m4f", "avr", "m0"}))))
def test_the_command_writes_a_filter(core, tmp_path):
    """Of the M4F with the same figures in two processes"""
    command = "design", EXAMPLES / "track.toml", "--core", core, "--flash", 512, "-o", tmp_path
    told, *again = in_two_processes(*command) if core == "m4f" else [json_of(*command)]
    assert all(one["ways"] == told["ways"] and len(one["ways"]) == 10 for one in again)
    others = ["track_report.txt", "track_test.c"] if told["chosen"]["way"] == "compiled" else []
    assert sorted(path.name for path in tmp_path.iterdir()) == ["track.c", "track.h", *others]
    assert {one["arithmetic"] for one in told["ways"]} == {"f32", "q31"}
    for one in told["ways"]:
        if core == "avr":  # no emulator
            assert one["instructions"] is one["stack"] is one["fits"] is None and one["not_measured"] == NO_EMULATOR
            assert "flags" not in one if one["way"] == "compiled" else one["flash"] > 0 and one["ram"] > 0
            continue
        assert one["instructions"] > 0 and one["flash"] > 0 and one["fits"]
        if one["way"] == "compiled":
            assert "gcc" in one["flags"] and "-ffp-contract" in one["flags"] and "include" not in one
        else:
            assert one["flags"] == costs.flags(core) and one["include"] == costs.include_path(core, one["way"])


# ------------------------------------------------------------------------------ what they are said with, and why there are none


@pytest.mark.parametrize("core", costs.CORES)
def test_the_flags_are_those_of_the_tests(core: str) -> None:
    described = subprocess.run(["sh", str(ROOT / "tests/target/cores.sh"), "describe", core, "gcc"], check=True, capture_output=True, text=True).stdout
    of = dict(line.split("=", 1) for line in described.splitlines())
    level = set() if core == "avr" else {"-O2"}
    assert {*of["user_profile"].split(), "-ffp-contract=off", *level} == set(costs.flags(core).split())
    assert set(of["profile"].split()) == {*of["user_profile"].split(), costs.COMPACT}
    assert costs.folders(core, "sizes") == [*([f"port/{of['port']}"] if of["port"] else []), "include", "src/fixed_size"]


def test_every_cost_says_its_flags(tmp_path: Path) -> None:
    done = kalmanq("design", EXAMPLES / "track.toml", "--core", "m4f", "--way", "init", "-o", tmp_path)
    printed, header = " ".join(done.stdout.split()), (tmp_path / "track.h").read_text()
    comment = " ".join(header[: header.index("*/")].replace(" * ", " ").split())
    for text in (printed, comment):
        assert f"{compiler(BY_NAME['m4f'])} {costs.flags('m4f')}" in text and "-Iport/armv7m -Iinclude" in text and costs.COMPACT in text


def test_without_a_compiler_the_reason_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path / "level.toml", model_file.text_of(five.level()))
    monkeypatch.setenv("PATH", host_alone(tmp_path))
    for core, gcc in (("m3", "arm-none-eabi-gcc"), ("avr", "avr-gcc")):
        said = f"{gcc} was not found: `kalmanq doctor` says how to get it"
        done = kalmanq("design", path, "--core", core, "-o", tmp_path)
        told = json_of("design", path, "--core", core)
        assert done.returncode == 0 and f"-: {said}" in " ".join(done.stdout.split()), done.stderr
        assert f"- instructions a step, - bytes of flash and - of RAM" in (tmp_path / "level.h").read_text()
        for one in told["ways"]:
            assert [one[name] for name in ("instructions", "flash", "ram", "stack", "fits")] == [None] * 5
            assert one["not_measured"] == (said if core == "m3" or one["way"] != "compiled" else NO_EMULATOR)
        assert told["chosen"] == {"arithmetic": "f32", "way": "lean"}  # which depends on no figure


def test_the_package_has_the_library_s_sources() -> None:
    """The wheel has them by tools/CMakeLists.txt"""
    of = [path.relative_to(ROOT) for folder in ("include", "src", *(f"port/{one}" for one in {*costs.PORTS.values()})) for path in (ROOT / folder).rglob("*.[ch]")]
    assert len(of) > 200 and all((costs.library() / one).read_bytes() == (ROOT / one).read_bytes() for one in of)


def test_without_the_sources_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(costs, "library", lambda: tmp_path)
    assert costs.costs(BY_NAME["m3"], designs_of(five.level(), "m3", 1)) == [
        (Cost(), f"the library's sources are not in {tmp_path}: install kalmanq again")] * 2


def test_a_compiler_that_fails_is_told_in_a_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", failing_gcc(tmp_path), prepend=":")
    assert costs.costs(BY_NAME["m3"], designs_of(five.level(), "m3", 1)) == [(Cost(), "arm-none-eabi-gcc: cannot find -lc")] * 2


def test_a_model_that_leaves_its_ranges_has_no_figures() -> None:
    model = Model(1, H=1, R=1, Q=1, P0=1, states=[Quantity("x", range=1)], measurements=[Quantity("z", range=1)])
    assert costs_of(model, "m3", [("f32", "lean")]) == [(Cost(), "each record that is drawn of the model leaves its ranges within 16 rows")]


def test_where_no_cost_is_known_the_choice_depends_on_no_figure() -> None:
    """Flash and RAM that are known may rule a way out"""
    model = five.track()

    def chosen(part: Part, cost: Cost):
        return design(model, part, draw(model), prices=lambda ways: [(cost, "unknown")] * len(ways)).chosen()

    one = chosen(Part("m3", 1 << 16, 1 << 12), Cost())
    assert (one.arithmetic, one.way, one.fits) == ("f32", "lean", None)
    assert chosen(Part("m3", 1 << 16, 1 << 12), Cost(flash=30_000, ram=300)).fits is None
    assert chosen(Part("m3", 1 << 16, 1 << 12), Cost(flash=30_000, ram=5000)) is None
    assert chosen(Part("m3", 1 << 14, 1 << 12), Cost(flash=30_000, ram=300)) is None
    assert chosen(Part("m3", 1 << 16, 1 << 12), Cost(100, 30_000, 300, 200)).fits is True
