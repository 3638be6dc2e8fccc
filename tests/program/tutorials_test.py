"""The tutorials run as they are written. BRIM_PROGRAM names the program, PYTHONPATH the built module.

A block of JSON after <!-- file: NAME --> is that file; blocks of sh and python are run in order in one folder. `brim view` is started
and stopped; pictures are made where Node, Chromium and the built page are there, films where FFmpeg is too."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

BRIM = os.environ["BRIM_PROGRAM"]
ROOT = pathlib.Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"(?:^<!-- file: (\S+) -->\n)?^```(json|sh|python)\n(.*?)^```$", re.M | re.S)


def can_draw(words):
    browser = any(shutil.which(name) for name in ("chromium", "chromium-browser", "google-chrome"))
    page = (ROOT / "viewer/dist/index.html").exists() and (ROOT / "viewer/node_modules").exists()
    return browser and page and shutil.which("node") and (".mp4" not in words or shutil.which("ffmpeg"))


class Tutorials(unittest.TestCase):
    def follow(self, page):
        env = {**os.environ, "PATH": f"{pathlib.Path(BRIM).parent}:{os.environ['PATH']}", "MPLBACKEND": "Agg"}
        blocks = BLOCK.findall((ROOT / "docs/tutorials" / page).read_text(encoding="utf-8"))
        self.assertGreater(len(blocks), 2)
        with tempfile.TemporaryDirectory() as folder:
            for name, language, text in blocks:
                if name:
                    pathlib.Path(folder, name).write_text(text)
                elif language == "python":
                    self.run_python(text, folder, env)
                elif language == "sh":
                    for line in filter(None, text.splitlines()):
                        self.run_line(line, folder, env)

    def run_line(self, line, folder, env):
        if line.startswith("brim view"):
            if (ROOT / "viewer/dist/index.html").exists():
                self.view(line.split()[1:], folder, env)
        elif not line.startswith("brim render") or can_draw(line):
            done = subprocess.run(["bash", "-euc", line], cwd=folder, env=env, capture_output=True, text=True, timeout=500)
            self.assertEqual(done.returncode, 0, f"{line}\n{done.stdout}{done.stderr}")

    def view(self, words, folder, env):
        process = subprocess.Popen([BRIM, *words, "--port", "0"], cwd=folder, env=env, stdout=subprocess.PIPE, text=True)
        self.assertIn("is shown at http://", process.stdout.readline())
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=60), 0)
        process.stdout.close()

    def run_python(self, text, folder, env):
        if "import brim" in text and subprocess.run([sys.executable, "-c", "import brim"], env=env, capture_output=True).returncode:
            return
        done = subprocess.run([sys.executable, "-c", text], cwd=folder, env=env, capture_output=True, text=True, timeout=500)
        self.assertEqual(done.returncode, 0, f"{text}\n{done.stdout}{done.stderr}")

    def test_animators(self):
        self.follow("animators.md")

    def test_machines(self):
        self.follow("machines.md")

    def test_researchers(self):
        self.follow("researchers.md")

    def test_scans(self):
        self.follow("scans.md")

    def test_every_tutorial_is_followed(self):
        pages = {page.stem for page in (ROOT / "docs/tutorials").glob("*.md")}
        self.assertEqual({f"test_{page}" for page in pages}, {n for n in dir(self) if n.startswith("test_")} - {"test_every_tutorial_is_followed"})


if __name__ == "__main__":
    unittest.main()
