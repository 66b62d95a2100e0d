#!/usr/bin/env python3
"""Each rule of imports.py finds the fault that it is there for: with one line more in a module."""
import pathlib
import unittest

from imports import Imports

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Broken(unittest.TestCase):
    def found(self, check, module, line, what):
        """With one line more at the end"""
        house = Imports(ROOT)
        house.texts[module] = house.texts.get(module, "") + "\n" + line + "\n"
        getattr(house, "check_" + check)()
        self.assertTrue(any(what in fault for fault in house.faults), house.faults)

    def test_the_packages_themselves(self):
        house = Imports(ROOT)
        for check in ("order", "circles", "names"):
            getattr(house, "check_" + check)()
        self.assertEqual(house.faults, [])

    def test_upwards(self):
        self.found("order", "kalmanq.model.model", "from kalmanq.run.filters import Filter", "run.filters, which is not")

    def test_upwards_inside_a_function(self):
        self.found("order", "kalmanq.firmware.reach", "def late():\n    from kalmanq.commands import run",
                   "commands.run, which is not")

    def test_beside(self):
        self.found("order", "kalmanq.run.filters", "import kalmanq.formulas.graph", "formulas.graph, which is not")

    def test_the_package_knows_no_studies(self):
        self.found("order", "kalmanq.commands.run", "import kalmanq_studies.gallery", "gallery, which is not before")

    def test_studies_are_below_the_commands(self):
        self.found("order", "kalmanq_studies.lectures.smoothing", "from kalmanq.commands import simulate", "simulate, which is not")
        self.found("order", "kalmanq_studies.gallery", "from kalmanq_studies.commands import gallery", "gallery, which is not")

    def test_a_name_from_nowhere(self):
        self.found("order", "kalmanq.run.steady", "import kalmanq.nothing", "there is no kalmanq.nothing")

    def test_a_folder_without_a_place(self):
        self.found("order", "kalmanq.elsewhere", "", "elsewhere has no place")

    def test_the_extension_is_the_core_s(self):
        self.found("order", "kalmanq.run.steady", "from kalmanq._core import lib", "_core, which is not")

    def test_a_circle(self):
        self.found("circles", "kalmanq.run.parts", "from kalmanq.run import filters", "imports itself by")

    def test_a_name_in_one_list(self):
        house = Imports(ROOT)
        house.texts["kalmanq"] = house.texts["kalmanq"].replace("SteadyFilter SteadyState", "SteadyState")
        house.check_names()
        self.assertEqual(house.faults, [
            "kalmanq: kalmanq.run.steady.SteadyFilter is in one list of names and not in the other"])


if __name__ == "__main__":
    unittest.main()
