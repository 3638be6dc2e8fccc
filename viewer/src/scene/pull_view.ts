/** The spring by which a body is pulled: a bead where it is held, a rod to where it is pulled. */
import * as THREE from 'three';
import { Glyphs } from './glyphs';

const colour = '#c2571a';
const kBead = 0.012; // radius of a bead, over the scene's radius
const kRod = 0.003; // likewise

export class PullView {
  readonly object = new THREE.Group();
  private readonly beads = new Glyphs(new THREE.IcosahedronGeometry(1, 2), colour, 0.6);
  private readonly rods = new Glyphs(
    new THREE.CylinderGeometry(1, 1, 1, 10).translate(0, 0.5, 0),
    colour,
    0.6,
  );

  constructor() {
    this.object.visible = false;
    this.object.add(this.beads.object, this.rods.object);
  }

  /** @param radius [m] of the scene */
  show(held: THREE.Vector3, to: THREE.Vector3, radius: number): void {
    this.object.visible = true;
    const matrix = new THREE.Matrix4();
    const turn = new THREE.Quaternion();
    const bead = this.beads.begin(2);
    bead.setMatrixAt(0, matrix.compose(held, turn, new THREE.Vector3().setScalar(kBead * radius)));
    bead.setMatrixAt(1, matrix.compose(to, turn, new THREE.Vector3().setScalar(0.6 * kBead * radius)));
    const along = to.clone().sub(held);
    const length = along.length();
    const rod = this.rods.begin(1);
    if (length > 0) turn.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length));
    rod.setMatrixAt(0, matrix.compose(held, turn, new THREE.Vector3(kRod * radius, length, kRod * radius)));
  }

  hide(): void {
    this.object.visible = false;
  }
}
