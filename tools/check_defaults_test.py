"""check_defaults finds defaults that a page tells and the schema does not have."""
import unittest

import check_defaults

KIND = {"required": ["radius"],
        "properties": {"radius": {}, "density": {"default": 1000}, "slack": {"default": False}, "fit": {}, "carve": {"default": []},
                       "law": {"enum": ["soft", "hard"], "default": "soft"}}}


def found(row, head="| key | unit | default | |"):
    page = f"{head}\n|---|---|---|---|\n{row}\n"
    return list(check_defaults.problems_of(page, "page.md", KIND, {"Options", "young"}))


class CheckDefaults(unittest.TestCase):
    def test_what_the_schema_has_is_good(self):
        for row in ("| `density` | kg | 1000 | > 0 |", "| `density` | kg | 1e3 | |", "| `slack` | | false | |", "| `law` | | `soft` | |",
                    "| `radius` | m | required | |", "| `radius` | m | needed | |", "| `carve`, `fit` | | none, none | |",
                    "| `density`, `slack` | kg | 1000, false | |", "| `density` | kg | 5; 1000 in scenes | |",
                    "| `density` | kg | 1000: that of water | |"):
            self.assertEqual(found(row), [], row)

    def test_another_number_is_found_with_its_line(self):
        self.assertIn("page.md:3: `density` is said to be 998 by default; the schema of scenes has 1000", found("| `density` | kg | 998 | |"))

    def test_another_word_is_found(self):
        for row in ("| `slack` | | true | |", "| `law` | | `hard` | |", "| `density` | | required | |", "| `radius` | | none | |",
                    "| `density`, `slack` | kg | 1000, true | |", "| `density` | kg | 5; 7 in scenes | |"):
            self.assertEqual(len(found(row)), 1, row)

    def test_what_tells_no_default_is_left_alone(self):
        for row in ("| `density` | kg | half the radius | |", "| `law` | | `CorotationalLinear` | |", "| `fit` | m | 3 | |",
                    "| `radius` or `density` | | required | |"):
            self.assertEqual(found(row), [], row)
        self.assertEqual(found("| `density` | kg | 998 | |", head="| key | unit | value | |"), [], "no column of defaults")

    def test_a_key_must_be_of_the_kind_or_of_a_header(self):
        self.assertEqual(found("| `young` | Pa | 1e5 | |"), [])
        self.assertEqual(len(found("| `yuong` | Pa | 1e5 | |")), 1)


if __name__ == "__main__":
    unittest.main()
