#!/usr/bin/env python3
"""words.py says which word stands where, and what to say; it fails nobody."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


class Advice(unittest.TestCase):
    def test_a_word_is_found_in_a_page_a_header_and_a_message(self):
        with tempfile.TemporaryDirectory() as work:
            root = pathlib.Path(work)
            for name, text in {"CONTRIBUTING.md": (ROOT / "CONTRIBUTING.md").read_text(), "page.md": "The tally is kept.\n",
                               "include/one.h": "/** The tally is\n * kept. */\n", "tools/kalmanq/one.py": "SAID = 'the tally is kept'\n"}.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            done = subprocess.run([sys.executable, "-B", HERE / "words.py", root], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("page.md", "include/one.h", "tools/kalmanq/one.py"):
            self.assertRegex(done.stdout, rf"(?m)^{name}: '[Tt]he tally is kept\.?': compensated sum$")
        self.assertIn("\n3 words to look at\n", done.stdout)


if __name__ == "__main__":
    unittest.main()
