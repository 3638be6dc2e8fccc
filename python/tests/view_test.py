"""World.show serves the viewer's page."""

import os
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

    def test_what_is_no_run_is_refused(self):
        with self.assertRaisesRegex(RuntimeError, "none"):
            brim.view("/none")


if __name__ == "__main__":
    unittest.main()
