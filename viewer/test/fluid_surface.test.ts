import { describe, expect, test } from 'vitest';
import { fluidSurface, type SurfaceMesh } from '../src/surface/fluid_surface';

const kRadius = 0.01;

/** Points of a lattice two radii apart within a box of so many. */
function lattice(nx: number, ny: number, nz: number, jitter = 0): Float32Array {
  const out: number[] = [];
  let seed = 12345;
  const random = () =>
    ((seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648 - 0.5) * 2 * jitter * kRadius;
  for (let k = 0; k < nz; ++k)
    for (let j = 0; j < ny; ++j)
      for (let i = 0; i < nx; ++i)
        out.push(
          (2 * i + 1) * kRadius + random(),
          (2 * j + 1) * kRadius + random(),
          (2 * k + 1) * kRadius + random(),
        );
  return Float32Array.from(out);
}

/** By the divergence theorem; positive when triangles run counter-clockwise seen from outside. */
function volume({ positions: p, cells }: SurfaceMesh): number {
  let sum = 0;
  for (let t = 0; t < cells.length; t += 3) {
    const [a, b, c] = [3 * cells[t]!, 3 * cells[t + 1]!, 3 * cells[t + 2]!];
    sum +=
      p[a]! * (p[b + 1]! * p[c + 2]! - p[b + 2]! * p[c + 1]!) +
      p[a + 1]! * (p[b + 2]! * p[c]! - p[b]! * p[c + 2]!) +
      p[a + 2]! * (p[b]! * p[c + 1]! - p[b + 1]! * p[c]!);
  }
  return sum / 6;
}

/** Times that each directed edge is met, less those of its reverse: all zero in a closed surface. */
function openEdges({ cells }: SurfaceMesh): number {
  const edges = new Map<string, number>();
  for (let c = 0; c < cells.length; ++c) {
    const a = cells[c]!;
    const b = cells[c % 3 === 2 ? c - 2 : c + 1]!;
    const key = a < b ? `${a} ${b}` : `${b} ${a}`;
    edges.set(key, (edges.get(key) ?? 0) + (a < b ? 1 : -1));
  }
  return [...edges.values()].filter((n) => n !== 0).length;
}

describe('the surface of a fluid of particles', () => {
  test('is closed and holds the volume of the particles within 15 percent', () => {
    for (const [points, what] of [
      [lattice(12, 10, 14), 'lattice'],
      [lattice(20, 8, 9, 0.5), 'shaken lattice'],
    ] as const) {
      const mesh = fluidSurface(points, kRadius);
      const true_ = (points.length / 3) * (2 * kRadius) ** 3;
      expect(openEdges(mesh), what).toBe(0);
      expect(volume(mesh) / true_, what).toBeGreaterThan(0.85);
      expect(volume(mesh) / true_, what).toBeLessThan(1.15);
    }
  });

  test('lies flat, half a spacing above the uppermost layer, to a quarter of a radius', () => {
    const { positions } = fluidSurface(lattice(24, 24, 8), kRadius);
    const heights: number[] = [];
    for (let v = 0; v < positions.length; v += 3) {
      const inner = [0, 1].every((a) => positions[v + a]! > 12 * kRadius && positions[v + a]! < 36 * kRadius);
      if (inner && positions[v + 2]! > 8 * kRadius) heights.push(positions[v + 2]! / kRadius);
    }
    expect(heights.length).toBeGreaterThan(50);
    for (const z of heights) expect(Math.abs(z - 16)).toBeLessThan(0.25);
  });

  test('keeps a lone drop, about as large as its ball, and a sheet one particle thick', () => {
    const drop = fluidSurface(Float32Array.from([0.3, -0.2, 5]), kRadius);
    const far = Math.max(
      ...Array.from({ length: drop.positions.length / 3 }, (_, v) =>
        Math.hypot(
          drop.positions[3 * v]! - 0.3,
          drop.positions[3 * v + 1]! + 0.2,
          drop.positions[3 * v + 2]! - 5,
        ),
      ),
    );
    expect(openEdges(drop)).toBe(0);
    expect(far / kRadius).toBeGreaterThan(0.7);
    expect(far / kRadius).toBeLessThan(1.7);
    const sheet = fluidSurface(lattice(16, 16, 1), kRadius);
    expect(openEdges(sheet)).toBe(0);
    expect(volume(sheet) / (256 * (2 * kRadius) ** 3)).toBeGreaterThan(0.6);
  });

  test('two drops far apart are two surfaces, and nothing lies between them', () => {
    const one = fluidSurface(Float32Array.from([0, 0, 0]), kRadius);
    const both = fluidSurface(Float32Array.from([0, 0, 0, 40, 30, 20]), kRadius);
    expect(openEdges(both)).toBe(0);
    for (let v = 0; v < both.positions.length; v += 3) {
      const [x, y, z] = both.positions.subarray(v, v + 3) as unknown as [number, number, number];
      expect(Math.min(Math.hypot(x, y, z), Math.hypot(x - 40, y - 30, z - 20))).toBeLessThan(5);
    }
    expect(one.cells.length).toBeGreaterThan(0);
  });

  test('of nothing, and of what is not a number, is nothing', () => {
    expect(fluidSurface(new Float32Array(0), kRadius).cells.length).toBe(0);
    expect(fluidSurface(Float32Array.from([NaN, 0, 0]), kRadius).cells.length).toBe(0);
    expect(fluidSurface(Float32Array.from([0, 0, 0]), 0).cells.length).toBe(0);
    const mixed = fluidSurface(Float32Array.from([NaN, 0, 0, 0, 0, 0]), kRadius);
    expect(mixed.cells.length).toBeGreaterThan(0);
  });
});
