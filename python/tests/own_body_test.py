"""Bodies written in Python."""

import gc
import threading
import unittest
import weakref

import numpy as np

import brim


class Blob(brim.OwnBody):
    """A ball that stretches along the axes: q = (centre, stretch)."""

    q0 = np.r_[0, 0, 0.35, 1, 1, 1]

    def deform(self, q, X):
        return q[:3] + q[3:] * X

    def inverse_deform(self, q, x):
        return (x - q[:3]) / q[3:]

    def distance(self, q, x):
        return (np.linalg.norm(self.inverse_deform(q, x), axis=1) - 0.3) * q[3:].min()

    def energy(self, q):
        return 2e3 * np.sum((q[3:] - 1) ** 2)


class ExactBlob(Blob):
    """The same with formulas in place of differences."""

    def jacobian(self, q, X):
        J = np.zeros((len(X), 3, 6))
        for i in range(3):
            J[:, i, i] = 1
            J[:, i, 3 + i] = X[:, i]
        return J

    def force(self, q):
        return np.r_[0, 0, 0, -4e3 * (q[3:] - 1)]


def blob_world(author, **keys):
    world = brim.World(voxel_size=0.05, **keys)
    world.add("obstacle", name="floor", shape=brim.plane())
    return world, world.add(author)


class OwnBodies(unittest.TestCase):
    def test_a_blob_falls_bounces_and_keeps_its_weight(self):
        world, blob = blob_world(Blob(surface=brim.sphere(0.3)))
        self.assertEqual((blob.kind, blob.name), ("Blob", "blob_1"))
        self.assertAlmostEqual(blob.mass / (4 / 3 * np.pi * 0.3**3 * 1000), 1.0, delta=0.03)
        lowest = 1.0
        for _ in range(60):
            world.step()
            lowest = min(lowest, blob.q[5])
        self.assertLess(lowest, 0.99)  # it was squeezed
        self.assertGreater(len(world.contacts), 0)

    def test_formulas_and_differences_agree(self):
        ends = []
        for kind in (Blob, ExactBlob):
            world, blob = blob_world(kind(surface=brim.sphere(0.3)))
            for _ in range(20):
                world.step()
            ends.append(blob.q.copy())
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)

    def test_a_jacobian_that_is_none_of_deform_is_refused(self):
        random = np.random.default_rng(7)

        class Zero(ExactBlob):
            def jacobian(self, q, X):
                return np.zeros((len(X), 3, 6))

        class Random(ExactBlob):
            def jacobian(self, q, X):
                return random.normal(size=(len(X), 3, 6))

        class Transposed(ExactBlob):
            def jacobian(self, q, X):
                return super().jacobian(q, X)[:, :, ::-1]

        for kind in (Zero, Random, Transposed):
            with self.subTest(kind.__name__):
                world = brim.World(voxel_size=0.05)
                with self.assertRaisesRegex(brim.InputError, r"'mine': jacobian\(q, X\) is not the derivative"):
                    world.add(kind(surface=brim.sphere(0.3), name="mine"))
                self.assertEqual(len(world), 0)
                world.step()

    def test_python_is_entered_on_the_stepping_thread_once_for_a_part(self):
        calls = []

        class Watched(ExactBlob):
            def distance(self, q, x):
                calls.append((threading.get_ident(), len(x)))
                return super().distance(q, x)

        world, _ = blob_world(Watched(surface=brim.sphere(0.3)))
        world.add("cloth", grid={"size": (2, 2), "cells": (20, 20)}, transform={"position": (0, 0, 0.02)})
        world.step()
        calls.clear()
        report = world.step()
        self.assertEqual({ident for ident, _ in calls}, {threading.get_ident()})
        # A grid step of a pair each: the sheet and the floor, and one call for all tiles.
        self.assertLessEqual(len(calls), 2 * max(1, report.substeps))
        self.assertTrue(all(n % 1000 == 0 for _, n in calls))

    def test_an_exception_leaves_the_last_whole_state_and_reaches_the_caller(self):
        class Fragile(ExactBlob):
            broken = ""

            def distance(self, q, x):
                if self.broken == "distance":
                    raise ZeroDivisionError("distance")
                return super().distance(q, x)

            def inverse_deform(self, q, x):
                if self.broken == "rest":
                    raise KeyboardInterrupt()
                return super().inverse_deform(q, x)

            def deform(self, q, X):
                if self.broken == "deform":
                    return X[:1]
                return super().deform(q, X)

            def energy(self, q):
                return np.nan if self.broken == "energy" else super().energy(q)

        author = Fragile(surface=brim.sphere(0.3))
        world, blob = blob_world(author)
        twin, _ = blob_world(ExactBlob(surface=brim.sphere(0.3)))
        for _ in range(10):
            world.step(), twin.step()
        for what, error, words in (("distance", ZeroDivisionError, "distance"), ("rest", KeyboardInterrupt, ""),
                                   ("deform", brim.InputError, r"Fragile.deform: gave shape \(1, 3\); must be"),
                                   ("energy", brim.InputError, "Fragile.energy: gave a value that is not finite")):
            with self.subTest(what):
                before, q = world.hash, blob.q.copy()
                author.broken = what
                with self.assertRaisesRegex(error, words):
                    world.step()
                author.broken = ""
                self.assertEqual(world.hash, before)
                np.testing.assert_array_equal(blob.q, q)
                world.step(), twin.step()
                self.assertEqual(world.hash, twin.hash)

    def test_two_threads_step_two_blobs(self):
        ends = []

        def run():
            world, blob = blob_world(ExactBlob(surface=brim.sphere(0.3)))
            for _ in range(10):
                world.step()
            ends.append(world.hash)

        threads = [threading.Thread(target=run) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(timeout=120)
            self.assertFalse(thread.is_alive())
        self.assertEqual(len(set(ends)), 1)

    def test_stepping_from_within_a_step_is_refused(self):
        class Greedy(ExactBlob):
            world = None

            def energy(self, q):
                if self.world is not None:
                    self.world.step()
                return super().energy(q)

        author = Greedy(surface=brim.sphere(0.3))
        world, _ = blob_world(author)
        author.world = world
        with self.assertRaisesRegex(RuntimeError, "in the middle of a step"):
            world.step()
        author.world = None
        world.step()

    def test_saved_states_are_gone_back_to_bit_for_bit(self):
        world, _ = blob_world(ExactBlob(surface=brim.sphere(0.3)))
        for _ in range(8):
            world.step()
        saved, ends = world.save(), []
        for _ in range(2):
            world.restore(saved)
            for _ in range(5):
                world.step()
            ends.append(world.hash)
        self.assertEqual(ends[0], ends[1])

    def test_the_check_names_what_is_wrong_in_one_line(self):
        surface = brim.sphere(0.3)
        for good in (Blob(surface=surface), ExactBlob(surface=surface, material="jelly")):
            brim.check(good)
        right, two_voxels = Blob.distance, 2 * 0.6 / 8

        def mine(kind=Blob, **methods):
            return type("Mine", (kind,), methods)(surface=surface, name="mine")

        wrong = {
            "force of coordinate 3": mine(force=lambda s, q: np.r_[0, 0, 0, -2e3 * (q[3:] - 1)]),
            "jacobian at X": mine(ExactBlob, jacobian=lambda s, q, X: 1.05 * ExactBlob.jacobian(s, q, X)),
            "inverse_deform of the place": mine(inverse_deform=lambda s, q, x: x, distance=lambda s, q, x: (
                np.linalg.norm((x - q[:3]) / q[3:], axis=1) - 0.3) * q[3:].min()),
            r"distance at x = \(.*must be negative|distance at x = \(.*must be positive": mine(
                distance=lambda s, q, x: -right(s, q, x)),
            "distance at x = .* a vertex of the surface": mine(distance=lambda s, q, x: right(s, q, x) + 0.1),
            "distance saturates": mine(distance=lambda s, q, x: np.minimum(right(s, q, x), two_voxels / 4)),
        }
        for words, body in wrong.items():
            with self.subTest(words):
                with self.assertRaisesRegex(brim.InputError, f"^body 'mine': ({words})") as caught:
                    brim.check(body)
                self.assertNotIn("\n", str(caught.exception))
        world, blob = blob_world(Blob(surface=surface))
        brim.check(blob)
        with self.assertRaisesRegex(brim.InputError, "'floor' is no own body"):
            brim.check(world["floor"])

    def test_coordinates_that_do_the_same_are_refused_by_name(self):
        class Twice(Blob):
            q0 = np.r_[0, 0, 0.35, 1, 1, 1, 0]

            def deform(self, q, X):
                return q[:3] + [0, 0, q[6]] + q[3:6] * X

            def inverse_deform(self, q, x):
                return (x - q[:3] - [0, 0, q[6]]) / q[3:6]

            def distance(self, q, x):
                return (np.linalg.norm(self.inverse_deform(q, x), axis=1) - 0.3) * q[3:6].min()

            def energy(self, q):
                return 2e3 * np.sum((q[3:6] - 1) ** 2)

        with self.assertRaisesRegex(brim.InputError, "coordinates 2 and 6 have no effects of their own"):
            brim.World().add(Twice(surface=brim.sphere(0.3)))

    def test_errors_of_distance_and_inverse_do_not_wait_for_the_first_contact(self):
        for method in ("distance", "inverse_deform"):
            with self.subTest(method):
                kind = type("Mine", (ExactBlob,), {method: lambda s, q, x: x[:, :2]})
                with self.assertRaisesRegex(brim.InputError, f"Mine.{method}: gave shape"):
                    brim.World().add(kind(surface=brim.sphere(0.3)))

    def test_a_body_is_told_the_time_and_wakes_by_itself(self):
        class Heart(Blob):
            goal = 1.0

            def update(self, t):
                self.goal = 1 + 0.2 * np.sin(6 * (t - 1.5)) if t > 1.5 else 1.0

            def energy(self, q):
                return 2e3 * (np.sum((q[3:5] - 1) ** 2) + (q[5] - self.goal) ** 2)

        world, heart = blob_world(Heart(surface=brim.sphere(0.3), density=500, stiffness_damping=0.02,
                                        q0=np.r_[0, 0, 0.3, 1, 1, 1]), sleep=True, gravity=(0, 0, 0))
        while world.time < 1.45:
            world.step()
        self.assertTrue(heart.asleep)
        heights = []
        while world.time < 2.5:
            world.step()
            heights.append(heart.q[5])
        self.assertFalse(heart.asleep)
        self.assertGreater(max(heights) - min(heights), 0.3)

    def test_misuse_is_told_with_what_to_do(self):
        surface = brim.sphere(0.3)
        world = brim.World(voxel_size=0.05)

        class Forgetful(Blob):
            def __init__(self):
                pass

        for body, keys, words in ((Blob, {}, r"Blob is a class; add a body of it, Blob\(surface="),
                                  (Blob(surface=surface), {"transform": {"position": (0, 0, 1)}},
                                   "transform: not with a body of your own; its place and motion are q0 and v0"),
                                  (Forgetful(), {}, r"Forgetful.__init__ must call super\(\).__init__\(surface"),
                                  (Blob(surface=surface, q0=np.zeros((2, 3))), {}, r"q0: .*not \(2, 3\)")):
            with self.subTest(words), self.assertRaisesRegex(brim.InputError, words):
                world.add(body, **keys)
        blob = world.add(Blob(surface=surface))
        with self.assertRaisesRegex(TypeError, "is not rigid; use generalized_force"):
            blob.torque(lambda t, q, v: (0, 0, 1))
        blob.set_velocity((1, 2, 3))
        np.testing.assert_allclose(blob.v[:3], (1, 2, 3), atol=1e-9)
        with self.assertRaisesRegex(brim.InputError, "no coordinates that turn it so"):
            blob.set_velocity((0, 0, 0), (0, 0, 1))

        class Lift(Blob):
            q0 = np.r_[0.5]

            def deform(self, q, X):
                return X + [0, 0, q[0]]

            def inverse_deform(self, q, x):
                return x - [0, 0, q[0]]

            def distance(self, q, x):
                return np.linalg.norm(self.inverse_deform(q, x), axis=1) - 0.3

            def energy(self, q):
                return 0.0

        lift = world.add(Lift(surface=surface))
        with self.assertRaisesRegex(brim.InputError, "no coordinates that move it so; set its v"):
            lift.set_velocity((1, 0, 0))
        lift.set_velocity((0, 0, 1))

    def test_the_author_goes_with_the_world(self):
        author = Blob(surface=brim.sphere(0.3))
        gone = weakref.ref(author)
        world, blob = blob_world(author)
        world.step()
        del author, world, blob
        gc.collect()
        self.assertIsNone(gone())

    def test_what_is_missing_is_said(self):
        class Empty(brim.OwnBody):
            q0 = [0.0]

        world, blob = blob_world(Blob(surface=brim.sphere(0.3)))
        with self.assertRaisesRegex(NotImplementedError, "Empty must say where its matter is"):
            world.add(Empty(surface=brim.sphere(0.3)))
        self.assertEqual(len(world), 2)
        ball = world.add("rigid", shape=brim.sphere(0.1), transform={"position": (3, 0, 1)})
        world.step()
        self.assertAlmostEqual(ball.v[2], -9.81 / 60, places=9)
        with self.assertRaisesRegex(brim.InputError, "q0: must be an array of one coordinate at least"):
            brim.World().add(Blob(surface=brim.sphere(0.3), q0=[]))
        with self.assertRaisesRegex(brim.InputError, 'Blob "b".*shape/radius'):
            brim.World().add(Blob(surface=brim.sphere(-0.3), name="b"))


if __name__ == "__main__":
    unittest.main()
