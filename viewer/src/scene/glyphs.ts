/** Small marks of one colour, many at a time. */
import * as THREE from 'three';
import { everywhere } from './body_parts';

/** Instances of one small mesh, drawn where they are seen, and as a ghost where a body hides them. */
export class Glyphs {
  readonly object = new THREE.Group();
  private capacity = 0;
  private shown: THREE.InstancedMesh | undefined;
  private ghost: THREE.InstancedMesh | undefined;
  private readonly solid: THREE.MeshStandardMaterial;
  private readonly faint: THREE.MeshBasicMaterial;

  constructor(
    private readonly geometry: THREE.BufferGeometry,
    colour: string,
    faintness = 0.3,
  ) {
    this.solid = new THREE.MeshStandardMaterial({ color: colour, roughness: 0.6 });
    this.faint = new THREE.MeshBasicMaterial({
      color: colour,
      transparent: true,
      opacity: faintness,
      depthTest: false,
      depthWrite: false,
    });
  }

  begin(count: number): THREE.InstancedMesh {
    if (count > this.capacity || !this.shown || !this.ghost) {
      this.capacity = Math.max(64, Math.ceil(count * 1.5));
      this.shown?.dispose();
      this.ghost?.dispose();
      this.object.clear();
      this.shown = new THREE.InstancedMesh(this.geometry, this.solid, this.capacity);
      this.ghost = new THREE.InstancedMesh(this.geometry, this.faint, this.capacity);
      this.shown.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
      this.ghost.instanceMatrix = this.shown.instanceMatrix;
      this.shown.frustumCulled = this.ghost.frustumCulled = false;
      this.shown.boundingSphere = this.ghost.boundingSphere = everywhere();
      this.ghost.renderOrder = 5;
      this.object.add(this.shown, this.ghost);
    }
    this.shown.count = this.ghost.count = count;
    this.shown.instanceMatrix.needsUpdate = true;
    return this.shown;
  }

  /** Colours that were set on the instances hold for their ghosts too. */
  shareColours() {
    if (!this.shown?.instanceColor || !this.ghost) return;
    this.shown.instanceColor.needsUpdate = true;
    this.ghost.instanceColor = this.shown.instanceColor;
  }

  get mesh(): THREE.InstancedMesh | undefined {
    return this.shown;
  }
}
