"""Tests of check_names.py on small trees."""

import pathlib
import tempfile
import unittest

import check_names


class Names(unittest.TestCase):
    def found(self, files):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, inside in files.items():
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                text = inside if name.endswith(".h") else f"namespace brim {{\n\nnamespace {{\n{inside}\n}}  // namespace\n\n}}  // namespace brim\n"
                path.write_text(text)
            return list(check_names.clashes(root))

    def test_one_constant_in_two_files_of_a_layer_clashes(self):
        files = {"src/brim/map/a.cpp": "constexpr int kOne = 1, kTwo = 2;", "src/brim/map/b.cpp": "constexpr double kTwo = 2.0;"}
        (clash,) = self.found(files)
        self.assertIn("kTwo in src/brim/map/a.cpp:4, src/brim/map/b.cpp:4", clash)

    def test_layers_are_apart_and_folders_of_a_layer_are_not(self):
        self.assertEqual(self.found({"src/brim/map/a.cpp": "struct A {", "src/brim/body/b.cpp": "struct A {"}), [])
        self.assertEqual(len(self.found({"src/brim/body/x/a.cpp": "struct A {", "src/brim/body/b.cpp": "struct A {"})), 1)

    def test_functions_clash_by_the_types_of_their_arguments(self):
        self.assertEqual(self.found({"src/brim/io/a.cpp": "void read(const Vec3& x) {", "src/brim/io/b.cpp": "void read(int x) {"}), [])
        self.assertEqual(len(self.found({"src/brim/io/a.cpp": "void read(const Vec3& x) {", "src/brim/io/b.cpp": "int read(const Vec3& y) {"})), 1)

    def test_a_type_of_a_header_may_not_be_named_again(self):
        self.assertEqual(len(self.found({"src/brim/io/a.h": "struct A {", "src/brim/io/b.cpp": "class A final : public B {"})), 1)

    def test_the_same_alias_may_be_said_twice_another_may_not(self):
        same = "using Json = nlohmann::json;"
        self.assertEqual(self.found({"apps/cli/a.cpp": same, "apps/cli/b.cpp": same}), [])
        self.assertEqual(len(self.found({"apps/cli/a.cpp": same, "apps/cli/b.cpp": "using Json = nlohmann::ordered_json;"})), 1)

    def test_a_test_has_a_namespace_of_its_files_name(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "tests/map").mkdir(parents=True)
            (root / "tests/map/a_test.cpp").write_text("namespace brim::a_test {\n")
            (root / "tests/map/b_test.cpp").write_text("namespace brim {\n")
            (said,) = check_names.tests_without_their_namespace(root)
        self.assertIn("tests/map/b_test.cpp", said)


if __name__ == "__main__":
    unittest.main()
