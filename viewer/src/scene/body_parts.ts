/** What views of bodies have in common. */
import * as THREE from 'three';
import type { BodyInfo } from '../run';

export interface BodyView {
  readonly object: THREE.Object3D;
  /** @param cells triangles of the frame, of a body whose triangles change */
  update(positions: Float32Array, cells?: Int32Array): void;
  setColour(colour: string): void;
  setWireframe(on: boolean): void;
  /** Only surfaces can be coloured by vertex. @param colours (nv, 3) linear; none: in the colour of the body */
  setValues?(colours: Float32Array | undefined): void;
  /** Hides what lies behind the planes, as the slice does to look inside. */
  setClipping(planes: THREE.Plane[] | null): void;
  /** Only particles can be shown as a surface; it is there once `settled` has come true. */
  setSurface?(on: boolean): void;
  settled?(): Promise<void>;
  /** Only surfaces can be floors. */
  asFloor?(center: THREE.Vector3, reach: number): void;
  dispose(): void;
}

export function clip(m: THREE.Material, planes: THREE.Plane[] | null) {
  m.clippingPlanes = planes;
  m.needsUpdate = true;
}

export function material(colour: string, body: BodyInfo): THREE.MeshStandardMaterial {
  return new THREE.MeshStandardMaterial({
    color: colour,
    roughness: body.fixed ? 0.95 : body.twoSided ? 0.8 : 0.46,
    metalness: 0,
    side: THREE.DoubleSide, // a look inside shows the inside, and open surfaces have two sides
    shadowSide: THREE.DoubleSide,
  });
}

/**
 * Bounds that hold any place: three.js would compute tight ones anew whenever things have moved, which costs more than
 * they save; a click then looks at every triangle.
 */
export const everywhere = () => new THREE.Sphere(new THREE.Vector3(), Infinity);

/** Instances of one small mesh. */
export function instances(
  geometry: THREE.BufferGeometry,
  m: THREE.Material,
  count: number,
): THREE.InstancedMesh {
  const mesh = new THREE.InstancedMesh(geometry, m, count);
  mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  mesh.frustumCulled = false;
  mesh.boundingSphere = everywhere();
  return mesh;
}
