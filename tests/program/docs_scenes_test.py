"""Scenes and parts of scenes that the pages show are what the program takes."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

BRIM = os.environ["BRIM_PROGRAM"]
ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BLOCK = re.compile(r"^```json\n(.*?)^```", re.M | re.S)
# What a part that stands alone may lack: bodies and files that it speaks of, and a run long enough for its windows.
LACKS = re.compile(r"is not a body|no body that can move is named|nor a stem or pattern of names|no such file|after the end of the run")
FLOOR = {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}}


def scene(block):
    """The scene that a block is or is a part of: an object, members of one, or bodies; None for what leaves out."""
    if "..." in block:
        return None
    for form in ("%s", "{%s}", '{"bodies": [%s]}'):
        try:
            found = json.loads(form % block.strip())
        except ValueError:
            continue
        if "kind" in found:
            found = {"bodies": [found]}
        found = {"brim": 1, "name": "page", "bodies": [FLOOR], **found}
        found.pop("$schema", None)
        if "duration" not in found:
            found.setdefault("frames", 1)
        return found
    raise AssertionError("neither a scene nor a part of one: " + block)


class DocsScenes(unittest.TestCase):
    def test_scenes_on_pages_are_valid(self):
        seen = 0
        with tempfile.TemporaryDirectory() as folder:
            for page in sorted(ROOT.glob("docs/**/*.md")):
                for block in BLOCK.findall(page.read_text(encoding="utf-8")):
                    given = scene(block)
                    if given is None:
                        continue
                    seen += 1
                    path = pathlib.Path(folder) / "page.json"
                    path.write_text(json.dumps(given))
                    said = subprocess.run([BRIM, "validate", str(path)], capture_output=True, text=True).stderr
                    wrong = [line for line in said.splitlines() if not LACKS.search(line)]
                    with self.subTest(page=page.name, scene=block[:200]):
                        self.assertEqual(wrong, [])
        self.assertGreater(seen, 10)

    def test_a_wrong_key_is_found(self):
        given = scene('{"kind": "rigid", "name": "box", "densty": 1, "shape": {"kind": "box", "size": [1, 1, 1]}}')
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "page.json"
            path.write_text(json.dumps(given))
            said = subprocess.run([BRIM, "validate", str(path)], capture_output=True, text=True).stderr
        self.assertIn("densty", said)
        self.assertFalse(LACKS.search(said))


if __name__ == "__main__":
    unittest.main()
