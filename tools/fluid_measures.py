#!/usr/bin/python3
"""What a run of a fluid shows, against what is known: draft of what floats, volume, speed that is left, front of a dam.

    tools/fluid_measures.py out/pool_block
    tools/fluid_measures.py out/dam_break --front 0.5

Draft: height of the surface over the lowest point of each rigid body, mean over the second half of the run, beside that
of a box of its mass and outline (Archimedes). The surface is that of the columns which the body's outline leaves free by
a cell: zero of the level set, or the volume of the particles above a level. Volume: of the cells, cut where the level
set says; of particles it is not known. Sheets: particles below them. Front: largest x over the column's length a, at
T = t sqrt(2 g / a), beside Martin and Moyce (1952), figure 3, n² = 2. Needs h5py.
"""
import argparse
import os
import sys

import with_numpy

with_numpy.need("numpy", "h5py")
import numpy as np  # noqa: E402

from run_file import RunFile  # noqa: E402
from scene_file import read_scene  # noqa: E402

GRAVITY = 9.81
MARTIN_AND_MOYCE = [(0.832, 1.217), (1.219, 1.474), (1.997, 2.292), (2.547, 2.995), (3.345, 4.134), (4.034, 4.944)]


class Particles:
    """A particle fluid: one column per square of a spacing."""

    def __init__(self, run, number, spec):
        self.step = spec["spacing"]
        self.run, self.body = run, run.bodies[number]

    def positions(self, frame):
        return self.run.positions(self.body, frame)

    def columns(self, frame):
        """(x, y, height) of the surface, shape (n, 3): of a column, what its particles stand for above a level.

        The level lies three spacings under the highest particles; the top layer is uneven, so that single columns mean
        little, but their mean keeps the volume.
        """
        x = self.positions(frame)
        at, column = np.unique(np.floor(x[:, :2] / self.step).astype(int), axis=0, return_inverse=True)
        column = column.ravel()
        top = np.full(len(at), -np.inf)
        np.maximum.at(top, column, x[:, 2])
        level = np.median(top) - 3 * self.step
        count = np.bincount(column[x[:, 2] > level], minlength=len(at))
        return np.column_stack([(at + 0.5) * self.step, level + count * self.step])

    def volume(self, frame):
        return None

    def front(self, frame):
        return self.positions(frame)[:, 0].max() + 0.5 * self.step


class Grid:
    """A grid fluid: q holds the level set at the cells, x fastest."""

    def __init__(self, run, number, spec):
        self.step = spec["cell_size"]
        self.lo, hi = np.array(spec["box"]["lo"]), np.array(spec["box"]["hi"])
        self.cells = np.round((hi - self.lo) / self.step).astype(int)
        self.q, self.first = run.file["frames/q"], int(run.bodies[number].attrs["q_offset"])

    def level_set(self, frame):
        nx, ny, nz = self.cells
        return self.q[frame, self.first:self.first + nx * ny * nz].reshape(nz, ny, nx)

    def columns(self, frame):
        phi = self.level_set(frame)
        out = []
        for j in range(self.cells[1]):
            for i in range(self.cells[0]):
                c = phi[:, j, i]
                k = np.flatnonzero((c[:-1] < 0) & (c[1:] >= 0))
                if len(k) == 0:
                    continue
                k = k[-1]
                z = k + 0.5 + c[k] / (c[k] - c[k + 1])
                out.append(self.lo + self.step * np.array([i + 0.5, j + 0.5, z]))
        return np.array(out)

    def volume(self, frame):
        return float(self.q[frame, self.first + self.cells.prod()])  # that it keeps

    def front(self, frame):
        return self.lo[0] + self.step * (np.flatnonzero((self.level_set(frame) < 0).any(axis=(0, 1)))[-1] + 1)


def outline(run, number, frame):
    x = run.positions(run.bodies[number], frame)
    return x.min(axis=0), x.max(axis=0)


def draft(run, fluid, number, frame):
    """[m], or None where no column is free."""
    lo, hi = outline(run, number, frame)
    columns = fluid.columns(frame)
    if len(columns) == 0:
        return None
    away = np.maximum(lo[:2] - columns[:, :2], columns[:, :2] - hi[:2]).max(axis=1)
    free = columns[away > fluid.step]
    return free[:, 2].mean() - lo[2] if len(free) else None


def shares(run, number, frame, shape):
    """The share of a box or ball below a height, as a function of it; it may have turned. Also its volume, [m³]."""
    body = run.bodies[number]
    first, now = run.positions(body, 0), run.positions(body, frame)
    centre = 0.5 * (first.min(axis=0) + first.max(axis=0))
    turn = np.linalg.lstsq(np.column_stack([first - centre, np.ones(len(first))]), now, rcond=None)[0]
    size = first.max(axis=0) - first.min(axis=0)
    grid = np.stack(np.meshgrid(*[(np.arange(40) + 0.5) / 40 - 0.5] * 3), axis=-1).reshape(-1, 3)
    if shape == "sphere":
        grid = grid[(grid**2).sum(axis=1) < 0.25]
    z = (grid * size) @ turn[:3, 2] + turn[3, 2]
    thickness = np.abs(size * turn[:3, 2]).sum() / 40  # of one of the small boxes that the points stand for
    return lambda level: float(np.clip((level - z) / thickness + 0.5, 0, 1).mean()), size.prod() * (np.pi / 6 if shape == "sphere" else 1.0)


def immersed(run, fluid, number, frame, shape):
    """Share of a box or ball under the surface; it may have turned. None where no column is free."""
    lo, hi = outline(run, number, frame)
    columns = fluid.columns(frame)
    away = np.maximum(lo[:2] - columns[:, :2], columns[:, :2] - hi[:2]).max(axis=1)
    free = columns[away > fluid.step]
    if not len(free):
        return None
    return shares(run, number, frame, shape)[0](free[:, 2].mean())


def immersed_in_basin(run, fluid, number, frame, shape, area):
    """Share of a box or ball under the surface of a fluid in a basin of vertical walls and a floor at z = 0.

    The surface is where the water's volume W, spacing³ a particle, fills the basin around the body: A z = W + V share(z). A
    narrow pool has too few columns beside the body: its layers lie along walls and body, and columns cut them anywhere.
    """
    share, volume = shares(run, number, frame, shape)
    kept = fluid.volume(frame)
    water = len(fluid.positions(frame)) * fluid.step**3 if kept is None else kept
    lo, hi = 0.0, (water + volume) / area
    for _ in range(50):
        middle = 0.5 * (lo + hi)
        lo, hi = (middle, hi) if area * middle - volume * share(middle) < water else (lo, middle)
    return share(hi)


def under_sheet(run, fluid, number, frame):
    """Particles below a sheet, within its outline, and all within it."""
    body = run.bodies[number]
    corners = run.positions(body, frame)[body.cells]
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = e1[:, 0] * e2[:, 1] - e1[:, 1] * e2[:, 0]
    flat = np.abs(area) > 1e-12
    a, e1, e2, area = a[flat], e1[flat], e2[flat], area[flat]
    under = within = 0
    for x in fluid.positions(frame):
        r = x - a
        u = (r[:, 0] * e2[:, 1] - r[:, 1] * e2[:, 0]) / area
        w = (e1[:, 0] * r[:, 1] - e1[:, 1] * r[:, 0]) / area
        hit = (u >= 0) & (w >= 0) & (u + w <= 1)
        if hit.any():
            within += 1
            under += bool((x[2] < (a[:, 2] + u * e1[:, 2] + w * e2[:, 2])[hit]).all())
    return under, within


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="folder that brim run wrote")
    parser.add_argument("--front", type=float, metavar="A", help="length of the column that breaks [m], from x = 0")
    options = parser.parse_args()
    try:
        run = RunFile(os.path.join(options.run, "run.h5"))
        scene = read_scene(os.path.join(options.run, "scene.json"))
    except OSError as error:
        sys.exit(f"{options.run}: {error}")
    specs = {b["name"]: b for b in scene["bodies"]}
    frames = run.frames
    found = False
    for number, body in enumerate(run.bodies):
        kind, name = body.kind, body.name
        if kind not in ("particle_fluid", "grid_fluid"):
            continue
        found = True
        spec = specs[name]
        fluid = (Particles if kind == "particle_fluid" else Grid)(run, number, spec)
        first, size = int(body.attrs["v_offset"]), int(body.attrs["v_size"])
        v = run.file["frames/v"][frames - max(1, frames // 10):frames, first:first + size]
        share = 3 if kind == "particle_fluid" else 1
        print(f"{name}: root mean square speed in the last tenth of the run {np.sqrt(share * (v**2).mean()):.3f} m/s")
        volumes = [fluid.volume(f) for f in range(frames)]
        if volumes[0]:
            print(f"{name}: volume {volumes[0]:.4f} m³, worst change {100 * max(abs(x / volumes[0] - 1) for x in volumes):.2f} %")
        for other, solid in enumerate(run.bodies):
            if solid.kind == "cloth" and kind == "particle_fluid":
                counts = [under_sheet(run, fluid, other, f) for f in range(0, frames, 6)]
                print(f"{solid.name}: particles of {name} under it {max(c[0] for c in counts)}, over it at the end "
                      f"{counts[-1][1] - counts[-1][0]}; looked at every sixth frame")
            if solid.kind != "rigid":
                continue
            found_drafts = [d for d in (draft(run, fluid, other, f) for f in range(frames // 2, frames)) if d is not None]
            if not found_drafts:
                continue
            lo, hi = outline(run, other, 0)
            mean = float(np.mean(found_drafts))
            shape = specs[solid.name].get("shape", {}).get("kind") if solid.name in specs else None
            if shape in ("box", "sphere"):
                size = (hi - lo).prod() * (np.pi / 6 if shape == "sphere" else 1.0)
                share = [immersed(run, fluid, other, f, shape) for f in range(frames // 2, frames)]
                rest = float(solid.attrs["mass"]) / (spec.get("density", 1000.0) * size)
                if rest < 1.0 and None not in share:
                    print(f"{solid.name}: share under the surface of {name} {np.mean(share):.4f}; Archimedes {rest:.4f} "
                          f"({100 * (np.mean(share) / rest - 1):+.1f} %)")
            if mean > (hi - lo)[2]:
                continue  # it sank
            wanted = float(solid.attrs["mass"]) / (spec.get("density", 1000.0) * (hi - lo)[0] * (hi - lo)[1])
            print(f"{solid.name}: draft in {name} {mean:.4f} m; a box of its outline and mass {wanted:.4f} m "
                  f"({100 * (mean / wanted - 1):+.1f} %)")
        if options.front:
            times = run.file["frames/time"][:frames] * np.sqrt(2 * GRAVITY / options.front)
            front = [fluid.front(f) / options.front for f in range(frames)]
            for t, z in MARTIN_AND_MOYCE:
                if t <= times[-1]:
                    print(f"T = {t:.3f}: front at {np.interp(t, times, front):.3f}, experiment {z:.3f}")
    if not found:
        sys.exit(f"{options.run}: no fluid in this run")


if __name__ == "__main__":
    main()
