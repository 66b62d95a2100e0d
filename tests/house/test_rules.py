#!/usr/bin/env python3
"""Each rule of rules.py finds the fault that it is there for: in a copy of src/ with one line changed."""
import pathlib
import shutil
import tempfile
import unittest

from rules import House

ROOT = pathlib.Path(__file__).resolve().parents[2]


# the rule; its check; a file of src/ and one line more before its last; what is said of that
FAULTS = [
    ("a name from nowhere", "headers_alone", "model/process.h", "static int one(void) { return nowhere(); }",
     "model/process.h: does not compile alone"),
    ("a folder to the right", "layers", "model/process.h", '#include "../filter/filter.h"',
     "model/process.h: includes filter/filter.h"),
    ("a header that is not there", "layers", "model/process.h", '#include "../arithmetic/nothing.h"',
     "which is not there"),
    ("past the door", "layers", "robust/update.h", '#include "../filter/step.h"',
     "robust/update.h: includes filter/step.h, and not the door filter/filter.h"),
    ("public text behind a door", "public_files", "filter/checks.h", '#include "readings.h"',
     "includes filter/filter.h, so filter/readings.h, which defines"),
    ("an api in a header", "public_files", "robust/update.h", '#include "../filter/api.h"',
     "which is for instances"),
    ("two texts of one name", "names", "em/sums.h", "static int size_is_valid(int size) { return size; }",
     "size_is_valid is defined in"),
    ("who knows the arithmetic", "arithmetic", "filter/state.h", "#if KQ_FLOATING\nstatic int one;\n#endif",
     "filter/state.h: knows its arithmetic"),
    ("a macro that makes a name", "macros", "filter/state.h", "#define JOIN(a, b) a##b", "makes a name"),
    ("T of a private name", "macros", "filter/state.h", "static int T(other)(void) { return 0; }",
     "T(other) is no public name"),
    ("a statement in an instance", "instances", "kq_filter_f32.c", "int statement;",
     "holds a statement: int statement;"),
]


class Broken(unittest.TestCase):
    def setUp(self):
        work = tempfile.TemporaryDirectory()
        self.addCleanup(work.cleanup)
        self.root = pathlib.Path(work.name)
        for folder in ("src", "include"):
            shutil.copytree(ROOT / folder, self.root / folder)

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

    def test_a_line_more(self):
        for rule, check, name, line, what in FAULTS:
            file = self.root / "src" / name
            text = file.read_text()
            *lines, last = text.rstrip().split("\n")
            file.write_text("\n".join([*lines, line, last, ""]))
            with self.subTest(rule):
                self.found(check, what)
            file.write_text(text)

    def test_guard(self):
        file = self.root / "src/model/process.h"
        file.write_text(file.read_text().replace("KQ_SRC_MODEL_PROCESS_H", "PROCESS_H"))
        self.found("guards", "model/process.h: its guard is not")

    def test_twins_in_another_order(self):
        file = self.root / "src/model/units_q31.h"
        text = file.read_text()
        moved = text[text.index("static int sensor_is_correlated"):].split("\n")[0] + "\n"
        text = text.replace(moved, "")
        file.write_text(text.replace("#endif\n", moved + "\n#endif\n"))
        self.found("arithmetic", "model/units_float.h: sensor_is_correlated is where")

    def test_parameters_are_a_functions(self):
        """Not what is in a comment above it"""
        house = House(self.root)
        for parameters, comment, count in (9, "", 1), (8, "", 0), (8, "/* s = norm(w, g), of each row */\n", 0):
            one = ", ".join(f"int x{k}" for k in range(parameters))
            house.headers = {"model/one.h": f"{comment}static int one({one})\n{{\n    return x0;\n}}\n"}
            self.assertEqual(len(list(house.guides())), count, comment)


if __name__ == "__main__":
    unittest.main()
