"""brim sweep: all combinations, gone on with where it was cut short, joined in one table. BRIM_PROGRAM names the program."""
import csv
import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

BRIM = os.environ["BRIM_PROGRAM"]
SCENE = """{"brim": 1, "name": "fall", "frames": 6, "parameters": {"r": 0.2}, "world": {"time_step": 0.01},
 "bodies": [{"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
  {"kind": "rigid", "name": "ball", "shape": {"kind": "sphere", "radius": "=r"}, "transform": {"position": [0, 0, "=5*r"]},
   "repeat": {"count": [1, 1, 2], "jitter": [0.1, 0, 0]}}],
 "expect": [{"metric": "speed", "max": 1}]}"""


class Sweep(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = pathlib.Path(self.folder.name)
        (self.root / "fall.json").write_text(SCENE)

    def brim(self, *words, code=0):
        done = subprocess.run([BRIM, *words], capture_output=True, text=True, timeout=300, cwd=self.root)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return done.stdout

    def table(self):
        with open(self.root / "s" / "summary.csv", newline="") as file:
            return list(csv.DictReader(file))

    def test_all_combinations_run_and_one_table_holds_them(self):
        words = ["sweep", "fall.json", "--set", "r=0.1,0.2", "--seeds", "1:3", "-o", "s", "--jobs", "2"]
        self.assertIn("6 of 6 runs completed", self.brim(*words))
        rows = self.table()
        self.assertEqual([(row["r"], row["seed"]) for row in rows], [(r, s) for r in ("0.1", "0.2") for s in "123"])
        self.assertEqual({row["end"] for row in rows}, {"completed"})
        self.assertEqual({row["threads"] for row in rows}, {"1"})
        self.assertEqual(len({row["hash"] for row in rows}), 6, "values and seeds make different runs")
        self.assertAlmostEqual(float(rows[0]["expect.speed"]), 9.81 * 0.06, places=3)
        # Bits are those of the run by itself.
        self.brim("run", "fall.json", "--set", "r=0.2", "--seed", "3", "-o", "alone", "--quiet")
        self.assertIn(rows[5]["hash"], (self.root / "alone" / "summary.json").read_text())
        # A second time nothing is left to do; another value adds its own.
        before = {p: p.stat().st_mtime_ns for p in (self.root / "s").glob("*/run.h5")}
        words[3] = "r=0.1,0.2,0.3"
        self.assertIn("9 of 9 runs completed", self.brim(*words))
        self.assertEqual(before, {p: p.stat().st_mtime_ns for p in before})

    def test_one_that_was_cut_short_is_gone_on_with_to_the_same_bits(self):
        words = ["sweep", "fall.json", "--set", "r=0.1,0.2", "-o", "s", "--jobs", "2", "--frames", "1500"]
        running = subprocess.Popen([BRIM, *words], cwd=self.root, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + 60
        while not list((self.root / "s").glob("*/run.h5")) and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(0.1)
        running.send_signal(signal.SIGINT)
        code = running.wait(timeout=60)
        self.assertIn(code, (0, 130))
        self.brim(*words)
        first = [row["hash"] for row in self.table()]
        self.brim(*words, "--force")
        self.assertEqual(first, [row["hash"] for row in self.table()])

    def test_a_changed_scene_is_not_taken_for_the_old_one(self):
        self.brim("sweep", "fall.json", "--set", "r=0.1", "-o", "s")
        (self.root / "fall.json").write_text(SCENE.replace("0.01}", "0.02}"))
        done = subprocess.run([BRIM, "sweep", "fall.json", "--set", "r=0.1", "-o", "s"], capture_output=True, text=True,
                              cwd=self.root)
        self.assertEqual(done.returncode, 2)
        self.assertIn("another scene", done.stderr)

    def test_expectations_and_failures_are_told(self):
        self.brim("sweep", "fall.json", "--set", "/expect/0/max=0.1", "-o", "s", "--check", code=1)
        self.assertEqual(self.table()[0]["expect_ok"], "false")
        self.assertIn("is not allowed", subprocess.run([BRIM, "sweep", "fall.json", "--set", "r=-1"], capture_output=True,
                                                       text=True, cwd=self.root).stderr)

    def test_commands_for_other_schedulers_make_the_same_runs(self):
        words = ["sweep", "fall.json", "--set", "r=0.1,0.2", "--seeds", "4,7", "-o", "s"]
        lines = self.brim(*words, "--emit", "parallel").splitlines()
        self.assertEqual(len(lines), 4)
        self.assertFalse((self.root / "s").exists())
        subprocess.run(lines[0], shell=True, check=True, cwd=self.root, stdout=subprocess.DEVNULL)
        slurm = self.brim(*words, "--emit", "slurm")
        self.assertIn("#SBATCH --array=0-2", slurm, "one of the four is done")
        for task in range(3):
            subprocess.run(["bash"], input=slurm, text=True, check=True, cwd=self.root, stdout=subprocess.DEVNULL,
                           env={**os.environ, "SLURM_ARRAY_TASK_ID": str(task)})
        self.assertIn("4 of 4 runs completed", self.brim(*words, "--join"))
        self.assertEqual(len(self.table()), 4)


if __name__ == "__main__":
    unittest.main()
