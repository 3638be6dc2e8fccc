import { expect, test } from 'vitest';
import { fakeRun } from '../dev/fake_run';
import { decodeArrays } from '../src/codec';
import { rgbOf } from '../src/slice';
import { largest, stressColours, stressFromArrays, stressStops } from '../src/stress';

test('stress is read by body, and its largest value found', () => {
  const stress = stressFromArrays(decodeArrays(fakeRun(3).stress(1)!));
  expect(stress.size).toBeGreaterThan(0);
  const most = Math.max(...[...stress.values()].flatMap((v) => [...v]));
  expect(largest(stress)).toBe(most);
  expect(largest(new Map())).toBe(0);
});

test('colours go from the first stop to the last, and stay there above it', () => {
  const of = (s: number) => [...stressColours(new Float32Array([s]), 1000)];
  const linear = (colour: string) =>
    [1, 3, 5].map((at) => {
      const c = parseInt(colour.slice(at, at + 2), 16) / 255;
      return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
    });
  linear(stressStops[0]!).forEach((c, k) => expect(of(0)[k]).toBeCloseTo(c, 5));
  linear(stressStops.at(-1)!).forEach((c, k) => expect(of(1000)[k]).toBeCloseTo(c, 5));
  expect(of(5000)).toEqual(of(1000));
  expect([...stressColours(new Float32Array([3]), 0)]).toEqual(of(0)); // nothing is stressed
});

test('every stop is lighter than the one before', () => {
  const lightness = stressStops.map(rgbOf).map(([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b);
  for (let i = 1; i < lightness.length; ++i) expect(lightness[i]!).toBeGreaterThan(lightness[i - 1]! + 10);
});
