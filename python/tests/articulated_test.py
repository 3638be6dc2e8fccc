"""Joints, links and drives of articulated bodies."""

import json
import pickle
import tempfile
import time
import unittest
from pathlib import Path

import numpy as np

import brim


def arm_world(gravity=(0, 0, -9.81), **keys):
    """Two driven hinges about y and a wrist without a drive, which lies on the x axis."""
    world = brim.World(time_step=1 / 240, voxel_size=0.02, gravity=gravity, **keys)

    def link(name, parent, **joint):
        at = {"parent": parent} if parent else {}
        position = (0.3, 0, 0) if parent else (0, 0, 0)
        return {"name": name, **at, "mass": 1, "shape": brim.box((0.26, 0.04, 0.04)), "transform": {"position": (0.15, 0, 0)},
                "joint": {"kind": "revolute", "axis": (0, 1, 0), "position": position, **joint}}

    drive = {"stiffness": 2000, "damping": 40}
    links = [link("shoulder", None, drive=drive, lower=-2, upper=2),
             link("elbow", "shoulder", drive={**drive, "force_limit": 80}), link("wrist", "elbow", damping=0.2)]
    return world, world.add("articulated", name="arm", links=links, transform={"position": (0, 0, 1)})


def run(world, steps):
    for _ in range(steps):
        world.step()


class Drives(unittest.TestCase):
    def test_a_joint_goes_where_it_is_aimed_and_stays(self):
        world, arm = arm_world(gravity=(0, 0, 0))
        self.assertEqual(arm.joints, ["shoulder", "elbow", "wrist"])
        self.assertEqual(arm.driven, ["shoulder", "elbow"])
        arm.set_drive("elbow", position=0.4)
        arm.set_drive(0, -0.3)
        run(world, 480)
        self.assertAlmostEqual(arm.joint("elbow").coordinate, 0.4, places=4)
        self.assertAlmostEqual(arm.joint("shoulder").coordinate, -0.3, places=4)
        self.assertLess(abs(arm.joint("elbow").rate), 1e-3)

    def test_all_drives_take_one_array(self):
        world, arm = arm_world()
        other, twin = arm_world()
        for i in range(20):
            q = np.array([0.01 * i, -0.02 * i])
            arm.set_drives(q, (2.4, -4.8))
            twin.set_drive("shoulder", q[0], 2.4)
            twin.joint("elbow").set_drive(q[1], velocity=-4.8)
            world.step()
            other.step()
        self.assertEqual(world.hash, other.hash)
        arm.set_drives(q)
        begin = time.process_time()
        for _ in range(2000):
            arm.set_drives(q)
        self.assertLess((time.process_time() - begin) / 2000, 200e-6)

    def test_keyframes_end_where_a_drive_is_aimed(self):
        world = brim.World(time_step=1 / 240, gravity=(0, 0, 0))
        drive = {"stiffness": 2000, "damping": 40, "keyframes": [{"time": 0, "target": 0}, {"time": 1, "target": 1}]}
        arm = world.add("articulated", links=[{"name": "l", "mass": 1, "shape": brim.box((0.2, 0.1, 0.1)),
                                               "joint": {"kind": "revolute", "drive": drive}}])
        run(world, 24)
        self.assertGreater(arm.q[0], 0.05)
        arm.set_drive("l", -0.2)
        run(world, 240)
        self.assertAlmostEqual(arm.q[0], -0.2, places=3)

    def test_drives_without_stiffness_take_velocities(self):
        world = brim.World(time_step=1 / 240, gravity=(0, 0, 0))
        wheel = world.add("articulated", links=[{"name": "wheel", "mass": 1, "shape": brim.cylinder(0.1, 0.05),
                                                 "joint": {"kind": "revolute", "drive": {"damping": 10}}}])
        wheel.set_drive("wheel", velocity=3)
        run(world, 60)
        self.assertAlmostEqual(wheel.v[0], 3, places=3)
        with self.assertRaisesRegex(brim.InputError, "cannot be at position 1; its drive has no stiffness"):
            wheel.set_drive("wheel", 1)

    def test_what_cannot_be_is_refused_by_name(self):
        world, arm = arm_world()
        chain = world.add("articulated", name="chain", chain={"links": 2, "length": 0.2, "radius": 0.03, "drive": {"stiffness": 5}},
                          transform={"position": (5, 0, 1)})
        before = world.save()
        for call, words in (
            (lambda: arm.set_drive("elbo", 1), '"elbo" is not a joint that moves of "arm"; did you mean "elbow"?'),
            (lambda: arm.set_drive("hat", 1), 'there are "shoulder", "elbow", "wrist"'),
            (lambda: arm.set_drive(3, 1), "3 is not a joint that moves of \"arm\"; must be a name, or a number from 0 to 2"),
            (lambda: arm.set_drive("wrist", 1), 'joint "wrist" of "arm" has no drive; joints with one: "shoulder", "elbow"'),
            (lambda: arm.set_drive("elbow"), "needs a position"),
            (lambda: arm.set_drive("elbow", np.nan), 'position nan of "elbow" of \'arm\' is not allowed; must be finite'),
            (lambda: arm.set_drives([0, np.inf]), 'position inf of "elbow"'),
            (lambda: arm.set_drives([0, 1, 2]), 'positions: shape (3,) is not allowed; must be (2,), one for each driven joint: '
                                                '"shoulder", "elbow"'),
            (lambda: arm.set_drives([0, 1], 3), "velocities: shape () is not allowed"),
            (lambda: arm.set_drives("ab"), "positions: must be an array of numbers"),
            (lambda: arm.link("hand"), '"hand" is not a link of "arm"; there are "shoulder"'),
            (lambda: chain.set_drive("0", 1), "is a ball joint; its drive holds it at rest"),
        ):
            with self.assertRaises(brim.InputError) as caught:
                call()
            self.assertIn(words, str(caught.exception))
        self.assertEqual(world.save(), before)
        self.assertEqual(chain.driven, [])
        with self.assertRaises(TypeError):
            chain.joint(0).coordinate
        self.assertEqual(chain.joint("0").q.shape, (4,))
        world.remove(arm)
        with self.assertRaisesRegex(brim.InputError, "was removed"):
            arm.set_drives([0, 0])

    def test_a_saved_scene_has_the_targets(self):
        world, arm = arm_world()
        box = world.add("rigid", name="box", shape=brim.box((0.2, 0.2, 0.2)), transform={"position": (3, 0, 1)})
        hinge = world.joint(box, kind="revolute", position=(3, 0, 1), axis=(0, 1, 0), drive={"stiffness": 100, "damping": 5})
        arm.set_drive("elbow", 0.4)
        hinge.set_drive(0.3)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.json"
            world.save_scene(path, frames=10)
            self.assertEqual(len(json.loads(path.read_text())["timeline"]), 2)
            again = brim.load(path)
        run(world, 60)
        run(again, 60)
        np.testing.assert_array_equal(arm.q, again["arm"].q)
        np.testing.assert_array_equal(box.q, again["box"].q)
        self.assertAlmostEqual(arm.joint("elbow").coordinate, 0.4, delta=0.05)

    def test_recorded_runs_are_taken_up_with_the_targets(self):
        world, arm = arm_world()
        with tempfile.TemporaryDirectory() as folder:
            for frame in world.run(frames=8, record=folder + "/run"):
                if frame.number == 3:
                    arm.set_drive("elbow", 0.4)
            end = world.hash
            again, other = arm_world()
            again.restore(brim.Run(folder + "/run").state(5))
        run(again, 3 * round(world.time / 8 * 240))
        np.testing.assert_array_equal(other.q, arm.q)
        self.assertEqual(again.hash, end)


class Reading(unittest.TestCase):
    def test_links_are_where_their_joints_put_them(self):
        world, arm = arm_world(gravity=(0, 0, 0))
        arm.q[:] = 0.3, -0.5, 0.9
        arm.v[:] = 1.0, 2.0, -3.0
        angle, place = np.cumsum(arm.q), np.array([0.0, 0, 1])
        rate, velocity = np.cumsum(arm.v), np.zeros(3)
        for i, name in enumerate(arm.links):
            link = arm.link(name)
            along = np.array([np.cos(angle[i]), 0, -np.sin(angle[i])])
            spin = np.array([0, rate[i], 0])
            np.testing.assert_allclose(link.position, place, atol=1e-12)
            np.testing.assert_allclose(link.rotation, (np.cos(angle[i] / 2), 0, np.sin(angle[i] / 2), 0), atol=1e-12)
            np.testing.assert_allclose(link.center, place + 0.15 * along, atol=1e-12)
            np.testing.assert_allclose(link.velocity, velocity, atol=1e-12)
            np.testing.assert_allclose(link.angular_velocity, spin, atol=1e-12)
            np.testing.assert_allclose(link.center_velocity, velocity + np.cross(spin, 0.15 * along), atol=1e-12)
            for point in ((0, 0, 0), (0.3, 0.1, -0.2)):
                J = arm.jacobian(name, point)
                self.assertEqual(J.shape, (6, 3))
                c, s = np.cos(angle[i]), np.sin(angle[i])
                arm_of = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ point
                np.testing.assert_allclose(J @ arm.v, np.r_[velocity + np.cross(spin, arm_of), spin], atol=1e-12)
            velocity = velocity + np.cross(spin, 0.3 * along)
            place = place + 0.3 * along

    def test_joints_have_views_limits_and_efforts(self):
        world, arm = arm_world()
        elbow = arm.joint("elbow")
        elbow.q[0] = 0.2
        self.assertEqual(arm.q[1], 0.2)
        self.assertEqual(arm.joint("shoulder").limits, (-2, 2))
        self.assertEqual(elbow.limits, (-np.inf, np.inf))
        self.assertEqual(elbow.kind, "revolute")
        arm.v[1] = 0.5
        self.assertAlmostEqual(elbow.effort, -80, msg="its limit")
        run(world, 720)
        # At rest the drives carry what hangs on them: the wrist hangs down, so that its weight acts at its joint.
        shoulder, elbow_at, wrist = (arm.link(i).position for i in range(3))
        centers = [arm.link(i).center for i in range(3)]
        of_shoulder = sum(9.81 * (c - shoulder)[0] for c in centers)
        of_elbow = sum(9.81 * (c - elbow_at)[0] for c in centers[1:])
        np.testing.assert_allclose(arm.efforts, (-of_shoulder, -of_elbow), rtol=2e-3)

    def test_center_is_that_of_all_mass_whatever_the_base(self):
        for base in ("fixed", "free"):
            world = brim.World(voxel_size=0.02)
            links = [{"name": "base", "mass": 5, "shape": brim.box((0.2, 0.2, 0.1)), "joint": {"kind": "fixed"}},
                     {"name": "l", "parent": "base", "mass": 1, "shape": brim.sphere(0.05), "transform": {"position": (0.6, 0, 0)},
                      "joint": {"kind": "revolute", "axis": (0, 1, 0)}}]
            arm = world.add("articulated", links=links, base=base, transform={"position": (0, 0, 1)})
            self.assertAlmostEqual(arm.mass, 6)
            np.testing.assert_allclose(arm.center, (0.1, 0, 1), atol=1e-9)


class Episodes(unittest.TestCase):
    def test_an_episode_with_a_cup_a_drive_and_a_force_is_reset_bit_for_bit(self):
        world, arm = arm_world(sleep=True)
        world.add("obstacle", name="floor", shape=brim.plane())
        box = world.add("rigid", name="box", shape=brim.box((0.1, 0.1, 0.1)), transform={"position": (0.3, 0, 0.05)})
        hinged = world.add("rigid", name="flap", shape=brim.box((0.2, 0.2, 0.05)), transform={"position": (2, 0, 1)})
        hinge = world.joint(hinged, kind="revolute", position=(2, 0, 1), axis=(0, 1, 0), drive={"stiffness": 50, "damping": 2})
        start = world.save()
        run(world, 40)
        alone = world.hash
        world.restore(start)

        def episode():
            cup = world.attach(box, arm, name="cup", point=tuple(box.center), stiffness=2000, damping=20)
            arm.set_drives([-0.4, 0.3])
            hinge.set_drive(0.5)
            world.apply_force(box, name="push", force=(2, 0, 0))
            run(world, 20)
            half = world.save()
            run(world, 20)
            return cup, half, world.hash

        cup, half, end = episode()
        self.assertFalse(cup.broken)
        self.assertNotEqual(end, alone)
        for _ in range(3):
            world.restore(start)
            self.assertTrue(cup.broken)
            self.assertEqual(cup.name, "cup")
            with self.assertRaisesRegex(brim.InputError, 'attachment "cup" is not there'):
                cup.set_drive(0)
            cup.detach()
            self.assertEqual([a.name for a in world.attachments], [hinge.name])
            run(world, 40)
            self.assertEqual(world.hash, alone)
            world.restore(start)
            again, other, now = episode()
            self.assertEqual(now, end)
            self.assertTrue(cup.broken)
            self.assertEqual(len(world.attachments), 2)
            again.detach()
        world.restore(half)
        self.assertFalse(cup.broken)
        run(world, 20)
        self.assertEqual(world.hash, end)
        # A pickled state means by names what it was saved with.
        world.restore(pickle.loads(pickle.dumps(half)))
        run(world, 20)
        self.assertEqual(world.hash, end)
        world.restore(pickle.loads(pickle.dumps(start)))
        self.assertEqual(len(world.attachments), 1)
        with self.assertRaisesRegex(brim.InputError, "it has the attachment 'cup', which this world does not have"):
            world.restore(pickle.loads(pickle.dumps(half)))

    def test_a_saved_scene_has_what_exists(self):
        world, arm = arm_world()
        start = world.save()
        world.attach(arm, name="cup", point=(0.1, 0, 1))
        world.apply_force(arm, name="push", point=(0.1, 0, 1), force=(1, 0, 0))
        world.restore(start)
        world.attach(arm, name="cup", point=(0.2, 0, 1))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.json"
            world.save_scene(path, frames=10)
            scene = json.loads(path.read_text())
            brim.load(path)
        self.assertEqual([a["point"] for a in scene["attachments"]], [[0.2, 0, 1]])
        self.assertEqual(scene["forces"], [])


if __name__ == "__main__":
    unittest.main()
