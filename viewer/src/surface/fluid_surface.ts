/**
 * A smooth surface around particles: where their smoothed density is half of what it is within the fluid.
 *
 *   ρ(x) = Σ_i w_i k(|x − x_i| / R) / ρ0,   k(s) = (1 − s²)³,   R = 3.6 r
 *
 * with r the particles' radius, half their spacing, and ρ0 the sum of k in a full lattice. The plain sum (w = 1) would let
 * single drops and thin sheets vanish, since they never reach a half: w_i = (1 / ρ(x_i))^0.8 of the plain sum lifts them, so
 * that a lone particle is drawn about as large as its ball and a flat surface stays where it is to a quarter of r.
 *
 * The level set is taken by surface nets (one vertex in each cell that it passes, at the mean of the crossings of the
 * cell's edges) on nodes 1.2 r apart, then smoothed twice without shrinking (Taubin). Chosen over marching cubes for
 * needing no table and making rounder triangles.
 */
import { BlockGrid, kSide } from './block_grid';

export interface SurfaceMesh {
  positions: Float32Array; // (nv, 3)
  cells: Uint32Array; // (nt, 3), counter-clockwise from outside
}

const kReach = 3.6; // R / r
const kStep = 1.2; // node spacing / r
const kLevel = 0.5;
const kLift = 0.8; // exponent of w
const kMostBlocks = 4_000_000; // in the table; coarser nodes beyond
// ∫ k dV = 2π B(3/2, 4) R³ = 0.6383 R³, over the volume (2 r)³ of a particle.
const kFull = (0.6383 * kReach ** 3) / 8;

/** Adds each particle's kernel to the nodes around it. @param weight of each; 1 when absent */
function splat(
  grid: BlockGrid,
  points: Float32Array,
  h: number,
  from: number[],
  reach: number,
  weight?: Float32Array,
) {
  const cells = reach / h;
  const inverse = 1 / (cells * cells);
  const [ox, oy, oz] = from as [number, number, number];
  for (let p = 0; p < points.length; p += 3) {
    const x = (points[p]! - ox) / h;
    const y = (points[p + 1]! - oy) / h;
    const z = (points[p + 2]! - oz) / h;
    if (!Number.isFinite(x + y + z)) continue;
    const w = (weight ? weight[p / 3]! : 1) / kFull;
    const i0 = Math.ceil(x - cells);
    const i1 = Math.floor(x + cells);
    const j0 = Math.ceil(y - cells);
    const j1 = Math.floor(y + cells);
    const k0 = Math.ceil(z - cells);
    const k1 = Math.floor(z + cells);
    for (let bk = k0 >> 3; bk <= k1 >> 3; ++bk)
      for (let bj = j0 >> 3; bj <= j1 >> 3; ++bj)
        for (let bi = i0 >> 3; bi <= i1 >> 3; ++bi) {
          const base = grid.touch(bi, bj, bk) * kSide ** 3;
          const { values } = grid;
          for (let k = Math.max(k0, 8 * bk); k <= Math.min(k1, 8 * bk + 7); ++k)
            for (let j = Math.max(j0, 8 * bj); j <= Math.min(j1, 8 * bj + 7); ++j) {
              const rest = 1 - ((j - y) * (j - y) + (k - z) * (k - z)) * inverse;
              if (rest <= 0) continue;
              const row = base + kSide * ((j & 7) + kSide * (k & 7));
              for (let i = Math.max(i0, 8 * bi); i <= Math.min(i1, 8 * bi + 7); ++i) {
                const s = rest - (i - x) * (i - x) * inverse;
                if (s > 0) values[row + (i & 7)]! += w * s * s * s;
              }
            }
        }
  }
}

/** What lifts sparse particles: a power of the density where each is, interpolated between nodes. */
function weights(grid: BlockGrid, points: Float32Array, h: number, from: number[]): Float32Array {
  const out = new Float32Array(points.length / 3);
  for (let p = 0; p < points.length; p += 3) {
    const x = (points[p]! - from[0]!) / h;
    const y = (points[p + 1]! - from[1]!) / h;
    const z = (points[p + 2]! - from[2]!) / h;
    const i = Math.floor(x);
    const j = Math.floor(y);
    const k = Math.floor(z);
    let rho = 0;
    for (let c = 0; c < 8; ++c) {
      const right = c & 1;
      const back = (c >> 1) & 1;
      const up = c >> 2;
      const at = grid.at(i + right, j + back, k + up);
      if (at < 0) continue;
      const share = (right ? x - i : 1 - x + i) * (back ? y - j : 1 - y + j) * (up ? z - k : 1 - z + k);
      rho += share * grid.values[at]!;
    }
    out[p / 3] = Math.min(1, Math.max(rho, 0.5 / kFull)) ** -kLift;
  }
  return out;
}

const kHalo = kSide + 1; // nodes of a block's cells along an axis

/** The level set of the grid; positions in steps from the grid's first node. */
function surfaceNets(grid: BlockGrid): { positions: number[]; cells: number[] } {
  const positions: number[] = [];
  const cells: number[] = [];
  const vertexOf = new Int32Array(grid.blocks.length * kSide ** 3).fill(-1); // cell -> vertex
  const local = new Float32Array(kHalo ** 3);
  const crossed: number[] = []; // edges with a change of sign: node, axis, whether it leaves the fluid; five numbers each
  const offsets = [0, 1, 2, 3, 4, 5, 6, 7].map((c) => (c & 1) + kHalo * (((c >> 1) & 1) + kHalo * (c >> 2)));
  for (let b = 0; b < grid.blocks.length; ++b) {
    const [bi, bj, bk] = grid.placeOf(b);
    let above = 0;
    for (let k = 0, n = 0; k < kHalo; ++k)
      for (let j = 0; j < kHalo; ++j)
        for (let i = 0; i < kHalo; ++i, ++n) {
          const at =
            i < kSide && j < kSide && k < kSide
              ? b * kSide ** 3 + i + kSide * (j + kSide * k)
              : grid.at(8 * bi + i, 8 * bj + j, 8 * bk + k);
          local[n] = (at < 0 ? 0 : grid.values[at]!) - kLevel;
          if (local[n]! > 0) ++above;
        }
    if (above === 0 || above === local.length) continue;
    for (let k = 0; k < kSide; ++k)
      for (let j = 0; j < kSide; ++j)
        for (let i = 0; i < kSide; ++i) {
          const n = i + kHalo * (j + kHalo * k);
          let mask = 0;
          for (let c = 0; c < 8; ++c) if (local[n + offsets[c]!]! > 0) mask |= 1 << c;
          if (mask === 0 || mask === 255) continue;
          let x = 0;
          let y = 0;
          let z = 0;
          let count = 0;
          for (let c = 0; c < 8; ++c)
            for (let axis = 0; axis < 3; ++axis) {
              const d = c | (1 << axis);
              if (d === c || ((mask >> c) & 1) === ((mask >> d) & 1)) continue;
              const here = local[n + offsets[c]!]!;
              const t = here / (here - local[n + offsets[d]!]!);
              x += axis === 0 ? t : c & 1;
              y += axis === 1 ? t : (c >> 1) & 1;
              z += axis === 2 ? t : c >> 2;
              ++count;
            }
          vertexOf[b * kSide ** 3 + i + kSide * (j + kSide * k)] = positions.length / 3;
          positions.push(8 * bi + i + x / count, 8 * bj + j + y / count, 8 * bk + k + z / count);
          for (let axis = 0; axis < 3; ++axis)
            if ((mask & 1) !== ((mask >> (1 << axis)) & 1))
              crossed.push(8 * bi + i, 8 * bj + j, 8 * bk + k, axis, mask & 1);
        }
  }
  const vertex = (i: number, j: number, k: number) => {
    const at = grid.at(i, j, k);
    return at < 0 ? -1 : vertexOf[at]!;
  };
  // Around each crossed edge, the four cells that share it make two triangles.
  for (let e = 0; e < crossed.length; e += 5) {
    const [i, j, k, axis, leaves] = crossed.slice(e, e + 5) as [number, number, number, number, number];
    const ui = axis === 2 ? 1 : 0; // one step along the axis that follows in the ring x, y, z; then the one after
    const uj = axis === 0 ? 1 : 0;
    const uk = axis === 1 ? 1 : 0;
    const a = vertex(i, j, k);
    const b = vertex(i - ui, j - uj, k - uk);
    const c = vertex(i - ui - uk, j - uj - ui, k - uk - uj);
    const d = vertex(i - uk, j - ui, k - uj);
    if (a < 0 || b < 0 || c < 0 || d < 0) continue;
    if (leaves) cells.push(a, b, c, a, c, d);
    else cells.push(a, c, b, a, d, c);
  }
  return { positions, cells };
}

/** Evens out bumps of single particles; the second, outward half of each round undoes the shrinking (Taubin). */
function smooth(positions: Float32Array, cells: ArrayLike<number>, rounds: number): void {
  const sum = new Float32Array(positions.length);
  const count = new Float32Array(positions.length / 3);
  for (let half = 0; half < 2 * rounds; ++half) {
    sum.fill(0);
    count.fill(0);
    for (let c = 0; c < cells.length; ++c) {
      const v = cells[c]!;
      const w = cells[c % 3 === 2 ? c - 2 : c + 1]!; // each edge is met once from either end
      for (let a = 0; a < 3; ++a) sum[3 * v + a]! += positions[3 * w + a]!;
      ++count[v]!;
    }
    const pull = half % 2 ? -0.53 : 0.5;
    for (let v = 0; v < count.length; ++v)
      if (count[v]! > 0)
        for (let a = 0; a < 3; ++a)
          positions[3 * v + a]! += pull * (sum[3 * v + a]! / count[v]! - positions[3 * v + a]!);
  }
}

/**
 * The surface of a fluid of particles.
 * @param points [m] (n, 3); those that are not finite are left out
 * @param radius [m] of a particle, half the spacing of the fluid at rest
 */
export function fluidSurface(points: Float32Array, radius: number): SurfaceMesh {
  const lo = [Infinity, Infinity, Infinity];
  const hi = [-Infinity, -Infinity, -Infinity];
  for (let p = 0; p < points.length; p += 3) {
    if (!Number.isFinite(points[p]! + points[p + 1]! + points[p + 2]!)) continue;
    for (let a = 0; a < 3; ++a) {
      lo[a] = Math.min(lo[a]!, points[p + a]!);
      hi[a] = Math.max(hi[a]!, points[p + a]!);
    }
  }
  if (!(radius > 0) || lo[0] === Infinity)
    return { positions: new Float32Array(0), cells: new Uint32Array(0) };
  let h = kStep * radius;
  const reach = kReach * radius;
  // Blocks start at multiples of their size, so that nodes stand still while the fluid moves.
  const first = (a: number) => Math.floor((lo[a]! - reach) / (kSide * h));
  const blocks = () =>
    [0, 1, 2].map((a) => Math.floor((hi[a]! + reach) / (kSide * h)) - first(a) + 1) as [
      number,
      number,
      number,
    ];
  while (blocks().reduce((n, b) => n * b, 1) > kMostBlocks) h *= 1.25;
  const from = [0, 1, 2].map((a) => first(a) * kSide * h);
  const grid = new BlockGrid(blocks());
  splat(grid, points, h, from, reach);
  const weight = weights(grid, points, h, from);
  grid.clear();
  splat(grid, points, h, from, reach, weight);
  const net = surfaceNets(grid);
  const positions = new Float32Array(net.positions);
  for (let i = 0; i < positions.length; ++i) positions[i] = from[i % 3]! + h * positions[i]!;
  smooth(positions, net.cells, 2);
  return { positions, cells: new Uint32Array(net.cells) };
}
