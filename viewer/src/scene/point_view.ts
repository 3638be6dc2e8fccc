/** Particles as lit balls, or as the surface around them. */
import * as THREE from 'three';
import { mergeVertices } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { BodyInfo } from '../run';
import { Surfacer, type ShadedSurface } from '../surface/surfacer';
import { clip, everywhere, instances, material, type BodyView } from './body_parts';

/**
 * A ball with fewer triangles the more of them there are: about 10⁵ in all, as long as they still look round; where
 * there are so many that each is small, its shading alone does.
 */
function ballGeometry(count: number): THREE.BufferGeometry {
  const detail = Math.round(Math.sqrt(100_000 / (20 * Math.max(1, count)))) - 1;
  const ball = new THREE.IcosahedronGeometry(1, Math.max(count > 12_000 ? 0 : 1, Math.min(6, detail)));
  ball.deleteAttribute('uv');
  ball.deleteAttribute('normal');
  const indexed = mergeVertices(ball);
  indexed.setAttribute('normal', indexed.getAttribute('position').clone());
  return indexed;
}

/** Balls of one size. */
export class PointView implements BodyView {
  readonly object: THREE.InstancedMesh;
  private readonly material: THREE.MeshStandardMaterial;

  constructor(
    body: BodyInfo,
    colour: string,
    private readonly radius: number,
  ) {
    this.material = material(colour, body);
    this.object = instances(ballGeometry(body.vertices), this.material, body.vertices);
  }

  update(positions: Float32Array): void {
    const m = this.object.instanceMatrix.array;
    for (let i = 0, j = 0; i < positions.length; i += 3, j += 16) {
      m[j] = m[j + 5] = m[j + 10] = this.radius;
      m[j + 12] = positions[i]!;
      m[j + 13] = positions[i + 1]!;
      m[j + 14] = positions[i + 2]!;
      m[j + 15] = 1;
    }
    this.object.instanceMatrix.needsUpdate = true;
  }
  setColour(colour: string) {
    this.material.color.set(colour);
  }
  setWireframe(on: boolean) {
    this.material.wireframe = on;
  }
  setClipping(planes: THREE.Plane[] | null) {
    clip(this.material, planes);
  }
  dispose() {
    this.object.geometry.dispose();
    this.object.dispose();
    this.material.dispose();
  }
}

/** Balls, or the surface around them. The balls stay until the first surface has come. */
export class ParticleView implements BodyView {
  readonly object = new THREE.Group();
  private readonly balls: PointView;
  private readonly surface: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
  private surfacer: Surfacer | undefined;
  private positions: Float32Array = new Float32Array(0);

  /** @param changed is called when a surface has come */
  constructor(
    body: BodyInfo,
    colour: string,
    private readonly radius: number,
    private readonly changed: () => void,
  ) {
    this.balls = new PointView(body, colour, radius);
    this.surface = new THREE.Mesh(new THREE.BufferGeometry(), material(colour, body));
    this.surface.castShadow = this.surface.receiveShadow = true;
    this.surface.frustumCulled = false;
    this.object.add(this.balls.object);
  }

  update(positions: Float32Array): void {
    this.positions = positions;
    if (this.surfacer) this.surfacer.ask(positions);
    else this.balls.update(positions);
  }
  setSurface(on: boolean): void {
    if (on === (this.surfacer !== undefined)) return;
    if (on) {
      this.surfacer = new Surfacer(this.radius, (made) => this.take(made));
      this.surfacer.ask(this.positions);
    } else {
      this.surfacer?.dispose();
      this.surfacer = undefined;
      this.object.remove(this.surface);
      this.object.add(this.balls.object);
      this.balls.update(this.positions);
    }
  }
  settled(): Promise<void> {
    return this.surfacer?.settled() ?? Promise.resolve();
  }
  private take({ positions, cells, normals }: ShadedSurface) {
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(cells, 1));
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
    geometry.boundingSphere = everywhere();
    this.surface.geometry.dispose();
    this.surface.geometry = geometry;
    this.object.remove(this.balls.object);
    this.object.add(this.surface);
    this.changed();
  }
  setColour(colour: string) {
    this.balls.setColour(colour);
    this.surface.material.color.set(colour);
  }
  setWireframe(on: boolean) {
    this.balls.setWireframe(on);
    this.surface.material.wireframe = on;
  }
  setClipping(planes: THREE.Plane[] | null) {
    this.balls.setClipping(planes);
    clip(this.surface.material, planes);
  }
  dispose() {
    this.surfacer?.dispose();
    this.balls.dispose();
    this.surface.geometry.dispose();
    this.surface.material.dispose();
  }
}
