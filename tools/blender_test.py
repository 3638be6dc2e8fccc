"""The Blender add-on (tools/blender) shows in Blender what run.h5 holds. Skipped without Blender or the program."""

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
BRIM = pathlib.Path(os.environ.get("BRIM", ROOT / "build/release/brim"))
BLENDER = shutil.which("blender")
READS_HDF5 = "import h5py"


def blender(*arguments, scripts, code=0):
    """Runs Blender without a window and the person's own settings; its output where it does not end with `code`."""
    command = [BLENDER, "--background", "--python-exit-code", "3", *map(str, arguments)]
    own = {"BLENDER_USER_SCRIPTS": str(scripts), "BLENDER_USER_CONFIG": str(scripts),
           "PATH": f"{pathlib.Path(BLENDER).parent}:{os.environ['PATH']}"}  # Debian's takes the libraries of the first python3
    done = subprocess.run(command, env={**os.environ, **own}, capture_output=True, text=True, timeout=300)
    if done.returncode != code:
        raise AssertionError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stdout[-3000:]}{done.stderr[-3000:]}")


@unittest.skipUnless(BLENDER, "no Blender")
@unittest.skipUnless(BRIM.exists(), "the program is not built")
class BlenderAddon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="brim_blender_")
        cls.work = pathlib.Path(cls.folder.name)
        cls.addClassCleanup(cls.folder.cleanup)
        try:
            blender("--python-expr", READS_HDF5, scripts=cls.work)
        except AssertionError:
            raise unittest.SkipTest("Blender's Python has no h5py") from None
        cls.run_folder = cls.work / "run"
        subprocess.run([BRIM, "run", ROOT / "tools/every_display.json", "-o", cls.run_folder, "--quiet"], check=True)

    def test_installed_from_its_zip_it_shows_the_positions_of_the_file_and_so_does_the_saved_scene(self):
        zipped, saved = self.work / "addon.zip", self.work / "scene.blend"
        subprocess.run([ROOT / "tools/blender/make_zip.py", zipped], check=True, stdout=subprocess.DEVNULL)
        check = ROOT / "tools/blender/check_import.py"
        blender("--python", check, "--", "import", self.run_folder, zipped, saved, scripts=self.work)
        blender(saved, "--python", check, "--", "play", self.run_folder, scripts=self.work)

    def test_bodies_that_are_removed_shrink_to_a_point(self):
        scene = json.loads((ROOT / "tools/every_display.json").read_text())
        scene["timeline"] = [{"at": 0.06, "remove": name} for name in ("ball", "sheet", "rope", "grains")]
        (self.work / "removed.json").write_text(json.dumps(scene))
        run, zipped = self.work / "removed", self.work / "addon_2.zip"
        subprocess.run([BRIM, "run", self.work / "removed.json", "-o", run, "--quiet"], check=True)
        subprocess.run([ROOT / "tools/blender/make_zip.py", zipped], check=True, stdout=subprocess.DEVNULL)
        blender("--python", ROOT / "tools/blender/check_import.py", "--", "import", run, zipped, self.work / "removed.blend",
                scripts=self.work)

    def test_a_run_is_rendered_without_a_window(self):
        script = ROOT / "tools/blender/render_run.py"
        picture, pictures = self.work / "one.png", self.work / "all"
        common = ["--size", "64x36", "--samples", "1"]
        blender("--python", script, "--", self.run_folder, "--render", picture, *common, "--surface", scripts=self.work)
        blender("--python", script, "--", self.run_folder, "--render", pictures, *common, "--step", "4", scripts=self.work)
        self.assertGreater(picture.stat().st_size, 1000)  # one colour alone would take some 200 bytes
        self.assertEqual([p.name for p in sorted(pictures.iterdir())], ["0000.png", "0004.png"])

    def test_a_file_that_is_no_run_is_refused(self):
        (self.work / "run.h5").write_text("nothing")
        blender("--python", ROOT / "tools/blender/render_run.py", "--", self.work, scripts=self.work, code=3)


if __name__ == "__main__":
    unittest.main()
