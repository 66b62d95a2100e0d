"""Tests of tools/cost.py: its files, its comparison, its reading of instructions, its errors."""

from __future__ import annotations

import math
import re
import subprocess
import sys
import tempfile
import unittest
import unittest.mock
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools" / "cost"), str(ROOT / "tools")]

import build
import command_line
import cores
import emulators
import readme
import table
from cases import CLANG, FILTER, GCC, LEAN, MODULES, NONLINEAR, REGIONS, SMALL, Choice, Own, own_programs, programs
from measure import stack_worst
from errors import UserError
from outputs import whole, write
from table import Row, Table, compare
from kalmanq.firmware.elf import LINE, Instruction, decoded
from kalmanq.firmware.emulated import Counted, most
from kalmanq.firmware.pushes import arm_push, riscv_push
from timing import m0_cycles, m3_cycles, m4_cycles, m7_cycles, rv32_cycles

ROW = Row(
    "m3", "q31", 4, 2, "runtime", "gcc-O2", "step", 1000, 1500, 400, 9000, 800, 300, 12000
)  # fmt: skip
HEADER = ",".join(table.COLUMNS)
LINE_OF_ROW = "m3,q31,4,2,runtime,gcc-O2,step,1000,1500,400,9000,800,300,12000"

# content (None: no such file), what the one line must say
BAD_TABLES = [
    (None, ["no such file"]),
    ("", ["row 1:", "no header"]),
    ("# gcc\n", ["row 2:", "no header"]),
    ("core,n\n", ["row 1:", "the columns must be"]),
    (f"# gcc\n{HEADER}\nm3,q31\n", ["row 3:", "2 fields, not 14"]),
    (f"{HEADER}\n{LINE_OF_ROW}\n{LINE_OF_ROW}\n", ["row 3:", "the same"]),
    (f"{HEADER}\n{LINE_OF_ROW.replace(',400,', ',,')}\n", ["row 2:", "stack_bytes is ''"]),
    (f"{HEADER}\n{LINE_OF_ROW.replace('1000', '-1')}\n", ["row 2:", "instructions is '-1'"]),
    (f"{HEADER}\n{LINE_OF_ROW.replace('12000', 'x')}\n", ["row 2:", "flash_program is 'x'"]),
]

BAD_COMMANDS = [
    (["--core", "m9"], "--core m9: must be one of m0, m3"),
    (["--n", "5"], "--n 5: must be one of 1, 2"),
    (["--core", "avr", "--arithmetic", "f64"], "there is nothing like that to measure"),
    (["--states", "17"], "--states 17: must be from 1 to 16"),
    (["--states", "5", "--controls", "-1"], "--controls -1: must be from 0 to 16"),
    (["--source", "nowhere"], "--source nowhere: is not a checkout"),
]

# line of objdump, timing, cycles, push, bytes
INSTRUCTIONS = [
    ("    8000:\tb5f0      \tpush\t{r4, r5, r6, r7, lr}", m3_cycles, 6, arm_push, 20),
    ("    8000:\tbdf0      \tpop\t{r4, r5, r6, r7, pc}", m0_cycles, 7, arm_push, 0),
    ("    8000:\te92d 4ff0 \tstmdb\tsp!, {r4, r5, r6, r7, r8, r9, sl, fp, lr}", m4_cycles, 10,
     arm_push, 36),
    ("    8000:\ted2d 8b10 \tvpush\t{d8-d15}", m4_cycles, 17, arm_push, 64),
    ("    8000:\tb083      \tsub\tsp, #12", m4_cycles, 1, arm_push, 12),
    ("    8000:\tf5ad 7d02 \tsub.w\tsp, sp, #520\t; 0x208", m4_cycles, 1, arm_push, 520),
    ("    8000:\t44a5      \tadd\tsp, r4", m0_cycles, 1, arm_push, None),
    ("    8000:\tf84d ed04 \tstr.w\tlr, [sp, #-4]!", m3_cycles, 1, arm_push, 4),
    ("    8000:\t6801      \tldr\tr1, [r0, #0]", m7_cycles, 1, arm_push, 0),
    ("    8000:\tfba1 2300 \tumull\tr2, r3, r1, r0", m3_cycles, 4, arm_push, 0),
    ("    8000:\tfba1 2300 \tumull\tr2, r3, r1, r0", m4_cycles, 1, arm_push, 0),
    ("    8000:\teeb1 7ac7 \tvsqrt.f32\ts14, s14", m4_cycles, 14, arm_push, 0),
    ("   10000:\t1101                \tadd\tsp,sp,-32", rv32_cycles, 1, riscv_push, 32),
    ("   10000:\t9116                \tadd\tsp,sp,t0", rv32_cycles, 1, riscv_push, None),
    ("   10000:\t6105                \taddi\tsp,sp,32", rv32_cycles, 1, riscv_push, 0),
    ("   10000:\t02b51533          \tmulh\ta0,a0,a1", rv32_cycles, 2, riscv_push, 0),
]  # fmt: skip


class Tables(unittest.TestCase):
    def test_reads_what_it_wrote(self) -> None:
        without = replace(ROW, what="predict", instructions_worst=None, flash_program=None)
        written = Table(("gcc 1", "gcc 2"), (ROW, without))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cost.csv"
            write(path, table.to_csv(written))
            self.assertEqual(table.read(path), written)
            self.assertEqual([path], list(Path(folder).iterdir()))

    def test_says_what_is_wrong(self) -> None:
        for content, words in BAD_TABLES:
            with self.subTest(content), tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "cost.csv"
                if content is not None:
                    path.write_text(content, encoding="utf-8")
                with self.assertRaises(UserError) as caught:
                    table.read(path)
                for word in [str(path), *words]:
                    self.assertIn(word, str(caught.exception))

    def test_a_failed_write_leaves_the_old_file(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cost.csv"
            path.write_text("old")
            with self.assertRaises(RuntimeError), whole(path) as temporary:
                temporary.write_text("half")
                raise RuntimeError
            self.assertEqual(path.read_text(), "old")
            self.assertEqual([path], list(Path(folder).iterdir()))


class Comparisons(unittest.TestCase):
    def test_growth_beyond_the_tolerance_fails(self) -> None:
        for column in ("instructions", "stack_bytes", "stack_worst", "flash_program"):
            grown = replace(ROW, **{column: round(getattr(ROW, column) * 1.031) + 1})
            found = compare([ROW], [grown])
            self.assertEqual([change.column for change in found.worse], [column])
            self.assertFalse(found.passes)
            self.assertTrue(compare([grown], [ROW]).passes)

    def test_a_little_growth_and_other_cycles_pass(self) -> None:
        found = compare([ROW], [replace(ROW, instructions=1030, cycles_estimate=9999)])
        self.assertTrue(found.passes)
        self.assertEqual((found.worse, found.better), ([], []))

    def test_a_figure_that_is_no_longer_measured_is_a_change(self) -> None:
        found = compare([replace(ROW, stack_worst=None)], [ROW])
        self.assertEqual([change.column for change in found.worse], ["stack_worst"])
        self.assertEqual(compare([ROW], [replace(ROW, stack_worst=None)]).better[0].now, 0)

    def test_a_missing_row_fails_either_way(self) -> None:
        self.assertEqual(compare([ROW], []).not_measured, [ROW])
        self.assertEqual(compare([], [ROW]).not_in_table, [ROW])
        self.assertFalse(compare([ROW], []).passes)
        self.assertFalse(compare([], [ROW]).passes)


class Calls(unittest.TestCase):
    def test_of_several_the_most_counts_and_the_deepest_stack(self) -> None:
        calls = [Counted(10, 80, 12), Counted(30, 64, 31), Counted(20, 96, 40)]
        self.assertEqual(most(calls), Counted(30, 96, 31))

    def test_the_smoother_is_not_in_the_stack_of_a_program_without(self) -> None:
        calls = {"step": Counted(stack=80), "hard_step": Counted(stack=90)}
        calls["filter_calls"] = Counted(stack=70)
        self.assertIsNone(stack_worst({"step": Counted(stack=80)}, "step"))
        for name in ("smooth", "hard_smooth", "smoother_calls"):
            calls[name] = Counted(stack=100 + len(name))
        self.assertEqual(stack_worst(calls, "step"), 90)
        self.assertEqual(stack_worst(calls, "smooth"), 114)
        calls["filter_calls"], calls["root_calls"] = Counted(stack=200), Counted(stack=95)
        self.assertEqual(stack_worst(calls, "roots"), 95)
        self.assertEqual(stack_worst(calls, "step"), 200)
        calls["lean"], calls["lean_calls"], calls["hard_lean"] = Counted(stack=50), Counted(stack=60), Counted(stack=300)
        self.assertEqual(stack_worst(calls, "lean"), 300)
        self.assertEqual(stack_worst(calls, "step"), 200)
        self.assertIsNone(stack_worst(calls, "predict"))

    def test_avr_counter_may_call_a_region_again(self) -> None:
        lines = ["region 3 100 120 40", "at 2 100", "region 3 90 99 44", "at 4 90"]
        found = emulators.parsed(lines)
        self.assertEqual((found[3].instructions, found[3].stack), (100, 44))
        self.assertEqual(found[3].by_address, {2: 100})


class Programs(unittest.TestCase):
    def test_marks_have_the_order_of_the_cases(self) -> None:
        text = (ROOT / "tools" / "cost" / "target" / "program.h").read_text(encoding="utf-8")
        names = re.findall(r"\bCOST_(?!KINDS)([A-Z_]+),", text)
        self.assertEqual([name.lower() for name in names], list(REGIONS))

    def test_the_filter_is_in_a_program_of_its_own(self) -> None:
        for program in programs(Choice()):
            for n, _ in program.dimensions:
                self.assertLessEqual(set(program.what(n)), set(program.group))

    def test_only_programs_with_what_is_chosen(self) -> None:
        groups = {program.group for program in programs(Choice(what=("lag",)))}
        self.assertEqual(groups, {MODULES})
        self.assertEqual({p.group for p in programs(Choice(what=("step",)))}, {FILTER})

    def test_what_is_beside_the_filter_is_measured_on_one_core_of_each_kind(self) -> None:
        taken = {(p.core, p.arithmetic) for p in programs(Choice(what=("lag",)))}
        wanted = {("m4f", "f32"), ("m7", "f64"), ("m0", "q31"), ("m3", "q31"), ("rv32", "q31")}
        self.assertEqual(taken, wanted)

    def test_nonlinear_steps_are_measured_for_flash_too(self) -> None:
        taken = {(p.core, p.arithmetic, p.profile) for p in programs(Choice(what=("extended",)))}
        wanted = {(*on, profile) for on in (("m4f", "f32"), ("m3", "q31")) for profile in (GCC, SMALL)}
        self.assertEqual(taken, wanted)
        groups = {p.group for p in programs(Choice(profile=(SMALL,)))}
        self.assertEqual(groups, {NONLINEAR})
        (q31,) = programs(Choice(("m3",), what=("extended",), profile=(GCC,)))
        self.assertNotIn("points", q31.what(4))

    def test_regions_are_those_of_the_program(self) -> None:
        (program,) = programs(Choice(("m3",), ("q31",), ("fixed",), (GCC,), (4,), ("steady",)))
        self.assertEqual(build.regions(program), {REGIONS.index("steady"): "user_steady_step_4_2"})


class Instructions(unittest.TestCase):
    def test_cycles_and_stack(self) -> None:
        for line, cycles_of, cycles, push, grows in INSTRUCTIONS:
            with self.subTest(line):
                instruction = self.read(line)
                self.assertEqual(cycles_of(instruction), cycles)
                self.assertEqual(push(instruction), grows)

    def test_an_instruction_without_operands_ends_at_its_line(self) -> None:
        text = "    8000:\tbf00      \tnop\n    8002:\t4770      \tbx\tlr\n"
        self.assertEqual([match[1] for match in LINE.finditer(text)], ["8000", "8002"])
        self.assertEqual(self.read(text), Instruction(2, "nop", ""))

    @staticmethod
    def read(line: str) -> Instruction:
        match = LINE.search(line)
        assert match is not None, line
        return decoded(match)


class Cards(unittest.TestCase):
    def test_a_line_has_all_its_figures(self) -> None:
        smooth = replace(ROW, what="smooth", ram_program=5000, stack_worst=850, flash_program=16000)
        update = replace(ROW, what="update", instructions_worst=7777)
        clang = replace(ROW, profile=CLANG, flash_program=11000)
        lean = replace(ROW, what=LEAN, instructions=1300, flash_program=7000, ram_program=100, stack_worst=400)
        (line,) = readme.cards((ROW, lean, smooth, update, clang))
        self.assertEqual(
            line.cells(),
            ["Cortex-M3", "q31", "4, 2", "12000, 11000", "", "7000", "16000", "300", "100", "5000",
             "800", "400", "850", "1000", "1300", "7777", "16 + 2 kB", "16 + 1 kB", "32 + 8 kB"],
        )  # fmt: skip
        self.assertEqual(len(line.cells()), len(readme.TITLES))
        self.assertEqual(line.short_cells()[3:], ["7000", "100", "400", "1300"])
        self.assertEqual(len(line.short_cells()), len(readme.SUMMARY_TITLES))
        self.assertEqual(list(readme.cards((ROW, update))), [])

    def test_a_part_holds_the_start_up_and_the_stack(self) -> None:
        edge = replace(ROW, flash_program=15 * 1024, ram_program=1000, stack_worst=24)
        self.assertEqual(readme.part(edge), "16 + 1 kB")
        self.assertEqual(readme.part(replace(edge, flash_program=15 * 1024 + 1)), "32 + 1 kB")
        self.assertEqual(readme.part(replace(edge, stack_worst=25)), "16 + 2 kB")
        self.assertEqual(readme.part(replace(edge, flash_program=70000)), "> 64 + 1 kB")

    def test_a_size_of_ones_own_is_measured_with_both_compilers(self) -> None:
        wanted = own_programs(Choice(("m3",), ("q31",), profile=(GCC,)), Own(5, 2, 1))
        self.assertEqual([(p.profile, p.dimensions, p.controls) for p in wanted],
                         [(GCC, ((5, 2),), 1), (CLANG, ((5, 2),), 1)])  # fmt: skip


class Readme(unittest.TestCase):
    def test_only_the_section_changes(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "README.md"
            path.write_text(f"above\n{readme.BEGIN}\nold\n{readme.END}\nbelow\n")
            text = readme.rewritten(path, (ROW,))
            self.assertTrue(text.startswith(f"above\n{readme.BEGIN}\nA real program"))
            self.assertTrue(text.endswith(f"{readme.END}\nbelow\n"))
            self.assertFalse(readme.matches(path, (ROW,)))
            path.write_text(text)
            self.assertTrue(readme.matches(path, (ROW,)))

    def test_a_function_with_all_its_figures_is_a_line(self) -> None:
        every = [
            replace(ROW, core=core, arithmetic=arithmetic, n=n, m=m, what="lag", instructions=7)
            for core, arithmetic in readme.MODULE_CORES
            for n, m in readme.MODULE_SIZES
        ]
        self.assertIn("L = 10 | 7 | 7 | 7 | 7 | 7 | 7 |\n", readme.section((*every, ROW)) + "\n")
        self.assertNotIn("L = 10", readme.section(tuple(every[1:])))
        of_one_core = readme.section(tuple(every[: len(readme.MODULE_SIZES)]))
        self.assertIn("L = 10 | 7 | 7 | 7 |  |  |  |\n", of_one_core + "\n")

    def test_the_short_table_has_the_figures_of_the_cards(self) -> None:
        rows = [
            replace(ROW, core="m0", what=what, flash_program=flash, instructions_worst=1)
            for what, flash in (("step", 12000), (LEAN, 7000), ("smooth", 1), ("update", 1))
        ]
        lines = readme.summary(tuple(rows)).splitlines()
        self.assertEqual(len(lines), 3)
        self.assertIn("| Cortex-M0 | q31 | 4, 2 | 7000 | 300 | 800 | 1000 |", lines[2])

    def test_every_function_has_a_line(self) -> None:
        named = {what for what, _, _ in readme.MODULE_ROWS}
        self.assertLessEqual({*MODULES, *NONLINEAR}, named)

    def test_without_its_marks_it_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "README.md"
            path.write_text(f"{readme.END}\n{readme.BEGIN}\n")
            with self.assertRaises(UserError):
                readme.rewritten(path, (ROW,))


class Headers(unittest.TestCase):
    def test_the_dearest_update_is_as_the_header_says(self) -> None:
        """Of all cores, rounded up"""
        rows = [row for row in table.read(ROOT / "tools" / "cost.csv").rows if row.what == "update" and row.instructions_worst]
        header = (ROOT / "include/kalmanq/filter.h").read_text(encoding="utf-8").replace("\n *", "")
        for arithmetic in ("f32", "q31"):
            comment = header[: header.index(f"kq_status kq_update_{arithmetic}(")].rpartition("/**")[2]
            said = re.search(r"up to (\d+) times as much at n = 2, (\d+) times at n = 9 .instructions_worst", comment)
            shares = [(row.n, row.instructions_worst / row.instructions) for row in rows if row.arithmetic == arithmetic]
            dearest = [math.ceil(max(share for n, share in shares if n in sizes)) for sizes in ((1, 2), (9,))]
            self.assertIsNotNone(said, comment)
            self.assertEqual([int(one) for one in said.groups()], dearest)


    def test_an_adaptation_takes_so_many_steps(self) -> None:
        """Of the cores that the page shows"""
        of = {row.key: row.instructions for row in table.read(ROOT / "tools" / "cost.csv").rows if row.profile == GCC}
        shares = [count / of[(*key[:-1], "step")] for key, count in of.items() if key[-1] == "adapted"]
        header = (ROOT / "include/kalmanq/adaptation.h").read_text(encoding="utf-8").replace("\n *", "")
        self.assertIn(f"Both take {math.floor(min(shares))} to {math.ceil(max(shares))} times a kq_step (tools/cost/README.md)", header)

    def test_the_page_of_tests_has_the_steps_of_the_table(self) -> None:
        steps = {(row.n, row.m): row.instructions for row in table.read(ROOT / "tools" / "cost.csv").rows
                 if (row.core, row.arithmetic, row.sizes, row.profile, row.what) == ("m3", "q31", "runtime", GCC, "step")}  # fmt: skip
        page = (ROOT / "tests/README.md").read_text(encoding="utf-8")
        self.assertIn(f"Cortex-M3: {steps[2, 1]}, {steps[4, 2]}, {steps[9, 3]} instructions against", page)


class Compilers(unittest.TestCase):
    VERSIONS = ("arm-none-eabi-gcc (15:12.2.rel1-1) 12.2.1 20221205", "avr-gcc (GCC) 5.4.0", "Debian clang version 14.0.6")

    def reason(self, *said: str) -> str:
        with unittest.mock.patch.object(cores, "compilers", lambda *_: said):
            return cores.incomparable(self.VERSIONS)

    def test_figures_of_another_major_version_are_skipped(self) -> None:
        self.assertEqual(self.reason("arm-none-eabi-gcc (Arm GNU Toolchain 12.3.Rel1) 12.3.1 20230626", "Ubuntu clang version 14.0.0-1ubuntu1"), "")
        self.assertEqual(self.reason(*self.VERSIONS[:2], "clang version 15.0.7"),
                         "skipped: figures are of clang 14, not of clang version 15.0.7")
        self.assertIn("of arm-none-eabi-gcc 12, not of arm-none-eabi-gcc (15:13.2.rel1-2) 13.2.1",
                      self.reason("arm-none-eabi-gcc (15:13.2.rel1-2) 13.2.1 20231009"))

    def test_so_are_figures_without_a_compiler(self) -> None:
        with unittest.mock.patch.object(cores, "compilers", side_effect=UserError("avr-gcc: No such file or directory")):
            self.assertEqual(cores.incomparable(self.VERSIONS), "skipped: figures are of cross compilers: avr-gcc: No such file or directory")


class Kept(unittest.TestCase):
    def test_the_table_has_the_rows_that_are_kept_and_no_others(self) -> None:
        """Whatever can be measured of them"""
        measurable = {
            (p.core, p.arithmetic, n, m, p.sizes, p.profile, what)
            for p in programs(Choice())
            for n, m in p.dimensions
            for what in p.what(n)
        }
        rows = table.read(ROOT / "tools" / "cost.csv").rows
        self.assertEqual({row.key for row in rows}, readme.kept() & measurable)

    def test_programs_of_the_table_have_its_sizes_alone(self) -> None:
        every = command_line.of_kept(programs(Choice()))
        kept = {(p.core, p.arithmetic, p.sizes, p.profile, p.group): p.dimensions for p in every}
        self.assertEqual(kept["m0", "f32", "runtime", CLANG, FILTER], readme.CARD_SIZES)
        self.assertEqual(kept["m3", "q31", "runtime", SMALL, NONLINEAR], readme.NONLINEAR_SIZES)
        self.assertNotIn(("m0", "textbook-f32", "runtime", GCC, FILTER), kept)


class Commands(unittest.TestCase):
    def test_every_row_is_measured_once(self) -> None:
        keys = [
            (p.core, p.arithmetic, p.sizes, p.profile, size, what)
            for p in programs(Choice())
            for size in p.dimensions
            for what in p.what(size[0])
        ]
        self.assertEqual(len(keys), len(set(keys)))

    def test_what_is_wrong_is_one_line(self) -> None:
        for arguments, line in BAD_COMMANDS:
            with self.subTest(arguments):
                done = subprocess.run(
                    [sys.executable, str(ROOT / "tools" / "cost.py"), *arguments],
                    capture_output=True, text=True, check=False,
                )  # fmt: skip
                self.assertEqual(done.returncode, 1)
                self.assertEqual(done.stdout, "")
                self.assertTrue(done.stderr.startswith(f"cost: {line}"), done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
