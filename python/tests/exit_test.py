"""A program that ends while daemon threads step worlds ends as it wants to, whatever they are at."""

import subprocess
import sys
import unittest

START = """
import threading, time
import numpy as np
import brim

class Blob(brim.OwnBody):
    q0 = np.r_[0, 0, 0.35, 1, 1, 1]
    def deform(self, q, X): return q[:3] + q[3:] * X
    def inverse_deform(self, q, x): return (x - q[:3]) / q[3:]
    def distance(self, q, x): return (np.linalg.norm(self.inverse_deform(q, x), axis=1) - 0.3) * q[3:].min()
    def energy(self, q): return 2e3 * np.sum((q[3:] - 1) ** 2)

def world(own):
    w = brim.World(voxel_size=0.05)
    w.add("obstacle", name="floor", shape=brim.plane())
    if own:
        w.add(Blob(surface=brim.sphere(0.3)))
    else:
        for i in range(20):
            w.add("rigid", name=f"b{i}", shape=brim.sphere(0.2), transform={"position": (0.3 * (i % 5), 0.3 * (i // 5), 1)})
    return w

def go_on(w, begun):
    while True:
        w.step()
        begun.set()

def begin(w):
    begun = threading.Event()
    threading.Thread(target=go_on, args=(w, begun), daemon=True).start()
    begun.wait()
"""


class Exit(unittest.TestCase):
    def ends_well(self, program: str) -> str:
        done = subprocess.run([sys.executable, "-c", START + program], capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout

    def test_while_a_thread_steps(self):
        for _ in range(3):
            self.assertEqual(self.ends_well("begin(world(False)); time.sleep(0.05); print('end')"), "end\n")

    def test_while_a_thread_steps_a_body_written_in_python(self):
        for _ in range(3):
            self.assertEqual(self.ends_well("begin(world(True)); time.sleep(0.05); print('end')"), "end\n")

    def test_while_several_threads_step(self):
        self.ends_well("for i in range(6): begin(world(i % 2 == 0))")

    def test_who_ends_it_may_still_step(self):
        # Functions for the end are called the last one first: this one after brim's own.
        program = "import atexit; atexit.register(lambda: print(end.step().ok))\n" + START + \
            "end = world(True); begin(world(True))"
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "True\n", ""))

    def test_by_an_exception_or_a_code_of_its_own(self):
        done = subprocess.run([sys.executable, "-c", START + "begin(world(True)); raise SystemExit(7)"],
                              capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (7, ""))


if __name__ == "__main__":
    unittest.main()
