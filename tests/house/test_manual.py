#!/usr/bin/env python3
"""Each rule of manual.py finds the fault, or has the advice, that it is there for: in a copy with one text changed."""
import pathlib
import shutil
import tempfile
import unittest

from manual import Manual

ROOT = pathlib.Path(__file__).resolve().parents[2]


# the rule; what is said of it; the header; what stands there, and in its place
FAULTS = [
    ("a parameter without a line", "steady.h: kq_steady_assign_q31: no line for memory", "steady.h",
     " *   memory   `length` words, yours", " * Memory is yours"),
    ("a status", "kq_smoothed_f32: does not name KQ_ERR_SIZE", "smoother.h",
     "KQ_ERR_SIZE (t), KQ_ERR_NOT_READY (step t", "(step t"),
    ("a status of a call inside", "kq_diffuse_smoothed_f32: does not name KQ_ERR_MISMATCH", "diffuse.h",
     "KQ_ERR_MISMATCH (view is", "(view is"),
    ("an event", "kq_forget_f32: does not name KQ_EVENT_OVERFLOW", "least_squares.h",
     "Events: KQ_EVENT_OVERFLOW", "Events"),
    ("no comment", "kq_status_text: has no comment", "status.h", "never NULL. */\n", "never NULL. */\n\n"),
]
ADVICE = [
    ("parameters that share a line", "kq_gain_f64: f shares a line with s", "filter.h",
     " *   f        read\n *   s        of n states; read\n *   K", " *   f, s     read\n *   K"),
    ("a line for nobody", "kq_sigma_f32: has no parameter k", "filter.h",
     " *   i        0 .. n-1\n * NaN if f or i is bad.  Cost",
     " *   i        0 .. n-1\n *   k        more\n * NaN if f or i is bad.  Cost"),
    ("a cost", "kq_covariance_f32: does not say what it costs", "filter.h",
     "Cost: n^3/6 multiplications.", ""),
    ("a result", "kq_taken_f32: does not say what a bad argument gives", "filter.h",
     "read; -1 if it is bad", "read"),
]


class Broken(unittest.TestCase):
    def manual(self, header="filter.h", old="", new=""):
        with tempfile.TemporaryDirectory() as work:
            root = pathlib.Path(work)
            for folder in ("src", "include"):
                shutil.copytree(ROOT / folder, root / folder)
            file = root / "include/kalmanq" / header
            self.assertIn(old, file.read_text())
            file.write_text(file.read_text().replace(old, new))
            manual = Manual(root)
            manual.check()
            return manual

    def test_the_tree_itself(self):
        self.assertEqual(self.manual().faults, [])

    def test_each_rule(self):
        for rule, what, *change in (*FAULTS, *ADVICE):
            with self.subTest(rule):
                manual = self.manual(*change)
                found, other = manual.faults, manual.advice
                if (rule, what, *change) in ADVICE:
                    found, other = other, found
                self.assertTrue(any(what in one for one in found), found)
                self.assertEqual(other, [])


if __name__ == "__main__":
    unittest.main()
