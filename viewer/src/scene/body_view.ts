/** Bodies as the picture shows them. One class per display kind behind one small interface. */
import * as THREE from 'three';
import { mergeVertices } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { BodyInfo, Topology } from '../run';
import { splitAtCreases, updateShading, vertexNormals, type SplitMesh } from './normals';

const kCrease = THREE.MathUtils.degToRad(38);

export interface BodyView {
  readonly object: THREE.Object3D;
  /** @param cells triangles of the frame, of a body whose triangles change */
  update(positions: Float32Array, cells?: Int32Array): void;
  setColour(colour: string): void;
  setWireframe(on: boolean): void;
  /** Hides what lies behind the planes, as the slice does to look inside. */
  setClipping(planes: THREE.Plane[] | null): void;
  /** Only surfaces can be floors. */
  asFloor?(center: THREE.Vector3, reach: number): void;
  dispose(): void;
}

function clip(m: THREE.Material, planes: THREE.Plane[] | null) {
  m.clippingPlanes = planes;
  m.needsUpdate = true;
}

function material(colour: string, body: BodyInfo): THREE.MeshStandardMaterial {
  return new THREE.MeshStandardMaterial({
    color: colour,
    roughness: body.fixed ? 0.95 : body.twoSided ? 0.8 : 0.46,
    metalness: 0,
    side: THREE.DoubleSide, // a look inside shows the inside, and open surfaces have two sides
    shadowSide: THREE.DoubleSide,
  });
}

/**
 * Lets a surface end in nothing, between two distances from a point, and makes it paler: a floor that stands for an
 * endless one should not show where its picture stops, nor be taken for one of the things on it.
 */
function fadeOut(m: THREE.MeshStandardMaterial, center: THREE.Vector3, from: number, to: number) {
  m.transparent = true;
  m.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, {
      fadeCenter: { value: center.clone() },
      fadeRange: { value: new THREE.Vector2(from, to) },
    });
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nvarying vec3 fadeAt;')
      .replace(
        '#include <begin_vertex>',
        '#include <begin_vertex>\nfadeAt = (modelMatrix * vec4(position, 1.0)).xyz;',
      );
    shader.fragmentShader = shader.fragmentShader
      .replace(
        '#include <common>',
        '#include <common>\nvarying vec3 fadeAt;\nuniform vec3 fadeCenter;\nuniform vec2 fadeRange;',
      )
      .replace(
        '#include <color_fragment>',
        '#include <color_fragment>\ndiffuseColor.rgb = mix(diffuseColor.rgb, vec3(1.0), 0.4);',
      )
      .replace(
        '#include <opaque_fragment>',
        '#include <opaque_fragment>\ngl_FragColor.a *= 1.0 - smoothstep(fadeRange.x, fadeRange.y, distance(fadeAt, fadeCenter));',
      );
  };
  m.needsUpdate = true;
}

class TriangleView implements BodyView {
  readonly object: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
  private split: SplitMesh | undefined;

  constructor(
    body: BodyInfo,
    private readonly topology: Topology,
    colour: string,
  ) {
    this.object = new THREE.Mesh(new THREE.BufferGeometry(), material(colour, body));
    this.object.castShadow = true;
    this.object.receiveShadow = true;
    this.object.frustumCulled = false; // bounds would have to follow every frame
  }

  update(positions: Float32Array): void {
    const geometry = this.object.geometry;
    if (!this.split) {
      this.split = splitAtCreases(positions, this.topology.cells, kCrease);
      const n = this.split.source.length * 3;
      geometry.setIndex(new THREE.BufferAttribute(this.split.index, 1));
      for (const name of ['position', 'normal'])
        geometry.setAttribute(
          name,
          new THREE.BufferAttribute(new Float32Array(n), 3).setUsage(THREE.DynamicDrawUsage),
        );
    }
    const p = geometry.getAttribute('position') as THREE.BufferAttribute;
    const n = geometry.getAttribute('normal') as THREE.BufferAttribute;
    updateShading(this.split, positions, p.array as Float32Array, n.array as Float32Array);
    p.needsUpdate = n.needsUpdate = true;
    geometry.boundingSphere = null;
    geometry.boundingBox = null;
  }

  /** Draws the surface as a floor without an end, under everything else; the studio's ground lays the shadows on it. */
  asFloor(center: THREE.Vector3, reach: number) {
    this.object.receiveShadow = false;
    fadeOut(this.object.material, center, 0.3 * reach, reach);
    this.object.material.depthWrite = false;
    this.object.renderOrder = -3;
    this.object.castShadow = false;
  }
  setColour(colour: string) {
    this.object.material.color.set(colour);
  }
  setWireframe(on: boolean) {
    this.object.material.wireframe = on;
  }
  setClipping(planes: THREE.Plane[] | null) {
    clip(this.object.material, planes);
  }
  dispose() {
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}

/** A surface that is another one in every frame; smooth all over, since its creases would come and go. */
class ChangingView extends TriangleView {
  override update(positions: Float32Array, cells?: Int32Array): void {
    if (!cells) return;
    // Buffers cannot change their size, so each frame has its own.
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(cells), 1));
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(vertexNormals(positions, cells), 3));
    this.object.geometry.dispose();
    this.object.geometry = geometry;
  }
}

/** Instances of one small mesh; picking needs their bounds renewed whenever they move. */
function instances(geometry: THREE.BufferGeometry, m: THREE.Material, count: number): THREE.InstancedMesh {
  const mesh = new THREE.InstancedMesh(geometry, m, count);
  mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
  mesh.castShadow = true;
  mesh.receiveShadow = true;
  mesh.frustumCulled = false;
  return mesh;
}

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

class PointView implements BodyView {
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
    this.object.boundingSphere = null;
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

class LineView implements BodyView {
  readonly object = new THREE.Group();
  private readonly material: THREE.MeshStandardMaterial;
  private readonly tubes: THREE.InstancedMesh;
  private readonly joints: PointView;

  constructor(
    body: BodyInfo,
    private readonly topology: Topology,
    colour: string,
    private readonly radius: number,
  ) {
    this.material = material(colour, body);
    const tube = new THREE.CylinderGeometry(1, 1, 1, 14, 1, true);
    this.tubes = instances(tube, this.material, topology.cells.length / 2);
    this.joints = new PointView(body, colour, radius);
    this.object.add(this.tubes, this.joints.object);
  }

  update(positions: Float32Array): void {
    const { cells } = this.topology;
    const from = new THREE.Vector3();
    const to = new THREE.Vector3();
    const up = new THREE.Vector3(0, 1, 0);
    const turn = new THREE.Quaternion();
    const scale = new THREE.Vector3();
    const matrix = new THREE.Matrix4();
    for (let s = 0; s < cells.length / 2; ++s) {
      from.fromArray(positions, 3 * cells[2 * s]!);
      to.fromArray(positions, 3 * cells[2 * s + 1]!);
      scale.copy(to).sub(from);
      const length = scale.length();
      turn.setFromUnitVectors(up, scale.divideScalar(length || 1));
      matrix.compose(from.add(to).multiplyScalar(0.5), turn, scale.set(this.radius, length, this.radius));
      this.tubes.setMatrixAt(s, matrix);
    }
    this.tubes.instanceMatrix.needsUpdate = true;
    this.tubes.boundingSphere = null;
    this.joints.update(positions);
  }
  setColour(colour: string) {
    this.material.color.set(colour);
    this.joints.setColour(colour);
  }
  setWireframe(on: boolean) {
    this.material.wireframe = on;
    this.joints.setWireframe(on);
  }
  setClipping(planes: THREE.Plane[] | null) {
    clip(this.material, planes);
    this.joints.setClipping(planes);
  }
  dispose() {
    this.tubes.geometry.dispose();
    this.tubes.dispose();
    this.material.dispose();
    this.joints.dispose();
  }
}

/** @param thinnest [m] lines and points without a radius of their own are drawn this thick */
export function makeBodyView(body: BodyInfo, topology: Topology, colour: string, thinnest: number): BodyView {
  const radius = body.radius > 0 ? body.radius : thinnest;
  if (body.display === 'points') return new PointView(body, colour, radius);
  if (body.display === 'lines') return new LineView(body, topology, colour, radius);
  return body.changing ? new ChangingView(body, topology, colour) : new TriangleView(body, topology, colour);
}
