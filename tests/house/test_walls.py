"""Tests of walls.py: each wall can be broken, and what may lead anywhere does"""
import unittest

import walls

HOUSES = {"core": ["src", "tests"], "host": ["tools", "tools/kalmanq"], "shelf": ["tools/cost", "port/rust"]}
BROKEN = [("tests/unit/one.c", "../../tools/kalmanq/native/calm.h", "the core names tools"), ("src/one.c", "port/rust/src", "the core names port/rust"),
          ("tools/kalmanq/one.py", "tools/cost/build.py", "the host names tools/cost"), ("tools/one.sh", "port/rust/", "the host names port/rust")]
WHOLE = [("tools/cost/one.py", "tools/kalmanq/ and tests/unit/"), ("tools/kalmanq/one.py", "src/kq_status.c"), ("src/one.c", "tools/cost/README.md"),
         ("tests/one.sh", "tools/test.sh core"), ("src/README.md", "tools/kalmanq/"), ("one.txt", "port/rust/")]


class Walls(unittest.TestCase):
    def test_each_can_be_broken(self):
        for name, text, said in BROKEN:
            self.assertEqual([one.split(": ")[1] for one in walls.faults([name], HOUSES, lambda _: text)], [said])

    def test_what_may_be_named(self):
        for name, text in WHOLE:
            self.assertEqual(list(walls.faults([name], HOUSES, lambda _: text)), [], name)

    def test_the_houses_are_three(self):
        self.assertEqual([len(folders) > 0 for folders in walls.houses().values()], [True, True, True])


if __name__ == "__main__":
    unittest.main()
