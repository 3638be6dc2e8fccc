"""The module is installed by cmake --install and by pip without network."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

BUILD, SOURCE = os.environ["BRIM_BUILD"], os.environ["BRIM_SOURCE"]
STEP = ("import brim; w = brim.World(); b = w.add('rigid', shape=brim.sphere(0.1)); w.step(); "
        "print(brim.__file__, b.v[2] < 0)")


def run(*command, **environment):
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env={**clean, **environment})
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


class Installed(unittest.TestCase):
    def test_by_cmake(self):
        with tempfile.TemporaryDirectory() as prefix:
            run("cmake", "--install", BUILD, "--prefix", prefix, "--component", "python")
            packages = next(Path(prefix).glob("lib/python3*/*-packages"))
            self.assertTrue((packages / "brim" / "py.typed").exists() and (packages / "brim" / "_core.pyi").exists())
            printed = run(sys.executable, "-c", STEP, PYTHONPATH=str(packages))
            self.assertEqual(printed.split(), [str(packages / "brim" / "__init__.py"), "True"])

    def test_by_pip_in_a_virtual_environment_without_network(self):
        with tempfile.TemporaryDirectory() as folder:
            venv = Path(folder) / "venv"
            # NumPy is Debian's; everything else comes from the checkout.
            run(sys.executable, "-m", "venv", "--system-site-packages", venv)
            nowhere = {"PIP_INDEX_URL": "http://127.0.0.1:9/none", "PIP_NO_INDEX": "1",
                       "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
            run(venv / "bin/python", "-m", "pip", "install", "-q", f"--config-settings=build-dir={BUILD}", SOURCE, **nowhere)
            printed = run(venv / "bin/python", "-c", STEP)
            self.assertTrue(printed.startswith(str(venv)), printed)
            self.assertTrue(printed.strip().endswith("True"))
            program = run(venv / "bin/python", "-c", "from brim.view import program; print(program())").strip()
            self.assertTrue(program.startswith(str(venv)))
            run(program, "--help")
            run(venv / "bin/python", "-m", "pip", "uninstall", "-q", "-y", "brim")


if __name__ == "__main__":
    unittest.main()
