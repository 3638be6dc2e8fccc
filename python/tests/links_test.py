"""Attachments, joints, forces and filters from Python."""

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

import brim
from world_test import ball_world, sheet_arrays


class Links(unittest.TestCase):
    def test_a_spring_carries_the_weight_and_says_so(self):
        world, ball = ball_world(height=5.0)
        k = 1e4
        spring = world.attach(ball, point=(0, 0, 5), stiffness=k, damping=2 * np.sqrt(k * ball.mass))
        self.assertTrue(np.isnan(spring.force).all())
        world.run(frames=240).all()
        weight = 9.81 * ball.mass
        np.testing.assert_allclose(spring.force, (0, 0, weight), atol=1e-3 * weight)
        self.assertAlmostEqual(spring.error, weight / k, places=5)
        self.assertAlmostEqual(ball.q[2], 5 - weight / k, places=5)
        spring.detach()
        self.assertTrue(spring.broken)
        before = ball.v[2]
        world.step()
        self.assertAlmostEqual(ball.v[2] - before, -9.81 / 60, places=6)

    def test_a_sheet_hangs_on_a_region_of_it(self):
        world = brim.World()
        vertices, triangles = sheet_arrays()
        sheet = world.add("cloth", vertices=vertices, triangles=triangles, thickness=0.02)
        most = vertices[:, 0].max()
        world.attach(sheet, region={"kind": "plane", "point": (most - 1e-6, 0, 0), "normal": (-1, 0, 0)})
        world.run(frames=30).all()
        edge = vertices[:, 0] > most - 1e-6
        # Rigid is as stiff as the solve bears: 1.7 mm where the whole sheet swings on its edge.
        self.assertLess(np.abs(sheet.positions[edge] - vertices[edge]).max(), 3e-3)
        self.assertLess(sheet.positions[:, 2].min(), vertices[:, 2].min() - 0.1)

    def test_particles_of_a_fluid_are_glued_to_a_plate_that_turns(self):
        world = brim.World(voxel_size=0.025, gravity=(0, 0, 0))
        plate = world.add("rigid", shape=brim.box((0.4, 0.4, 0.05)), transform={"position": (0, 0, 0)})
        water = world.add("particle_fluid", shape=brim.box((0.2, 0.2, 0.1)), spacing=0.05, viscosity=5,
                          transform={"position": (0, 0, 0.075)})
        start = water.positions.copy()
        lowest = start[:, 2] < start[:, 2].min() + 1e-3
        glue = world.attach(water, to=plate, region={"kind": "box", "lo": (-1, -1, 0), "hi": (1, 1, 0.06)}, touch=False)
        plate.v[:] = 0, 0, 0, 0, 0, 0.5
        world.run(frames=30).all()
        angle = 2 * np.arctan2(plate.q[6], plate.q[3])
        self.assertGreater(angle, 0.05)
        turned = np.c_[start[:, 0] * np.cos(angle) - start[:, 1] * np.sin(angle),
                       start[:, 0] * np.sin(angle) + start[:, 1] * np.cos(angle), start[:, 2]]
        at = plate.q[:3]
        self.assertLess(np.abs(water.positions[lowest] - turned[lowest] - at).max(), 2e-3)
        glue.detach()
        world.step()
        self.assertTrue(glue.broken)

    def test_a_motor_turns_and_is_aimed_anew(self):
        world, ball = ball_world(height=5.0, gravity=(0, 0, 0))
        axle = world.joint(ball, kind="revolute", position=(0, 0, 5), drive={"damping": 100, "target_velocity": 2})
        world.run(frames=60).all()
        self.assertAlmostEqual(ball.v[5], 2, places=3)
        axle.set_drive(velocity=-1)
        world.run(frames=60).all()
        self.assertAlmostEqual(ball.v[5], -1, places=3)
        self.assertEqual([a.name for a in world.attachments], [axle.name])

    def test_filters_forces_and_gravity(self):
        world, ball = ball_world(height=0.2)
        floor = world.bodies[0] if world.bodies[0].number != ball.number else world.bodies[1]
        world.set_touch(ball, floor)
        world.step()
        self.assertEqual(len(world.contacts), 0)
        world.set_touch(ball, floor, True)
        world.set_gravity((0, 0, 0))
        ball.v[:] = 0
        world.apply_force(ball, force=(6, 0, 0))
        world.step()
        self.assertAlmostEqual(ball.linear_momentum[0], 6 / 60, delta=0.03)

    def test_a_force_ends_by_its_name_and_a_state_from_before_brings_it_back(self):
        world, ball = ball_world(height=5.0, gravity=(0, 0, 0))
        first = world.apply_force(ball, force=(6, 0, 0))
        self.assertEqual(first, "force_1")
        self.assertEqual(world.apply_force(ball, name="push", force=(0, 12, 0)), "push")
        before = world.save()
        world.remove_force(first)
        world.step()
        np.testing.assert_allclose(ball.linear_momentum, (0, 12 / 60, 0), atol=1e-12)
        self.assertEqual(world.apply_force(ball, force=(6, 0, 0)), "force_2")
        self.assertEqual(world.apply_force(ball, force=(6, 0, 0)), "force_3")
        world.remove_force("force_2")
        self.assertEqual(world.apply_force(ball, force=(6, 0, 0)), "force_4", "force_3 is taken")
        with self.assertRaisesRegex(brim.InputError, '^remove_force: "force_1" is not one of the world\'s forces; '
                                                     'those are "push", "force_3", "force_4"$'):
            world.remove_force(first)
        with tempfile.TemporaryDirectory() as folder:
            world.save_scene(Path(folder) / "scene.json", frames=10)
            saved = json.loads((Path(folder) / "scene.json").read_text())["forces"]
        self.assertEqual([force["name"] for force in saved], ["push", "force_3", "force_4"])
        world.restore(before)
        world.step()
        np.testing.assert_allclose(ball.linear_momentum, (6 / 60, 12 / 60, 0), atol=1e-12)

    def test_a_filter_that_names_no_body_and_errors_that_name_a_link_once(self):
        world, ball = ball_world(height=5.0)
        with self.assertRaisesRegex(brim.InputError, r'^filter: between/1: "flor" is not a body.*did you mean "floor"'):
            world.set_touch(ball, "flor")
        with self.assertRaisesRegex(brim.InputError, r'^filter: between/1: "x\*" is not allowed; must match'):
            world.set_touch(ball, "x*")
        world.attach(ball, name="pin", point=(0, 0, 5))
        with self.assertRaisesRegex(brim.InputError, '^attachment "pin": there is another one of that name$'):
            world.attach(ball, name="pin", point=(0, 0, 5))
        with self.assertRaisesRegex(brim.InputError, '^joint "pin": there is another one of that name$'):
            world.joint(ball, name="pin", kind="ball", position=(0, 0, 5))

    def test_what_a_scene_file_could_not_say_is_refused_in_its_words(self):
        world, ball = ball_world(height=5.0)
        for call, words in (
            (lambda: world.attach(ball), "\"point\" or \"region\""),
            (lambda: world.attach("bull", point=(0, 0, 0)), "bull"),
            (lambda: world.attach(ball, point=(0, 0, 0), stiffness=-1), "stiffness"),
            (lambda: world.joint(ball, kind="hinge", position=(0, 0, 0)), "revolute"),
            (lambda: world.apply_force(ball, mass=3), "mass"),
        ):
            with self.assertRaises(brim.InputError) as caught:
                call()
            self.assertIn(words, str(caught.exception))
            self.assertNotIn("<added>", str(caught.exception))
        self.assertEqual(world.attachments, [])

    def test_a_saved_scene_steps_with_the_same_bits(self):
        world, ball = ball_world(height=5.0)
        world.attach(ball, point=(0.1, 0, 5), stiffness=200)
        world.apply_force(ball, gravity_scale=0.5, torque=(0, 0, 1))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.json"
            world.save_scene(path, frames=10)
            self.assertEqual(len(json.loads(path.read_text())["attachments"]), 1)
            again = brim.load(path)
        for _ in range(20):
            world.step()
            again.step()
        self.assertEqual(world.hash, again.hash)

    def test_wind_may_be_a_function_of_time_and_place(self):
        def world_with(**wind):
            world = brim.World(gravity=(0, 0, 0))
            vertices, triangles = sheet_arrays()
            sheet = world.add("cloth", name="sheet", vertices=vertices, triangles=triangles, areal_density=5.0)
            world.apply_force(sheet, wind=wind)
            return world, sheet

        asked = []

        def field(t, x):
            asked.append((t, x.shape))
            return [0, 0, 3.0]

        world, sheet = world_with(field=field)
        uniform, same = world_with(velocity=(0, 0, 3.0))
        for _ in range(3):
            world.step()
            uniform.step()
        np.testing.assert_array_equal(sheet.q, same.q)
        self.assertGreater(sheet.linear_momentum[2], 0)
        self.assertEqual(asked[0], (0.0, (len(sheet_arrays()[1]), 3)))
        # What it raises, and what is of no use, reaches the caller.
        world, sheet = world_with(field=lambda t, x: 1 / 0)
        with self.assertRaises(ZeroDivisionError):
            world.step()
        world, sheet = world_with(field=lambda t, x: np.zeros((5, 3)))
        with self.assertRaisesRegex(ValueError, "cannot be broadcast"):
            world.step()
        world, sheet = world_with(field={"velocity": ["0", "0", "U"], "constants": {"U": 3}})
        for _ in range(3):
            world.step()
        np.testing.assert_array_equal(sheet.q, same.q)

    def test_a_part_of_a_body_may_be_told_not_to_touch(self):
        world, ball = ball_world(height=0.3)
        world.set_touch("floor", ball, region={"kind": "sphere", "center": (0, 0, 0), "radius": 1})
        world.run(frames=30).all()
        self.assertLess(ball.q[2], -0.2)


if __name__ == "__main__":
    unittest.main()
