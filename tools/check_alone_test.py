"""Tests of check_alone.py on a build of two small files."""

import io
import json
import os
import pathlib
import sys
import tempfile
import unittest
from contextlib import redirect_stdout
from unittest import mock

import check_alone


class Alone(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(os.path.realpath(self.folder.name))
        self.addCleanup(self.folder.cleanup)
        (self.root / "size.h").write_text("#pragma once\n#include <vector>\ninline std::vector<int> sizes() { return {1}; }\n")
        (self.root / "forgets.h").write_text("#pragma once\ninline std::vector<int> none() { return {}; }\n")
        (self.root / "good.cpp").write_text('#include "size.h"\nint first() { return sizes()[0]; }\n')
        (self.root / "forgets.cpp").write_text("int last() { return sizes().back(); }\n")
        entries = [{"directory": str(self.root), "file": name, "command": f"ccache c++ -std=c++17 -Wall -o {name}.o -c {name}"}
                   for name in ("good.cpp", "forgets.cpp")]
        (self.root / "compile_commands.json").write_text(json.dumps(entries))

    def run_on(self, names, *options):
        text = "".join(f"{self.root / name}\n" for name in names)
        with mock.patch.object(sys, "argv", ["check_alone.py", str(self.root), *options]), mock.patch.object(sys, "stdin", io.StringIO(text)):
            said = io.StringIO()
            with redirect_stdout(said):
                return check_alone.main(), said.getvalue()

    def test_what_includes_all_it_uses_passes(self):
        self.assertEqual(self.run_on(["good.cpp", "size.h"]), (0, "alone: 2 files need no other\n"))

    def test_a_file_and_a_header_that_forget_an_include_are_named(self):
        for name, missing in (("forgets.cpp", "sizes"), ("forgets.h", "vector")):
            ended, said = self.run_on(["good.cpp", name])
            self.assertEqual(ended, 1)
            self.assertIn(f"{name} cannot be compiled alone", said)
            self.assertIn(missing, said)
            self.assertNotIn("good.cpp cannot", said)

    def test_a_file_that_no_build_has_is_passed_by(self):
        (self.root / "other.cpp").write_text("nonsense\n")
        self.assertEqual(self.run_on(["other.cpp"])[0], 0)

    def test_the_clock_leaves_out_and_says_so(self):
        ended, said = self.run_on(["forgets.cpp"], "--seconds", "0")
        self.assertEqual(ended, 0)
        self.assertIn("1 of 1 files were left out", said)


if __name__ == "__main__":
    unittest.main()
