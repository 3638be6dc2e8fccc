"""A script that needs NumPy finds a Python that has it, or says so in one line."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parent
SCRIPT = "import sys; sys.path.insert(0, {tools!r})\nimport with_numpy\n{set}with_numpy.need({module!r})\nprint(sys.executable, sys.argv[1:])\n"


class WithNumpy(unittest.TestCase):
    def run_script(self, module, debian=None):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder, "script.py")
            script.write_text(SCRIPT.format(tools=str(TOOLS), module=module, set=f"with_numpy.DEBIAN = {debian!r}\n" if debian else ""))
            return subprocess.run([sys.executable, str(script), "a", "b c"], capture_output=True, text=True)

    def test_a_python_that_has_it_goes_on(self):
        done = self.run_script("json")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("['a', 'b c']", done.stdout)

    def test_where_none_has_it_one_line_says_what_to_install(self):
        done = self.run_script("no_such_module")
        self.assertEqual(done.returncode, 3)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertIn("apt install python3-no_such_module", done.stderr)

    def test_another_python_that_has_it_is_started_with_the_same_arguments(self):
        with tempfile.TemporaryDirectory() as folder:
            module = pathlib.Path(folder, "only_there.py")
            module.write_text("")
            other = pathlib.Path(folder, "python3")
            other.write_text(f'#!/bin/sh\nPYTHONPATH={folder} exec "{sys.executable}" "$@"\n')
            other.chmod(0o755)
            done = self.run_script("only_there", str(other))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("['a', 'b c']", done.stdout)


if __name__ == "__main__":
    unittest.main()
