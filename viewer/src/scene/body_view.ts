/** Bodies as the picture shows them. One class per display kind behind one small interface. */
import * as THREE from 'three';
import type { BodyInfo, Topology } from '../run';
import { clip, everywhere, instances, material, type BodyView } from './body_parts';
import { splitAtCreases, updateShading, vertexNormals, type SplitMesh } from './normals';
import { ParticleView, PointView } from './point_view';

export type { BodyView };

const kCrease = THREE.MathUtils.degToRad(38);

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
  private colour: string;

  constructor(
    body: BodyInfo,
    private readonly topology: Topology,
    colour: string,
  ) {
    this.object = new THREE.Mesh(new THREE.BufferGeometry(), material(colour, body));
    this.colour = colour;
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
      geometry.boundingSphere = everywhere();
    }
    const p = geometry.getAttribute('position') as THREE.BufferAttribute;
    const n = geometry.getAttribute('normal') as THREE.BufferAttribute;
    updateShading(this.split, positions, p.array as Float32Array, n.array as Float32Array);
    p.needsUpdate = n.needsUpdate = true;
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
    this.colour = colour;
    if (!this.object.material.vertexColors) this.object.material.color.set(colour);
  }
  setValues(colours: Float32Array | undefined) {
    const { geometry, material } = this.object;
    const source = this.split?.source;
    const on = colours !== undefined && source !== undefined;
    if (on) {
      const known = geometry.getAttribute('color') as THREE.BufferAttribute | undefined;
      const shown =
        known ??
        new THREE.BufferAttribute(new Float32Array(3 * source.length), 3).setUsage(THREE.DynamicDrawUsage);
      if (!known) geometry.setAttribute('color', shown);
      const spread = shown.array as Float32Array;
      source.forEach((v, i) => spread.set(colours.subarray(3 * v, 3 * v + 3), 3 * i));
      shown.needsUpdate = true;
    } else geometry.deleteAttribute('color');
    material.color.set(on ? '#ffffff' : this.colour);
    if (on !== material.vertexColors) {
      material.vertexColors = on;
      material.needsUpdate = true;
    }
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
    geometry.boundingSphere = everywhere();
    this.object.geometry.dispose();
    this.object.geometry = geometry;
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

/** @param thinnest [m] lines and points without a radius of their own are drawn this thick @param changed called when a view has changed by itself */
export function makeBodyView(
  body: BodyInfo,
  topology: Topology,
  colour: string,
  thinnest: number,
  changed: () => void,
): BodyView {
  const radius = body.radius > 0 ? body.radius : thinnest;
  if (body.display === 'points') return new ParticleView(body, colour, radius, changed);
  if (body.display === 'lines') return new LineView(body, topology, colour, radius);
  return body.changing ? new ChangingView(body, topology, colour) : new TriangleView(body, topology, colour);
}
