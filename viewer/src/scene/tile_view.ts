/** The tiles in which densities were compared, as wire boxes, coloured by their step. */
import * as THREE from 'three';

const kTileSize = 8; // nodes per side
const levelColours = ['#2b6cb0', '#2f9e77', '#b7791f', '#a0436f'];
const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 1, (i >> 1) & 1, (i >> 2) & 1] as const);
const edges = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) =>
  [1, 2, 4].filter((b) => !(i & b)).map((b) => [i, i | b] as const),
);

/** Ends of the twelve edges of every tile, (24 n, 3), and a colour for each end. Boxes hold whole cells of their nodes. */
export function tileEdges(
  key: Int32Array,
  step: Float32Array,
): { positions: Float32Array; colours: Float32Array } {
  const n = step.length;
  const positions = new Float32Array(n * 72);
  const colours = new Float32Array(n * 72);
  const finest = step.reduce((a, b) => Math.min(a, b), Infinity);
  const palette = levelColours.map((c) => new THREE.Color(c));
  let at = 0;
  for (let t = 0; t < n; ++t) {
    const h = step[t]!;
    const level = Math.max(0, Math.min(palette.length - 1, Math.round(Math.log2(h / finest))));
    const colour = palette[level]!;
    for (const edge of edges)
      for (const end of edge) {
        for (let k = 0; k < 3; ++k)
          positions[at + k] = h * (kTileSize * (key[3 * t + k]! + corners[end]![k]!) - 0.5);
        colour.toArray(colours, at);
        at += 3;
      }
  }
  return { positions, colours };
}

export class TileView {
  readonly object: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;

  constructor() {
    const material = new THREE.LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.55 });
    this.object = new THREE.LineSegments(new THREE.BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  update(tiles: { key: Int32Array; step: Float32Array }): void {
    if (!this.object.visible) return;
    const { positions, colours } = tileEdges(tiles.key, tiles.step);
    this.object.geometry.dispose();
    this.object.geometry = new THREE.BufferGeometry();
    this.object.geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    this.object.geometry.setAttribute('color', new THREE.BufferAttribute(colours, 3));
  }
}
