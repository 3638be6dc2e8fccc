/** What the server tells of a run, in the shapes the page works with. docs/viewer.md describes the interface. */
import { find, type NamedArray } from './codec';

export type Display = 'triangles' | 'lines' | 'points';

export interface BodyInfo {
  index: number;
  name: string;
  kind: string;
  display: Display;
  twoSided: boolean;
  radius: number; // [m] of lines and points
  vertices: number;
  changing?: boolean; // its triangles come with every frame, and are others each time
  fixed: boolean; // its one set of positions comes with the topology
  parts: number[]; // global part numbers
}

export interface Warning {
  time: number;
  code: string;
  message: string;
}

/** A sensor; channel c of sensor n is the series "sensor n c". */
export interface SensorInfo {
  name: string;
  kind: string;
  channels: string[];
  units: string[];
}

/** An attachment or joint. */
export interface LinkInfo {
  name: string;
  kind: 'point' | 'region' | 'fixed' | 'ball' | 'hinge' | 'slider';
  bodies?: [number, number] | undefined; // -1: space; none in runs of older versions
}

/** Points that attachments and joints hold; of a hinge or slider the first two lie on its axis. */
export interface LinkEnds {
  count: number;
  link: Int32Array; // (n) which of RunInfo.links, in rising order
  a: Float32Array; // (n, 3) [m] on its first body
  b: Float32Array; // (n, 3) [m] on the other one, or in space
}

export interface RunInfo {
  name: string;
  scene: string;
  brimVersion: string;
  frames: number;
  complete: boolean; // no more frames are to be expected
  stopped?: boolean; // because the writer is gone without having ended the run
  interactive?: boolean; // its bodies can be pulled while it is made
  slices?: boolean; // densities can be asked for
  bodies: BodyInfo[];
  parts: { name: string; body: number; voxelSize?: number }[];
  sensors?: SensorInfo[];
  links?: LinkInfo[];
  warnings: Warning[];
  summary: Record<string, unknown>;
}

export interface Topology {
  cells: Int32Array; // (n, 3) triangles, (n, 2) lines, empty for points
  positions: Float32Array | undefined; // (nv, 3), of a fixed body
}

export interface Contacts {
  count: number;
  position: Float32Array; // (n, 3) [m]
  force: Float32Array; // (n, 3) [N] normal, on the first part
  friction: Float32Array; // (n, 3) [N] on the first part
  overlap: Float32Array; // (n) [voxels]
  pair: Int32Array; // (n, 2) global part numbers
}

/**
 * Size of the voxel that each contact lies in: the grid's step is the finer of what the two parts ask for, taken from the
 * steps of the frame's tiles, which are the finest one times powers of two. (n) [m]
 */
export function contactSteps(
  c: Contacts,
  parts: RunInfo['parts'],
  tileSteps: ArrayLike<number>,
): Float32Array {
  const steps = [...new Set(Array.from(tileSteps))].sort((a, b) => a - b);
  const known = new Map<number, number>();
  const stepFor = (wanted: number) => {
    const at = known.get(wanted);
    if (at !== undefined) return at;
    const step = steps.findLast((s) => s <= wanted * 1.001) ?? steps[0] ?? wanted;
    known.set(wanted, step);
    return step;
  };
  return Float32Array.from({ length: c.count }, (_, i) => {
    const sizes = [c.pair[2 * i]!, c.pair[2 * i + 1]!].map((p) => parts[p]?.voxelSize || Infinity);
    const finer = Math.min(...sizes);
    return stepFor(finer < Infinity ? finer : (steps[0] ?? 0));
  });
}

export interface Frame {
  index: number;
  positions: Map<number, Float32Array>; // body -> (nv, 3) [m]
  cells: Map<number, Int32Array>; // body -> (nt, 3), of bodies whose triangles change
  removed: Set<number>; // bodies that are no longer in the world
  contacts: Contacts;
  tiles: { key: Int32Array; step: Float32Array }; // (n, 3), (n) [m]
  pairs: PairTotal[];
  links: LinkEnds;
  bytes: number;
}

export type Series = Map<string, Float64Array>;

const noFloats = new Float32Array(0);
const noInts = new Int32Array(0);

const floats = (a: NamedArray[], name: string, body = -1) =>
  (find(a, name, body)?.data as Float32Array | undefined) ?? noFloats;
const ints = (a: NamedArray[], name: string) => (find(a, name)?.data as Int32Array | undefined) ?? noInts;

export function frameFromArrays(index: number, arrays: NamedArray[], bytes: number): Frame {
  const positions = new Map<number, Float32Array>();
  const cells = new Map<number, Int32Array>();
  for (const a of arrays)
    if (a.name === 'positions') positions.set(a.body, a.data as Float32Array);
    else if (a.name === 'triangles') cells.set(a.body, a.data as Int32Array);
  const position = floats(arrays, 'contacts/position');
  const link = ints(arrays, 'links/link');
  return {
    index,
    positions,
    cells,
    removed: new Set(ints(arrays, 'removed')),
    contacts: {
      count: position.length / 3,
      position,
      force: floats(arrays, 'contacts/force'),
      friction: floats(arrays, 'contacts/friction'),
      overlap: floats(arrays, 'contacts/overlap'),
      pair: ints(arrays, 'contacts/pair'),
    },
    tiles: { key: ints(arrays, 'tiles/key'), step: floats(arrays, 'tiles/step') },
    pairs: pairsFromArrays(arrays),
    links: { count: link.length, link, a: floats(arrays, 'links/a'), b: floats(arrays, 'links/b') },
    bytes,
  };
}

/** The totals of each touching pair, as the run recorded them. */
function pairsFromArrays(arrays: NamedArray[]): PairTotal[] {
  const parts = ints(arrays, 'pairs/parts');
  const nodes = ints(arrays, 'pairs/contacts');
  const normal = floats(arrays, 'pairs/normal');
  const friction = floats(arrays, 'pairs/friction');
  const overlap = floats(arrays, 'pairs/overlap');
  const pressure = floats(arrays, 'pairs/pressure');
  return Array.from(nodes, (count, i) => ({
    a: parts[2 * i]!,
    b: parts[2 * i + 1]!,
    count,
    normal: normal[i]!,
    friction: friction[i]!,
    worstOverlap: overlap[i]!,
    pressure: pressure[i]!,
  })).sort((x, y) => x.a - y.a || x.b - y.b);
}

export function topologyFromArrays(arrays: NamedArray[]): Topology {
  const cells = arrays.find((a) => a.name === 'triangles' || a.name === 'lines');
  const body = arrays.find((a) => a.name === 'positions');
  return {
    cells: (cells?.data as Int32Array | undefined) ?? noInts,
    positions: body?.data as Float32Array | undefined,
  };
}

export function seriesFromArrays(arrays: NamedArray[]): Series {
  const series: Series = new Map();
  for (const a of arrays) series.set(a.name, a.data as Float64Array);
  return series;
}

/** What two parts do to each other, all their contacts together. */
export interface PairTotal {
  a: number;
  b: number;
  count: number; // nodes
  normal: number; // [N] magnitude
  friction: number; // [N] magnitude
  worstOverlap: number; // [voxels]
  pressure: number; // largest, as a fraction of the stiffness; saturates near 0.5
}
