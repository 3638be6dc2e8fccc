"""What one may do by mistake: it is told, and nothing of the world is another for it."""

import _thread
import pathlib
import tempfile
import threading
import time
import unittest

import brim
from world_test import ball_world
import numpy as np


def sheet(cells: int) -> dict:
    side = np.linspace(-0.5, 0.5, cells + 1)
    x, y = np.meshgrid(side, side)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    triangles = np.concatenate([np.stack([first, first + 1, first + cells + 2], axis=1),
                                np.stack([first, first + cells + 2, first + cells + 1], axis=1)])
    return {"vertices": vertices, "triangles": triangles, "areal_density": 0.5, "thickness": 0.04}


class Misuse(unittest.TestCase):
    def test_ctrl_c_ends_a_step_that_takes_long_and_undoes_it(self):
        # Some 20,000 nodes fall on a floor, in up to 64 sub-steps: half a minute.
        world = brim.World(time_step=1.0, cg_tolerance=1e-9)
        world.add("obstacle", name="floor", shape={"kind": "plane"}, voxel_size=0.02)
        world.add("finite_elements", name="block", shape=brim.box([0.5, 0.5, 0.5]), lattice_spacing=0.02, transform={"position": [0, 0, 0.4]})
        before = world["block"].q.copy()
        began = time.monotonic()
        threading.Timer(0.5, _thread.interrupt_main).start()
        with self.assertRaises(KeyboardInterrupt):
            world.step()
        self.assertLess(time.monotonic() - began, 10.0)
        self.assertEqual(world.time, 0.0)
        np.testing.assert_array_equal(world["block"].q, before)

    def test_arrays_of_a_refused_body_replace_no_others(self):
        world = brim.World(voxel_size=0.05)
        world.add("cloth", name="sheet", **sheet(10))
        with self.assertRaises(brim.InputError):
            world.add("cloth", name="sheet", **sheet(4))
        with tempfile.TemporaryDirectory() as folder:
            world.save_scene(f"{folder}/s.json")
            again = brim.load(f"{folder}/s.json")
            self.assertEqual(again["sheet"].q.size, 3 * 121)
            self.assertEqual(len(list(pathlib.Path(folder, "arrays").iterdir())), 1)

    def test_arrays_of_names_alike_are_their_own_and_stay_in_the_folder(self):
        world = brim.World(voxel_size=0.05)
        cells = {"../../evil": 3, "a.0": 4, "a": 5, "a_0": 6}
        for name, n in cells.items():
            world.add("cloth", name=name, transform={"position": (0, 0, n)}, **sheet(n))
        with tempfile.TemporaryDirectory() as outer:
            folder = pathlib.Path(outer, "in", "ner")
            folder.mkdir(parents=True)
            world.save_scene(folder / "s.json")
            self.assertEqual(sorted(p.name for p in pathlib.Path(outer).iterdir()), ["in"])
            again = brim.load(folder / "s.json")
            for name, n in cells.items():
                self.assertEqual(again[name].q.size, 3 * (n + 1) ** 2, name)

    def test_a_body_of_another_world_is_refused(self):
        one, other = brim.World(voxel_size=0.1), brim.World(voxel_size=0.1)
        for world in (one, other):
            world.add("rigid", name="a", shape=brim.sphere(0.2))
            world.add("rigid", name="b", shape=brim.sphere(0.2), transform={"position": (1, 0, 0)})
        with self.assertRaisesRegex(brim.InputError, "of another world"):
            one.remove(other["b"])
        with self.assertRaisesRegex(brim.InputError, "of another world"):
            one.force(one["a"], other["b"])
        self.assertEqual(len(one.bodies), 2)

    def test_numbers_out_of_range_are_refused(self):
        world = brim.World(voxel_size=0.1, materials={"ice": {"friction": 0}})
        with self.assertRaisesRegex(brim.InputError, "friction: -1 is not allowed"):
            world.set_pair("ice", "ice", friction=-1)
        with self.assertRaisesRegex(brim.InputError, "must be the name of a kind"):
            world.add(5)

    def test_a_number_of_frames_is_whole(self):
        world = brim.World(voxel_size=0.1)
        world.add("rigid", name="ball", shape=brim.sphere(0.2))
        for frames in (2.5, 2.0, "2"):
            with self.assertRaisesRegex(TypeError, "frames: .* is not allowed; must be a whole number from 0"):
                world.run(frames=frames)
        with self.assertRaisesRegex(ValueError, "frames: -1 is not allowed"):
            world.run(frames=-1)
        self.assertEqual(world.run(frames=np.int64(2)).all().number, 2)

    def test_what_a_force_may_not_do_is_refused_in_words(self):
        world, ball = ball_world()
        before = world.hash

        def gives_nothing(t, x, v):
            return None

        for function, error, words in (
            (gives_nothing, ValueError, "gives_nothing: gave None; must give numbers"),
            (lambda t, x, v: world.step(), RuntimeError, "in the middle of a step"),
            (lambda t, x, v: world.add("rigid", shape=brim.sphere(0.1)), RuntimeError, "in the middle of a step"),
            (lambda t, x, v: world.restore(world.save()), RuntimeError, "in the middle of a step"),
        ):
            ball.force(function)
            with self.assertRaisesRegex(error, words):
                world.step()
            ball.remove_force(function)
        self.assertEqual(world.hash, before)
        self.assertEqual(len(world), 2)
        ball.force(lambda t, x, v: (0 * world.time, ball.center[0], 0))
        world.step()

    def test_shapes_of_vectors_and_actions_are_told(self):
        world, ball = ball_world()
        with self.assertRaisesRegex(brim.InputError, r"gravity: shape \(2,\) is not allowed; must be \(3,\)"):
            world.set_gravity((0, 0))
        for ask, words in ((lambda: ball.set_velocity((0, 0)), r"velocity: shape \(2,\) is not allowed; must be \(3,\)"),
                           (lambda: ball.set_velocity((0, 0, 0), 1.0), r"angular_velocity: shape \(\) is not allowed"),
                           (lambda: ball.set_velocity("fast"), "velocity: 'fast' is not allowed; must be numbers"),
                           (lambda: ball.move((0, 0)), r"by: shape \(2,\) is not allowed"),
                           (lambda: ball.move(rotation=(1, 0, 0)), "must be a quaternion"),
                           (lambda: ball.move(rotation=(0, 0, 0, 0)), "must have a length and finite numbers"),
                           (lambda: ball.grab((1, 2)), r"at: shape \(2,\) is not allowed")):
            with self.assertRaisesRegex(brim.InputError, words):
                ask()
        with tempfile.TemporaryDirectory() as folder:
            world.run(frames=1, record=f"{folder}/run").all()
            with self.assertRaisesRegex(brim.InputError, "holds a run already; .*force=True"):
                world.run(frames=1, record=f"{folder}/run").all()

        class Nothing(brim.Env):
            def build(self):
                return ball_world()[0]

            def act(self, action):
                pass

            def observe(self):
                return 0.0

        envs = brim.Envs(Nothing, 2)
        for actions, words in ((None, "actions: None is not allowed; there are 2 environments"), ([1], "actions: 1 are not allowed")):
            with self.assertRaisesRegex(ValueError, words):
                envs.step(actions)
        envs.close()

    def test_a_removed_body_is_not_written(self):
        world, ball = ball_world()
        before = world.save()
        world.remove(ball)
        with self.assertRaisesRegex(ValueError, "read-only"):
            ball.q[0] = 5
        with self.assertRaisesRegex(ValueError, "read-only"):
            ball.v = 0
        world.restore(before)
        ball.q[0] = 0.1
        world.step()

    def test_a_library_that_is_no_plugin_is_refused(self):
        library = brim._core.__file__  # one that is there
        with self.assertRaisesRegex(brim.InputError, f"load_plugin: {library}: is no plugin of brim"):
            brim.load_plugin(library)
        with self.assertRaisesRegex(brim.InputError, "load_plugin: .*none.so.*cannot open"):
            brim.load_plugin("none.so")

    def test_a_filter_from_before_the_first_step_outlives_a_restored_state(self):
        def world() -> brim.World:
            w = brim.World(voxel_size=0.1)
            w.add("obstacle", name="floor", shape=brim.plane())
            w.add("rigid", name="ball", shape=brim.sphere(0.2), transform={"position": (0, 0, 0.5)})
            return w

        plain, filtered = world(), world()
        state = plain.save()
        filtered.set_touch("ball", "floor", False)
        filtered.restore(state)
        for _ in range(240):
            filtered.step()
        self.assertLess(filtered["ball"].q[2], -1.0)

    def test_a_restored_world_tells_nothing_of_what_was_before(self):
        world = brim.World(voxel_size=0.1)
        world.add("obstacle", name="floor", shape=brim.plane())
        world.add("rigid", name="ball", shape=brim.sphere(0.2), transform={"position": (0, 0, 0.3)})
        start = world.save()
        for _ in range(120):
            world.step()
        self.assertGreater(len(world.contacts["position"]), 0)
        world.restore(start)
        self.assertEqual(len(world.contacts["position"]), 0)
        self.assertEqual(len(world.tiles[0]), 0)
        with self.assertRaises(brim.InputError):
            world["ball"].q[3:] = 0.0
            world.step()


if __name__ == "__main__":
    unittest.main()
