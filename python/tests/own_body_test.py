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
