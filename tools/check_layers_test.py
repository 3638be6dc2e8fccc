"""The layer check finds what it is there to find, on small trees made for the purpose."""

import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import check_layers  # noqa: E402

ARCHITECTURE = """# Architecture
```layers
core ->
math -> core      # comments are allowed
mesh -> math
grid -> math
io -> mesh
apps -> io grid
```
"""
DEPENDENCIES = """# Dependencies
```third-party
Eigen/ -> math+
hdf5.h -> io
```
"""


class CheckLayers(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.write("docs/architecture.md", ARCHITECTURE)
        self.write("docs/dependencies.md", DEPENDENCIES)

    def write(self, path, *lines):
        path = self.root / path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(lines) + "\n")

    def problems(self):
        return check_layers.check(self.root)[0]

    def assert_one_problem(self, *words):
        problems = self.problems()
        self.assertEqual(len(problems), 1, problems)
        for word in words:
            self.assertIn(word, problems[0])

    def test_an_orderly_tree_has_no_problem(self):
        self.write("src/brim/core/error.h", "#include <string>", "#include <unistd.h>")
        self.write("src/brim/math/types.h", "#include <Eigen/Core>", '#include "brim/core/error.h"')
        # The second include is allowed only through math: the table is closed transitively.
        self.write("src/brim/mesh/tri.h", '#include "brim/math/types.h"', '#include "brim/core/error.h"')
        self.write("src/brim/io/obj.cpp", "#include <hdf5.h>", '#include "brim/mesh/tri.h"')
        self.write("apps/cli/main.cpp", '#include "brim/core/error.h"', '#include "arguments.h"')
        self.assertEqual(self.problems(), [])

    def test_a_layer_may_not_look_up(self):
        self.write("src/brim/math/types.h", "// first line", '#include "brim/mesh/tri.h"')
        self.assert_one_problem("src/brim/math/types.h:2", "math may not include")

    def test_siblings_may_not_include_each_other(self):
        self.write("src/brim/mesh/tri.h", '#include "brim/grid/tile.h"')
        self.assert_one_problem("mesh may not include brim/grid/tile.h")

    def test_angle_brackets_do_not_hide_a_violation(self):
        self.write("src/brim/core/error.h", "#  include <brim/math/types.h>")
        self.assert_one_problem("core may not include")

    def test_a_circle_of_files_in_one_layer_is_found(self):
        self.write("src/brim/mesh/a.h", '#include "brim/mesh/b.h"')
        self.write("src/brim/mesh/b.h", '#include "brim/mesh/c.h"')
        self.write("src/brim/mesh/c.h", '#include "brim/mesh/a.h"')
        self.assert_one_problem("circle", "brim/mesh/a.h -> brim/mesh/b.h -> brim/mesh/c.h -> brim/mesh/a.h")

    def test_a_diamond_is_not_a_circle(self):
        self.write("src/brim/mesh/a.h", '#include "brim/mesh/b.h"', '#include "brim/mesh/c.h"')
        self.write("src/brim/mesh/b.h", '#include "brim/mesh/d.h"')
        self.write("src/brim/mesh/c.h", '#include "brim/mesh/d.h"')
        self.write("src/brim/mesh/d.h")
        self.assertEqual(self.problems(), [])

    def test_a_third_party_header_stays_in_its_layer(self):
        self.write("src/brim/mesh/a.cpp", "#include <hdf5.h>")
        self.assert_one_problem("<hdf5.h> belongs to io, not to mesh")

    def test_plus_means_this_layer_and_those_above(self):
        self.write("src/brim/core/a.cpp", "#include <Eigen/Core>")
        self.write("src/brim/mesh/a.cpp", "#include <Eigen/Core>")
        self.assert_one_problem("src/brim/core/a.cpp:1")

    def test_an_unlisted_third_party_header_is_named(self):
        self.write("src/brim/mesh/a.cpp", "#include <boost/array.hpp>")
        self.assert_one_problem("<boost/array.hpp> is not listed")

    def test_a_file_in_no_layer_is_named(self):
        self.write("src/brim/misc/a.h")
        self.assert_one_problem("src/brim/misc/a.h", "no layer")

    def test_paths_inside_the_library_are_written_in_full(self):
        self.write("src/brim/mesh/a.cpp", '#include "tri.h"')
        self.assert_one_problem('instead of "tri.h"')

    def test_missing_or_broken_rules_are_an_error_and_not_a_pass(self):
        for text in (None, "# no block\n", "```layers\n```\n", "```layers\nmath core\n```\n",
                     "```layers\nmath -> nowhere\n```\n", "```layers\na -> b\nb -> a\n```\n",
                     "```layers\na ->\na ->\n```\n"):
            with self.subTest(text=text):
                if text is None:
                    (self.root / "docs/architecture.md").unlink()
                else:
                    self.write("docs/architecture.md", text)
                with self.assertRaises(check_layers.RuleError):
                    self.problems()


if __name__ == "__main__":
    unittest.main()
