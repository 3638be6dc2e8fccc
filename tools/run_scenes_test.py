"""The runner of scenes tells misses, known misses and surprises apart."""

import json
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import run_scenes  # noqa: E402
from scene_file import read_scene  # noqa: E402


def summary(*expect, end="completed"):
    return {"end": end, "expect": [{"metric": "contacts", "max": 1.0, "value": 0.5, **e} for e in expect]}


class Judge(unittest.TestCase):
    def counts(self, given):
        return tuple(len(part) for part in run_scenes.judge(given))

    def test_what_holds_is_met(self):
        self.assertEqual(self.counts(summary({"ok": True}, {"ok": True})), (2, 0, 0))

    def test_what_is_missed_surprises(self):
        self.assertEqual(self.counts(summary({"ok": True}, {"ok": False, "value": None, "reached": False})), (1, 0, 1))

    def test_a_known_miss_must_miss(self):
        self.assertEqual(self.counts(summary({"ok": False, "known_miss": "2 for a reason"})), (0, 1, 0))
        self.assertEqual(self.counts(summary({"ok": True, "known_miss": "2 for a reason"})), (0, 0, 1))

    def test_a_known_miss_that_is_worse_surprises(self):
        self.assertEqual(self.counts(summary({"ok": False, "known_miss": "2 for a reason", "known_worst": 2.5, "worse": True})), (0, 0, 1))

    def test_a_run_without_its_end_surprises(self):
        self.assertEqual(self.counts(summary({"ok": True}, end="failed")), (1, 0, 1))

    def test_chaotic_metrics_are_judged_by_their_median(self):
        values = (0.9, 1.1, 0.8)
        each = [summary({"ok": v <= 1.0, "value": v}) for v in values]
        self.assertTrue(run_scenes.over_starts(each, {"contacts"})["expect"][0]["ok"])
        self.assertFalse(run_scenes.over_starts(each, set())["expect"][0]["ok"])
        each = [summary({"ok": False, "value": v, "known_miss": "2", "known_worst": 2.5}) for v in (2.0, 2.4, 9.0)]
        self.assertEqual(tuple(map(len, run_scenes.judge(run_scenes.over_starts(each, {"contacts"})))), (0, 1, 0))
        each = [summary({"ok": False, "value": v, "known_miss": "2", "known_worst": 2.5}) for v in (2.0, 2.6, 9.0)]
        self.assertEqual(tuple(map(len, run_scenes.judge(run_scenes.over_starts(each, {"contacts"})))), (0, 0, 1))

    def test_of_what_is_not_judged_by_its_median_the_worst_start_counts(self):
        each = [summary({"ok": True, "value": 0.5, "known_miss": "2"}), summary({"ok": False, "value": 1.5, "known_miss": "2"}),
                summary({"ok": False, "value": 3.0, "known_miss": "2", "known_worst": 2.5, "worse": True})]
        self.assertEqual(run_scenes.over_starts(each, set())["expect"][0]["value"], 3.0)
        self.assertEqual(run_scenes.over_starts(each[:2], set())["expect"][0]["value"], 1.5)

    def test_starts_without_figures_surprise(self):
        name = next(iter(run_scenes.starts_in()))
        with tempfile.TemporaryDirectory() as folder:
            for command in (["true"], ["false"]):
                *_, met, known, surprises = run_scenes.run(name, command, run_scenes.ROOT / "scenes" / f"{name}.json", Path(folder), 10.0)
                self.assertEqual((met, known, len(surprises)), ([], [], 1))

    def test_one_start_that_ends_early_counts(self):
        each = [summary({"ok": True}), summary({"ok": True}, end="failed")]
        self.assertEqual(tuple(map(len, run_scenes.judge(run_scenes.over_starts(each, set())))), (1, 0, 1))

    def test_pairs_are_held_to_their_list(self):
        figures = {"pairs": [{"upper": u, "lower": "b", "run": u != "d", "ok": u in "ac"} for u in "acdef"]}
        met, known, surprises = run_scenes.judge_pairs(figures, {"c on b": "known", "e on b": "known"})
        self.assertEqual((met, len(known), len(surprises)), (["a on b"], 1, 2))
        met, known, surprises = run_scenes.judge_pairs(figures, {"c on b": "known", "e on b": "known"}, cut_short=True)
        self.assertEqual((met, len(known), len(surprises)), (["a on b", "c on b"], 1, 1))


class Lists(unittest.TestCase):
    def test_the_lists_name_scenes_that_are_there(self):
        everything = run_scenes.jobs("brim", Path("out"), Path("plugin"))
        for name in ("fast.txt", "slow.txt"):
            for scene in run_scenes.names_in(run_scenes.ROOT / "scenes" / name):
                self.assertIn(scene, everything)

    def test_starts_name_scenes_and_metrics_that_are_there(self):
        for name, (options, metrics) in run_scenes.starts_in().items():
            self.assertIn(options[0], ("--seeds", "--set"))
            expected = read_scene(run_scenes.ROOT / "scenes" / f"{name}.json")["expect"]
            self.assertLessEqual(metrics, {e["metric"] for e in expected})

    def test_every_scene_expects_something(self):
        for name, (_, path) in run_scenes.jobs("brim", Path("out"), Path("plugin")).items():
            if path is not None:
                self.assertTrue(read_scene(path).get("expect"), f"{name} expects nothing")

    def test_the_known_misses_of_pairs_name_pairs(self):
        kinds = {k["name"] for k in read_scene(run_scenes.PAIRS / "kinds.json")["kinds"]}
        user = {k["name"] for k in read_scene(run_scenes.ROOT / run_scenes.USER_KIND[1])["kinds"]}
        misses = json.loads((run_scenes.PAIRS / "known_misses.json").read_text(encoding="utf-8"))
        self.assertEqual(set(misses), set(run_scenes.PAIR_TABLES))
        for table, pairs in misses.items():
            for pair, why in pairs.items():
                self.assertLessEqual(set(pair.split(" on ")), kinds | user)
                self.assertEqual(bool(set(pair.split(" on ")) & user), table.startswith("user_"))
                self.assertTrue(why)

    def test_the_page_of_pairs_says_why_each_known_miss_fails(self):
        own, user = (read_scene(path) for path in (run_scenes.PAIRS / "kinds.json", run_scenes.ROOT / run_scenes.USER_KIND[1]))
        misses = read_scene(run_scenes.PAIRS / "known_misses.json")
        for table, pairs in misses.items():
            name = table.removeprefix("user_")
            kind = "constraint_notes" if name == "constraint" else "notes"
            notes = []
            for source in (own, user):
                where = source if name in ("penalty", "constraint") else source.get("worlds", {}).get(name, {})
                notes += where.get(kind, [])
            told = {pair for note in notes for pair in note["pairs"]}
            for pair in pairs:
                self.assertTrue({pair, *pair.split(" on ")} & told, f"no note of {table} is about {pair}")


if __name__ == "__main__":
    unittest.main()
