import { expect, test } from 'vitest';
import { fakeRun } from '../dev/fake_run';
import { decodeArrays } from '../src/codec';
import {
  between,
  densityPixels,
  overlapPixels,
  rgbOf,
  sliceFromArrays,
  tileOutlines,
  worstOverlap,
  type Slice,
} from '../src/slice';

const one = (changes: Partial<Slice>): Slice => ({
  axis: 2,
  at: 0.5,
  step: 0.1,
  lowest: 0,
  highest: 1,
  first: [0, 0],
  count: [1, 1],
  density: new Float32Array([0]),
  body: new Int32Array([-1]),
  second: new Float32Array([0]),
  secondBody: new Int32Array([-1]),
  overlap: new Float32Array([0]),
  ...changes,
});

test('a slice is read from its message, and one that lacks an array is refused', () => {
  const message = decodeArrays(fakeRun(3).slice(1, { axis: 1, at: -0.4, body: -1 })!);
  const s = sliceFromArrays(message);
  expect(s.axis).toBe(1);
  expect(Math.abs(s.at + 0.4)).toBeLessThan(s.step);
  expect(s.density.length).toBe(s.count[0] * s.count[1]);
  expect(() => sliceFromArrays(message.filter((a) => a.name !== 'overlap'))).toThrow('overlap');
});

test('a full node has the colour of its body, an empty one none', () => {
  const full = one({ density: new Float32Array([1]), body: new Int32Array([1]) });
  expect([...densityPixels(full, ['#000000', '#804020'], false)]).toEqual([128, 64, 32, 255]);
  expect([...densityPixels(one({}), ['#000000'], false)]).toEqual([0, 0, 0, 0]);
});

test('where two bodies share a node their colours mix in the shares of their densities', () => {
  const shared = one({
    density: new Float32Array([0.75]),
    body: new Int32Array([0]),
    second: new Float32Array([0.25]),
    secondBody: new Int32Array([1]),
  });
  const [r, g, , a] = densityPixels(shared, ['#ff0000', '#00ff00'], false);
  expect([r, g, a]).toEqual([Math.round(255 * 0.75 * 0.75), Math.round(255 * 0.25 * 0.75), 191]);
});

test('the deepest overlap is 255, none is 0, and any at all is more than 0', () => {
  const s = one({ overlap: new Float32Array([0, 1e-6, 0.1, 0.4]) });
  expect(worstOverlap(s)).toBeCloseTo(0.4);
  expect([...overlapPixels(s)]).toEqual([0, 1, 128, 255]);
  expect([...overlapPixels(one({}))]).toEqual([0]);
});

test('colour maps start and end at their first and last stop', () => {
  const stops = ['#000000', '#102030', '#ffffff'].map(rgbOf);
  expect(between(stops, -1)).toEqual([0, 0, 0]);
  expect(between(stops, 0.25)).toEqual([8, 16, 24]);
  expect(between(stops, 2)).toEqual([255, 255, 255]);
});

test('only tiles that the plane cuts are outlined, in the plane and around their own nodes', () => {
  const tiles = { key: new Int32Array([0, 0, 0, 0, 0, 1]), step: new Float32Array([0.1, 0.1]) };
  const { positions, steps } = tileOutlines(one({}), tiles);
  expect(steps.length).toBe(1);
  expect(positions.length).toBe(4 * 2 * 3);
  const along = (k: number) => [...positions].filter((_, i) => i % 3 === k);
  expect(Math.min(...along(0))).toBeCloseTo(-0.05);
  expect(Math.max(...along(1))).toBeCloseTo(0.75);
  expect(new Set(along(2))).toEqual(new Set([0.5]));
});
