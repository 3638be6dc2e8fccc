# %% [markdown]
# Pressure under a soft ball: contact forces as arrays, summed on a grid, beside Hertz's theory.

# %%
import sys
from pathlib import Path

import brim
import matplotlib.pyplot as plt
import numpy as np

OUT = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "out")
OUT.mkdir(parents=True, exist_ok=True)

# %% A ball of 10 cm, soft as rubber foam, is pressed on the floor by its weight and by a force on all of its nodes.
R, E, nu, extra = 0.1, 2e5, 0.3, 60.0
world = brim.World(time_step=1 / 60, voxel_size=0.0075, materials={"smooth": {"friction": 0.0}})
floor = world.add("obstacle", name="floor", shape=brim.plane(), material="smooth")
ball = world.add("finite_elements", shape=brim.sphere(R), lattice_spacing=0.025, young_modulus=E, poisson_ratio=nu,
                 density=1000, mass_damping=6.0, material="smooth", transform={"position": (0, 0, R)})


@ball.force
def press(t, x, v):
    return 0, 0, -extra / len(x) * min(1.0, t / 0.5)


world.run(frames=90).all()

# %% Contacts to a map of pressure: force over the area of a cell.
load = 9.81 * ball.mass + extra
contacts = world.contacts
sign = np.where(contacts["body_a"] == ball.number, 1.0, -1.0)
cell = 0.0075
edges = np.arange(-8.5, 9) * cell
force, *_ = np.histogram2d(contacts["position"][:, 0], contacts["position"][:, 1], bins=(edges, edges),
                           weights=sign * contacts["force"][:, 2])
pressure = force / cell**2
carried = world.force(ball, floor)[2]

# %% Hertz: an elastic ball on a rigid plane.
stiffness = E / (1 - nu**2)
a = (3 * load * R / (4 * stiffness)) ** (1 / 3)
peak = 3 * load / (2 * np.pi * a**2)
middle = 0.5 * (edges[1:] + edges[:-1])
r = np.hypot(*np.meshgrid(middle, middle, indexing="ij"))

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6))
image = left.imshow(pressure.T / 1e3, origin="lower", extent=100 * edges[[0, -1, 0, -1]], cmap="magma")
left.set(xlabel="x [cm]", ylabel="y [cm]", title=f"pressure [kPa]; {carried:.1f} N of {load:.1f} N")
figure.colorbar(image, ax=left)
right.plot(100 * r.ravel(), pressure.ravel() / 1e3, ".", label="brim, cells of one voxel")
s = np.linspace(0, a, 100)
right.plot(100 * s, peak * np.sqrt(1 - (s / a) ** 2) / 1e3, label="Hertz")
right.set(xlabel="distance from the middle [cm]", ylabel="[kPa]", xlim=(0, 6.5))
right.legend()
figure.tight_layout()
figure.savefig(OUT / "pressure_map.png", dpi=90)
print(f"carried {carried:.2f} N of {load:.2f} N; mean of the middle cells {pressure[7:10, 7:10].mean() / 1e3:.1f} kPa, "
      f"Hertz's peak {peak / 1e3:.1f} kPa")
assert abs(carried / load - 1) < 0.05
