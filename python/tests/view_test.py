"""World.show serves the viewer's page."""

import os
import subprocess
import sys
import unittest
import urllib.request
from pathlib import Path

import brim
from world_test import ball_world


PAGE = Path(os.environ.get("BRIM_VIEWER_DIR", Path(os.environ["BRIM_SOURCE"]) / "viewer/dist"))


@unittest.skipUnless((PAGE / "index.html").exists(), "the viewer is not built")
class Views(unittest.TestCase):
    def test_a_world_is_shown_until_it_is_closed(self):
        world, _ = ball_world()
        with world.show() as view:
            with urllib.request.urlopen(view.url, timeout=20) as page:
                self.assertIn(b"<html", page.read().lower())
            self.assertIn(f'<iframe src="{view.url}"', view._repr_html_())
        with self.assertRaises(OSError):
            urllib.request.urlopen(view.url, timeout=5)

    def test_the_page_ends_with_the_script_that_showed_it(self):
        # A body of the script's own: the world holds it, its class the script's names, these the world and the page.
        script = ("import brim, numpy as np\n"
                  "class Blob(brim.OwnBody):\n"
                  "    q0 = np.r_[0, 0, 2]\n"
                  "    def place(self, q, X): return q + X\n"
                  "    def rest(self, q, x): return x - q\n"
                  "    def distance(self, q, x): return np.linalg.norm(x - q, axis=1) - .3\n"
                  "    def energy(self, q): return 0.0\n"
                  "world = brim.World(voxel_size=0.1)\n"
                  "world.add(Blob(surface=brim.sphere(.3)))\n"
                  "page = world.show(); print(page.url)")
        url = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                             timeout=60).stdout.strip()
        with self.assertRaises(OSError):
            urllib.request.urlopen(url, timeout=5)

    def test_what_is_no_run_is_refused(self):
        with self.assertRaisesRegex(RuntimeError, "none"):
            brim.view("/none")


if __name__ == "__main__":
    unittest.main()
