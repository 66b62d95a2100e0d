#!/usr/bin/env python3
"""Each rule of manual.py finds the fault that it is there for: in a copy with one text changed."""
import pathlib
import shutil
import tempfile
import unittest

from manual import Manual

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Broken(unittest.TestCase):
    def faults(self, header="filter.h", old="", new=""):
        with tempfile.TemporaryDirectory() as work:
            root = pathlib.Path(work)
            for folder in ("src", "include"):
                shutil.copytree(ROOT / folder, root / folder)
            file = root / "include/kalmanq" / header
            self.assertIn(old, file.read_text())
            file.write_text(file.read_text().replace(old, new))
            manual = Manual(root)
            manual.check()
            return manual.faults

    def found(self, what, *change):
        faults = self.faults(*change)
        self.assertTrue(any(what in fault for fault in faults), faults)

    def test_the_tree_itself(self):
        self.assertEqual(self.faults(), [])

    def test_a_parameter_without_a_line(self):
        self.found("steady.h: kq_steady_assign_q31: no line for memory", "steady.h", " *   memory   `length` words, yours", " * Memory is yours")

    def test_parameters_that_share_a_line(self):
        self.found("kq_gain_f64: f shares a line with s", "filter.h", " *   f        read\n *   s        of n states; read\n *   K",
                   " *   f, s     read\n *   K")

    def test_a_line_for_nobody(self):
        self.found("kq_sigma_f32: has no parameter k", "filter.h", " *   i        0 .. n-1\n * NaN if f or i is bad.  Cost",
                   " *   i        0 .. n-1\n *   k        more\n * NaN if f or i is bad.  Cost")

    def test_a_status(self):
        self.found("kq_smoothed_f32: does not name KQ_ERR_SIZE", "smoother.h", "KQ_ERR_SIZE (t), KQ_ERR_NOT_READY (step t", "(step t")

    def test_a_status_of_a_call_inside(self):
        self.found("kq_diffuse_smoothed_f32: does not name KQ_ERR_MISMATCH", "diffuse.h", "KQ_ERR_MISMATCH (view is", "(view is")

    def test_an_event(self):
        self.found("kq_forget_f32: does not name KQ_EVENT_OVERFLOW", "least_squares.h", "Events: KQ_EVENT_OVERFLOW", "Events")

    def test_a_cost(self):
        self.found("kq_covariance_f32: does not say what it costs", "filter.h", "Cost: n^3/6 multiplications.", "")

    def test_a_result(self):
        self.found("kq_taken_f32: does not say what a bad argument gives", "filter.h", "read; -1 if it is bad", "read")

    def test_no_comment(self):
        self.found("kq_status_text: has no comment", "status.h", "never NULL. */\n", "never NULL. */\n\n")


if __name__ == "__main__":
    unittest.main()
