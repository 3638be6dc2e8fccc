"""Rays, nearest points and overlaps from Python."""

import unittest

import brim
import numpy as np


class Blob(brim.OwnBody):
    """A ball that moves along x."""
    q0 = np.array([4.0])

    def deform(self, q, X):
        return X + np.array([q[0], 0, 1])

    def inverse_deform(self, q, x):
        return x - np.array([q[0], 0, 1])

    def distance(self, q, x):
        return np.linalg.norm(self.inverse_deform(q, x), axis=1) - 0.3


def world_of_balls() -> brim.World:
    world = brim.World(voxel_size=0.1)
    world.add("obstacle", name="floor", shape=brim.plane())
    for i in range(3):
        world.add("rigid", name=f"ball_{i}", shape=brim.sphere(0.5), transform={"position": (2 * i, 0, 1)})
    return world


class Query(unittest.TestCase):
    def test_a_ray_meets_the_first_body_and_what_is_ignored_is_not_seen(self):
        world = world_of_balls()
        hit = world.raycast((-3, 0, 1), (2, 0, 0))
        self.assertIsInstance(hit, brim.Hit)
        self.assertEqual(hit.body, world["ball_0"])
        self.assertAlmostEqual(hit.distance, 2.5, places=12)
        np.testing.assert_allclose(hit.point, (-0.5, 0, 1), atol=1e-12)
        np.testing.assert_allclose(hit.normal, (-1, 0, 0), atol=1e-9)
        self.assertIsNone(world.raycast((-3, 0, 1), (1, 0, 0), 2.4))
        self.assertEqual(world.raycast((-3, 0, 1), (1, 0, 0), ignore="ball_0").body.name, "ball_1")
        self.assertEqual(world.raycast((-3, 0, 1), (1, 0, 0), ignore=[world["ball_0"], "ball_1"]).body.name, "ball_2")
        self.assertEqual(world.raycast((-3, 0, 1), (1, 0, 0), only=["ball_2"]).body.name, "ball_2")
        self.assertIsNone(world.raycast((-3, 0, 1), (1, 0, 0), only=[]))

    def test_nearest_points_and_overlaps(self):
        world = world_of_balls()
        near = world.closest_point((2, 0, 1.2))
        self.assertEqual((near.body.name, near.part), ("ball_1", 0))
        self.assertAlmostEqual(near.distance, -0.3, places=12)
        self.assertIsNone(world.closest_point((0, 0, 5), 1.0))
        names = lambda bodies: [body.name for body in bodies]
        self.assertEqual(names(world.overlap_ball((1, 0, 1), 0.51)), ["ball_0", "ball_1"])
        self.assertEqual(names(world.overlap_ball((1, 0, 1), 0.49)), [])
        self.assertEqual(names(world.overlap_box((1, 0, 1), (1.1, 0.2, 0.2))), ["ball_0", "ball_1"])
        self.assertEqual(names(world.overlap_box((1, 0, 1), (1.1, 0.2, 0.2), (1, 0, 0, 1))), [], "turned by a quarter")

    def test_what_is_written_and_edited_is_seen_at_once(self):
        world = world_of_balls()
        ball = world["ball_0"]
        ball.q[2] = 3.0
        self.assertAlmostEqual(world.raycast((0, 0, 9), (0, 0, -1)).distance, 5.5, places=12)
        ball.move((0, 0, 1))
        self.assertAlmostEqual(world.raycast((0, 0, 9), (0, 0, -1)).distance, 4.5, places=12)
        ball.remove()
        self.assertEqual(world.raycast((0, 0, 9), (0, 0, -1)).body.name, "floor")

    def test_a_body_written_in_python_is_met(self):
        world = brim.World(voxel_size=0.1)
        blob = world.add(Blob(surface=brim.sphere(0.3)), name="blob")
        blob.q[0] = 2.0
        hit = world.raycast((0, 0, 1), (1, 0, 0))
        self.assertEqual(hit.body, blob)
        self.assertAlmostEqual(hit.distance, 1.7, delta=0.02)

    def test_mistakes_are_told(self):
        world = world_of_balls()
        with self.assertRaisesRegex(brim.InputError, "direction is zero"):
            world.raycast((0, 0, 0), (0, 0, 0))
        with self.assertRaisesRegex(brim.InputError, r"point: shape \(2,\) is not allowed"):
            world.closest_point((0, 0))
        with self.assertRaisesRegex(brim.InputError, "radius -1"):
            world.overlap_ball((0, 0, 0), -1)
        with self.assertRaises(KeyError):
            world.raycast((0, 0, 0), (0, 0, 1), ignore="nobody")


if __name__ == "__main__":
    unittest.main()
