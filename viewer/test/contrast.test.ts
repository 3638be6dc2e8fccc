import { readFileSync } from 'node:fs';
import { expect, test } from 'vitest';

const style = readFileSync(new URL('../src/style.css', import.meta.url), 'utf8');
const named = (name: string) => new RegExp(`--${name}: (#[0-9a-f]{6})`).exec(style)![1]!;

/** Relative luminance of an sRGB colour (WCAG 2). */
function luminance(colour: string): number {
  const [r, g, b] = [1, 3, 5].map((i) => {
    const c = parseInt(colour.slice(i, i + 2), 16) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
}

test.each([
  ['ink', 'panel'],
  ['soft', 'panel'],
  ['soft', 'card'],
  ['accent', 'card'],
  ['alarm', 'card'],
  ['caution', 'card'],
])('text in %s on %s has the contrast that WCAG AA asks for', (text, ground) => {
  const [dark, light] = [luminance(named(text)), luminance(named(ground))].sort((a, b) => a - b);
  expect((light! + 0.05) / (dark! + 0.05)).toBeGreaterThan(4.5);
});
