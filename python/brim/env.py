"""Worlds as environments for reinforcement learning, in the form of gymnasium."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any, Callable

import numpy as np

from .world import World

try:
    from gymnasium import Env as _Base  # type: ignore[import]
except ImportError:

    class _Base:  # type: ignore[no-redef]
        """Stands for gymnasium.Env where that is not installed."""

        def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
            if seed is not None or not hasattr(self, "np_random"):
                self.np_random = np.random.default_rng(seed)

        def close(self) -> None:
            pass


class Env(_Base):  # type: ignore[misc, type-arg]
    """An environment around a world. Derive from it and say::

        build(self) -> World                       made once; each episode starts from its first state, bit for bit
        start(self)                                changes of that state at random: use self.np_random
        act(self, action)                          before the steps of an action: set velocities, forces, ...
        observe(self) -> observation
        judge(self) -> (reward, terminated)

    ``frames`` is the number of steps of the world per action, ``limit`` the number of actions after which an episode is
    cut. Set observation_space and action_space where gymnasium's tools want them.
    """

    frames: int = 1
    limit: int = 1000

    def __init__(self) -> None:
        super().__init__()
        self.world = self.build()
        self._first = self.world.save()
        self._actions = 0

    def build(self) -> World:
        raise NotImplementedError(f"{type(self).__name__} must make its world: build()")

    def start(self) -> None:
        pass

    def act(self, action: Any) -> None:
        raise NotImplementedError(f"{type(self).__name__} must say what an action does: act(action)")

    def observe(self) -> Any:
        raise NotImplementedError(f"{type(self).__name__} must say what is seen: observe()")

    def judge(self) -> tuple[float, bool]:
        return 0.0, False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """@return observation, info"""
        super().reset(seed=seed, options=options)
        self._actions = 0
        self.world.restore(self._first)
        self.start()
        return self.observe(), {"time": self.world.time}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """@return observation, reward, terminated, truncated, info"""
        self.act(action)
        for _ in range(self.frames):
            report = self.world.step()
        self._actions += 1
        reward, terminated = self.judge()
        info = {"time": self.world.time, "contacts": report.contacts}
        return self.observe(), float(reward), bool(terminated), self._actions >= self.limit, info


class Envs:
    """Many environments of one kind, each stepped in a thread of its own; one that ends is reset. Values are stacked along
    a first axis. brim.set_threads(1) keeps each world to its thread, which is fastest for many small worlds."""

    def __init__(self, make: Callable[[], Env], count: int) -> None:
        if count < 1:
            raise ValueError(f"count: {count} is not allowed; must be at least 1")
        self.envs = [make() for _ in range(count)]
        self._threads = ThreadPoolExecutor(count)

    def reset(self, *, seed: int | None = None) -> tuple[Any, list[dict[str, Any]]]:
        """Environment i takes seed + i. @return observations, infos"""
        seeds = [None if seed is None else seed + i for i in range(len(self.envs))]
        results = list(self._threads.map(self._begin, self.envs, seeds))
        return np.stack([np.asarray(r[0]) for r in results]), [r[1] for r in results]

    @staticmethod
    def _begin(env: Env, seed: int | None) -> tuple[Any, dict[str, Any]]:
        return env.reset(seed=seed)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, list[dict[str, Any]]]:
        """@return observations, rewards (n,), terminated (n,), truncated (n,), infos; where an episode ended, the observation
        is the first of the next, and info["last"] the last of it"""
        try:
            count = len(actions)
        except TypeError:
            count = None
        if count != len(self.envs):
            given = f"{actions!r} is" if count is None else f"{count} are"
            raise ValueError(f"actions: {given} not allowed; there are {len(self.envs)} environments, each with one")
        results = list(self._threads.map(self._one, self.envs, actions))
        observations, rewards, terminated, truncated, infos = zip(*results)
        return (np.stack([np.asarray(o) for o in observations]), np.array(rewards), np.array(terminated),
                np.array(truncated), list(infos))

    @staticmethod
    def _one(env: Env, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        observation, reward, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            info["last"] = observation
            observation, _ = env.reset()
        return observation, reward, terminated, truncated, info

    def close(self) -> None:
        self._threads.shutdown()
        for env in self.envs:
            env.close()
