"""Forces written in Python."""

import unittest

import numpy as np

import brim
from world_test import ball_world, sheet_arrays


class Forces(unittest.TestCase):
    def test_a_force_on_a_rigid_body_changes_its_momentum_by_its_impulse(self):
        world, ball = ball_world(height=5.0, gravity=(0, 0, 0))
        asked = []

        @ball.force
        def push(t, x, v):
            asked.append((t, x.copy(), v.copy()))
            return [1.0, 0, 2.0]

        world.step()
        world.step()
        np.testing.assert_allclose(ball.linear_momentum, np.array([1, 0, 2]) * 2 / 60, rtol=1e-9)
        self.assertEqual([a[0] for a in asked], [0.0, 1 / 60])
        self.assertEqual(asked[0][1].shape, (1, 3))
        np.testing.assert_array_equal(asked[0][1][0], (0, 0, 5))
        ball.remove_force(push)
        before = ball.linear_momentum
        world.step()
        np.testing.assert_allclose(ball.linear_momentum, before, rtol=1e-9)

    def test_a_torque_changes_the_angular_momentum(self):
        world, ball = ball_world(height=5.0, gravity=(0, 0, 0))
        ball.torque(lambda t, q, v: [0, 0, 3.0])
        world.step()
        self.assertAlmostEqual(ball.v[5] * 0.4 * ball.mass * 0.2**2, 3.0 / 60, places=9)

    def test_a_force_on_nodes_is_broadcast_and_fixed_nodes_stay(self):
        world = brim.World(gravity=(0, 0, 0))
        vertices, triangles = sheet_arrays()
        free = world.add("cloth", vertices=vertices, triangles=triangles)
        held = world.add("cloth", vertices=vertices + (3, 0, 0), triangles=triangles, 
                         constraints=[{"select": {"kind": "box", "lo": (2, -1, 0), "hi": (2.6, 1, 1)}}])

        @free.force
        @held.force
        def wind(t, x, v):
            self.assertEqual(x.shape, (81, 3))
            return [0.02, 0, 0]

        for _ in range(3):
            world.step()
        np.testing.assert_allclose(free.linear_momentum, (81 * 0.02 * 3 / 60, 0, 0), rtol=1e-6, atol=1e-12)
        fixed = vertices[:, 0] + 3 <= 2.6
        np.testing.assert_allclose(held.positions[fixed], (vertices + (3, 0, 0))[fixed], atol=1e-6)
        self.assertGreater(held.velocities[~fixed, 0].mean(), 0)

    def test_the_floor_carries_weight_and_force_of_a_soft_body(self):
        world = brim.World(voxel_size=0.02)
        floor = world.add("obstacle", shape=brim.plane())
        soft = world.add("finite_elements", shape=brim.box((0.2, 0.2, 0.1)), lattice_spacing=0.05, young_modulus=2e5,
                         stiffness_damping=0.01, transform={"position": (0, 0, 0.05)})
        soft.force(lambda t, x, v: (0, 0, -60 / len(x)))
        for _ in range(90):
            world.step()
        self.assertAlmostEqual(world.force(soft, floor)[2] / (9.81 * soft.mass + 60), 1.0, places=3)
        self.assertLess(np.abs(soft.velocities).max(), 1e-3)

    def test_every_kind_takes_forces_or_says_that_it_does_not(self):
        from world_test import KINDS
        for kind, keys in KINDS.items():
            with self.subTest(kind):
                world = brim.World(voxel_size=0.05, gravity=(0, 0, 0))
                body = world.add(kind, transform={"position": (0, 0, 1)}, **keys)
                if kind in ("obstacle", "grid_fluid"):
                    with self.assertRaisesRegex(TypeError, "takes no forces"):
                        body.generalized_force(lambda t, q, v: 0)
                    continue
                body.generalized_force(lambda t, q, v: 1e-3)
                if body.nodal:
                    body.force(lambda t, x, v: (2e-3, 0, 0))
                    n = len(body.positions)
                    world.step()
                    np.testing.assert_allclose(body.linear_momentum, np.array([3e-3, 1e-3, 1e-3]) * n / 60, rtol=1e-5)
                else:
                    world.step()
                    self.assertGreater(np.abs(body.v).max(), 0)

    def test_a_spring_to_the_wall_swings_with_its_period(self):
        world = brim.World(time_step=1e-3, gravity=(0, 0, 0))
        ball = world.add("rigid", shape=brim.sphere(0.1), mass=1.0, transform={"position": (0.1, 0, 0)})
        ball.force(lambda t, x, v: -100.0 * x)  # omega = 10 / s
        crossings = []
        before = ball.q[0]
        for _ in range(1300):
            world.step()
            if before > 0 >= ball.q[0] or before < 0 <= ball.q[0]:
                crossings.append(world.time)
            before = ball.q[0]
        self.assertAlmostEqual(np.diff(crossings).mean(), np.pi / 10, delta=2e-3)

    def test_what_a_force_raises_reaches_the_caller_and_nothing_has_happened(self):
        world, ball = ball_world()
        other = world.add("rigid", shape=brim.sphere(0.1), transform={"position": (2, 0, 1)})
        other.force(lambda t, x, v: [1, 0, 0])

        @ball.force
        def broken(t, x, v):
            raise KeyError("mine")

        before = world.hash
        with self.assertRaisesRegex(KeyError, "mine"):
            world.step()
        self.assertEqual(world.hash, before)
        ball.remove_force(broken)
        world.step()

    def test_values_of_the_wrong_shape_or_not_finite_are_refused(self):
        world, ball = ball_world()
        wrong = ball.force(lambda t, x, v: [1, 2])
        with self.assertRaisesRegex(ValueError, r"cannot be broadcast to shape \(1, 3\)"):
            world.step()
        ball.remove_force(wrong)
        ball.force(lambda t, x, v: [np.nan, 0, 0])
        with self.assertRaisesRegex(brim.InputError, 'force on body "ball".*not finite'):
            world.step()

    def test_sensors_and_controllers_are_called_after_each_step(self):
        world, ball = ball_world(height=3.0)
        seen = []

        @world.each_step
        def hold(w):
            seen.append((w.time, ball.v[2]))
            ball.v[:] = 0

        world.step()
        world.step()
        np.testing.assert_allclose(seen, [(1 / 60, -9.81 / 60), (2 / 60, -9.81 / 60)], rtol=1e-9)

    def test_generalized_forces_drive_joints(self):
        world = brim.World(gravity=(0, 0, 0))
        chain = world.add("articulated", chain={"links": 3, "length": 0.2, "radius": 0.03, "joint": "revolute"})
        chain.generalized_force(lambda t, q, v: np.full(v.shape, 1e-3))
        with self.assertRaisesRegex(TypeError, "generalized_force"):
            chain.force(lambda t, x, v: 0)
        world.step()
        self.assertGreater(np.abs(chain.v).max(), 0)


if __name__ == "__main__":
    unittest.main()
