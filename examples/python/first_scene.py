# %% [markdown]
# # A first scene
# A floor, a ball and a sheet: made, stepped, recorded, drawn.

# %%
import sys
from pathlib import Path

import brim
import matplotlib.pyplot as plt
import numpy as np

OUT = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out")
OUT.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# A world is empty. Bodies are added by the keys of a scene file; a sheet may come as arrays of vertices and triangles.

# %%
world = brim.World(name="first_scene", time_step=1 / 60, voxel_size=0.03)
world.add("obstacle", name="floor", shape=brim.plane())
ball = world.add("rigid", name="ball", shape=brim.sphere(0.25), density=300, transform={"position": (0, 0, 0.25)})

n = 17
side = np.linspace(-0.6, 0.6, n)
vertices = np.array([(x, y, 0.62) for y in side for x in side])
corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
triangles = np.concatenate([np.c_[corner, corner + 1, corner + n + 1], np.c_[corner, corner + n + 1, corner + n]])
sheet = world.add("cloth", name="sheet", vertices=vertices, triangles=triangles, thickness=0.06, areal_density=0.3)
print(world.bodies)

# %% [markdown]
# `run` steps and records; every frame is there to be looked at while it goes.

# %%
times, heights, loads = [], [], []
for frame in world.run(frames=90, record=OUT / "first_scene"):
    times.append(frame.time)
    heights.append(sheet.positions[:, 2].min())
    loads.append(world.force(sheet, ball)[2])
print(f"after {frame.time:.2f} s the ball carries {loads[-1]:.2f} N of the sheet's {9.81 * sheet.mass:.2f} N")

# %% [markdown]
# What was recorded opens as arrays. `world.show()` would serve it to the viewer.

# %%
run = brim.Run(OUT / "first_scene")
positions = run["sheet"].positions
figure = plt.figure(figsize=(9, 3.6), layout="constrained")
scene = figure.add_subplot(1, 2, 1, projection="3d")
scene.plot_trisurf(*positions[-1].T, triangles=triangles, color="#4c78a8", linewidth=0.1, edgecolor="white")
scene.set(title=f"the sheet after {run.times[-1]:.1f} s", zlim=(0, 0.7))
scene.set_box_aspect((1.2, 1.2, 0.7))
plot = figure.add_subplot(1, 2, 2)
plot.plot(times, loads, label="force of the ball on the sheet, z [N]")
plot.axhline(9.81 * sheet.mass, color="grey", linestyle=":", label="weight of the sheet")
plot.set(xlabel="t [s]")
plot.legend()
figure.savefig(OUT / "first_scene.png", dpi=110)

# %% The sheet lies on the ball, and hangs down around it.
assert positions.shape == (91, n * n, 3)
assert positions[-1][:, 2].max() > 0.45 and min(heights) < 0.5
