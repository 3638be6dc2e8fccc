# %% [markdown]
# Many small worlds in threads: how far a box slides for friction and speed, beside v²/(2 μ g).

# %%
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path

import brim
import matplotlib.pyplot as plt
import numpy as np

OUT = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out")
OUT.mkdir(parents=True, exist_ok=True)
brim.set_threads(1)  # each world keeps to the thread that steps it


def slide(mu, speed):
    """Distance that a box slides on a floor [m]."""
    world = brim.World(time_step=1 / 500, voxel_size=0.025, response="constraint", materials={"m": {"friction": mu}})
    world.add("obstacle", name="floor", shape=brim.plane(), material="m")
    box = world.add("rigid", shape=brim.box((0.2, 0.2, 0.1)), material="m", transform={"position": (0, 0, 0.05)},
                    velocity=(speed, 0, 0))
    while world.time < 3 and (world.time == 0 or np.abs(box.v[0]) > 1e-3):
        world.step()
    return box.q[0]


# %%
frictions, speeds = np.array([0.1, 0.2, 0.3, 0.5]), np.array([0.5, 1.0, 1.5])
with ThreadPoolExecutor() as threads:
    distance = list(threads.map(lambda pair: slide(*pair), product(frictions, speeds)))
distance = np.array(distance).reshape(len(frictions), len(speeds))
theory = speeds**2 / (2 * frictions[:, None] * 9.81)

# %%
figure, axes = plt.subplots(figsize=(5, 3.6))
for i, speed in enumerate(speeds):
    line, = axes.plot(frictions, theory[:, i], label=f"{speed} m/s")
    axes.plot(frictions, distance[:, i], "o", color=line.get_color())
axes.set(xlabel="coefficient of friction", ylabel="sliding distance [m]", title="brim (dots) and v²/(2 μ g)")
axes.legend()
figure.tight_layout()
figure.savefig(OUT / "parameter_study.png", dpi=90)
error = np.abs(distance / theory - 1).max()
print(f"{distance.size} worlds; largest deviation from theory {100 * error:.1f} %")
assert error < 0.03  # implicit Euler: dt μ g / v, 2 % at the slowest
