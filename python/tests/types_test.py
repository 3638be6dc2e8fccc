"""The types that are written by hand are those of the module."""

import importlib.util
import inspect
import os
import re
import subprocess
import sys
import tempfile
import unittest

import brim

SOURCE = os.environ["BRIM_SOURCE"]


@unittest.skipUnless(importlib.util.find_spec("mypy"), "no mypy")
class Types(unittest.TestCase):
    def test_stubs_are_those_of_the_compiled_part(self):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as allowed:
            # pybind11 gives constructors and methods no signature that can be read.
            allowed.write("brim\\._core\\..*\\.__(init|getstate|setstate|hash|eq|new)__\n")
            # Their metaclass is pybind11's.
            allowed.write("brim\\._core\\.(Recorder|RunReader|SensorRecord|Session|State|StepReport|StepWarning)\n")
            allowed.flush()
            done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "brim._core", "--ignore-missing-stub",
                                   "--ignore-unused-allowlist", "--allowlist", allowed.name], capture_output=True,
                                  text=True, env={**os.environ, "MYPYPATH": os.path.join(SOURCE, "python")})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_package_and_its_users_pass_mypy(self):
        with tempfile.TemporaryDirectory() as folder:
            user = os.path.join(folder, "user.py")
            with open(user, "w") as file:
                file.write("import brim\nworld = brim.World(time_step=0.01)\n"
                           "report: brim.StepReport = world.step()\n"
                           "for frame in world.run(3):\n    t: float = frame.time\n"
                           "x: str = brim.Run('a').times.dtype.name\n")
            done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--no-warn-unused-ignores", "--cache-dir",
                                   folder, os.path.join(SOURCE, "python", "brim"), user], capture_output=True, text=True,
                                  env={**os.environ, "MYPYPATH": os.path.join(SOURCE, "python"), "PYTHONPATH": ""})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Docstrings(unittest.TestCase):
    def test_every_public_name_says_what_it_is(self):
        missing = []
        for name in brim.__all__:
            thing = getattr(brim, name)
            if not inspect.isclass(thing) and not callable(thing):
                continue
            if not inspect.getdoc(thing):
                missing.append(name)
        self.assertEqual(missing, [])

    def test_physical_properties_name_a_unit(self):
        for owner, names in ((brim.Body, ("mass", "positions", "velocities", "kinetic_energy", "linear_momentum")),
                             (brim.World, ("time", "time_step", "contacts", "pairs")),
                             (brim.RunBody, ("positions", "center", "velocity", "force"))):
            for name in names:
                self.assertRegex(inspect.getdoc(getattr(owner, name)), re.compile(r"\[[^\]]*\]"), f"{owner}.{name}")


if __name__ == "__main__":
    unittest.main()
