"""The check of references finds names that lead nowhere, and does not cry wolf."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import check_references  # noqa: E402


class CheckReferences(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        for name, text in {
            "dev": "cmd_test() {\n}\n",
            "docs/page.md": "",
            "apps/cli/run.cpp": 'app.add_subcommand("run", "runs");\ncommand->add_flag("--check", check, "holds");\n',
            "apps/cli/values.cpp": 'command.add_option("--set", set, "for several commands");\n',
            "apps/cli/view.cpp": 'app.add_subcommand("view", "shows");\ncommand->add_option("--port", port, "");\n',
            "tools/plot.py": 'parser.add_argument("--frames")\n',
            "scenes/bounce.json": "{}",
            "tests/io/file_test.cpp": "TEST(Reader, ReadsFiles) {\nTEST_F(Other, Thing) {\n",
            "bench/speed_bench.cpp": "",
            "src/brim/io/file.h": "",
        }.items():
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_text(text)

    def problems(self, text, name="docs/page.md"):
        (self.root / name).write_text(text)
        return check_references.check(self.root)

    def test_what_is_there_passes(self):
        self.assertEqual(self.problems("`tests/io/file_test.cpp`, `src/brim/io/file.h`, `brim/io/file.h`, `./dev test`, "
                                       "`brim run`, `build/release/bench/speed_bench`, `build/release/tests/test_io`, "
                                       "`--gtest_filter='Reader.*:Other.Thing-*Slow*'`, `tests/<layer>/NAME_test.cpp`, "
                                       "`brim run a.json --check --set x=1`, `brim view out | x --none`, `...ReadsFiles`, "
                                       "`test_io --gtest_filter=Reader.*`, `tools/plot.py --frames 3`, `Scene_bounce`"), [])

    def test_each_kind_of_name_is_found_missing(self):
        for text in ("`tests/io/none_test.cpp`", "`brim/io/none.h`", "`./dev tset`", "`brim rum x.json`",
                     "`build/release/bench/none_bench`", "`build/release/tests/test_none`",
                     "`--gtest_filter=Reader.*:None.*`", "`test_map --gtest_filter=Reader.*`", "`...ReadsNothing*`",
                     "`brim run a.json --port 3`", "`brim view out --chek`", "`tools/plot.py --steps 3`",
                     "`./dev test` and `Scene_bouncy`"):
            found = self.problems("\n" + text + "\n")
            self.assertEqual(len(found), 1, f"{text}: {found}")
            self.assertTrue(found[0].startswith("docs/page.md:2: "), found)

    def test_prose_is_no_command(self):
        self.assertEqual(self.problems("There brim lets bodies touch.\nbrim is a program.\n"), [])

    def test_comments_are_read_and_code_is_not(self):
        found = self.problems('int x;\n/// Tests: tests/io/none_test.cpp\nconst char* p = "tests/io/other.cpp";\n',
                              "src/brim/io/file.h")
        self.assertEqual([p.split(":")[1] for p in found], ["2"])


if __name__ == "__main__":
    unittest.main()
