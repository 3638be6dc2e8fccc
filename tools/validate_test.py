"""Tests the frame of the validation suite without running brim."""
import pathlib
import tempfile
import unittest

try:
    from validate import fits, page, plot
    from validate.__main__ import Outcome
    from validate.experiment import REGISTRY, Case, Experiment, cases
    from validate.experiments import every  # noqa: F401
except ModuleNotFoundError as error:
    raise unittest.SkipTest(f"needs NumPy and h5py: {error}") from error
import numpy as np


class Frame(unittest.TestCase):
    def an_experiment(self, **about):
        return Experiment("name", "", "", "", "m", scene=None, measure=None, theory=lambda c: 2.0, tolerance=0.1, **about)

    def test_cases_are_all_combinations(self):
        self.assertEqual([c.label for c in cases(a=(1, 2), b=("x",))], ["a 1, b x", "a 2, b x"])

    def test_errors_are_relative_or_by_scale(self):
        self.assertAlmostEqual(self.an_experiment().error(Case(), 2.1), 0.05)
        self.assertAlmostEqual(self.an_experiment(scale=10.0).error(Case(), 2.1), 0.01)

    def test_a_known_miss_is_one_of_its_case_alone(self):
        e = self.an_experiment(misses={"gap 0": "why"})
        self.assertEqual(e.miss(Case(gap=0)), "why")
        self.assertEqual(e.miss(Case(gap=0, h=1)), "why")
        self.assertIsNone(e.miss(Case(gap=0.02)))

    def test_a_known_miss_that_grows_over_what_the_page_tells_is_not_expected(self):
        e = self.an_experiment(misses={"": "why"})
        for error, expected in ((0.05, False), (0.15, True), (0.17, True), (0.20, False)):
            outcome = Outcome(e, Case(), told=-0.15)
            outcome.value, outcome.error = 2.0 * (1.0 - error), -error
            self.assertEqual(outcome.expected, expected, error)
        self.assertIn("WORSE", outcome.verdict)

    def test_errors_are_read_from_the_page(self):
        with tempfile.TemporaryDirectory() as folder:
            docs = pathlib.Path(folder)
            (docs / "validation.md").write_text("# Validation\n\n## A\n\n### bounce\n\n| case | theory [m] | brim | error | |\n|---|---|---|---|---|\n"
                                                "| e 0.3 | 0.09 | 0.0893 | -0.78 % | met |\n", encoding="utf-8")
            self.assertAlmostEqual(page.errors_of(docs)["bounce", "e 0.3"], -0.0078)

    def test_orders_periods_and_spins_are_those_of_made_up_data(self):
        self.assertAlmostEqual(fits.order([1.0, 0.5, 0.25], [-0.4, -0.1, -0.025]), 2.0)
        t = np.linspace(0, 10, 2001)
        self.assertAlmostEqual(fits.period(t, 3 + np.sin(2 * np.pi * t / 1.7)), 1.7, places=3)
        x = np.random.default_rng(1).normal(size=(20, 3))
        self.assertTrue(np.allclose(fits.mean_spin(x, np.cross([1.0, 2.0, 3.0], x) + 5.0), [1, 2, 3]))

    def test_every_experiment_makes_scenes_and_has_a_theory(self):
        self.assertGreater(len(REGISTRY), 30)
        for e in REGISTRY.values():
            for case in e.cases:
                self.assertIn("bodies", e.scene(case), e.name)
                self.assertTrue(np.isfinite(e.theory(case)), e.name)
            for label in e.misses:
                self.assertTrue(any(e.miss(c) for c in e.cases), f"{e.name}: {label}")

    def test_a_plot_has_each_line_and_the_theory(self):
        text = plot.svg([("a<b", [(0, 0), (1, 2)])], [(0, 1), (1, 1)], ("x", "y"))
        self.assertEqual(text.count("<polyline"), 2)
        self.assertIn("a&lt;b", text)


if __name__ == "__main__":
    unittest.main()
