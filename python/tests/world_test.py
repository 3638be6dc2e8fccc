"""Worlds built in Python: adding, stepping, state, contacts."""

import gc
import pickle
import subprocess
import sys
import threading
import unittest

import numpy as np

import brim


def ball_world(height=0.3, **keys):
    world = brim.World(time_step=1 / 60, **keys)
    world.add("obstacle", name="floor", shape=brim.plane())
    ball = world.add("rigid", name="ball", shape=brim.sphere(0.2), transform={"position": (0, 0, height)})
    return world, ball


def sheet_arrays(n=8, side=1.0, z=0.5):
    """Vertices (n, 3) and triangles of a square sheet at height z."""
    x = np.linspace(-side / 2, side / 2, n + 1)
    vertices = np.array([(a, b, z) for b in x for a in x])
    triangles = []
    for j in range(n):
        for i in range(n):
            a = j * (n + 1) + i
            triangles += [(a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1)]
    return vertices, np.array(triangles)


CUBE = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], float) * 0.4
CUBE_TETS = np.array([(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)])

# One entry of every kind, and two steps of it above a floor.
KINDS = {
    "obstacle": dict(shape=brim.box((0.2, 0.2, 0.2))),
    "rigid": dict(shape=brim.torus(0.2, 0.05)),
    "finite_elements": dict(shape=brim.sphere(0.2), lattice_spacing=0.1),
    "cloth": dict(grid={"size": (0.5, 0.5), "cells": (6, 6)}),
    "particle_fluid": dict(shape=brim.box((0.2, 0.2, 0.2)), spacing=0.05),
    "image_volume": dict(shape=brim.sphere(0.2), image_spacing=0.05),
    "articulated": dict(chain={"links": 3, "length": 0.2, "radius": 0.03}),
    "mass_spring": dict(grid={"size": (0.4, 0.4), "cells": (4, 4)}, form="net", thickness=0.02),
    "rod": dict(points=[(0, 0, 0), (0.5, 0, 0)], segments=8, radius=0.02),
    "points": dict(grid={"count": (3, 3, 3), "spacing": 0.1}, radius=0.04),
    "meshless": dict(shape=brim.box((0.2, 0.2, 0.2)), frame_spacing=0.1),
    "grid_fluid": dict(box={"lo": (0, 0, 0), "hi": (0.4, 0.4, 0.4)}, cell_size=0.1, fill=[{"kind": "all"}]),
}


class EveryKind(unittest.TestCase):
    def test_kinds_are_those_of_the_schema(self):
        import json
        body = json.loads(brim._core.scene_schema())["$defs"]["body"]["oneOf"]
        self.assertEqual({b["$ref"].rsplit("/", 1)[1] for b in body}, set(KINDS))

    def test_each_kind_is_added_stepped_and_shown(self):
        for kind, keys in KINDS.items():
            with self.subTest(kind):
                world = brim.World(voxel_size=0.05)
                world.add("obstacle", name="floor", shape=brim.plane())
                body = world.add(kind, transform={"position": (0, 0, 1)}, **keys)
                self.assertEqual(body.kind, kind)
                self.assertEqual(body.name, f"{kind}_1")
                world.step()
                world.step()
                self.assertEqual(body.q.ndim, 1)
                self.assertTrue(np.isfinite(body.q).all() and np.isfinite(body.v).all())
                self.assertEqual(body.positions.shape[1], 3)
                self.assertGreater(len(body.positions), 0)
                if kind not in ("obstacle", "grid_fluid"):
                    self.assertLess(body.linear_momentum[2], 0)


class Report(unittest.TestCase):
    def test_has_every_number_by_name(self):
        world, _ = ball_world()
        report = world.step()
        self.assertIn("momentum_error", report.fields())
        for name, value in report.fields().items():
            self.assertEqual(getattr(report, name), value, name)


class State(unittest.TestCase):
    def test_free_fall_is_that_of_theory(self):
        world, ball = ball_world(height=10.0)
        for _ in range(30):
            world.step()
        self.assertAlmostEqual(world.time, 0.5, places=12)
        self.assertAlmostEqual(ball.v[2], -9.81 * 0.5, places=9)

    def test_views_follow_steps_and_the_same_memory(self):
        world, ball = ball_world()
        q, v = ball.q, ball.v
        before = q.copy()
        world.step()
        self.assertFalse(np.array_equal(q, before))
        self.assertTrue(np.shares_memory(q, ball.q))
        self.assertLess(v[2], 0)

    def test_views_survive_additions_and_restorations(self):
        world, ball = ball_world()
        q = ball.q
        saved = world.save()
        world.step()
        world.restore(saved)
        np.testing.assert_array_equal(q[:3], (0, 0, 0.3))
        for i in range(50):
            world.add("rigid", shape=brim.sphere(0.1), transform={"position": (i + 1, 0, 1)})
        world.step()
        np.testing.assert_array_equal(q, ball.q)
        self.assertLess(q[2], 0.3)

    def test_views_outlive_the_world(self):
        world, ball = ball_world()
        q = ball.q
        world.step()
        kept = q.copy()
        del world, ball
        gc.collect()
        for _ in range(20):
            np.zeros(1000)
        np.testing.assert_array_equal(q, kept)

    def test_writing_moves_the_body(self):
        world, ball = ball_world(height=5.0)
        ball.v[:3] = (1, 2, 3)
        ball.q[0] = 7.0
        np.testing.assert_allclose(ball.linear_momentum / ball.mass, (1, 2, 3), rtol=1e-12)
        np.testing.assert_allclose(ball.positions.mean(0)[0], 7.0, atol=1e-6)
        world.step()
        np.testing.assert_allclose(ball.q[0], 7 + 1 / 60, rtol=1e-12)
        ball.v = np.zeros(6)
        world.step()
        np.testing.assert_allclose(ball.v[2], -9.81 / 60, rtol=1e-12)

    def test_what_is_not_finite_is_refused_and_named(self):
        world, ball = ball_world()
        ball.v[1] = np.nan
        with self.assertRaisesRegex(brim.InputError, r'v\[1\] of body "ball" is not finite'):
            world.step()
        ball.v[1] = 0
        world.step()

    def test_save_and_restore_are_bit_for_bit(self):
        world = brim.World(voxel_size=0.05, response="constraint")
        world.add("obstacle", name="floor", shape=brim.plane())
        world.add("rigid", shape=brim.box((0.3, 0.3, 0.3)), transform={"position": (0, 0, 0.16)},
                  repeat={"count": (1, 1, 3), "spacing": (0, 0, 0.31)})
        world.add("cloth", grid={"size": (1, 1), "cells": (8, 8)}, transform={"position": (0, 0, 1.2)})
        for _ in range(5):
            world.step()
        saved = pickle.loads(pickle.dumps(world.save()))
        self.assertEqual(saved, world.save())
        hashes = []
        for _ in range(8):
            world.step()
            hashes.append(world.hash)
        world.restore(saved)
        again = []
        for _ in range(8):
            world.step()
            again.append(world.hash)
        self.assertEqual(hashes, again)

    def test_copies_in_a_circle_are_handles_in_order(self):
        world = brim.World(gravity=(0, 0, 0))
        ring = world.add("rigid", name="b", shape=brim.box((0.2, 0.1, 0.1)), transform={"position": (1, 0, 0)}, velocity=(0, 2, 0),
                         repeat={"around": {"count": 4, "axis": (0, 0, 1)}})
        self.assertEqual([b.name for b in ring], ["b.0", "b.1", "b.2", "b.3"])
        np.testing.assert_allclose([b.q[:3] for b in ring], [(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)], atol=1e-12)
        np.testing.assert_allclose([b.v[:3] for b in ring], [(0, 2, 0), (-2, 0, 0), (0, -2, 0), (2, 0, 0)], atol=1e-12)

    def test_forces_and_writing_wake_what_sleeps(self):
        world, ball = ball_world(height=0.2, voxel_size=0.05, sleep=True)

        def rest():
            for _ in range(300):
                world.step()
                if ball.asleep:
                    return
            self.fail("it does not come to rest")

        rest()
        ball.v[2] = 1.0
        world.step()
        self.assertFalse(ball.asleep)
        self.assertGreater(ball.q[2], 0.205)
        rest()
        ball.force(lambda t, x, v: (0, 0, 100 * ball.mass))
        world.step()
        self.assertFalse(ball.asleep)
        self.assertGreater(ball.v[2], 1.0)

    def test_a_state_of_another_world_is_refused(self):
        world, _ = ball_world()
        saved = world.save()
        world.add("rigid", shape=brim.sphere(0.1), transform={"position": (2, 0, 1)})
        with self.assertRaisesRegex(brim.InputError, "coordinates"):
            world.restore(saved)


class Contact(unittest.TestCase):
    def test_a_ball_at_rest_is_carried_by_the_floor(self):
        world, ball = ball_world(height=0.2, voxel_size=0.05)
        for _ in range(120):
            world.step()
        weight = ball.mass * 9.81
        floor = world["floor"]
        self.assertAlmostEqual(world.force(ball, floor)[2] / weight, 1.0, places=2)
        np.testing.assert_array_equal(world.force(ball, floor), -world.force(floor, ball))
        np.testing.assert_array_equal(world.force(ball, floor), ball.contact_force)
        contacts = world.contacts
        self.assertGreater(len(contacts), 0)
        self.assertEqual(contacts["force"].shape, (len(contacts), 3))
        self.assertAlmostEqual(abs(contacts["force"].sum(0)[2]) / weight, 1.0, places=2)
        self.assertEqual(set(contacts["body_a"]) | set(contacts["body_b"]), {floor.number, ball.number})
        self.assertEqual(world.pairs["contacts"].sum(), len(contacts))

    def test_stress_of_a_stretched_solid_is_that_of_hooke_in_elements_and_samples(self):
        world = brim.World(gravity=(0, 0, 0))
        box = dict(shape=brim.box((0.4, 0.2, 0.2)), young_modulus=1e5, poisson_ratio=0)
        bar = world.add("finite_elements", name="bar", lattice_spacing=0.1, **box)
        jelly = world.add("meshless", name="jelly", frame_spacing=0.1, transform={"position": (0, 1, 0)}, **box)
        for solid in (bar, jelly):
            solid.positions[:, 0] *= 1.01
            s = solid.stress
            n = len(s.stress)
            self.assertEqual((s.deformation.shape, s.volume.shape, s.centers.shape), ((n, 3, 3), (n,), (n, 3)))
            np.testing.assert_allclose(s.von_mises, 1e3, rtol=1e-3)
            np.testing.assert_allclose(s.strain[:, 0, 0], 0.5 * (1.01**2 - 1), rtol=1e-6)
        self.assertEqual(bar.stress.tetrahedra.shape, (len(bar.stress.stress), 4))
        self.assertAlmostEqual(bar.stress.volume.sum(), 0.4 * 0.2 * 0.2, places=6)
        self.assertEqual(jelly.stress.tetrahedra.shape, (0, 4))
        with self.assertRaisesRegex(TypeError, "no elements of an elastic solid"):
            world.add("rigid", name="ball", shape=brim.sphere(0.1), transform={"position": (0, 3, 0)}).stress

    def test_density_of_a_ball_sums_to_its_volume(self):
        world, ball = ball_world(height=0.0)
        n = np.arange(-3, 3)
        tiles = np.stack(np.meshgrid(n, n, n, indexing="ij"), -1).reshape(-1, 3)
        h = 0.02
        rho = world.density(1, h, tiles)
        self.assertEqual(rho.shape, (len(tiles), 8, 8, 8))
        self.assertAlmostEqual(rho.sum() * h**3 / (4 / 3 * np.pi * 0.2**3), 1.0, delta=0.02)
        # Axes are x, y, z: the node furthest along x of the row through the centre is the first beyond the radius.
        centre = rho[(tiles == (1, 0, 0)).all(1)][0][:, 0, 0]
        self.assertTrue((np.diff(centre) <= 0).all() and centre[0] == 1 and centre[-1] == 0)

    def test_active_tiles_hold_the_contacts(self):
        world, _ = ball_world(height=0.19, voxel_size=0.05, response="penalty")
        world.step()
        keys, h = world.tiles
        self.assertEqual(keys.shape, (len(h), 3))
        self.assertTrue((h > 0).all() and len(h) > 0)


class Refusals(unittest.TestCase):
    def test_messages_are_those_of_scenes_with_the_body_in_place_of_the_line(self):
        world = brim.World()
        for keys, words in (
                (dict(shape=brim.sphere(-1)), 'rigid "b": shape/radius: -1 is not allowed; must be a number above 0'),
                (dict(shap=brim.sphere(1)), 'rigid "b": shap: unknown key "shap"; did you mean "shape"?'),
                (dict(), 'rigid "b": the key "shape" is missing'),
                (dict(shape=brim.sphere(1), mass=float("nan")), "mass: nan is not allowed; numbers must be finite"),
                (dict(shape=brim.sphere(1), mass=object()), "mass: a value of type object is not allowed"),
                (dict(shape=brim.sphere(1), material="rubbr"), 'material: "rubbr" is not a material'),
        ):
            with self.subTest(words):
                with self.assertRaises(brim.InputError) as caught:
                    world.add("rigid", name="b", **keys)
                self.assertIn(words, str(caught.exception))
                self.assertEqual(len(world), 0)
        with self.assertRaisesRegex(brim.InputError, 'did you mean "rigid"'):
            world.add("rigit", shape=brim.sphere(1))

    def test_every_line_of_several_mistakes_names_the_body(self):
        world = brim.World()
        with self.assertRaises(brim.InputError) as caught:
            world.add("particle_fluid", name="water", region=1, spacing=-1)
        lines = str(caught.exception).splitlines()
        self.assertGreaterEqual(len(lines), 3, lines)  # two keys that are wrong, one that is missing
        for line in lines:
            self.assertTrue(line.startswith('particle_fluid "water": ') and "/bodies" not in line, line)

    def test_keys_of_the_world_are_checked(self):
        with self.assertRaisesRegex(brim.InputError, "World: time_step: -1 is not allowed"):
            brim.World(time_step=-1)
        with self.assertRaisesRegex(brim.InputError, "World: voxelsize: unknown key"):
            brim.World(voxelsize=1)

    def test_names_are_unique(self):
        world, _ = ball_world()
        with self.assertRaisesRegex(brim.InputError, "already the name of a body"):
            world.add("rigid", name="ball", shape=brim.sphere(1))
        self.assertEqual(len(world), 2)

    def test_arrays_are_checked(self):
        world = brim.World()
        vertices, triangles = sheet_arrays()
        broken = vertices.copy()
        broken[3, 1] = np.inf
        for v, t, words in ((vertices[:, :2], triangles, r"vertices: shape \(81, 2\) is not allowed; must be \(n, 3\)"),
                            (broken, triangles, r"vertices\[3\] is not finite"),
                            (vertices, triangles + 1, r"triangles\[\d+\] names vertex 81; there are 81"),
                            (vertices, triangles.astype(float), "triangles: must be an array of whole numbers"),
                            (vertices, triangles[:, :2], r"triangles: shape \(128, 2\) is not allowed"),
                            ("abc", triangles, "vertices: must be an array of numbers")):
            with self.subTest(words):
                with self.assertRaisesRegex(brim.InputError, words):
                    world.add("cloth", vertices=v, triangles=t)
        self.assertEqual(len(world), 0)


class Arrays(unittest.TestCase):
    def test_a_sheet_of_arrays_keeps_its_vertices_in_order(self):
        vertices, triangles = sheet_arrays()
        world = brim.World()
        sheet = world.add("cloth", vertices=vertices, triangles=triangles, thickness=0.02)
        np.testing.assert_allclose(sheet.positions, vertices, atol=1e-7)
        self.assertTrue(np.shares_memory(sheet.positions, sheet.q))

    def test_tetrahedra_and_closed_meshes(self):
        world = brim.World()
        soft = world.add("finite_elements", vertices=CUBE, tetrahedra=CUBE_TETS, young_modulus=1e5)
        np.testing.assert_array_equal(soft.positions, CUBE)
        faces = np.array([(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7),
                          (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)])
        solid = world.add("rigid", shape=brim.mesh(vertices=CUBE, triangles=faces), density=1000)
        self.assertAlmostEqual(solid.mass, 64.0, places=4)
        with self.assertRaisesRegex(brim.InputError, "not a closed surface"):
            world.add("rigid", shape=brim.mesh(vertices=CUBE, triangles=faces[:-1]))

    def test_intensities_become_a_volume_of_the_right_size_and_place(self):
        x, y, z = np.meshgrid(*(np.arange(n) for n in (40, 30, 20)), indexing="ij")
        ct = np.where((x >= 5) & (x < 35) & (y >= 5) & (y < 25) & (z >= 5) & (z < 15), 1000.0, 0.0)
        world = brim.World()
        bone = world.add("image_volume", intensities=ct, spacing=(0.01, 0.01, 0.02), window=(500, 500), density=1000)
        self.assertAlmostEqual(bone.mass / (1000 * 0.3 * 0.2 * 0.2), 1.0, delta=0.03)
        extent = np.ptp(bone.positions, axis=0)
        np.testing.assert_allclose(extent, (0.3, 0.2, 0.2), atol=0.011)
        with self.assertRaisesRegex(brim.InputError, "no voxel has a finite intensity"):
            world.add("image_volume", intensities=np.nan * ct, spacing=(0.01, 0.01, 0.02), window=(0, 0))
        with self.assertRaisesRegex(brim.InputError, "only a deformable volume has \"young_modulus\""):
            world.add("image_volume", intensities=ct, spacing=(0.01, 0.01, 0.02), window=(500, 500), young_modulus=1e5)


class Threads(unittest.TestCase):
    def test_two_threads_step_two_worlds_and_get_the_bits_of_one(self):
        def run(out):
            world, _ = ball_world(height=0.25, voxel_size=0.05)
            world.add("cloth", grid={"size": (1, 1), "cells": (10, 10)}, transform={"position": (0, 0, 0.6)})
            for _ in range(15):
                world.step()
            out.append(world.hash)

        alone = []
        run(alone)
        together = []
        threads = [threading.Thread(target=run, args=(together,)) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(timeout=120)
            self.assertFalse(thread.is_alive())
        self.assertEqual(together, alone * 2)

    def test_other_threads_run_during_a_step_and_see_whole_states(self):
        world, ball = ball_world(height=3.0)
        world.add("cloth", grid={"size": (2, 2), "cells": (40, 40)}, transform={"position": (0, 0, 0.5)})
        ball.v[2] = 0.0
        seen = set()
        done = threading.Event()
        v = ball.v

        def watch():
            while not done.is_set():
                seen.add(float(v[2]))

        watcher = threading.Thread(target=watch)
        watcher.start()
        whole = {0.0}
        for _ in range(5):
            world.step()
            whole.add(float(v[2]))
        done.set()
        watcher.join(timeout=60)
        self.assertLessEqual(seen, whole)

    def test_one_world_is_stepped_by_one_thread_at_a_time(self):
        world, _ = ball_world()
        world.add("cloth", grid={"size": (2, 2), "cells": (60, 60)}, transform={"position": (0, 0, 0.5)})
        errors = []

        def run():
            for _ in range(3):
                try:
                    world.step()
                except RuntimeError as error:
                    errors.append(str(error))

        threads = [threading.Thread(target=run) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(timeout=120)
            self.assertFalse(thread.is_alive())
        self.assertTrue(all("in the middle of a step" in e for e in errors), errors)


class Threads(unittest.TestCase):
    def test_a_program_that_sets_how_many_ends_as_others_do(self):
        for set_them in ("brim.set_threads(1)", "brim.set_threads(2); brim.set_threads(0)", "w = brim.World(time_step=0.01); brim.set_threads(1); w.step()"):
            done = subprocess.run([sys.executable, "-c", f"import brim; {set_them}"], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr), (0, ""), set_them)


if __name__ == "__main__":
    unittest.main()
