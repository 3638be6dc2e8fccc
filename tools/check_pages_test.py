"""check_pages finds what cannot be found."""
import json
import tempfile
import unittest
from pathlib import Path

import check_pages


class CheckPages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        (self.root / "docs/bodies").mkdir(parents=True)
        (self.root / "schema").mkdir()
        self.write("schema/scene.schema.json", json.dumps({"$defs": {"body": {"oneOf": [{"$ref": "#/$defs/rigid"}]}}}))
        self.write("docs/index.md", "[a](a.md) [rigid](bodies/rigid.md#shape)")
        self.write("docs/a.md", "[b](b.md)")
        self.write("docs/b.md", "```\n[c](c.md)\n```")
        self.write("docs/bodies/rigid.md", "")

    def write(self, name, text):
        (self.root / name).write_text(text)

    def found(self):
        return list(check_pages.problems(self.root))

    def test_what_is_near_is_good(self):
        self.assertEqual(self.found(), [])

    def test_a_page_that_nothing_leads_to_is_found(self):
        self.write("docs/c.md", "")
        self.assertEqual(len(self.found()), 1, "a link in code is none")

    def test_a_page_three_clicks_away_is_found(self):
        self.write("docs/b.md", "[c](c.md)")
        self.write("docs/c.md", "")
        self.assertIn("3 clicks", self.found()[0])

    def test_a_kind_without_a_page_is_found(self):
        (self.root / "docs/bodies/rigid.md").unlink()
        self.assertIn("the kind rigid has no page", self.found()[0])

    def test_a_kind_that_the_front_page_leaves_out_is_found(self):
        self.write("docs/index.md", "[a](a.md)")
        self.write("docs/a.md", "[b](b.md) [rigid](bodies/rigid.md)")
        self.assertIn("does not name it", self.found()[0])


if __name__ == "__main__":
    unittest.main()
