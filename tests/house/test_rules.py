#!/usr/bin/env python3
"""Each rule of rules.py finds the fault that it is there for: in a copy of src/ with one line changed."""
import pathlib
import shutil
import tempfile
import unittest

from rules import House

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Broken(unittest.TestCase):
    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.root = pathlib.Path(work.name)
        for folder in ("src", "include"):
            shutil.copytree(ROOT / folder, self.root / folder)

    def add(self, name, line):
        """One more line in a file of src/, before its last line"""
        file = self.root / "src" / name
        lines = file.read_text().rstrip().split("\n")
        file.write_text("\n".join([*lines[:-1], line, lines[-1], ""]))

    def faults(self, check):
        house = House(self.root)
        if check == "headers_alone":  # of one header: rules.py compiles all of them
            house.headers = {name: house.headers[name] for name in ("model/process.h",)}
        getattr(house, "check_" + check)()
        return house.faults

    def found(self, check, what):
        self.assertTrue(any(what in fault for fault in self.faults(check)), self.faults(check))

    def test_the_tree_itself(self):
        for check in ("guards", "layers", "public_files", "names", "arithmetic", "macros", "instances"):
            self.assertEqual(self.faults(check), [])

    def test_guard(self):
        file = self.root / "src/model/process.h"
        file.write_text(file.read_text().replace("KQ_SRC_MODEL_PROCESS_H", "PROCESS_H"))
        self.found("guards", "model/process.h: its guard is not")

    def test_a_name_from_nowhere(self):
        self.add("model/process.h", "static int one(void) { return nowhere(); }")
        self.found("headers_alone", "model/process.h: does not compile alone")

    def test_a_folder_to_the_right(self):
        self.add("model/process.h", '#include "../filter/filter.h"')
        self.found("layers", "model/process.h: includes filter/filter.h")

    def test_a_header_that_is_not_there(self):
        self.add("model/process.h", '#include "../arithmetic/nothing.h"')
        self.found("layers", "which is not there")

    def test_past_the_door(self):
        self.add("robust/update.h", '#include "../filter/step.h"')
        self.found("layers", "robust/update.h: includes filter/step.h, and not the door filter/filter.h")

    def test_public_text_behind_a_door(self):
        self.add("filter/checks.h", '#include "readings.h"')
        self.found("public_files", "includes filter/filter.h, so filter/readings.h, which defines")

    def test_an_api_in_a_header(self):
        self.add("robust/update.h", '#include "../filter/api.h"')
        self.found("public_files", "which is for instances")

    def test_two_texts_of_one_name(self):
        self.add("em/sums.h", "static int size_is_valid(int size) { return size; }")
        self.found("names", "size_is_valid is defined in")

    def test_who_knows_the_arithmetic(self):
        self.add("filter/state.h", "#if KQ_FLOATING\nstatic int one;\n#endif")
        self.found("arithmetic", "filter/state.h: knows its arithmetic")

    def test_twins_in_another_order(self):
        file = self.root / "src/model/units_q31.h"
        text = file.read_text()
        moved = text[text.index("static int sensor_is_correlated"):].split("\n")[0] + "\n"
        text = text.replace(moved, "")
        file.write_text(text.replace("#endif\n", moved + "\n#endif\n"))
        self.found("arithmetic", "model/units_float.h: sensor_is_correlated is where")

    def test_a_macro_that_makes_a_name(self):
        self.add("filter/state.h", "#define JOIN(a, b) a##b")
        self.found("macros", "makes a name")

    def test_t_of_a_private_name(self):
        self.add("filter/state.h", "static int T(other)(void) { return 0; }")
        self.found("macros", "T(other) is no public name")

    def test_a_statement_in_an_instance(self):
        self.add("kq_filter_f32.c", "int statement;")
        self.found("instances", "holds a statement: int statement;")


if __name__ == "__main__":
    unittest.main()
