import pathlib
import tempfile
import unittest

import scene_file

ROOT = pathlib.Path(__file__).resolve().parent.parent


class ReadScene(unittest.TestCase):
    def test_comments_are_left_out_and_strings_are_kept(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "scene.json")
            path.write_text('{ // one\n "a": "no // comment", /* two\n lines */ "b": "\\" /* none */" // end\n}')
            self.assertEqual(scene_file.read_scene(path), {"a": "no // comment", "b": '" /* none */'})

    def test_every_scene_can_be_read(self):
        scenes = [*(ROOT / "scenes").glob("**/*.json"), *(ROOT / "bench/scenes").glob("*.json")]
        self.assertGreater(len(scenes), 50)
        for path in scenes:
            with self.subTest(path.name):
                scene_file.read_scene(path)


if __name__ == "__main__":
    unittest.main()
