"""The link check finds broken links, and does not cry wolf."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import check_links  # noqa: E402


class CheckLinks(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        (self.root / "docs").mkdir()
        (self.root / "docs/page.md").write_text("# One title, two\n```\n# not a title\n```\n")

    def problems(self, text):
        (self.root / "README.md").write_text(text)
        return check_links.check(self.root)

    def test_links_that_lead_somewhere_pass(self):
        self.assertEqual(self.problems("# Top\n[a](docs/page.md) [b](docs/page.md#one-title-two) [c](#top) [d](docs)\n"
                                       "[e](https://example.org/x) `[f](nowhere)`\n```\n[g](nowhere)\n```\n"), [])

    def test_a_missing_file_is_named_with_its_line(self):
        self.assertEqual(self.problems("# Top\n\n![picture](docs/none.png)\n"),
                         ["README.md:3: docs/none.png: no such file"])

    def test_lines_are_counted_across_fenced_blocks(self):
        self.assertEqual(self.problems("```\na\nb\n```\n[x](none)\n"), ["README.md:5: none: no such file"])

    def test_a_missing_heading_is_named(self):
        self.assertEqual(self.problems("[x](docs/page.md#not-a-title)\n"),
                         ["README.md:1: docs/page.md#not-a-title: no such heading"])


if __name__ == "__main__":
    unittest.main()
