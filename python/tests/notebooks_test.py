"""The examples are notebooks: all of them convert, and the first one runs in a kernel and becomes a page with its pictures
(examples_test.py runs the code of all)."""

import importlib.util
import os
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(os.environ["BRIM_SOURCE"])
sys.path.insert(0, str(SOURCE / "tools/site"))
import notebooks  # noqa: E402

HERE = all(importlib.util.find_spec(name) for name in ("nbformat", "nbclient", "ipykernel", "matplotlib"))


class Notebooks(unittest.TestCase):
    def test_cells_are_taken_apart(self):
        text = "# %% [markdown]\n# # Title\n# words\n\n# %%\nx = 1\n\n# %% A line above.\ny = 2\n"
        self.assertEqual(notebooks.cells(text), [("markdown", "# Title\nwords"), ("code", "x = 1"), ("markdown", "A line above."),
                                                 ("code", "y = 2")])

    @unittest.skipUnless(HERE, "no nbclient, ipykernel or matplotlib")
    def test_every_example_is_a_notebook(self):
        for path in notebooks.EXAMPLES.glob("*.py"):
            book = notebooks.notebook(path)
            self.assertTrue(book.cells[0].source.startswith("# "), path.name)
            self.assertGreater(sum(cell.cell_type == "code" for cell in book.cells), 2, path.name)

    @unittest.skipUnless(HERE, "no nbclient, ipykernel or matplotlib")
    def test_the_first_one_runs_and_is_a_page(self):
        with tempfile.TemporaryDirectory() as folder:
            notebooks.make(Path(folder), ["first_scene"])
            page = Path(folder, "first_scene.md").read_text(encoding="utf-8")
            self.assertIn("N of the sheet's", page)
            self.assertIn("](first_scene_1.png)", page)
            self.assertTrue(Path(folder, "first_scene_1.png").read_bytes().startswith(b"\x89PNG"))
            self.assertTrue(Path(folder, "first_scene.ipynb").exists())


if __name__ == "__main__":
    unittest.main()
