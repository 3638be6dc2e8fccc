# %% [markdown]
# # A body of one's own
# A balloon that stretches along the axes. It says where its matter is and what energy it holds; contact with every
# other kind of body follows.

# %%
import sys
from pathlib import Path

import brim
import matplotlib.pyplot as plt
import numpy as np

OUT = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out")
OUT.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# Coordinates are the centre and the stretch along each axis, $q = (c, s)$. At rest the matter at $X$ lies at $c + s X$;
# the energy wants volume and shape back,
# $E = \frac{k}{2} \sum_i (s_i - 1)^2 + \frac{K}{2} (s_1 s_2 s_3 - 1)^2$.

# %%
R = 0.3


class Balloon(brim.OwnBody):
    """A ball that stretches along the axes and keeps its volume."""
    q0 = np.r_[0, 0, 0.8, 1, 1, 1]
    k, K = 40.0, 2000.0

    def deform(self, q, X):
        return q[:3] + q[3:] * X

    def inverse_deform(self, q, x):
        return (x - q[:3]) / q[3:]

    def distance(self, q, x):
        return (np.linalg.norm(self.inverse_deform(q, x), axis=1) - R) * q[3:].min()

    def energy(self, q):
        s = q[3:]
        return 0.5 * self.k * np.sum((s - 1) ** 2) + 0.5 * self.K * (np.prod(s) - 1) ** 2


world = brim.World(time_step=1 / 120, voxel_size=0.04)
floor = world.add("obstacle", name="floor", shape=brim.plane())
balloon = world.add(Balloon(surface=brim.sphere(R), density=50), name="balloon")
box = world.add("rigid", name="box", shape=brim.box((0.4, 0.4, 0.1)), mass=3, transform={"position": (0, 0, 1.3)})

# %% [markdown]
# The box knows nothing of the balloon, nor the balloon of it.

# %%
trace = []
for frame in world.run(frames=240):
    trace.append([frame.time, *balloon.q[3:], box.q[2], world.force(balloon, floor)[2]])
trace = np.array(trace)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
for i, axis in enumerate("xyz"):
    left.plot(trace[:, 0], trace[:, 1 + i], label=f"stretch along {axis}")
left.plot(trace[:, 0], trace[:, 1:4].prod(axis=1), "k:", label="volume")
left.set(xlabel="t [s]", ylabel="over that at rest")
left.legend()
right.plot(trace[:, 0], trace[:, 5], label="the floor on the balloon, z [N]")
right.axhline(9.81 * (balloon.mass + box.mass), color="grey", linestyle=":", label="weight of both")
right.set(xlabel="t [s]")
right.legend()
figure.savefig(OUT / "own_body.png", dpi=110)
print(f"stretch {np.round(balloon.q[3:], 3)}, the box lies at {box.q[2]:.3f} m")

# %% It is pressed flat under the box and keeps its volume.
assert balloon.q[5] < 0.97 and abs(np.prod(balloon.q[3:]) - 1) < 0.05
