/** A plane of density samples: what the server tells of it, and the colours it is shown in. */
import { find, type NamedArray } from './codec';

export interface SliceWish {
  axis: number; // across the plane: 0 x, 1 y, 2 z
  at: number; // [m] along the axis
  body: number; // -1 for all
}

export interface Slice {
  axis: number;
  at: number; // [m] of the layer of nodes that is shown
  step: number; // [m] between nodes
  lowest: number; // [m] along the axis
  highest: number;
  first: [number, number]; // node (0, 0) lies at step * first along the axes after this one, x y z in a ring
  count: [number, number];
  density: Float32Array; // (count[1], count[0]) of the body that fills the node most
  body: Int32Array; // that body, -1 for none
  second: Float32Array;
  secondBody: Int32Array;
  overlap: Float32Array; // max(0, ρ_a + ρ_b − 1)
}

export function sliceFromArrays(arrays: NamedArray[]): Slice {
  const need = (name: string) => {
    const a = find(arrays, name);
    if (!a) throw new Error(`the slice lacks ${name}`);
    return a.data;
  };
  const plane = need('plane');
  const nodes = need('nodes');
  return {
    axis: plane[0]!,
    at: plane[1]!,
    step: plane[2]!,
    lowest: plane[3]!,
    highest: plane[4]!,
    first: [nodes[0]!, nodes[1]!],
    count: [nodes[2]!, nodes[3]!],
    density: need('density') as Float32Array,
    body: need('body') as Int32Array,
    second: need('second') as Float32Array,
    secondBody: need('second_body') as Int32Array,
    overlap: need('overlap') as Float32Array,
  };
}

type Rgb = readonly [number, number, number];

export function rgbOf(colour: string): Rgb {
  const n = parseInt(colour.slice(1), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}

/** Stops of the colour map of a single body, from empty to full: pale, then ever deeper blue. */
export const densityStops = ['#f4efe6', '#cfe1d8', '#86bcc4', '#3f86ae', '#27508c', '#1b2559'];
/** Stops of the overlap, from touching to the deepest on the plane. */
export const overlapStops = ['#ff2f63', '#ff7a3c', '#ffe14d'];

/** Colour at t in [0, 1] between evenly spaced stops. */
export function between(stops: readonly Rgb[], t: number): Rgb {
  const x = Math.max(0, Math.min(1, t)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(x));
  const a = stops[i]!;
  const b = stops[i + 1]!;
  const f = x - i;
  return [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])];
}

/**
 * Pixels of the densities, one per node: colour times density, and the density (so that colours blend in the right
 * shares between nodes). With one body its colour follows its density; with all, bodies keep their own.
 */
export function densityPixels(slice: Slice, colours: string[], single: boolean): Uint8Array<ArrayBuffer> {
  const n = slice.density.length;
  const out = new Uint8Array(4 * n);
  const own = colours.map(rgbOf);
  const stops = densityStops.map(rgbOf);
  const grey: Rgb = [128, 128, 128];
  for (let i = 0; i < n; ++i) {
    const rho = Math.min(1, slice.density[i]!);
    if (!(rho > 0)) continue;
    let c: Rgb;
    if (single) c = between(stops, rho);
    else {
      const a = own[slice.body[i]!] ?? grey;
      const other = Math.min(1, slice.second[i]!);
      const b = own[slice.secondBody[i]!] ?? a;
      const s = other / (rho + other);
      c = [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), a[2] + s * (b[2] - a[2])];
    }
    for (let k = 0; k < 3; ++k) out[4 * i + k] = Math.round(c[k]! * rho);
    out[4 * i + 3] = Math.round(255 * rho);
  }
  return out;
}

/** The deepest overlap of the plane. */
export function worstOverlap(slice: Slice): number {
  let worst = 0;
  for (const o of slice.overlap) if (o > worst) worst = o;
  return worst;
}

/** Pixels of the overlap: the root of its share in the deepest, so that light touches show beside heavy ones. */
export function overlapPixels(slice: Slice): Uint8Array<ArrayBuffer> {
  const worst = worstOverlap(slice);
  const out = new Uint8Array(slice.overlap.length);
  if (worst > 0)
    slice.overlap.forEach(
      (o, i) => (out[i] = o > 0 ? Math.max(1, Math.round(255 * Math.sqrt(o / worst))) : 0),
    );
  return out;
}

const kTileSize = 8;

/** Edges of the active tiles where the plane cuts them, (n, 2 ends, 3) [m], with the step of each tile. */
export function tileOutlines(
  slice: Slice,
  tiles: { key: Int32Array; step: Float32Array },
): { positions: Float32Array; steps: number[] } {
  const u = (slice.axis + 1) % 3;
  const v = (slice.axis + 2) % 3;
  const positions: number[] = [];
  const steps: number[] = [];
  const corners = [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 1],
  ] as const;
  tiles.step.forEach((h, t) => {
    const low = (k: number, side: number) => h * (kTileSize * (tiles.key[3 * t + k]! + side) - 0.5);
    if (slice.at < low(slice.axis, 0) || slice.at > low(slice.axis, 1)) return;
    corners.forEach((c, i) => {
      for (const [a, b] of [c, corners[(i + 1) % 4]!]) {
        const p = [0, 0, 0];
        p[slice.axis] = slice.at;
        p[u] = low(u, a!);
        p[v] = low(v, b!);
        positions.push(...p);
      }
    });
    steps.push(h);
  });
  return { positions: Float32Array.from(positions), steps };
}
