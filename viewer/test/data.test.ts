import * as THREE from 'three';
import { expect, test } from 'vitest';
import { FrameCache } from '../src/frame_cache';
import { array } from '../src/codec';
import { contactSteps, frameFromArrays, type Frame } from '../src/run';
import { roundLength } from '../src/scene/ground';
import { boxWithoutStrays } from '../src/scene/bounds';
import { linkBox, linkMarks } from '../src/scene/link_view';
import { outside } from '../src/scene/outside';
import { tileEdges } from '../src/scene/tile_view';
import { human } from '../src/ui/dom';
import { appendSeries, plotSpecs, roundUp, squeeze } from '../src/ui/plot_data';
import { crc32, zip } from '../src/ui/zip';

const frame = (index: number, bytes: number): Frame => ({ ...frameFromArrays(index, [], bytes) });

test('the cache asks once for a frame, keeps the latest used, and forgets the rest', async () => {
  const asked: number[] = [];
  const cache = new FrameCache((i) => (asked.push(i), Promise.resolve(frame(i, 10))), 30);
  await Promise.all([cache.get(1), cache.get(1)]);
  expect(asked).toEqual([1]);
  for (const i of [2, 3, 1, 4]) await cache.get(i);
  expect([1, 2, 3, 4].map((i) => cache.peek(i) !== undefined)).toEqual([true, false, true, true]);
});

test('a frame that could not be had is asked for again', async () => {
  let fail = true;
  const cache = new FrameCache((i) =>
    fail ? Promise.reject(new Error('no')) : Promise.resolve(frame(i, 1)),
  );
  await expect(cache.get(5)).rejects.toThrow('no');
  fail = false;
  expect((await cache.get(5)).index).toBe(5);
});

test('pairs are read as the run recorded them, in the order of their parts', () => {
  const arrays = [
    array('pairs/parts', new Int32Array([1, 2, 0, 2]), 2),
    array('pairs/contacts', new Int32Array([7, 3])),
    array('pairs/normal', new Float32Array([5, 1])),
    array('pairs/friction', new Float32Array([2, 0.5])),
    array('pairs/overlap', new Float32Array([0.25, 2])),
    array('pairs/pressure', new Float32Array([0.125, 0.5])),
  ];
  expect(frameFromArrays(0, arrays, 0).pairs).toEqual([
    { a: 0, b: 2, count: 3, normal: 1, friction: 0.5, worstOverlap: 2, pressure: 0.5 },
    { a: 1, b: 2, count: 7, normal: 5, friction: 2, worstOverlap: 0.25, pressure: 0.125 },
  ]);
});

test('a frame names the bodies that were removed, and most frames none', () => {
  const arrays = [array('removed', new Int32Array([2, 5])), array('positions', new Float32Array(3), 3, 0)];
  expect(frameFromArrays(0, arrays, 0).removed).toEqual(new Set([2, 5]));
  expect(frameFromArrays(0, [], 0).removed.size).toBe(0);
});

test('a tile is drawn around its own eight nodes per side', () => {
  const { positions } = tileEdges(new Int32Array([1, 0, -1]), new Float32Array([0.5]));
  const along = (k: number) => [...positions].filter((_, i) => i % 3 === k);
  expect([0, 1, 2].map((k) => [Math.min(...along(k)), Math.max(...along(k))])).toEqual([
    [3.75, 7.75],
    [-0.25, 3.75],
    [-4.25, -0.25],
  ]);
  expect(positions.length).toBe(12 * 2 * 3);
});

test('a rod joins the two ends of what is apart, and an axis goes through a hinge', () => {
  const arrays = [
    array('links/link', new Int32Array([0, 1, 1, 2])),
    array('links/a', new Float32Array([0, 0, 1, 2, 0, 0, 3, 0, 0, 5, 5, 5]), 3),
    array('links/b', new Float32Array([0, 0, 3, 2, 0, 0, 3, 0, 0, 5, 5, 5]), 3),
  ];
  const ends = frameFromArrays(0, arrays, 0).links;
  const kinds = (['point', 'hinge', 'ball'] as const).map((kind) => ({ name: kind, kind }));
  const { beads, rods } = linkMarks(ends, kinds, 1);
  expect(rods.map((r) => [r.from.toArray(), r.to.toArray(), r.axis])).toEqual([
    [[0, 0, 1], [0, 0, 3], false],
    [[2, 0, 0], [3, 0, 0], true],
  ]);
  expect(beads.map((b) => b.toArray())).toEqual([
    [0, 0, 1],
    [0, 0, 3],
    [2.5, 0, 0],
    [5, 5, 5],
  ]);
  // A run from before ends were recorded has none, and an axis that is short for the scene is drawn longer.
  expect(linkMarks(frameFromArrays(0, [], 0).links, [], 1)).toEqual({ beads: [], dots: [], rods: [] });
  const long = linkMarks(ends, kinds, 100).rods[1]!;
  expect(long.to.x - long.from.x).toBeCloseTo(14);
});

test('what a picture is to show holds far beads and the ends of axes, with the size of a bead', () => {
  const arrays = [
    array('links/link', new Int32Array([0, 1, 1])),
    array('links/a', new Float32Array([0, 0, 1, 2, 0, 0, 3, 0, 0]), 3),
    array('links/b', new Float32Array([0, 0, 9, 2, 0, 0, 3, 0, 0]), 3),
  ];
  const ends = frameFromArrays(0, arrays, 0).links;
  const kinds = (['point', 'hinge'] as const).map((kind) => ({ name: kind, kind }));
  const bodies = new THREE.Box3(new THREE.Vector3(0, 0, 0), new THREE.Vector3(0, 0, 100)); // radius 50 m
  const box = linkBox(ends, kinds, bodies);
  const bead = 0.008 * 50;
  expect(box.max.z).toBeCloseTo(9 + bead); // the far end of the point
  expect(box.max.x).toBeCloseTo(2.5 + 0.07 * 50 + bead); // an axis that is short for the scene is drawn longer
  expect(linkBox(frameFromArrays(0, [], 0).links, [], bodies).isEmpty()).toBe(true);
});

test('points of a region are dots, not beads', () => {
  const held = new Float32Array([0, 0, 1, 0, 1, 1]);
  const arrays = [
    array('links/link', new Int32Array([0, 0])),
    array('links/a', held, 3),
    array('links/b', held, 3),
  ];
  const ends = frameFromArrays(0, arrays, 0).links;
  const { beads, dots } = linkMarks(ends, [{ name: 'seam', kind: 'region' }], 1);
  expect([beads.length, dots.length]).toEqual([0, 2]);
});

test('a few drops that flew far do not make the rest small, and nothing is cut off where none did', () => {
  const cube = Array.from({ length: 3000 }, (_, i) => ((Math.floor(i / 3) * 37 + 11 * (i % 3)) % 100) / 100);
  const drop = [50, 0.5, 0.5];
  const box = boxWithoutStrays(Float32Array.from([...cube, ...drop]));
  expect(box.max.x).toBeGreaterThan(0.9);
  expect(box.max.x).toBeLessThan(1);
  expect(boxWithoutStrays(Float32Array.from(cube)).max.x).toBeCloseTo(0.99);
  expect(boxWithoutStrays(Float32Array.from(drop)).max.x).toBe(50);
});

test('an arm goes from the surface of a solid to what is held outside it, and from nothing else', () => {
  // A cube from 0 to 1, corner v at (v & 1, v >> 1 & 1, v >> 2).
  const positions = Float32Array.from({ length: 24 }, (_, i) => (Math.floor(i / 3) >> (i % 3)) & 1);
  const triangles = new Int32Array([
    0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7,
    5,
  ]);
  const inside = new THREE.Vector3(0.5, 0.5, 0.9);
  expect(outside(inside, positions, triangles)).toBeUndefined();
  expect(
    outside(new THREE.Vector3(0.25, 0.5, 3), positions, triangles)?.distanceTo(
      new THREE.Vector3(0.25, 0.5, 1),
    ),
  ).toBeCloseTo(0);
  const arms = (at: number[], bodies?: [number, number]) => {
    const held = new Float32Array(at);
    const arrays = [
      array('links/link', new Int32Array([0])),
      array('links/a', held, 3),
      array('links/b', held, 3),
    ];
    const ends = frameFromArrays(0, arrays, 0).links;
    const links = [{ name: 'pin', kind: 'point' as const, bodies }];
    return linkMarks(ends, links, 1, (body) => (body === 0 ? { positions, triangles } : undefined)).rods.map(
      (r) => [r.from.toArray(), r.to.toArray()],
    );
  };
  const rod = [
    [
      [0.25, 0.5, 1],
      [0.25, 0.5, 3],
    ],
  ];
  expect(arms([0.25, 0.5, 3], [0, -1])).toEqual(rod);
  expect(arms([0.25, 0.5, 3], [1, 0])).toEqual(rod);
  expect(arms([0.25, 0.5, 0.9], [0, -1])).toEqual([]); // inside
  expect(arms([0.25, 0.5, 1.01], [0, -1])).toEqual([]); // on its surface, as the eye sees it
  expect(arms([0.25, 0.5, 3], [1, -1])).toEqual([]); // of a body without a surface
  expect(arms([0.25, 0.5, 3])).toEqual([]); // a run that does not say whose it is
});

test('readings of a sensor are drawn together, axis by axis, before all else', () => {
  const values = new Float64Array([0, 1]);
  const sensors = [
    {
      name: 'plate',
      kind: 'force',
      channels: ['force_x', 'force_z', 'torque_x', 'overlap'],
      units: ['N', 'N', 'N m', 'voxels'],
    },
    { name: 'gauge', kind: 'level', channels: ['level', 'depth'], units: ['m', 'm'] },
  ];
  const keys = [
    'contacts',
    'sensor 0 0',
    'sensor 0 1',
    'sensor 0 2',
    'sensor 0 3',
    'sensor 1 0',
    'sensor 1 1',
  ];
  const specs = plotSpecs(new Map(keys.map((key) => [key, values])), sensors);
  expect(specs.map((s) => [s.title, s.unit, s.curves.map((c) => c.name)])).toEqual([
    ['plate: force', 'N', ['x', 'z']],
    ['plate: torque', 'N m', ['x']],
    ['gauge: level', 'm', ['level']],
    ['Contacts', '', ['nodes']],
  ]);
});

test('squeezing keeps the largest value of every bin and loses no frame', () => {
  const values = Float64Array.from({ length: 1000 }, (_, i) => (i === 777 ? 9 : Math.sin(i)));
  for (const bins of [1, 3, 64, 999, 5000]) {
    const out = squeeze(values, bins, 'max');
    expect(Math.max(...out)).toBe(9);
    expect(out.length).toBe(Math.min(bins, 1000));
  }
  expect([...squeeze([1, 3, 5, 7], 2, 'mean')]).toEqual([2, 6]);
  expect(squeeze([], 10, 'mean').length).toBe(0);
});

test('plots exist for the series that a run has', () => {
  expect(plotSpecs(new Map()).length).toBe(0);
  const specs = plotSpecs(
    new Map([
      ['seconds_solve', new Float64Array(2)],
      ['contacts', new Float64Array(2)],
    ]),
  );
  expect(specs.map((s) => [s.title, s.curves.length])).toEqual([
    ['Time per frame', 1],
    ['Contacts', 1],
  ]);
});

test('the phases of a frame add up to its time: contact is no second time in the solve', () => {
  const seconds = (...x: number[]) => new Float64Array(x);
  const [spec] = plotSpecs(
    new Map([
      ['seconds_detect', seconds(1, 2)],
      ['seconds_solve', seconds(5, 8)],
      ['seconds_solve_contact', seconds(3, 8)],
    ]),
  );
  const of = (name: string) => Array.from(spec!.curves.find((c) => c.name === name)!.values);
  expect(of('solve')).toEqual([2, 0]);
  expect(of('solve contact')).toEqual([3, 8]);
  expect(spec!.curves.reduce((sum, c) => sum + c.values[0]!, 0)).toBe(6);
});

test('series of a growing run are joined in order', () => {
  const joined = appendSeries(
    new Map([['time', new Float64Array([0, 1])]]),
    new Map([['time', new Float64Array([2])]]),
  );
  expect([...joined.get('time')!]).toEqual([0, 1, 2]);
});

test('round numbers lie above or near', () => {
  for (let x = 1e-6; x < 1e6; x *= 1.37) {
    expect(roundUp(x)).toBeGreaterThanOrEqual(x * (1 - 1e-6));
    expect(roundUp(x)).toBeLessThanOrEqual(x * 2.5);
    expect(Math.abs(Math.log(roundLength(x) / x))).toBeLessThan(Math.log(1.8));
  }
  expect([0, -1, NaN, Infinity].map(roundUp)).toEqual([1, 1, 1, 1]);
});

test('numbers are written for people', () => {
  expect(human(0.00123, 's')).toBe('1.23 ms');
  expect(human(1234567, 'N')).toBe('1.23 MN');
  expect(human(-2.5, 'J')).toBe('−2.5 J');
  expect(human(0.9999, 's')).toBe('1 s');
  expect(human(3e-12)).toBe('3.0e−12');
  expect(human(NaN, 'J')).toBe('not a number');
});

test('a zip holds its files under the checksum that the format asks for', async () => {
  expect(crc32(new TextEncoder().encode('123456789'))).toBe(0xcbf43926); // the check value of CRC-32
  const data = new TextEncoder().encode('hello');
  const bytes = new Uint8Array(await zip([{ name: 'a.txt', data }]).arrayBuffer());
  const view = new DataView(bytes.buffer);
  const end = bytes.length - 22;
  expect(view.getUint32(end, true)).toBe(0x06054b50);
  const directory = view.getUint32(end + 16, true);
  expect(view.getUint32(directory, true)).toBe(0x02014b50);
  expect(view.getUint32(directory + 16, true)).toBe(crc32(data));
  expect(new TextDecoder().decode(bytes.subarray(30 + 5, 30 + 5 + 5))).toBe('hello');
});

test('a contact lies in a voxel of the finer of its two parts, in a step that the grid has', () => {
  const parts = [0.1, 0.05, 0.021, undefined].map((voxelSize, i) => ({
    name: String(i),
    body: i,
    ...(voxelSize === undefined ? {} : { voxelSize }),
  }));
  const pair = new Int32Array([0, 1, 1, 2, 0, 3, 3, 3]);
  const { contacts } = frameFromArrays(
    0,
    [array('contacts/position', new Float32Array(12), 3), array('contacts/pair', pair, 2)],
    0,
  );
  // Steps are the finest times powers of two: 0.1 and 0.05 are rounded down to 0.08 and 0.04.
  const steps = [...contactSteps(contacts, parts, new Float32Array([0.08, 0.02, 0.04, 0.02]))];
  [0.04, 0.02, 0.08, 0.02].forEach((h, i) => expect(steps[i]).toBeCloseTo(h, 6));
  const unknown = [...contactSteps(contacts, parts, [])];
  expect(unknown[0]).toBeCloseTo(0.05, 6);
});
