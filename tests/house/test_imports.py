#!/usr/bin/env python3
"""Each rule of imports.py finds the fault that it is there for: with one line more in a module."""
import pathlib
import unittest

from imports import Imports

ROOT = pathlib.Path(__file__).resolve().parents[2]


# the rule; its check; a module and one line more at its end; what is said of that
FAULTS = [
    ("upwards", "order", "kalmanq.model.model", "from kalmanq.run.filters import Filter", "run.filters, which is not"),
    ("upwards inside a function", "order", "kalmanq.firmware.reach",
     "def late():\n    from kalmanq.commands import run", "commands.run, which is not"),
    ("beside", "order", "kalmanq.run.filters", "import kalmanq.formulas.graph", "formulas.graph, which is not"),
    ("the package knows no studies", "order", "kalmanq.commands.run", "import kalmanq_studies.gallery",
     "gallery, which is not before"),
    ("studies are below the commands", "order", "kalmanq_studies.lectures.smoothing",
     "from kalmanq.commands import simulate", "simulate, which is not"),
    ("studies are below their commands", "order", "kalmanq_studies.gallery",
     "from kalmanq_studies.commands import gallery", "gallery, which is not"),
    ("a name from nowhere", "order", "kalmanq.run.steady", "import kalmanq.nothing", "there is no kalmanq.nothing"),
    ("a folder without a place", "order", "kalmanq.elsewhere", "", "elsewhere has no place"),
    ("the extension is the core's", "order", "kalmanq.run.steady", "from kalmanq._core import lib",
     "_core, which is not"),
    ("a circle", "circles", "kalmanq.run.parts", "from kalmanq.run import filters", "imports itself by"),
]


class Broken(unittest.TestCase):
    def test_the_packages_themselves(self):
        house = Imports(ROOT)
        for check in ("order", "circles", "names"):
            getattr(house, "check_" + check)()
        self.assertEqual(house.faults, [])

    def test_each_rule(self):
        for rule, check, module, line, what in FAULTS:
            with self.subTest(rule):
                house = Imports(ROOT)
                house.texts[module] = house.texts.get(module, "") + "\n" + line + "\n"
                getattr(house, "check_" + check)()
                self.assertTrue(any(what in fault for fault in house.faults), house.faults)

    def test_a_name_in_one_list(self):
        house = Imports(ROOT)
        house.texts["kalmanq"] = house.texts["kalmanq"].replace("SteadyFilter SteadyState", "SteadyState")
        house.check_names()
        self.assertEqual(house.faults, [
            "kalmanq: kalmanq.run.steady.SteadyFilter is in one list of names and not in the other"])


if __name__ == "__main__":
    unittest.main()
