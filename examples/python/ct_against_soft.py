# %% [markdown]
# A volume of intensities, as a scanner gives it, falls on a soft block: no mesh of the bone is made.

# %%
import sys
from pathlib import Path

import brim
import matplotlib.pyplot as plt
import numpy as np

OUT = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out")
OUT.mkdir(parents=True, exist_ok=True)

# %% A made-up bone: two heads and a shaft, 1200 HU inside, air outside, a soft edge and noise. Any array (nx, ny, nz) will do.
spacing = np.array([1.5e-3, 1.5e-3, 1.5e-3])
n = (80, 32, 32)
x, y, z = ((np.arange(k) - (k - 1) / 2) * s for k, s in zip(n, spacing))
x, y, z = np.meshgrid(x, y, z, indexing="ij")
shaft = np.hypot(y, z) - 0.007 - 0.03 * np.clip(np.abs(x) - 0.02, 0, None) ** 1.5
heads = np.minimum(np.hypot(x - 0.035, np.hypot(y, z)), np.hypot(x + 0.035, np.hypot(y - 0.004, z))) - 0.015
inside = np.minimum(np.maximum(shaft, np.abs(x) - 0.035), heads)
ct = np.clip(-inside / 2e-3, -0.5, 0.5) * 2200 + 100 + np.random.default_rng(0).normal(0, 20, n)

# %%
world = brim.World(time_step=1 / 120, voxel_size=0.004)
world.add("obstacle", name="table", shape=brim.plane())
gel = world.add("finite_elements", name="gel", shape=brim.box((0.14, 0.08, 0.03)), lattice_spacing=0.015, density=1000,
                young_modulus=1e4, stiffness_damping=0.01, transform={"position": (0, 0, 0.015)})
bone = world.add("image_volume", name="bone", intensities=ct, spacing=spacing, window=(300, 300), density=1800,
                 transform={"position": (0, 0, 0.055)})
heights, forces, times = [], [], []
for frame in world.run(frames=90):
    times.append(frame.time)
    heights.append(bone.q[2])
    forces.append(world.force(bone, gel)[2])

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4))
half = [100 * spacing[0] * n[0] / 2, 100 * spacing[2] * n[2] / 2]
left.imshow(ct[:, n[1] // 2].T, origin="lower", cmap="gray", extent=[-half[0], half[0], -half[1], half[1]])
left.set(title="the volume, a slice [HU]", xlabel="x [cm]", ylabel="z [cm]")
right.plot(times, forces, label="force of the gel on the bone [N]")
right.axhline(9.81 * bone.mass, color="gray", linestyle=":", label="weight of the bone")
right.set(xlabel="time [s]")
right.legend()
figure.tight_layout()
figure.savefig(OUT / "ct_against_soft.png", dpi=90)
rest = np.mean(forces[-15:])
print(f"bone of {1e3 * bone.mass:.0f} g lies {1e3 * (bone.q[2] - 0.03):.1f} mm above the gel's top at rest; the gel carries "
      f"{rest:.3f} N of {9.81 * bone.mass:.3f} N")
assert abs(rest / (9.81 * bone.mass) - 1) < 0.1
