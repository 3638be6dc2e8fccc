/** Contacts of a frame: a dot or its voxel where each is, an arrow for its normal force, another for friction. */
import * as THREE from 'three';
import type { Contacts } from '../run';
import { between, overlapStops, rgbOf } from '../slice';
import { Glyphs } from './glyphs';

export type ContactStyle = 'off' | 'points' | 'forces' | 'all' | 'voxels';

/** Colour of voxels that both bodies' ramps reach, where densities do not overlap yet and no force acts. */
export const nearColour = '#a9bccb';
export const deepOverlap = 0.5; // [voxels] at which a voxel has the last colour

export const normalColour = '#c2303a';
export const frictionColour = '#e0a100';

const kFaint = 0.12; // opacity of dots that a body hides

/** Radius of a dot for a run of so many contacts, relative to that of the scene: the bodies of a pile stay readable. */
export const dotSize = (contacts: number) =>
  Math.max(0.0012, 0.0045 * Math.min(1, Math.sqrt(100 / Math.max(1, contacts))));

export class ContactView {
  readonly object = new THREE.Group();
  style: ContactStyle = 'off';
  scale = 1; // of arrows, times the length chosen from the run's largest force
  private readonly dots = new Glyphs(new THREE.IcosahedronGeometry(1, 2), '#202a36', kFaint);
  private readonly voxels = new Glyphs(new THREE.BoxGeometry(1, 1, 1), '#ffffff', 0.4);
  private readonly shafts = [0, 1].map((k) => this.glyphs(new THREE.CylinderGeometry(1, 1, 1, 10), k));
  private readonly heads = [0, 1].map((k) => this.glyphs(new THREE.ConeGeometry(1, 1, 14), k));
  private most = 0; // contacts seen so far in the run: the more there are, the smaller and fainter are their dots
  private largest = 0; // [N] largest force seen so far in the run: arrows keep their scale from frame to frame

  /** @param isFixed tells whether a part never moves: forces are drawn on the part that does */
  constructor(private readonly isFixed: (part: number) => boolean) {
    this.object.add(
      this.dots.object,
      this.voxels.object,
      ...this.shafts.map((g) => g.object),
      ...this.heads.map((g) => g.object),
    );
  }

  private glyphs(geometry: THREE.BufferGeometry, kind: number): Glyphs {
    geometry.translate(0, 0.5, 0);
    return new Glyphs(geometry, kind === 0 ? normalColour : frictionColour);
  }

  /** +1 or -1: the sign that turns the recorded force, on the first part, into that on the part it is drawn on. */
  sign(c: Contacts, i: number): number {
    return this.isFixed(c.pair[2 * i]!) && !this.isFixed(c.pair[2 * i + 1]!) ? -1 : 1;
  }

  /** @param steps [m] voxel size of each contact, asked for only when voxels are shown */
  update(c: Contacts, radius: number, steps: () => Float32Array): void {
    let largest = 0; // squared
    for (let i = 0; i < 3 * c.count; i += 3) {
      const f = c.force[i]! ** 2 + c.force[i + 1]! ** 2 + c.force[i + 2]! ** 2;
      if (f > largest && f < Infinity) largest = f;
    }
    this.largest = Math.max(this.largest, Math.sqrt(largest));
    this.most = Math.max(this.most, c.count);
    this.object.visible = this.style !== 'off';
    if (!this.object.visible) return;
    const showDots = this.style === 'points' || this.style === 'all';
    const showArrows = this.style === 'forces' || this.style === 'all';
    const matrix = new THREE.Matrix4();
    const dot = this.dots.begin(showDots ? c.count : 0);
    const size = dotSize(this.most) * radius;
    if (showDots)
      for (let i = 0; i < c.count; ++i) {
        matrix
          .makeScale(size, size, size)
          .setPosition(c.position[3 * i]!, c.position[3 * i + 1]!, c.position[3 * i + 2]!);
        dot.setMatrixAt(i, matrix);
      }
    this.cubes(c, this.style === 'voxels' ? steps() : undefined);
    this.arrows(0, c, showArrows ? c.force : undefined, radius);
    this.arrows(1, c, showArrows ? c.friction : undefined, radius);
  }

  private cubes(c: Contacts, steps: Float32Array | undefined): void {
    const mesh = this.voxels.begin(steps ? c.count : 0);
    if (!steps) return;
    const stops = overlapStops.map(rgbOf);
    const near = rgbOf(nearColour);
    const colour = new THREE.Color();
    const matrix = new THREE.Matrix4();
    for (let i = 0; i < c.count; ++i) {
      const size = 0.94 * steps[i]!; // a gap shows one from the next
      matrix
        .makeScale(size, size, size)
        .setPosition(c.position[3 * i]!, c.position[3 * i + 1]!, c.position[3 * i + 2]!);
      mesh.setMatrixAt(i, matrix);
      const overlap = c.overlap[i]!;
      const [r, g, b] = overlap > 0 ? between(stops, overlap / deepOverlap) : near;
      mesh.setColorAt(i, colour.setRGB(r / 255, g / 255, b / 255, THREE.SRGBColorSpace));
    }
    this.voxels.shareColours();
  }

  private arrows(kind: number, c: Contacts, vectors: Float32Array | undefined, radius: number): void {
    const count = vectors?.length ? c.count : 0;
    const shaft = this.shafts[kind]!.begin(count);
    const head = this.heads[kind]!.begin(count);
    if (!vectors || count === 0) return;
    const perNewton = this.largest > 0 ? (0.32 * radius * this.scale) / this.largest : 0;
    const thick = 0.0034 * radius;
    const up = new THREE.Vector3(0, 1, 0);
    const v = new THREE.Vector3();
    const at = new THREE.Vector3();
    const size = new THREE.Vector3();
    const turn = new THREE.Quaternion();
    const matrix = new THREE.Matrix4();
    for (let i = 0; i < count; ++i) {
      v.fromArray(vectors, 3 * i).multiplyScalar(perNewton * this.sign(c, i));
      at.fromArray(c.position, 3 * i);
      const length = v.length();
      const drawn = Number.isFinite(length) && length > 0.2 * thick;
      turn.setFromUnitVectors(up, drawn ? v.divideScalar(length) : up);
      const tip = drawn ? Math.min(0.45 * length, 5 * thick) : 0;
      const width = drawn ? thick * Math.min(1, length / (4 * thick)) : 0;
      shaft.setMatrixAt(i, matrix.compose(at, turn, size.set(width, drawn ? length - tip : 0, width)));
      if (drawn) at.addScaledVector(v, length - tip);
      head.setMatrixAt(i, matrix.compose(at, turn, size.set(2.4 * width, tip, 2.4 * width)));
    }
  }

  /** The contact under a ray, or -1. */
  pick(ray: THREE.Raycaster): number {
    if (!this.object.visible) return -1;
    const meshes = [this.dots, this.voxels, ...this.shafts, ...this.heads].flatMap((g) =>
      g.mesh && g.mesh.count > 0 ? [g.mesh] : [],
    );
    return ray.intersectObjects(meshes, false)[0]?.instanceId ?? -1;
  }
}
