"""Scenes: loading, saving, recording, and the bits of the program."""

import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

import brim
from world_test import CUBE, CUBE_TETS, ball_world, sheet_arrays

SOURCE, PROGRAM = Path(os.environ["BRIM_SOURCE"]), os.path.join(os.environ["BRIM_BUILD"], "brim")

SCENE = {
    "brim": 1, "name": "small", "frames": 12, "steps_per_frame": 2,
    "world": {"voxel_size": 0.05, "time_step": 0.01},
    "materials": {"ice": {"friction": 0.05}},
    "bodies": [
        {"kind": "obstacle", "name": "floor", "shape": {"kind": "plane"}},
        {"kind": "rigid", "name": "ball", "material": "ice", "shape": {"kind": "sphere", "radius": 0.2},
         "transform": {"position": [0, 0, 0.21]}, "velocity": [1, 0, 0]},
        {"kind": "cloth", "name": "sheet", "grid": {"size": [1, 1], "cells": [8, 8]},
         "transform": {"position": [0, 0, 0.5]}},
    ],
    "expect": [{"metric": "worst_overlap", "max": 3}, {"metric": "speed", "body": "ball", "min": 1000}],
}


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_program(self, scene, out, *more):
        subprocess.run([PROGRAM, "run", str(scene), "-o", str(out), "--quiet", *more], check=True,
                       stdout=subprocess.DEVNULL)
        return brim.Run(out)


class Levels(Folder):
    SCENE = {**SCENE, "world": {**SCENE["world"], "levels": {"bodies": {"ball": 1, "sheet": 2}}}}

    def test_a_loaded_world_has_the_levels_of_its_scene(self):
        path = self.folder / "coarse.json"
        path.write_text(json.dumps(self.SCENE))
        theirs = self.run_program(path, self.folder / "program")
        world = brim.load(path)
        for frame in range(1, 13):
            for _ in range(SCENE["steps_per_frame"]):
                world.step()
            self.assertEqual(world.save(), theirs.state(frame))
        path.write_text(json.dumps(SCENE))
        self.assertNotEqual(self.run_program(path, self.folder / "fine").state(12), theirs.state(12))

    def test_levels_may_name_bodies_that_are_added_later(self):
        path = self.folder / "coarse.json"
        path.write_text(json.dumps(self.SCENE))
        loaded = brim.load(path)
        world = brim.World(**self.SCENE["world"], materials=SCENE["materials"], steps_per_frame=2)
        for entry in SCENE["bodies"]:
            keys = dict(entry)
            world.add(keys.pop("kind"), **keys)
        for _ in range(12):
            loaded.step(), world.step()
        self.assertEqual(loaded.save(), world.save())
        loaded.add("rigid", name="late", shape={"kind": "sphere", "radius": 0.1}, transform={"position": [0, 0, 2]})
        loaded.step()

    def test_levels_out_of_range_are_refused(self):
        with self.assertRaisesRegex(brim.InputError, "levels/bodies/ball: 9"):
            brim.World(levels={"bodies": {"ball": 9}})


class Scenes(Folder):
    def test_a_scene_file_has_the_bits_of_the_program(self):
        path = self.folder / "small.json"
        path.write_text(json.dumps(SCENE))
        theirs = self.run_program(path, self.folder / "program")
        world = brim.load(path)
        self.assertEqual((world.name, len(world)), ("small", 3))
        frames = list(world.run(record=self.folder / "python"))
        self.assertEqual(len(frames), 12)
        ours = brim.Run(self.folder / "python")
        self.assertEqual(len(ours), len(theirs))
        for frame in range(len(ours)):
            self.assertEqual(ours.state(frame), theirs.state(frame))
        np.testing.assert_array_equal(ours["sheet"].positions, theirs["sheet"].positions)
        np.testing.assert_array_equal(ours.series("worst_overlap"), theirs.series("worst_overlap"))
        self.assertEqual((self.folder / "python/scene.json").read_bytes(), path.read_bytes())
        # The summary is that of the program as well, but for times.
        sums = [json.loads((self.folder / who / "summary.json").read_text()) for who in ("python", "program")]
        for key in ("expect", "steps", "contacts"):
            self.assertEqual(sums[0].get(key), sums[1].get(key))

    def test_parameters_are_set_as_by_the_program(self):
        path = self.folder / "small.json"
        bodies = [dict(body) for body in SCENE["bodies"]]
        bodies[1]["velocity"] = ["=speed", 0, 0]
        path.write_text(json.dumps({**SCENE, "parameters": {"speed": 1}, "bodies": bodies}))
        self.assertEqual(brim.load(path)["ball"].v[0], 1)
        world = brim.load(path, set={"speed": 2.5, "/world/time_step": 0.005})
        self.assertEqual(world["ball"].v[0], 2.5)
        self.run_program(path, self.folder / "program", "--set", "speed=2.5", "--set", "/world/time_step=0.005")
        world.run(record=self.folder / "python").all()
        self.assertEqual(brim.Run(self.folder / "program").state(12), brim.Run(self.folder / "python").state(12))
        with self.assertRaisesRegex(brim.InputError, 'did you mean "speed"'):
            brim.load(path, set={"sped": 2})
        with self.assertRaisesRegex(brim.InputError, "random"):
            brim.load(path, seed=3)

    def test_findings_come_with_a_recorded_run(self):
        path = self.folder / "small.json"
        path.write_text(json.dumps(SCENE))
        run = brim.load(path).run(record=self.folder / "run")
        run.all()
        self.assertEqual([(f["metric"], f["ok"]) for f in run.findings], [("worst_overlap", True), ("speed", False)])

    def test_a_world_built_of_keys_is_that_of_the_file(self):
        path = self.folder / "small.json"
        path.write_text(json.dumps(SCENE))
        loaded = brim.load(path)
        built = brim.World(materials=SCENE["materials"], **SCENE["world"])
        for body in SCENE["bodies"]:
            built.add(**body)
        for _ in range(10):
            loaded.step(), built.step()
        self.assertEqual(loaded.hash, built.hash)

    def test_a_world_of_arrays_saves_as_a_scene_with_the_same_bits(self):
        world = brim.World(voxel_size=0.05, name="arrays")
        world.add("obstacle", name="floor", shape=brim.plane())
        vertices, triangles = sheet_arrays(z=1 / 3)
        world.add("cloth", name="sheet", vertices=vertices * np.pi, triangles=triangles, thickness=0.04)
        world.add("finite_elements", name="soft", vertices=CUBE / 3 + (0, 0, 1.5), tetrahedra=CUBE_TETS,
                  young_modulus=1e5)
        ct = np.zeros((12, 12, 12))
        ct[2:-2, 2:-2, 2:-2] = 800
        world.add("image_volume", name="bone", intensities=ct, spacing=(0.03, 0.03, 0.04), window=(300, 500),
                  transform={"position": (0.5, 0, 1.7)})
        scene = self.folder / "scene" / "arrays.json"
        world.save_scene(scene, frames=6)
        self.assertEqual(sorted(p.name for p in (scene.parent / "arrays").iterdir()),
                         ["bone.nrrd", "sheet.ply", "soft.vtk"])
        theirs = self.run_program(scene, self.folder / "program")
        world.run(6, record=self.folder / "python").all()
        ours = brim.Run(self.folder / "python")
        self.assertEqual(ours.state(-1), theirs.state(-1))
        # The recorded run can be gone on with by the program: its scene and arrays are beside it.
        more = self.run_program(self.folder / "python/scene.json", self.folder / "again")
        self.assertEqual(more.state(-1), ours.state(-1))

    def test_bodies_added_to_a_loaded_scene_are_recorded_with_it(self):
        path = self.folder / "small.json"
        path.write_text(json.dumps(SCENE))
        world = brim.load(path)
        world.add("rigid", name="late", shape=brim.box((0.1, 0.1, 0.1)), transform={"position": (0, 0, 1)})
        world.run(2, record=self.folder / "run").all()
        theirs = self.run_program(self.folder / "run/scene.json", self.folder / "again")
        self.assertEqual(brim.Run(self.folder / "run").state(-1), theirs.state(-1))

    def test_messages_of_files_name_file_and_line(self):
        path = self.folder / "bad.json"
        path.write_text('{"brim": 1, "name": "bad", "frames": 1,\n "bodies": [{"kind": "rigit", "name": "a"}]}')
        with self.assertRaisesRegex(brim.InputError, r'bad.json:2: /bodies/0/kind: "rigit".*did you mean "rigid"'):
            brim.load(path)
        with self.assertRaisesRegex(brim.InputError, "no such file"):
            brim.load(self.folder / "none.json")


class Runs(Folder):
    def test_frames_are_counted_timed_and_joined(self):
        world, _ = ball_world(steps_per_frame=3)
        frames = list(world.run(4))
        self.assertEqual([f.number for f in frames], [1, 2, 3, 4])
        np.testing.assert_allclose([f.time for f in frames], np.arange(1, 5) * 3 / 60)
        self.assertEqual(frames[-1].report.substeps, world.report.substeps)
        self.assertGreaterEqual(frames[0].report.substeps, 3)

    def test_a_recorded_run_opens_as_arrays(self):
        world, ball = ball_world(voxel_size=0.05, height=0.2)
        states = [world.save()]
        for _ in world.run(20, record=self.folder / "run"):
            states.append(world.save())
        run = brim.Run(self.folder / "run")
        self.assertEqual((len(run), run.name, [b.name for b in run.bodies]), (21, "world", ["floor", "ball"]))
        np.testing.assert_allclose(run.times, np.arange(21) / 60, atol=1e-12)
        recorded = run["ball"]
        self.assertEqual(recorded.positions.shape, (21, len(ball.positions), 3))
        np.testing.assert_array_equal(recorded.positions[-1], recorded.positions_at(20))
        np.testing.assert_allclose(recorded.positions[-1], ball.positions, atol=1e-6)
        self.assertEqual(recorded.triangles.shape[1], 3)
        np.testing.assert_allclose(recorded.force[-1], ball.contact_force, rtol=1e-6)
        self.assertGreater(recorded.impulse[:, 2].max(), 0)
        momentum = ball.mass * (np.diff(recorded.velocity[:, 2]) + 9.81 / 60)
        np.testing.assert_allclose(recorded.impulse[1:, 2], momentum, rtol=1e-5, atol=1e-6 * ball.mass)
        np.testing.assert_array_equal(recorded.q(-1), ball.q)
        np.testing.assert_array_equal(recorded.v(20), ball.v)
        np.testing.assert_array_equal(run.contacts(-1), world.contacts)
        np.testing.assert_array_equal(run.pairs(-1)["force"], world.pairs["force"])
        self.assertEqual([run.state(f) for f in range(21)], states)
        world.restore(run.state(7))
        world.step()
        self.assertEqual(world.save(), states[8])
        self.assertEqual(run.series("contacts").shape, (21,))
        for wrong in (lambda: run.state(21), lambda: run.series("none"), lambda: brim.Run(self.folder / "none")):
            with self.assertRaises(brim.InputError):
                wrong()
        with self.assertRaises(KeyError):
            run["none"]

    def test_a_run_that_is_left_keeps_its_frames(self):
        world, _ = ball_world()
        for frame in world.run(20, record=self.folder / "run"):
            if frame.number == 5:
                break
        self.assertEqual(json.loads((self.folder / "run/summary.json").read_text())["end"], "interrupted")
        self.assertEqual(len(brim.Run(self.folder / "run")), 6)

    def test_an_exception_in_a_run_keeps_its_frames_and_is_raised(self):
        world, ball = ball_world()

        @ball.force
        def late(t, x, v):
            if t > 0.05:
                raise OverflowError("late")
            return 0

        with self.assertRaises(OverflowError):
            world.run(20, record=self.folder / "run").all()
        self.assertEqual(len(brim.Run(self.folder / "run")), 5)

    def test_old_runs_are_not_replaced_unless_told(self):
        world, _ = ball_world()
        world.run(1, record=self.folder / "run").all()
        with self.assertRaisesRegex(brim.InputError, "run"):
            world.run(1, record=self.folder / "run")
        world.run(2, record=self.folder / "run", force=True).all()
        self.assertEqual(len(brim.Run(self.folder / "run")), 3)

    def test_own_bodies_are_recorded_but_not_saved(self):
        from own_body_test import Blob
        world, _ = ball_world()
        world.add(Blob(surface=brim.sphere(0.3), name="blob"))
        with self.assertRaisesRegex(brim.InputError, "written in Python"):
            world.save_scene(self.folder / "scene.json")
        world.run(2, record=self.folder / "run").all()
        self.assertEqual(brim.Run(self.folder / "run")["blob"].kind, "Blob")


if __name__ == "__main__":
    unittest.main()
