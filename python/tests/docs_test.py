"""The examples of docs/python.md and README.md run as they are written."""

import contextlib
import io
import os
import re
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["BRIM_SOURCE"])


def examples(page):
    """[(line, code)] of the page's blocks of Python."""
    text = page.read_text(encoding="utf-8")
    return [(text.count("\n", 0, m.start()) + 2, m[1]) for m in re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S)]


class Examples(unittest.TestCase):
    def run_page(self, page):
        found = examples(page)
        self.assertGreater(len(found), 0)
        names = {"__name__": "__docs__"}
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                for line, code in found:
                    with self.subTest(f"{page.name}:{line}"), contextlib.redirect_stdout(io.StringIO()):
                        exec(compile("\n" * (line - 1) + code, str(page), "exec"), names)
            finally:
                os.chdir(before)

    def test_docs_python(self):
        self.run_page(SOURCE / "docs/python.md")

    def test_readme(self):
        self.run_page(SOURCE / "README.md")


if __name__ == "__main__":
    unittest.main()
