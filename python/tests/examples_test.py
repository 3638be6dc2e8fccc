"""The examples of examples/python run; each ends with what it claims."""

import importlib.util
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FOLDER = Path(os.environ["BRIM_SOURCE"]) / "examples/python"


@unittest.skipUnless(importlib.util.find_spec("matplotlib"), "no matplotlib")
class Examples(unittest.TestCase):
    def test_each_runs_and_draws_its_picture(self):
        files = sorted(FOLDER.glob("*.py"))
        self.assertGreater(len(files), 4)
        for file in files:
            with self.subTest(file.name), tempfile.TemporaryDirectory() as out:
                done = subprocess.run([sys.executable, str(file), out], capture_output=True, text=True,
                                      env={**os.environ, "MPLBACKEND": "Agg"})
                self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                self.assertTrue((Path(out) / f"{file.stem}.png").exists())


if __name__ == "__main__":
    unittest.main()
