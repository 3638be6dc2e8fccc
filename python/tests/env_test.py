"""Environments in the form of gymnasium."""

import unittest

import numpy as np

import brim


class Push(brim.Env):
    """Push a ball on ice to x = 1."""

    frames = 2
    limit = 30

    def build(self):
        world = brim.World(voxel_size=0.05, materials={"ice": {"friction": 0.0}})
        world.add("obstacle", name="floor", shape=brim.plane(), material="ice")
        self.ball = world.add("rigid", shape=brim.sphere(0.2), mass=1.0, material="ice",
                              transform={"position": (0, 0, 0.2)})
        self.ball.force(lambda t, x, v: (self.push, 0, 0))
        self.push = 0.0
        return world

    def start(self):
        self.push = 0.0
        self.ball.q[0] = self.np_random.uniform(-0.1, 0.1)

    def act(self, action):
        self.push = float(action)

    def observe(self):
        return np.r_[self.ball.q[0], self.ball.v[0]]

    def judge(self):
        return -abs(1 - self.ball.q[0]), self.ball.q[0] > 1


class Environments(unittest.TestCase):
    def test_an_episode_has_gymnasium_s_shape_and_is_repeatable(self):
        env = Push()
        episodes = []
        for _ in range(2):
            seen, info = env.reset(seed=3)
            self.assertEqual(info["time"], 0.0)
            episode = [seen]
            for _ in range(10):
                seen, reward, terminated, truncated, info = env.step(1.0)
                episode.append(seen)
                self.assertIsInstance(reward, float)
                self.assertIsInstance(terminated, bool)
                self.assertFalse(terminated or truncated)
            episodes.append(np.array(episode))
        np.testing.assert_array_equal(*episodes)
        self.assertAlmostEqual(episodes[0][-1, 1], 10 * 2 / 60, places=3)
        self.assertNotEqual(env.reset(seed=4)[0][0], episodes[0][0, 0])

    def test_episodes_end_by_goal_and_by_limit(self):
        env = Push()
        env.reset(seed=0)
        for number in range(1, 40):
            *_, terminated, truncated, _ = env.step(20.0)
            if terminated or truncated:
                break
        self.assertTrue(terminated)
        self.assertLess(number, 30)
        env.reset(seed=0)
        for number in range(1, 40):
            *_, terminated, truncated, _ = env.step(0.0)
            if terminated or truncated:
                break
        self.assertTrue(truncated)
        self.assertEqual(number, 30)

    def test_many_in_threads_do_as_each_alone(self):
        alone = []
        for i in range(3):
            env = Push()
            env.reset(seed=5 + i)
            for _ in range(5):
                seen, *_ = env.step(i)
            alone.append(seen)
        envs = brim.Envs(Push, 3)
        self.addCleanup(envs.close)
        seen, infos = envs.reset(seed=5)
        self.assertEqual((seen.shape, len(infos)), ((3, 2), 3))
        for _ in range(5):
            seen, rewards, terminated, truncated, infos = envs.step([0, 1, 2])
        np.testing.assert_array_equal(seen, alone)
        self.assertEqual((rewards.shape, terminated.dtype, truncated.dtype), ((3,), bool, bool))

    def test_the_class_is_gymnasium_s_where_that_is(self):
        try:
            import gymnasium
        except ImportError:
            self.skipTest("no gymnasium")
        self.assertTrue(issubclass(brim.Env, gymnasium.Env))


if __name__ == "__main__":
    unittest.main()
