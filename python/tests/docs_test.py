"""The examples of docs/python.md, docs/sensors.md and README.md run as they are written."""

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

    def test_docs_sensors(self):
        self.run_page(SOURCE / "docs/sensors.md")

    def test_docs_formats(self):
        try:
            import h5py  # noqa: F401
        except ImportError:
            self.skipTest("no h5py")
        import brim
        world = brim.World(name="demo")
        world.add("obstacle", name="floor", shape=brim.plane())
        world.add("rigid", name="ball", shape=brim.sphere(0.2), transform={"position": (0, 0, 0.2)})
        with tempfile.TemporaryDirectory() as folder:
            run = str(Path(folder, "run"))
            world.run(frames=3, record=run).all()
            found = examples(SOURCE / "docs/formats.md")
            self.assertGreater(len(found), 0)
            for line, code in found:
                with self.subTest(f"formats.md:{line}"), contextlib.redirect_stdout(io.StringIO()):
                    names = {}
                    exec(compile(code.replace("out/demo", run), "formats.md", "exec"), names)
                    self.assertAlmostEqual(names["height"].min(), 0.2, places=2)
                    names["run"].close()

    def test_readme(self):
        self.run_page(SOURCE / "README.md")


if __name__ == "__main__":
    unittest.main()
