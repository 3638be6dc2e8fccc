"""The program's help, errors and descriptions of itself. BRIM_PROGRAM names the program."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BRIM = os.environ["BRIM_PROGRAM"]
ROOT = pathlib.Path(__file__).resolve().parents[2]


def brim(*words, cwd=None):
    done = subprocess.run([BRIM, *words], capture_output=True, text=True, timeout=120, cwd=cwd)
    return done.returncode, done.stdout, done.stderr


class Help(unittest.TestCase):
    def test_words_are_understood_as_people_write_them(self):
        for words in (["help"], ["--help"]):
            code, out, _ = brim(*words)
            self.assertEqual(code, 0)
            for command in ("run", "view", "sweep", "info"):
                self.assertRegex(out, rf"\n  {command} ")
        self.assertIn("--resume", brim("help", "run")[1])
        for words in (["version"], ["--version"]):
            code, out, _ = brim(*words)
            self.assertEqual(code, 0)
            self.assertRegex(out, r"^brim \d+\.\d+\.\d+( \([0-9a-f]{12}(, changed)?\))?\n$")
        if (ROOT / ".git").exists():
            self.assertIn("(", brim("version")[1], "the commit is known in a checkout")

    def test_a_misspelt_command_is_guessed_and_a_missing_argument_names_its_help(self):
        self.assertEqual(brim("rnu", "x.json")[2], 'brim: error: "rnu" is not a command; did you mean "run"? brim help lists them\n'
                         .replace("? brim", "?; brim"))
        self.assertIn('did you mean "render"?', brim("help", "rendr")[2])
        self.assertIn("brim run --help", brim("run")[2])
        self.assertIn("brim info --help", brim("info")[2])
        self.assertIn("brim help", brim()[2])
        for words in (["rnu"], ["run"], [], ["help", "rendr"], ["run", "a", "b"], ["completion", "tcsh"]):
            code, _, err = brim(*words)
            self.assertEqual(code, 2, words)
            self.assertEqual(err.count("\n"), 1, words)

    def test_all_errors_of_a_scene_are_told_a_line_each(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "bad.jsonc").write_text(
                '// two mistakes\n{"brim": 1, "name": "bad", "frames": 1,\n "world": {"time_step": -1},\n'
                ' "bodies": [{"kind": "jely", "name": "a"}]}')
            code, _, err = brim("validate", "bad.jsonc", cwd=folder)
            self.assertEqual(code, 2)
            lines = err.splitlines()
            self.assertEqual(len(lines), 2, err)
            self.assertTrue(lines[0].startswith("brim: error: bad.jsonc:3: /world/time_step: -1"), lines[0])
            self.assertIn("--plugin", lines[1])

    def test_a_flat_mesh_gets_a_sentence(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
            pathlib.Path(folder, "flat.json").write_text(
                '{"brim": 1, "name": "flat", "frames": 1, "bodies": [{"kind": "rigid", "name": "a", "shape": '
                '{"kind": "mesh", "file": "flat.obj", "treatment": "winding_number"}}]}')
            code, _, err = brim("validate", "flat.json", cwd=folder)
            self.assertEqual(code, 2)
            self.assertIn("flat.obj is flat and encloses nothing", err)
            pathlib.Path(folder, "flat.obj").write_text("v 0 0 0\nv 1 0 0.3\nv 1 1 0.5\nv 0 1 0.2\nf 1 2 3\nf 1 3 4\n")  # tilted
            self.assertIn("flat.obj is flat and encloses nothing", brim("validate", "flat.json", cwd=folder)[2])
            code, out, _ = brim("info", "flat.obj", cwd=folder)
            self.assertEqual(code, 0)
            self.assertIn('needs treatment "thickness", as it is flat', out)
            self.assertNotIn("nan", err)

    def test_scenes_with_comments_may_be_named_jsonc(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "a.jsonc").write_text(
                '{"brim": 1, "name": "a", "frames": 1, /* floor */ "parameters": {"h": 0.1},\n'
                '"bodies": [{"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}}]}')
            code, out, _ = brim("info", "a.jsonc", cwd=folder)
            self.assertEqual(code, 0)
            self.assertIn("parameters, for --set: h = 0.1", out)

    def test_completion_and_manual_name_every_command_and_option(self):
        out = brim("completion", "bash")[1]
        self.assertEqual(subprocess.run(["bash", "-n"], input=out, text=True, check=False).returncode, 0)
        asked = "COMP_WORDS=(brim run --fr); COMP_CWORD=2; _brim; echo ${COMPREPLY[*]}; COMP_WORDS=(brim sw); COMP_CWORD=1; _brim; echo ${COMPREPLY[*]}"
        done = subprocess.run(["bash", "-c", out + asked], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.split(), ["--frames", "sweep"])
        commands = re.findall(r"^  (\w+)  ", brim("help")[1].split("Subcommands:")[1], re.M)
        self.assertGreater(len(commands), 8)
        whole = brim("manual")[1]
        for shell in ("bash", "zsh", "fish"):
            text = brim("completion", shell)[1]
            for command in commands:
                self.assertIn(command, text)
        for command in commands:
            self.assertIn(f"brim\\-{command}", whole)
            page = brim("manual", command)[1]
            self.assertTrue(page.startswith(f".TH brim-{command} 1"), page[:60])
            for option in set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", brim(command, "--help")[1], re.M)) - {"--help"}:
                self.assertIn(option.replace("-", "\\-"), page)

    def test_exit_codes_are_those_of_the_page(self):
        page = (ROOT / "docs" / "command_line.md").read_text()
        codes = dict(re.findall(r"k(Good|Failed|BadInput|Interrupted) = (\d+)", (ROOT / "apps/cli/commands.h").read_text()))
        self.assertEqual(sorted(re.findall(r"^\| (\d+) \|", page, re.M)), sorted(codes.values()))
        for command in re.findall(r"^  (\w+)  ", brim("help")[1].split("Subcommands:")[1], re.M):
            self.assertIn(f"`brim {command}", page)


if __name__ == "__main__":
    unittest.main()
