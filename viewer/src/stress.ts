/** Von Mises stress at the vertices of elastic solids, and the colours it is shown in. */
import type { NamedArray } from './codec';
import { between, rgbOf } from './slice';

/** Kinds whose bodies may be elastic solids; an image volume may be rigid as well. */
export const elasticKinds = ['finite_elements', 'image_volume', 'meshless'];

/** body -> (nv) [Pa] */
export type Stress = Map<number, Float32Array>;

export function stressFromArrays(arrays: NamedArray[]): Stress {
  const stress: Stress = new Map();
  for (const a of arrays) if (a.name === 'von_mises') stress.set(a.body, a.data as Float32Array);
  return stress;
}

/** The largest value of a frame, [Pa]. */
export function largest(stress: Stress): number {
  let most = 0;
  for (const values of stress.values()) for (const s of values) if (s > most) most = s;
  return most;
}

/** Stops of the colour map, from none to the largest: evenly lighter, so that it reads in grey as well. */
export const stressStops = ['#22265c', '#3b5fa0', '#2f95a6', '#55b97c', '#b3cf55', '#fbe45c'];

const stops = stressStops.map(rgbOf);
const linear = Float32Array.from({ length: 256 }, (_, i) => {
  const c = i / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
});

/** Linear colours of values, (nv, 3). @param top [Pa] value of the last stop */
export function stressColours(values: Float32Array, top: number): Float32Array {
  const out = new Float32Array(3 * values.length);
  values.forEach((s, i) =>
    between(stops, top > 0 ? s / top : 0).forEach((c, k) => (out[3 * i + k] = linear[Math.round(c)]!)),
  );
  return out;
}
