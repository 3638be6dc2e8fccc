#!/usr/bin/env python3
"""Figure 3 of the paper: a density field reduced to 16 nodes a side and read back, and the errors of that.

  tools/figure3.py                 docs/pictures/figure3.png, and its table into docs/levels.md
  tools/figure3.py -o FILE         the picture alone, elsewhere; the table is printed

A made field of 256² and, where the Python module of brim and the folder BRIM_DATA (or ../shared/data) are there, that of a
mesh of 256³ (spot) are reduced by subsampling, by averaging over boxes, and by a pyramid of binomial filters; read back by
constant, linear and cubic (Catmull-Rom) interpolation. From points of the true surface one looks along the true normal for the
isovalue 0.5 that was read back: its distance is the error of place, the angle of its gradient that of the normal.
Needs NumPy and Matplotlib (and Pillow, which it brings).
"""

import argparse
import itertools
import os
import pathlib
import sys

import with_numpy

with_numpy.need("numpy")
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/levels.md"
SIDE = 256
RATIOS = (1, 2, 4, 8, 16)
SHOWN = 16
METHODS = ("subsampling", "box", "binomial")
READINGS = ("constant", "linear", "cubic")
BINOMIAL = np.array([1, 6, 15, 20, 15, 6, 1]) / 64.0


# ---- fields, in units of a fine node --------------------------------------------------------------------------------

def made_distance(p):
    """About the signed distance to a shape with a round side, a square corner, a notch, a hole and a thin bar. p (n, 2)."""
    def box(center, half, turn=0.0):
        c, s = np.cos(turn), np.sin(turn)
        q = np.abs((p - center) @ np.array([[c, -s], [s, c]])) - half
        return np.linalg.norm(np.maximum(q, 0), axis=-1) + np.minimum(q.max(-1), 0)

    def disc(center, radius):
        return np.linalg.norm(p - center, axis=-1) - radius

    body = np.minimum(disc((104, 110), 62), box((150, 150), (52, 44), 0.3))
    body = np.maximum(body, -disc((96, 92), 22))
    body = np.maximum(body, -box((168, 118), (7, 26), 0.3))
    return np.minimum(body, box((92, 196), (44, 5), 0.2))


def made_field():
    """Covered share of each of 256 x 256 nodes' cells, 8 x 8 samples each; points of the outline and their normals."""
    fine = (np.arange(SIDE * 8) + 0.5) / 8 - 0.5
    grid = np.stack(np.meshgrid(fine, fine, indexing="ij"), -1).reshape(-1, 2)
    inside = (made_distance(grid) < 0).reshape(SIDE, 8, SIDE, 8)
    # Points on the outline: from nodes near it along the gradient.
    random = np.random.default_rng(3)
    p = random.uniform(8, SIDE - 8, (200000, 2))
    p = p[np.abs(made_distance(p)) < 1.0]
    for _ in range(8):
        n = gradient(made_distance, p, 0.05)
        p = p - made_distance(p)[:, None] * n
    good = np.abs(made_distance(p)) < 1e-3
    return inside.mean((1, 3)), p[good][:2000], gradient(made_distance, p[good][:2000], 0.05)


def gradient(f, p, step):
    """Unit gradient of f by central differences; zero where f is flat."""
    g = np.stack([f(p + step * e) - f(p - step * e) for e in np.eye(p.shape[1])], -1)
    return g / np.maximum(np.linalg.norm(g, axis=-1, keepdims=True), 1e-300) * (np.abs(g).max(-1, keepdims=True) > 1e-12)


def mesh_field(data):
    """Density of spot at 256³ nodes as brim samples it (ramp of 3 nodes), and points of its triangles with normals."""
    import brim
    lines = [line.split() for line in (data / "spot.obj").read_text().splitlines()]
    x = np.array([list(map(float, w[1:4])) for w in lines if w and w[0] == "v"])
    faces = np.array([[int(c.split("/")[0]) - 1 for c in w[1:4]] for w in lines if w and w[0] == "f"])
    low, high = x.min(0), x.max(0)
    h = (high - low).max() / 224
    x = (x - 0.5 * (low + high)) / h
    world = brim.World(voxel_size=h)
    world.add("rigid", name="spot", voxel_size=h, shape={"kind": "mesh", "file": str(data / "spot.obj"), "center": True})
    field = np.zeros((SIDE,) * 3, np.float32)
    keys = np.array(list(itertools.product(range(-16, 16), repeat=3)))
    for part in np.array_split(keys, 32):
        for key, block in zip(part, world.density(0, h, part)):
            i, j, k = (key + 16) * 8
            field[i:i + 8, j:j + 8, k:k + 8] = block
    corners = x[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    pick = np.random.default_rng(3).choice(len(faces), 3000, p=area / area.sum())
    return field, corners[pick].mean(1) + SIDE // 2, normal[pick] / area[pick, None]


# ---- reducing and reading back ----------------------------------------------------------------------------------------

def reduced(field, ratio, method):
    """The field at every ratio-th node, and the place of its first node."""
    if ratio == 1:
        return field, 0.0
    if method == "subsampling":
        return field[(slice(ratio // 2, None, ratio),) * field.ndim], float(ratio // 2)
    if method == "box":
        shape = [n for side in field.shape for n in (side // ratio, ratio)]
        return field.reshape(shape).mean(tuple(range(1, 2 * field.ndim, 2))), 0.5 * (ratio - 1)
    out, place = field, 0.0
    for level in range(ratio.bit_length() - 1):  # every second node of the filtered level before
        for axis in range(out.ndim):
            padded = np.pad(out, [(3, 3) if a == axis else (0, 0) for a in range(out.ndim)])
            n = out.shape[axis]
            out = sum(w * np.take(padded, range(i, i + n, 2), axis=axis) for i, w in enumerate(BINOMIAL))
    return out, place


def reader(coarse, first, ratio, reading):
    """f(p): the reduced field read back at points (n, d), in fine nodes."""
    flat, shape = coarse.reshape(-1).astype(float), np.array(coarse.shape)
    strides = np.array([int(np.prod(shape[a + 1:])) for a in range(len(shape))])

    def at(index):
        inside = ((index >= 0) & (index < shape)).all(-1)
        return np.where(inside, flat[(np.clip(index, 0, shape - 1) * strides).sum(-1)], 0.0)

    def weights(t):
        if reading == "linear":
            return {0: 1 - t, 1: t}
        return {-1: 0.5 * (-t + 2 * t**2 - t**3), 0: 0.5 * (2 - 5 * t**2 + 3 * t**3),
                1: 0.5 * (t + 4 * t**2 - 3 * t**3), 2: 0.5 * (t**3 - t**2)}

    def f(p):
        q = (p - first) / ratio
        if reading == "constant":
            return at(np.floor(q + 0.5).astype(int))
        base = np.floor(q).astype(int)
        along = [weights(q[..., a] - base[..., a]) for a in range(len(shape))]
        total = 0.0
        for offset in itertools.product(along[0], repeat=len(shape)):
            w = 1.0
            for a, o in enumerate(offset):
                w = w * along[a][o]
            total = total + w * at(base + np.array(offset))
        return total
    return f


def errors(f, points, normals, ratio):
    """Root mean square distance of the isovalue 0.5 along the true normal, share of points without one within 1.5 coarse
    nodes, mean angle of the gradient (differences over a coarse node) to the true normal, degrees."""
    reach = max(1.5 * ratio, 2.0)
    t = np.linspace(-reach, reach, 49)
    values = np.stack([f(points + s * normals) for s in t]) - 0.5
    crossing = (values[:-1] > 0) & (values[1:] <= 0)
    share = values[:-1] / np.where(crossing, values[:-1] - values[1:], 1.0)
    place = np.where(crossing, t[:-1, None] + share * (t[1] - t[0]), np.inf)
    found = np.take_along_axis(place, np.abs(place).argmin(0)[None], 0)[0]
    hit = np.isfinite(found)
    n = -gradient(f, (points + np.where(hit, found, 0.0)[:, None] * normals)[hit], 0.5 * ratio)
    angle = np.degrees(np.arccos(np.clip((n * normals[hit]).sum(-1), -1, 1)))
    return np.sqrt(np.mean(found[hit] ** 2)), 1 - hit.mean(), angle.mean()


# ---- picture and page ---------------------------------------------------------------------------------------------------

def table(fields):
    lines = ["| field | reduced by | read back | " + " | ".join(f"1:{r}" for r in RATIOS) + " |",
             "|---|---|---|" + "---|" * len(RATIOS)]
    for name, (field, points, normals) in fields.items():
        for method in METHODS:
            for reading in READINGS:
                cells = []
                for ratio in RATIOS:
                    rms, lost, angle = errors(reader(*reduced(field, ratio, method), ratio, reading), points, normals, ratio)
                    cells.append(f"{rms:.2f}, {angle:.0f}°" + (f", {100 * lost:.0f} %" if lost >= 0.005 else ""))
                lines.append(f"| {name} | {method} | {reading} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def picture(fields, out):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from PIL import Image
    methods = ("subsampling", "box", "binomial")
    figure, axes = plt.subplots(len(methods) * len(fields), 4, figsize=(9.6, 7.4 * len(fields)), layout="constrained",
                                squeeze=False)
    place = np.arange(SIDE, dtype=float)
    rows = iter(axes)
    for name, (field, _, _) in fields.items():
        cut = field if field.ndim == 2 else field[SIDE // 2]
        nodes = np.stack(np.meshgrid(place, place, indexing="ij"), -1)
        if field.ndim == 3:
            nodes = np.concatenate([np.full(nodes.shape[:2] + (1,), SIDE / 2), nodes], -1)
        for method in methods:
            row = next(rows)
            coarse, first = reduced(field, SHOWN, method)
            views = [("original", cut)] + [
                (f"{method}, {reading}", reader(coarse, first, SHOWN, reading)(nodes.reshape(-1, nodes.shape[-1])).reshape(
                    SIDE, SIDE)) for reading in READINGS]
            for axis, (title, values) in zip(row, views):
                axis.imshow(values.T, origin="lower", cmap="gray", vmin=0, vmax=1, interpolation="nearest")
                axis.contour(cut.T, [0.5], colors="#4aa3ff", linewidths=0.5)
                axis.contour(values.T, [0.5], colors="red", linewidths=1.0)
                axis.set_title(f"{name}: original" if title == "original" else title, fontsize=8)
                axis.set_axis_off()
    figure.savefig(out, dpi=70, metadata={"Software": "brim"})
    with Image.open(out) as picture:  # as a palette it has half the bytes
        small = picture.convert("RGB").quantize(256)
    small.save(out, optimize=True)


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, help="picture; the table is then printed")
    options = parser.parse_args(arguments)
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        parser.error("needs Matplotlib (Debian: python3-matplotlib, which /usr/bin/python3 sees)")
    fields = {"made, 256²": made_field()}
    data = pathlib.Path(os.environ.get("BRIM_DATA") or ROOT.parent / "shared/data")
    sys.path.insert(0, str(ROOT / "build/release/python"))
    try:
        if (data / "spot.obj").exists():
            fields["spot, 256³"] = mesh_field(data)
        else:
            print("the mesh is left out: set BRIM_DATA to the folder with spot.obj", file=sys.stderr)
    except ImportError:
        print("the mesh is left out: the Python module of brim is not built (./dev build)", file=sys.stderr)
    picture(fields, options.output or ROOT / "docs/pictures/figure3.png")
    text = table(fields)
    if options.output:
        print(text, end="")
        return 0
    page = PAGE.read_text(encoding="utf-8")
    begin, end = "<!-- tools/figure3.py -->\n", "<!-- end -->"
    head, rest = page.split(begin)
    PAGE.write_text(head + begin + text + end + rest.split(end, 1)[1], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
