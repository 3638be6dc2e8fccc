/** Colours of bodies: muted, and told apart by people with any common colour vision (test/palette.test.ts). */

export const bodyColours = [
  '#4f83b5', // steel blue
  '#e2a03f', // amber
  '#b8455f', // rose
  '#43a88c', // sea green
  '#e8c9a0', // sand
  '#6b4f8f', // violet
  '#8cc7dd', // sky
  '#7b5a3a', // umber
] as const;

export const fixedColour = '#b4babd';

/** Default colours of a run's bodies: grey for what never moves, the list in order for the rest. */
export function defaultColours(bodies: { fixed: boolean }[]): string[] {
  let next = 0;
  return bodies.map((b) => (b.fixed ? fixedColour : bodyColours[next++ % bodyColours.length]!));
}

/** One colour per phase of a step, in the order of the stack. */
export const phaseColours: Record<string, string> = {
  presence: '#b9c6d3',
  refine: '#8fa9c4',
  rasterize: '#4f83b5',
  detect: '#3f9c84',
  respond: '#9ac59a',
  solve: '#e2a03f',
  solve_contact: '#cf6f4a',
  advance: '#b79ac8',
  record: '#8d8d92',
};
