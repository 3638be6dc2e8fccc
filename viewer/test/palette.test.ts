import { expect, test } from 'vitest';
import { bodyColours, defaultColours, fixedColour } from '../src/scene/palette';

type Rgb = [number, number, number];

const linear = (hex: string): Rgb =>
  [1, 3, 5].map((i) => {
    const c = parseInt(hex.slice(i, i + 2), 16) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  }) as Rgb;

const times = (m: number[][], v: Rgb) => m.map((row) => row.reduce((s, x, k) => s + x * v[k]!, 0)) as Rgb;

/** Full protanopia and deuteranopia after Machado, Oliveira and Fernandes (2009), on linear sRGB. */
const vision = {
  common: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  protan: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deutan: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
};

/** CIE L*a*b* under D65. */
function lab(rgb: Rgb): Rgb {
  const xyz = times(
    [
      [0.4124, 0.3576, 0.1805],
      [0.2126, 0.7152, 0.0722],
      [0.0193, 0.1192, 0.9505],
    ],
    rgb,
  );
  const [x, y, z] = [xyz[0] / 0.9505, xyz[1], xyz[2] / 1.089].map((t) =>
    t > 0.008856 ? Math.cbrt(Math.max(t, 0)) : 7.787 * t + 16 / 116,
  ) as Rgb;
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

for (const [name, matrix] of Object.entries(vision))
  test(`any two colours of bodies differ clearly for ${name} vision`, () => {
    const labs = [...bodyColours, fixedColour].map((c) => lab(times(matrix, linear(c))));
    for (let i = 0; i < labs.length; ++i)
      for (let j = 0; j < i; ++j) {
        const difference = Math.hypot(...labs[i]!.map((x, k) => x - labs[j]![k]!));
        // About 2.3 is just noticeable side by side; 12 is told apart at a glance.
        expect(difference, `${bodyColours[i]} and ${bodyColours[j]}`).toBeGreaterThan(12);
      }
  });

test('fixed bodies are grey and the others go through the list', () => {
  const colours = defaultColours([{ fixed: true }, ...Array.from({ length: 10 }, () => ({ fixed: false }))]);
  expect(colours[0]).toBe(fixedColour);
  expect(colours[1]).toBe(bodyColours[0]);
  expect(colours[9]).toBe(bodyColours[0]);
});
