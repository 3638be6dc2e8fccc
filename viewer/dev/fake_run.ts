/**
 * A made-up run in the shapes of the HTTP interface: bodies of every display kind, contacts, tiles, series and
 * warnings, as functions of time. It moves plausibly and obeys no law; the page is developed and tested against it.
 */
import { array, encodeArrays, type NamedArray } from '../src/codec';
import type { RunInfo } from '../src/run';
import type { SliceWish } from '../src/slice';
import { elasticKinds } from '../src/stress';
import { box, sheet, sphere, type Shape } from './shapes';

type Move = (time: number) => Float32Array<ArrayBuffer>;

interface FakeBody {
  name: string;
  kind: string;
  display: 'triangles' | 'lines' | 'points';
  twoSided: boolean;
  radius: number;
  cells: Int32Array<ArrayBuffer>;
  fixed?: Float32Array<ArrayBuffer>;
  move?: Move;
  surface?: (time: number) => Shape; // other vertices and triangles each time, as of a fluid
}

export interface FakeRun {
  frames: number;
  complete: boolean;
  stopped: boolean;
  broken: Set<number>; // frames that the server fails to read, like those of a damaged file
  interactive: boolean; // its bodies can be pulled
  asked: string[]; // what was asked of them
  info(): RunInfo;
  topology(body: number): ArrayBuffer | undefined;
  frame(f: number): ArrayBuffer | undefined;
  slice(f: number, wish: SliceWish): ArrayBuffer | undefined;
  stress(f: number): ArrayBuffer | undefined;
  series(from: number): ArrayBuffer;
}

const kFrameTime = 1 / 60;

function mapped(
  shape: Shape,
  at: (p: [number, number, number], time: number) => [number, number, number],
): Move {
  return (time) => {
    const out = new Float32Array(shape.positions.length);
    for (let i = 0; i < out.length; i += 3)
      out.set(at([shape.positions[i]!, shape.positions[i + 1]!, shape.positions[i + 2]!], time), i);
    return out;
  };
}

/** Height of a ball dropped from h0 that loses part of its speed at each bounce. */
function bounce(time: number, h0: number, restitution: number): number {
  let h = h0;
  let t = time + Math.sqrt((2 * h0) / 9.81);
  while (h > 0.003) {
    const half = Math.sqrt((2 * h) / 9.81);
    if (t < 2 * half) return Math.max(0, h - 0.5 * 9.81 * (t - half) ** 2);
    t -= 2 * half;
    h *= restitution * restitution;
  }
  return 0;
}

/** Any number in [0, 1) that depends on i alone. */
const noise = (i: number) => {
  const x = Math.sin(i * 12.9898 + 4.1414) * 43758.5453;
  return x - Math.floor(x);
};

function makeBodies(): FakeBody[] {
  const ground = sheet(1);
  for (let i = 0; i < ground.positions.length; i += 3)
    ground.positions.set([ground.positions[i]! * 2, ground.positions[i + 1]! * 2, 0], i);
  const crate = box(0.22, 0.22, 0.22);
  const ball = sphere(4);
  const cloth = sheet(48);
  const rodCount = 28;
  const rods = 3;
  const dots = 500;
  const segments = new Int32Array(rods * (rodCount - 1) * 2);
  for (let r = 0, s = 0; r < rods; ++r)
    for (let i = 0; i + 1 < rodCount; ++i, s += 2) segments.set([r * rodCount + i, r * rodCount + i + 1], s);
  return [
    {
      name: 'floor',
      kind: 'fixed',
      display: 'triangles',
      twoSided: false,
      radius: 0,
      cells: ground.triangles,
      fixed: ground.positions,
    },
    {
      name: 'crate',
      kind: 'rigid',
      display: 'triangles',
      twoSided: false,
      radius: 0,
      cells: crate.triangles,
      move: mapped(crate, ([x, y, z], t) => {
        const spin = 0.5 * Math.exp(-1.4 * t) * Math.cos(5 * t) * Math.min(1, bounce(t, 0.5, 0.5) * 8);
        const c = Math.cos(spin);
        const s = Math.sin(spin);
        return [
          -0.62 + c * x + s * z,
          -0.35 + y,
          0.22 + bounce(t, 0.5, 0.5) + 0.3 * Math.abs(s) + c * z - s * x,
        ];
      }),
    },
    {
      name: 'jelly ball',
      kind: 'finite_elements',
      display: 'triangles',
      twoSided: false,
      radius: 0,
      cells: ball.triangles,
      move: mapped(ball, ([x, y, z], t) => {
        const wobble = 1 + 0.16 * Math.exp(-1.2 * t) * Math.cos(13 * t);
        const h = bounce(t, 0.7, 0.72);
        return [
          0.5 + (0.28 * x) / Math.sqrt(wobble),
          -0.42 + (0.28 * y) / Math.sqrt(wobble),
          0.28 * wobble + h + 0.28 * wobble * z,
        ];
      }),
    },
    {
      name: 'cloth',
      kind: 'cloth',
      display: 'triangles',
      twoSided: true,
      radius: 0.002,
      cells: cloth.triangles,
      move: mapped(cloth, ([x, y], t) => {
        const down = (1 - y) / 2;
        const wave =
          0.09 * down * Math.sin(5 * x - 4 * t + 2 * down) + 0.07 * down * Math.sin(3 * t + 3 * down);
        return [0.75 * x, 0.62 + wave, 1.35 - 1.1 * down + 0.02 * Math.sin(7 * x + 2 * t) * down];
      }),
    },
    {
      name: 'rods',
      kind: 'rod',
      display: 'lines',
      twoSided: false,
      radius: 0.014,
      cells: segments,
      move: (t) => {
        const out = new Float32Array(rods * rodCount * 3);
        for (let r = 0; r < rods; ++r)
          for (let i = 0; i < rodCount; ++i) {
            const s = i / (rodCount - 1);
            const bend = s * s * (0.25 + 0.1 * Math.sin(2.2 * t + 0.8 * r));
            out.set(
              [0.98 + 0.07 * r - bend, 0.05 + 0.1 * r, 0.9 * s * (1 - 0.25 * bend)],
              3 * (r * rodCount + i),
            );
          }
        return out;
      },
    },
    {
      name: 'grains',
      kind: 'points',
      display: 'points',
      twoSided: false,
      radius: 0.018,
      cells: new Int32Array(0),
      move: (t) => {
        const out = new Float32Array(dots * 3);
        for (let i = 0; i < dots; ++i) {
          const fall = bounce(Math.max(0, t - 0.6 * noise(3 * i + 2)), 0.2 + 0.5 * noise(3 * i + 2), 0.3);
          const a = 2 * Math.PI * noise(3 * i);
          const r = 0.3 * Math.sqrt(noise(3 * i + 1)) * (1 + 0.25 * (1 - Math.exp(-2 * t)));
          const pile = 0.018 + 0.12 * Math.max(0, 1 - r / 0.32) * noise(7 * i);
          out.set([-0.1 + r * Math.cos(a), -0.95 + r * Math.sin(a) * 0.8, pile + fall], 3 * i);
        }
        return out;
      },
    },
    {
      name: 'puddle',
      kind: 'fluid',
      display: 'triangles',
      twoSided: false,
      radius: 0,
      cells: new Int32Array(0),
      surface: (t) => {
        const shape = sheet(6 + (Math.round(t / kFrameTime) % 7));
        for (let i = 0; i < shape.positions.length; i += 3) {
          const [x, y] = [shape.positions[i]!, shape.positions[i + 1]!];
          shape.positions.set([0.9 + 0.2 * x, 0.5 + 0.2 * y, 0.04 + 0.02 * Math.sin(8 * t + 3 * x)], i);
        }
        return shape;
      },
    },
  ];
}

/** Densities on a plane of two made-up solids: the jelly ball as a ball, and everything below the floor. */
function ballSlice(positions: (Float32Array | undefined)[], wish: SliceWish): ArrayBuffer {
  const step = 0.04;
  const ball = positions[2]!;
  const middle = [0, 1, 2].map((k) => {
    let sum = 0;
    for (let i = k; i < ball.length; i += 3) sum += ball[i]!;
    return sum / (ball.length / 3);
  });
  const low = [-1.2, -1.2, -0.2];
  const high = [1.2, 1.2, 1.5];
  const u = (wish.axis + 1) % 3;
  const v = (wish.axis + 2) % 3;
  const at = step * Math.round(Math.max(low[wish.axis]!, Math.min(high[wish.axis]!, wish.at)) / step);
  const first = [u, v].map((k) => Math.floor(low[k]! / step));
  const count = [u, v].map((k, i) => Math.ceil(high[k]! / step) - first[i]! + 1);
  const n = count[0]! * count[1]!;
  const [density, second, overlap] = [0, 0, 0].map(() => new Float32Array(n)) as [
    Float32Array<ArrayBuffer>,
    Float32Array<ArrayBuffer>,
    Float32Array<ArrayBuffer>,
  ];
  const body = new Int32Array(n).fill(-1);
  const secondBody = new Int32Array(n).fill(-1);
  const ramp = (d: number) => {
    const s = Math.max(0, Math.min(1, 0.5 - d / (3 * step)));
    return s * s * (3 - 2 * s);
  };
  for (let i = 0; i < n; ++i) {
    const x = [0, 0, 0];
    x[wish.axis] = at;
    x[u] = step * (first[0]! + (i % count[0]!));
    x[v] = step * (first[1]! + Math.floor(i / count[0]!));
    const d = Math.hypot(...x.map((c, k) => c - middle[k]!)) - 0.28;
    const both = [
      { rho: ramp(x[2]!), of: 0 },
      { rho: ramp(d), of: 2 },
    ].filter((b) => b.rho > 0 && (wish.body < 0 || wish.body === b.of));
    both.sort((a, b) => b.rho - a.rho);
    if (both[0]) [density[i], body[i]] = [both[0].rho, both[0].of];
    if (both[1]) [second[i], secondBody[i]] = [both[1].rho, both[1].of];
    overlap[i] = Math.max(0, density[i]! + second[i]! - 1);
  }
  return encodeArrays([
    array('plane', new Float64Array([wish.axis, at, step, low[wish.axis]!, high[wish.axis]!])),
    array('nodes', new Int32Array([...first, ...count])),
    array('density', density, count[0]),
    array('body', body, count[0]),
    array('second', second, count[0]),
    array('second_body', secondBody, count[0]),
    array('overlap', overlap, count[0]),
  ]);
}

interface FakeContacts {
  force: number[];
  friction: number[];
  overlap: number[];
  pair: number[];
}

/** The totals of every touching pair. */
function pairArrays(c: FakeContacts): NamedArray[] {
  const keys = [...new Set(c.overlap.map((_, i) => `${c.pair[2 * i]},${c.pair[2 * i + 1]}`))];
  const of = (key: string) =>
    c.overlap.flatMap((_, i) => (`${c.pair[2 * i]},${c.pair[2 * i + 1]}` === key ? [i] : []));
  const total = (values: number[], key: string) =>
    Math.hypot(...[0, 1, 2].map((k) => of(key).reduce((sum, i) => sum + values[3 * i + k]!, 0)));
  return [
    array('pairs/parts', new Int32Array(keys.flatMap((k) => k.split(',').map(Number))), 2),
    array('pairs/contacts', new Int32Array(keys.map((k) => of(k).length))),
    array('pairs/normal', new Float32Array(keys.map((k) => total(c.force, k)))),
    array('pairs/friction', new Float32Array(keys.map((k) => total(c.friction, k)))),
    array('pairs/overlap', new Float32Array(keys.map((k) => Math.max(...of(k).map((i) => c.overlap[i]!))))),
    array('pairs/pressure', new Float32Array(keys.length).fill(0.1)),
  ];
}

const phases = [
  'presence',
  'refine',
  'rasterize',
  'detect',
  'respond',
  'solve',
  'solve_contact',
  'advance',
  'record',
];

export function fakeRun(frames = 180, complete = true): FakeRun {
  const bodies = makeBodies();
  const partOf = (body: number) => body; // one part per body

  const contactsOf = (positions: (Float32Array | undefined)[], time: number) => {
    const position: number[] = [];
    const force: number[] = [];
    const friction: number[] = [];
    const overlap: number[] = [];
    const pair: number[] = [];
    [1, 2].forEach((b) => {
      const p = positions[b]!;
      for (let i = 0; i < p.length; i += 3) {
        const depth = 0.03 - p[i + 2]!;
        if (depth <= 0) continue;
        position.push(p[i]!, p[i + 1]!, 0);
        force.push(0, 0, -600 * depth);
        friction.push(60 * depth * Math.cos(time), 60 * depth * Math.sin(time), 0);
        overlap.push(40 * depth);
        pair.push(partOf(0), partOf(b));
      }
    });
    return { position, force, friction, overlap, pair };
  };

  const sample = (f: number) => {
    const time = f * kFrameTime;
    const positions = bodies.map((b) => b.surface?.(time).positions ?? b.move?.(time));
    const c = contactsOf(positions, time);
    const tiles = new Set<string>();
    const step = 0.025;
    for (let i = 0; i < c.position.length; i += 3)
      for (const dz of [-0.02, 0.02])
        tiles.add([c.position[i]!, c.position[i + 1]!, dz].map((x) => Math.floor(x / (8 * step))).join());
    const key = new Int32Array([...tiles].sort().flatMap((k) => k.split(',').map(Number)));
    return { time, positions, c, key, step };
  };

  const run: FakeRun = {
    frames,
    complete,
    stopped: false,
    broken: new Set(),
    interactive: false,
    asked: [],
    info: () => ({
      name: 'made-up run',
      scene: 'made-up',
      brimVersion: '0.1.0',
      frames: run.frames,
      complete: run.complete,
      stopped: run.stopped,
      interactive: run.interactive,
      slices: true,
      bodies: bodies.map((b, index) => ({
        index,
        name: b.name,
        kind: b.kind,
        display: b.display,
        twoSided: b.twoSided,
        radius: b.radius,
        vertices: (b.fixed ?? b.move?.(0) ?? []).length / 3,
        changing: b.surface !== undefined,
        fixed: b.fixed !== undefined,
        parts: [partOf(index)],
      })),
      parts: bodies.map((b, body) => ({ name: b.name, body, voxelSize: 0.05 })),
      links: [{ name: 'thread', kind: 'point' }],
      warnings: [
        {
          time: 0.38,
          code: 'saturation',
          message: 'jelly ball and floor press deeper than the ramp is wide',
        },
        {
          time: 1.6,
          code: 'no_convergence',
          message: 'the solve stopped at residual 3e-4 after 200 iterations',
        },
      ].filter((w) => w.time < run.frames * kFrameTime),
      summary: {},
    }),
    topology: (body) => {
      const b = bodies[body];
      if (!b) return undefined;
      const arrays: NamedArray[] = [];
      if (b.display === 'triangles' && !b.surface) arrays.push(array('triangles', b.cells, 3, body));
      if (b.display === 'lines') arrays.push(array('lines', b.cells, 2, body));
      if (b.fixed) arrays.push(array('positions', b.fixed, 3, body));
      return encodeArrays(arrays);
    },
    frame: (f) => {
      if (f < 0 || f >= run.frames) return undefined;
      const s = sample(f);
      const arrays: NamedArray[] = [array('time', new Float64Array([s.time]))];
      s.positions.forEach((p, body) => {
        if (p) arrays.push(array('positions', p as Float32Array<ArrayBuffer>, 3, body));
      });
      bodies.forEach((b, body) => {
        if (b.surface) arrays.push(array('triangles', b.surface(s.time).triangles, 3, body));
      });
      arrays.push(
        array('contacts/position', new Float32Array(s.c.position), 3),
        array('contacts/force', new Float32Array(s.c.force), 3),
        array('contacts/friction', new Float32Array(s.c.friction), 3),
        array('contacts/overlap', new Float32Array(s.c.overlap)),
        array('contacts/pair', new Int32Array(s.c.pair), 2),
        array('tiles/key', s.key, 3),
        array('tiles/step', new Float32Array(s.key.length / 3).fill(s.step)),
        ...pairArrays(s.c),
        array('links/link', new Int32Array([0])),
        array('links/a', (s.positions[2] as Float32Array<ArrayBuffer>).slice(0, 3), 3),
        array('links/b', new Float32Array([0, 0, 1.4]), 3),
      );
      return encodeArrays(arrays);
    },
    slice: (f, wish) => (f < 0 || f >= run.frames ? undefined : ballSlice(sample(f).positions, wish)),
    // More towards the floor, and more from frame to frame.
    stress: (f) => {
      if (f < 0 || f >= run.frames) return undefined;
      const { positions } = sample(f);
      return encodeArrays(
        bodies.flatMap((b, body) => {
          const p = positions[body];
          if (!elasticKinds.includes(b.kind) || !p) return [];
          const values = Float32Array.from(
            { length: p.length / 3 },
            (_, i) => ((1 + f) * 1e3) / (1 + p[3 * i + 2]!),
          );
          return [array('von_mises', values, 1, body)];
        }),
      );
    },
    series: (from) => {
      const count = Math.max(0, run.frames - from);
      const column = (value: (f: number) => number) => new Float64Array(count).map((_, i) => value(from + i));
      const contacts = column((f) => sample(f).c.overlap.length);
      const worst = column((f) => Math.max(0, ...sample(f).c.overlap));
      const cost = [0.3, 0.2, 1.6, 0.9, 0.5, 2.4, 1.2, 0.15, 0.25];
      return encodeArrays([
        array(
          'time',
          column((f) => f * kFrameTime),
        ),
        array('contacts', contacts),
        array('worst_overlap', worst),
        array(
          'cg_iterations',
          contacts.map((c, i) => 12 + Math.round(c / 6 + 5 * noise(from + i))),
        ),
        array(
          'kinetic_energy',
          column((f) => 4 * Math.exp(-0.9 * f * kFrameTime) * (1 + Math.sin(f / 7)) + 0.3),
        ),
        array(
          'potential_energy',
          column((f) => 9 + 5 * Math.exp(-0.8 * f * kFrameTime)),
        ),
        array(
          'contact_energy',
          worst.map((w) => 0.4 * w * w),
        ),
        array(
          'momentum_error',
          column((f) => 1e-12 * (1 + 4 * noise(f))),
        ),
        array(
          'angular_error',
          column((f) => 3e-12 * (1 + 4 * noise(f + 5000))),
        ),
        ...phases.map((name, k) =>
          array(
            `seconds_${name}`,
            contacts.map((c, i) => 1e-3 * cost[k]! * (0.7 + 0.012 * c + 0.15 * noise(17 * k + from + i))),
          ),
        ),
      ]);
    },
  };
  return run;
}
