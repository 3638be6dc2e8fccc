"""Editing a world between its steps: every edit from Python, and runs that were edited."""

import os
import pickle
import tempfile
import unittest

import brim
import numpy as np


def stack() -> brim.World:
    world = brim.World(voxel_size=0.1, materials={"ice": {"friction": 0}, "rubber": {"friction": 1}})
    world.add("obstacle", name="floor", shape=brim.plane(), material="rubber")
    for i in range(3):
        world.add("rigid", name=f"box_{i}", shape=brim.box((0.5, 0.5, 0.5)), material="rubber",
                  transform={"position": (0, 0, 0.25 + 0.5 * i)})
    return world


class Editing(unittest.TestCase):
    def test_a_removed_body_is_gone_and_an_earlier_state_brings_it_back(self):
        world = stack()
        world.run(frames=5).all()
        saved = world.save()
        box = world["box_1"]
        view = box.q
        last = view.copy()
        world.remove(box)
        self.assertTrue(box.removed)
        self.assertEqual([b.name for b in world.bodies], ["floor", "box_0", "box_2"])
        with self.assertRaises(KeyError):
            world["box_1"]
        world.run(frames=60).all()
        np.testing.assert_array_equal(view, last)
        self.assertAlmostEqual(world["box_2"].q[2], 0.75, delta=0.03)
        with self.assertRaisesRegex(brim.InputError, "remove: 'box_1' was removed"):
            box.remove()
        world.restore(saved)
        self.assertFalse(box.removed)
        twin = stack()
        twin.run(frames=5).all()
        self.assertEqual(world.save(), twin.save())

    def test_a_frozen_body_stays_and_takes_no_velocity(self):
        world = stack()
        box = world["box_2"]
        box.freeze()
        world["box_1"].remove()
        z = box.q[2]
        box.v[:] = 1.0
        world.run(frames=20).all()
        self.assertTrue(box.frozen)
        self.assertEqual(box.q[2], z)
        np.testing.assert_array_equal(box.v, 0)
        box.thaw()
        world.run(frames=60).all()
        self.assertAlmostEqual(box.q[2], 0.75, delta=0.03)

    def test_an_impulse_changes_the_velocities_at_once(self):
        world = stack()
        box = world["box_2"]
        center = box.center
        at = world.apply_impulse("box_2", (1, 0, 0), center + (0, 0, 0.25))
        np.testing.assert_allclose(at, center + (0, 0, 0.25))
        np.testing.assert_allclose(box.v[:3], (1 / box.mass, 0, 0), atol=1e-12)
        np.testing.assert_allclose(box.v[3:], (0, 0.25 / (box.mass * 0.5 ** 2 / 6), 0), atol=1e-9)
        box.v[:] = 0
        np.testing.assert_array_equal(box.v, 0)
        for call, words in (
            (lambda: world.apply_impulse("floor", (1, 0, 0), center), "'floor' .obstacle. does not move by forces"),
            (lambda: world.apply_impulse(box, (np.nan, 0, 0), center), "finite numbers"),
            (lambda: world.apply_impulse(box, (1, 0), center), r"impulse: shape \(2,\)"),
        ):
            with self.assertRaisesRegex(brim.InputError, words):
                call()
        np.testing.assert_array_equal(box.v, 0)

    def test_a_hand_pulls_a_body_and_is_in_no_state(self):
        world = stack()
        box = world["box_2"]
        self.assertIsNone(world.grabbed)
        with self.assertRaisesRegex(brim.InputError, "pull: nothing is grabbed"):
            world.pull((0, 0, 1))
        with self.assertRaisesRegex(brim.InputError, "grab: 'floor' does not move"):
            world["floor"].grab((0, 0, 0))
        start = world.save()
        box.grab()
        self.assertEqual(world.grabbed, box)
        world.pull((0, 0, 2.5))
        world.run(frames=90).all()
        self.assertAlmostEqual(box.center[2], 2.5, delta=0.05)
        world.release()
        self.assertIsNone(world.grabbed)
        world.restore(start)
        world.step()
        after = world.hash
        world.restore(start)
        box.grab((0.25, 0.25, 1.5), stiffness=1e3, damping=10)
        world.release()
        world.step()
        self.assertEqual(world.hash, after)

    def test_move_and_set_velocity(self):
        world = stack()
        box = world["box_2"]
        box.move((0, 0, 1))
        np.testing.assert_allclose(box.center, (0, 0, 2.25), atol=1e-12)
        box.move(to=(1, 0, 2), rotation=(np.sqrt(0.5), 0, 0, np.sqrt(0.5)))
        np.testing.assert_allclose(box.q, (1, 0, 2, np.sqrt(0.5), 0, 0, np.sqrt(0.5)), atol=1e-12)
        box.move(rotation=[[0, -1, 0], [1, 0, 0], [0, 0, 1]], about=(0, 0, 0))
        np.testing.assert_allclose(box.center, (0, 1, 2), atol=1e-12)
        box.set_velocity((1, 2, 3), angular_velocity=(0, 0, 4))
        np.testing.assert_allclose(box.v, (1, 2, 3, 0, 0, 4), atol=1e-12)
        pin = world.attach(box, point=(0, 1, 2))
        with self.assertRaisesRegex(brim.InputError, f"is held by '{pin.name}'; detach it first"):
            box.move((0, 0, 1))
        with self.assertRaisesRegex(ValueError, "must be a quaternion"):
            world["box_1"].move(rotation=(1, 2, 3))
        with self.assertRaisesRegex(brim.InputError, "finite numbers"):
            world["box_1"].move((np.nan, 0, 0))

    def test_a_driven_obstacle_pushes_and_carries(self):
        world = brim.World(voxel_size=0.1)
        plate = world.add("obstacle", name="plate", shape=brim.box((6, 2, 0.4)), transform={"position": (0, 0, -0.2)})
        box = world.add("rigid", shape=brim.box((0.5, 0.5, 0.5)), transform={"position": (0, 0, 0.25)})
        plate.set_velocity((0.5, 0, 0))
        world.run(frames=60).all()
        saved = world.save()
        self.assertAlmostEqual(plate.q[0], 0.5, delta=1e-9)
        self.assertAlmostEqual(box.v[0], 0.5, delta=0.02)
        turn = (np.cos(0.1), 0, 0, np.sin(0.1))
        plate.set_target((0.6, 0, -0.2))
        world.step()
        np.testing.assert_allclose(plate.q[:3], (0.6, 0, -0.2), atol=1e-12)
        plate.set_target(rotation=turn, duration=0.5)
        world.run(frames=40).all()
        np.testing.assert_allclose(plate.q, (0.6, 0, -0.2, *turn), atol=1e-12)
        np.testing.assert_array_equal(plate.v, 0)
        world.restore(saved)
        world.step()
        self.assertAlmostEqual(plate.v[0], 0.5, delta=1e-12)
        with self.assertRaisesRegex(brim.InputError, r"\(rigid\) moves by forces; obstacles are driven"):
            box.set_target((0, 0, 1))
        with self.assertRaisesRegex(brim.InputError, "finite numbers"):
            plate.set_target((np.nan, 0, 0))

    def test_materials(self):
        world = stack()
        world.set_gravity((3, 0, -9.81))
        box = world["box_0"]
        self.assertEqual(box.material, {"name": "rubber", "friction": 1.0, "restitution": 0.0, "rolling_resistance": 0.0, "response": "inherit"})
        box.material = "ice"
        self.assertEqual(box.material["friction"], 0.0)
        world["box_1"].set_material(friction=0.25)
        self.assertEqual(world["box_1"].material["name"], "rubber")
        world.set_material("rubber", restitution=0.5)
        self.assertEqual([b.material["restitution"] for b in world.bodies], [0.5, 0, 0.5, 0.5])
        world.set_pair("ice", "rubber", friction=0.7)
        world.set_stiffness(1e6)
        self.assertEqual(world.step().stiffness, 1e6)
        with self.assertRaisesRegex(brim.InputError, 'material "wood" is not one of the world\'s; those are "default", "fluid", "ice"'):
            box.material = "wood"
        with self.assertRaisesRegex(brim.InputError, 'material of "box_0": roughness is not known'):
            box.set_material(roughness=1)
        with self.assertRaisesRegex(brim.InputError, "friction -1 is not allowed; must be a number from 0"):
            box.set_material(friction=-1)
        with self.assertRaises(KeyError):
            world.set_material("wood", friction=1)

    def test_an_edited_run_goes_on_from_any_frame_of_its_recording_with_the_same_bits(self):
        with tempfile.TemporaryDirectory() as folder:
            path, record = os.path.join(folder, "scene.json"), os.path.join(folder, "run")
            stack().save_scene(path, frames=20)
            world = brim.load(path)
            states = [world.save()]
            for frame in world.run(frames=20, record=record):
                states.append(world.save())
                if frame.number == 4:
                    world["box_0"].freeze()
                if frame.number == 8:
                    world["box_1"].remove()
                    world.set_gravity((1, 0, -5))
                if frame.number == 12:
                    world["box_2"].material = "ice"
                    world["box_2"].move((0.5, 0, 0.2))
            run = brim.Run(record)
            for first in (3, 4, 9, 13, 16):
                again = brim.load(path)
                again.restore(run.state(first))
                self.assertEqual(again.save(), states[first])
                if first in (3, 4):
                    continue  # edits come after these, which nobody makes here
                if first == 9:
                    for _ in range(3):
                        again.step()
                    self.assertEqual(again.save(), states[12])
                else:
                    while again.time < world.time - 1e-9:
                        again.step()
                    self.assertEqual(again.save(), world.save())
            shown = run["box_1"].positions
            self.assertGreater(np.ptp(shown[8], axis=0).min(), 0.1)
            np.testing.assert_array_equal(np.ptp(shown[9:], axis=1), 0)
            self.assertEqual(pickle.loads(pickle.dumps(states[-1])), states[-1])

    def test_bodies_added_while_recording_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            world = stack()
            with self.assertRaisesRegex(brim.InputError, "add bodies before a recording begins"):
                for _ in world.run(frames=3, record=os.path.join(folder, "run")):
                    world.add("rigid", name="late", shape=brim.sphere(0.1), transform={"position": (3, 0, 1)})


if __name__ == "__main__":
    unittest.main()
