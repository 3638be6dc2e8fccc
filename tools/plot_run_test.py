"""Laws of the diagrams of a run (tools/plot_run.py)."""

import importlib.util
import pathlib
import tempfile
import unittest

import plot_run


def recorded(frames=3):
    """A run whose phases are known: the solve takes 4 s a frame, 1 s of it for contact; a second is no phase's."""
    second = [1.0] * frames
    seconds = {name: second for name in ("presence", "refine", "rasterize", "detect", "respond", "solve_contact", "advance",
                                         "record")}
    seconds["solve"] = [4.0] * frames
    series = {name: second for name in ("kinetic_energy", "potential_energy", "contact_energy", "worst_overlap", "contacts",
                                        "cg_iterations", "sweeps", "substeps")}
    series["wall"] = [11.0] * frames
    return {"scene": "made", "version": "0", "frame_time": 1.0, "time": [1.0 + f for f in range(frames)],
            "seconds": seconds, "series": series}


class PlotRun(unittest.TestCase):
    def test_stacked_phases_add_up_to_the_time_in_steps(self):
        data = recorded()
        seconds = plot_run.phases(data)
        layers = plot_run.DETECTION + plot_run.RESPONSE + plot_run.REST
        for frame, wall in enumerate(data["series"]["wall"]):
            self.assertAlmostEqual(sum(seconds[name][frame] for name, *_ in layers), wall)
        self.assertEqual(seconds["other"][0], 1.0)
        self.assertEqual(seconds["bodies"][0], 3.0)

    def test_shares_are_those_of_the_stack(self):
        data = recorded()
        detection, contact = plot_run.shares(plot_run.phases(data), data["series"]["wall"])
        self.assertAlmostEqual(detection, 4 / 11)
        self.assertAlmostEqual(contact, 6 / 11)

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "no Matplotlib")
    def test_equal_runs_give_equal_files(self):
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / name for name in ("a.svg", "b.svg", "c.png")]
            for file in files:
                plot_run.draw(recorded(), str(file))
            self.assertEqual(files[0].read_bytes(), files[1].read_bytes())
            self.assertTrue(files[2].read_bytes().startswith(b"\x89PNG"))
            self.assertEqual(len(list(pathlib.Path(folder).iterdir())), 3)


if __name__ == "__main__":
    unittest.main()
