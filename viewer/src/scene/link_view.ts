/**
 * Attachments and joints of a frame: a bead at what is held, a rod to where it is held, the axis of what turns or
 * slides, and an arm from a body to a bead that lies outside it.
 */
import * as THREE from 'three';
import type { LinkEnds, LinkInfo } from '../run';
import { Glyphs } from './glyphs';
import { outside } from './outside';

export const linkColour = '#0f7f8c';
const kApart = 1e-3; // distance of two ends, over the scene's radius, from which a rod is drawn between them
const kArm = 0.02; // distance of a bead from a body's surface, likewise, from which an arm is drawn
const kBead = 0.008; // radius of a bead, likewise
const kDot = 0.004; // radius of a point of a region, likewise
const kAxis = 0.07; // least half length of an axis, likewise

export interface LinkMarks {
  beads: THREE.Vector3[];
  dots: THREE.Vector3[]; // points of regions, of which there are many: smaller than beads
  rods: { from: THREE.Vector3; to: THREE.Vector3; axis: boolean }[];
}

/** The triangles that a body shows, or none. */
export type SurfaceOf = (body: number) => { positions: Float32Array; triangles: Int32Array } | undefined;

/** What is drawn of the ends of a frame. @param radius [m] of the scene */
export function linkMarks(
  ends: LinkEnds,
  links: LinkInfo[],
  radius: number,
  surface: SurfaceOf = () => undefined,
): LinkMarks {
  const marks: LinkMarks = { beads: [], dots: [], rods: [] };
  const at = (x: Float32Array, i: number) => new THREE.Vector3().fromArray(x, 3 * i);
  for (let first = 0, next = 0; first < ends.count; first = next) {
    const link = ends.link[first]!;
    while (next < ends.count && ends.link[next] === link) ++next;
    const kind = links[link]?.kind;
    const middle = new THREE.Vector3();
    const other = new THREE.Vector3(); // of side a
    for (let i = first; i < next; ++i) {
      middle.addScaledVector(at(ends.b, i), 1 / (next - first));
      other.addScaledVector(at(ends.a, i), 1 / (next - first));
    }
    const join = (from: THREE.Vector3, to: THREE.Vector3) => {
      const apart = from.distanceTo(to) > kApart * radius;
      if (apart) marks.rods.push({ from, to, axis: false });
      return apart;
    };
    const arm = (side: 0 | 1, bead: THREE.Vector3) => {
      const shown = surface(links[link]?.bodies?.[side] ?? -1);
      const from = shown && outside(bead, shown.positions, shown.triangles);
      if (from && from.distanceTo(bead) > kArm * radius) marks.rods.push({ from, to: bead, axis: false });
    };
    if (kind === 'hinge' || kind === 'slider') {
      const half = at(ends.b, first + 1)
        .sub(at(ends.b, first))
        .multiplyScalar(0.5);
      if (half.length() > 0) half.setLength(Math.max(half.length(), kAxis * radius));
      marks.beads.push(middle);
      marks.rods.push({ from: middle.clone().sub(half), to: middle.clone().add(half), axis: true });
      join(other, middle);
    } else if (kind === 'fixed') {
      marks.beads.push(middle);
      for (let i = first; i < next; ++i) join(middle, at(ends.b, i));
    } else
      for (let i = first; i < next; ++i) {
        const [a, b] = [at(ends.a, i), at(ends.b, i)];
        (kind === 'region' ? marks.dots : marks.beads).push(a, ...(join(a, b) ? [b] : []));
        if (kind !== 'region') (arm(0, a), arm(1, b));
      }
    if (kind === 'hinge' || kind === 'slider' || kind === 'fixed') (arm(0, other), arm(1, middle));
  }
  return marks;
}

/** Box of the beads and rods of a frame. @param bodies box of the bodies, which sets the size of the marks */
export function linkBox(ends: LinkEnds, links: LinkInfo[], bodies: THREE.Box3): THREE.Box3 {
  const radius = bodies.isEmpty() ? 0 : 0.5 * bodies.min.distanceTo(bodies.max);
  const { beads, dots, rods } = linkMarks(ends, links, radius);
  const box = new THREE.Box3();
  for (const p of [...beads, ...dots, ...rods.flatMap((r) => [r.from, r.to])])
    if (Number.isFinite(p.x + p.y + p.z)) box.expandByPoint(p);
  return box.isEmpty() ? box : box.expandByScalar(kBead * radius);
}

export class LinkView {
  readonly object = new THREE.Group();
  private readonly beads = new Glyphs(new THREE.IcosahedronGeometry(1, 2), linkColour, 0.45);
  private readonly rods = new Glyphs(
    new THREE.CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0),
    linkColour,
    0.45,
  );

  constructor() {
    this.object.add(this.beads.object, this.rods.object);
  }

  update(ends: LinkEnds, links: LinkInfo[], radius: number, surface: SurfaceOf): void {
    if (!this.object.visible) return;
    const { beads, dots, rods } = linkMarks(ends, links, radius, surface);
    const matrix = new THREE.Matrix4();
    const size = new THREE.Vector3();
    const turn = new THREE.Quaternion();
    const bead = this.beads.begin(beads.length + dots.length);
    size.setScalar(kBead * radius);
    beads.forEach((at, i) => bead.setMatrixAt(i, matrix.compose(at, turn, size)));
    size.setScalar(kDot * radius);
    dots.forEach((at, i) => bead.setMatrixAt(beads.length + i, matrix.compose(at, turn, size)));
    const up = new THREE.Vector3(0, 1, 0);
    const rod = this.rods.begin(rods.length);
    rods.forEach(({ from, to, axis }, i) => {
      const along = to.clone().sub(from);
      const length = along.length();
      const width = (axis ? 0.004 : 0.0025) * radius;
      turn.setFromUnitVectors(up, length > 0 ? along.divideScalar(length) : up);
      rod.setMatrixAt(i, matrix.compose(from, turn, size.set(width, length, width)));
    });
  }
}
